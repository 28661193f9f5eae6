#include "core/atlas/weld.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <tuple>

#include "core/base/random.h"

namespace lightbatch::atlas {
namespace {

using scene::kNone;

/// Open-addressing table from the bits of a position to its index.
class PointTable {
 public:
  PointTable(std::size_t capacity, std::vector<Vec3d>& points)
      : points_(points), slots_(std::bit_ceil(2 * capacity + 1), kNone) {}

  std::uint32_t index_of(const Vec3f& position) {
    const Vec3f p{position.x + 0.0f, position.y + 0.0f, position.z + 0.0f};  // -0 becomes +0
    const std::uint64_t xy =
        std::uint64_t{std::bit_cast<std::uint32_t>(p.x)} << 32 | std::bit_cast<std::uint32_t>(p.y);
    const std::size_t mask = slots_.size() - 1;
    std::size_t at = mix_bits(mix_bits(xy) ^ std::bit_cast<std::uint32_t>(p.z)) & mask;
    const Vec3d wide = to_double(p);
    while (slots_[at] != kNone && points_[slots_[at]] != wide) at = (at + 1) & mask;
    if (slots_[at] == kNone) {
      slots_[at] = static_cast<std::uint32_t>(points_.size());
      points_.push_back(wide);
    }
    return slots_[at];
  }

 private:
  std::vector<Vec3d>& points_;
  std::vector<std::uint32_t> slots_;
};

void add_triangles(const scene::Scene& scene, std::span<const std::uint32_t> triangles,
                   Mesh& mesh) {
  PointTable table(triangles.size() * 3 / 2 + 8, mesh.points);
  std::uint32_t lowest = std::numeric_limits<std::uint32_t>::max(), highest = 0;
  for (const std::uint32_t t : triangles) {
    for (const std::uint32_t v : scene.triangles[t].vertex) {
      lowest = std::min(lowest, v);
      highest = std::max(highest, v);
    }
  }
  // Vertices of one node are usually one run: remember what each was welded to.
  const std::size_t range = triangles.empty() ? 0 : std::size_t{highest} - lowest + 1;
  std::vector<std::uint32_t> seen(range <= 12 * triangles.size() ? range : 0, kNone);

  mesh.corners.reserve(triangles.size());
  for (std::uint32_t i = 0; i < triangles.size(); ++i) {
    std::array<std::uint32_t, 3> corner{};
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t v = scene.triangles[triangles[i]].vertex[k];
      std::uint32_t* memo = seen.empty() ? nullptr : &seen[v - lowest];
      corner[k] = memo != nullptr && *memo != kNone ? *memo : table.index_of(scene.positions[v]);
      if (memo != nullptr) *memo = corner[k];
    }
    const Vec3d &a = mesh.points[corner[0]], &b = mesh.points[corner[1]],
                &c = mesh.points[corner[2]];
    const Vec3d twice = cross(b - a, c - a);
    const double size = length(twice);
    if (!(size > 0)) continue;
    mesh.corners.push_back(corner);
    mesh.source.push_back(i);
    mesh.normals.push_back(twice / size);
    mesh.areas.push_back(size / 2);
  }
}

void add_slack(Mesh& mesh) {
  double reach = 0;
  for (const Vec3d& p : mesh.points) {
    reach = std::max({reach, std::abs(p.x), std::abs(p.y), std::abs(p.z)});
  }
  const double rounding = reach * 0x1p-24;  // what storing a corner as float may move it, per axis
  mesh.slack.reserve(mesh.size());
  for (std::uint32_t t = 0; t < mesh.size(); ++t) {
    const auto& [i, j, k] = mesh.corners[t];
    const Vec3d &a = mesh.points[i], &b = mesh.points[j], &c = mesh.points[k];
    const double longest =
        std::sqrt(std::max({dot(b - a, b - a), dot(c - b, c - b), dot(a - c, a - c)}));
    const double height = 2 * mesh.areas[t] / longest;
    const double thin = height < 1e-5 * longest ? 1.0 : 0.0;
    mesh.slack.push_back(static_cast<float>(std::min(3.0, thin + 2 * rounding / height)));
  }
}

struct Side {
  std::uint32_t far = 0;  // larger point of the edge
  std::uint32_t half_edge = 0;
};

/// Pairs the sides of one edge; `forward` tells which run from the smaller point.
void pair_edge(std::span<const Side> sides, Mesh& mesh) {
  constexpr std::size_t kMaxSides = 32;
  if (sides.size() < 2 || sides.size() > kMaxSides) return;
  const auto forward = [&](std::uint32_t e) {
    return mesh.corners[e / 3][e % 3] < mesh.corners[e / 3][(e + 1) % 3];
  };
  const auto join = [&](std::uint32_t a, std::uint32_t b) {
    mesh.twin[a] = b;
    mesh.twin[b] = a;
  };
  if (sides.size() == 2) {
    if (forward(sides[0].half_edge) != forward(sides[1].half_edge)) {
      join(sides[0].half_edge, sides[1].half_edge);
    }
    return;
  }
  std::vector<std::tuple<double, std::uint32_t, std::uint32_t>> pairs;  // fold, sides
  for (const Side& a : sides) {
    for (const Side& b : sides) {
      if (!forward(a.half_edge) || forward(b.half_edge)) continue;
      const double cosine = dot(mesh.normals[a.half_edge / 3], mesh.normals[b.half_edge / 3]);
      pairs.emplace_back(-cosine, a.half_edge, b.half_edge);
    }
  }
  std::sort(pairs.begin(), pairs.end());
  for (const auto& [fold, a, b] : pairs) {
    if (mesh.twin[a] == kNone && mesh.twin[b] == kNone) join(a, b);
  }
}

void pair_edges(Mesh& mesh) {
  const std::uint32_t half_edges = 3 * mesh.size();
  mesh.twin.assign(half_edges, kNone);
  std::vector<std::uint32_t> first(mesh.points.size() + 1, 0);
  const auto ends = [&](std::uint32_t e) {
    return std::minmax(mesh.corners[e / 3][e % 3], mesh.corners[e / 3][(e + 1) % 3]);
  };
  for (std::uint32_t e = 0; e < half_edges; ++e) ++first[ends(e).first + 1];
  for (std::size_t p = 1; p < first.size(); ++p) first[p] += first[p - 1];
  std::vector<Side> sides(half_edges);
  std::vector<std::uint32_t> next(first.begin(), first.end() - 1);
  for (std::uint32_t e = 0; e < half_edges; ++e) {
    const auto [low, high] = ends(e);
    sides[next[low]++] = {high, e};
  }
  for (std::size_t p = 0; p + 1 < first.size(); ++p) {
    const auto begin = sides.begin() + first[p], end = sides.begin() + first[p + 1];
    std::sort(begin, end, [](const Side& a, const Side& b) {
      return std::tie(a.far, a.half_edge) < std::tie(b.far, b.half_edge);
    });
    for (auto run = begin; run != end;) {
      const auto stop = std::find_if(run, end, [&](const Side& s) { return s.far != run->far; });
      pair_edge(std::span(run, stop), mesh);
      run = stop;
    }
  }
}

}  // namespace

Mesh weld(const scene::Scene& scene, std::span<const std::uint32_t> triangles) {
  Mesh mesh;
  add_triangles(scene, triangles, mesh);
  add_slack(mesh);
  pair_edges(mesh);
  return mesh;
}

}  // namespace lightbatch::atlas
