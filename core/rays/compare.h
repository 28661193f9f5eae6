#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "core/hierarchy/comparators.h"
#include "core/math/aabb.h"
#include "core/math/vec.h"

namespace lightbatch::rays {

/// One way to build the hierarchy, measured.
struct ComparisonRow {
  hierarchy::Method method = hierarchy::Method::kSweep;
  std::string name;
  double build_seconds = 0;  // wall time
  double sah_cost = 0;       // single primitives at the leaves
  double sah_cost_merged = 0;
  double overlap = 0;  // effective partial overlap
  double void_area = 0;
  int depth = 0;
  double rays_per_second = 0;       // any-hit between random surface points, one thread
  double grid_rays_per_second = 0;  // the same with regular grids as high in the tree as they go
};

struct CompareOptions {
  std::uint32_t rays = 100000;
  std::uint32_t overlap_samples = 20000;
  std::uint64_t seed = 1;
};

/// Builds and measures the scene's hierarchy in every way of hierarchy::Method; ways that have no
/// tree of bounded depth for the input are left out. boxes[i] bounds triangles[i]; objects as in
/// hierarchy::build_with.
std::vector<ComparisonRow> compare(std::span<const Aabb> boxes, std::span<const Vec3f> positions,
                                   std::span<const std::array<std::uint32_t, 3>> triangles,
                                   std::span<const std::uint32_t> objects,
                                   const CompareOptions& options = {});

}  // namespace lightbatch::rays
