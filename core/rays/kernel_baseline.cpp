#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <optional>
#include <span>
#include <utility>

#include "core/hierarchy/split_rule.h"
#include "core/rays/exact_test.h"
#include "core/rays/kernel.h"

namespace lightbatch::rays {
namespace {

#include "core/rays/kernel_impl.h"

}  // namespace

const Kernel& baseline_kernel() {
  static constexpr Kernel kKernel = {cast_closest, cast_occluded, cast_bundles};
  return kKernel;
}

}  // namespace lightbatch::rays
