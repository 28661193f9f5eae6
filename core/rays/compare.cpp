#include "core/rays/compare.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <optional>

#include "core/base/random.h"
#include "core/hierarchy/statistics.h"
#include "core/rays/caster.h"

namespace lightbatch::rays {
namespace {

constexpr int kBuilds = 3;
using Clock = std::chrono::steady_clock;
double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

std::vector<Segment> surface_pairs(std::span<const Vec3f> positions,
                                   std::span<const std::array<std::uint32_t, 3>> triangles,
                                   const CompareOptions& options) {
  const auto corner = [&](std::uint32_t t, std::size_t k) {
    return to_double(positions[triangles[t][k]]);
  };
  std::vector<double> sums;
  double total = 0;
  for (std::uint32_t t = 0; t < triangles.size(); ++t) {
    total += length(cross(corner(t, 1) - corner(t, 0), corner(t, 2) - corner(t, 0)));
    sums.push_back(total);
  }
  std::vector<Segment> segments;
  if (!(total > 0)) return segments;
  for (std::uint32_t i = 0; i < options.rays; ++i) {
    Random random(item_seed(options.seed, i));
    const auto pick = [&](std::uint32_t& t) {
      const auto found = std::upper_bound(sums.begin(), sums.end(), random.next_double() * total);
      t = static_cast<std::uint32_t>(
          std::min<std::ptrdiff_t>(found - sums.begin(), std::ssize(sums) - 1));
      const double q = std::sqrt(random.next_double()), r = random.next_double();
      return to_float(corner(t, 0) * (1 - q) + corner(t, 1) * (q * (1 - r)) +
                      corner(t, 2) * (q * r));
    };
    Segment s{};
    const Vec3f a = pick(s.exclude_a), b = pick(s.exclude_b);
    s.ray = {a, b - a, 0, 1};
    segments.push_back(s);
  }
  return segments;
}

}  // namespace

std::vector<ComparisonRow> compare(std::span<const Aabb> boxes, std::span<const Vec3f> positions,
                                   std::span<const std::array<std::uint32_t, 3>> triangles,
                                   std::span<const std::uint32_t> objects,
                                   const CompareOptions& options) {
  const std::vector<Segment> segments = surface_pairs(positions, triangles, options);
  std::vector<ComparisonRow> rows;
  for (const hierarchy::Method method : hierarchy::kMethods) {
    std::optional<hierarchy::Hierarchy> tree;
    ComparisonRow row;
    row.build_seconds = std::numeric_limits<double>::infinity();
    // Fresh memory disturbs the first: the best of a few, where that is quick.
    const Clock::time_point first = Clock::now();
    for (int run = 0; run < kBuilds && (run == 0 || seconds_since(first) < 1); ++run) {
      const Clock::time_point begin = Clock::now();
      tree = hierarchy::build_with(method, boxes, objects);
      row.build_seconds = std::min(row.build_seconds, seconds_since(begin));
    }
    if (!tree) continue;
    row.method = method;
    row.name = hierarchy::method_name(method);
    const hierarchy::Statistics s = measure(*tree);
    row.sah_cost = s.sah_cost;
    row.sah_cost_merged = s.sah_cost_merged;
    row.void_area = s.void_area;
    row.depth = s.depth;
    row.overlap = effective_partial_overlap(*tree, positions, triangles, options.overlap_samples,
                                            options.seed);
    const auto rate = [&](Grids grids) {
      const Caster caster(*tree, positions, triangles, {}, grids);
      const Clock::time_point start = Clock::now();
      for (const Segment& segment : segments) {
        caster.occluded(segment.ray, segment.exclude_a, segment.exclude_b);
      }
      const double spent = seconds_since(start);
      return spent > 0 ? static_cast<double>(segments.size()) / spent : 0.0;
    };
    row.rays_per_second = rate(Grids::kWhereCheaper);
    row.grid_rays_per_second = rate(Grids::kEverywhere);
    rows.push_back(std::move(row));
  }
  return rows;
}

}  // namespace lightbatch::rays
