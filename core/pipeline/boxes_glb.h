#pragma once

#include <span>
#include <vector>

#include "core/base/bytes.h"
#include "core/base/status.h"
#include "core/math/aabb.h"

namespace lightbatch::pipeline {

struct BoxLevel {
  int level = 0;
  std::vector<Aabb> boxes;  // recentred coordinates
};

/// Boxes as wireframes (LINES), one node "level L" for each level; origin is the world position of
/// recentred zero.
Result<Bytes> boxes_glb(std::span<const BoxLevel> levels, const Vec3d& origin);

}  // namespace lightbatch::pipeline
