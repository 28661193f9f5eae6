#include "core/hierarchy/sweep.h"

#if defined(__SSE2__)
#include <emmintrin.h>
#endif

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <cstring>
#include <limits>
#include <numeric>
#include <span>
#include <utility>
#include <vector>

#include "core/base/parallel.h"
#include "core/hierarchy/records.h"
#include "core/hierarchy/split_rule.h"

namespace lightbatch::hierarchy {
namespace {

#include "core/hierarchy/sweep_impl.h"
}  // namespace

void sweep_baseline(std::span<const Aabb> boxes, TreeArrays& tree) { Sweep(boxes, tree).run(); }

}  // namespace lightbatch::hierarchy
