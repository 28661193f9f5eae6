#pragma once

#include <cstdint>

#include "core/hierarchy/large_vector.h"

namespace lightbatch::hierarchy {

/// A node as it is built; 32 bytes, no initialisation.
struct alignas(32) TreeNode {
  float lower[3];
  std::uint32_t first;
  float upper[3];
  std::uint32_t count;
};
using TreeNodes = LargeVector<TreeNode>;

}  // namespace lightbatch::hierarchy
