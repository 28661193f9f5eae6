#include "core/scene_in/place.h"

#include <algorithm>
#include <cmath>

#include "core/base/parallel.h"

namespace lightbatch::scene_in {
namespace {

/// A triangle is collinear when its height is below this part of its longest edge: a float
/// coordinate's own rounding.
constexpr double kCollinear = 1e-7;

/// Blocks of this many triangles or vertices; large enough to hide the cost of a task.
constexpr std::size_t kGrain = 16384;

bool has_area(const Vec3f& a, const Vec3f& b, const Vec3f& c) {
  const Vec3d e0 = to_double(b) - to_double(a);
  const Vec3d e1 = to_double(c) - to_double(a);
  const Vec3d e2 = to_double(c) - to_double(b);
  const double longest = std::max(dot(e0, e0), std::max(dot(e1, e1), dot(e2, e2)));
  const double limit = kCollinear * longest;
  const Vec3d normal = cross(e0, e1);
  return longest > 0 && dot(normal, normal) > limit * limit;
}

/// A piece of one placement's vertices or triangles: the unit of parallel work.
struct Piece {
  std::uint32_t placement = 0;
  std::uint32_t begin = 0;
  std::uint32_t end = 0;
};

template <typename Size>
std::vector<Piece> cut(const std::vector<Placement>& placements, Size size_of) {
  std::vector<Piece> pieces;
  for (std::uint32_t p = 0; p < placements.size(); ++p) {
    const std::size_t size = size_of(p);
    for (std::size_t begin = 0; begin < size; begin += kGrain) {
      pieces.push_back({p, static_cast<std::uint32_t>(begin),
                        static_cast<std::uint32_t>(std::min(size, begin + kGrain))});
    }
  }
  return pieces;
}

}  // namespace

Result<Vec3d> choose_origin(const std::vector<Placement>& placements,
                            const std::vector<Primitive>& primitives, const std::string& file) {
  Aabbd box;
  for (const Placement& placement : placements) {
    const Aabb& local = primitives[placement.primitive].box;
    if (local.is_empty()) continue;
    for (unsigned k = 0; k < 8; ++k) {
      box.add(placement.object.to_world.point(to_double(local.corner(k))));
    }
  }
  if (box.is_empty()) return Vec3d{};
  const double size = box.diagonal();
  if (!std::isfinite(size) || size > kLargestScene || !is_finite(box.centre())) {
    return malformed(file, "the scene is larger than 1e15 metres or not finite");
  }
  const double grid = std::ldexp(1.0, std::max(-300, std::ilogb(std::max(size, 1e-300)) - 3));
  const Vec3d centre = box.centre();
  return Vec3d{std::round(centre.x / grid) * grid, std::round(centre.y / grid) * grid,
               std::round(centre.z / grid) * grid};
}

void place_objects(const std::vector<Placement>& placements,
                   const std::vector<Primitive>& primitives, bool uv0, bool uv1,
                   scene::Scene& scene) {
  const auto primitive_of = [&](std::uint32_t p) -> const Primitive& {
    return primitives[placements[p].primitive];
  };
  // Vertices: each placement its own, in order.
  std::vector<std::uint32_t> first_vertex(placements.size() + 1, 0);
  for (std::uint32_t p = 0; p < placements.size(); ++p) {
    first_vertex[p + 1] =
        first_vertex[p] + static_cast<std::uint32_t>(primitive_of(p).positions.size());
  }
  scene.positions.resize(first_vertex.back());
  if (uv0) scene.uv0.resize(first_vertex.back());
  if (uv1) scene.uv1.resize(first_vertex.back());
  const bool coloured = std::any_of(primitives.begin(), primitives.end(),
                                    [](const Primitive& p) { return !p.colors.empty(); });
  if (coloured) scene.colors.resize(first_vertex.back());
  const std::vector<Piece> vertex_pieces =
      cut(placements, [&](std::uint32_t p) { return primitive_of(p).positions.size(); });
  parallel_for(vertex_pieces.size(), 1, [&](std::size_t first, std::size_t last) {
    for (std::size_t i = first; i < last; ++i) {
      const Piece& piece = vertex_pieces[i];
      const Primitive& primitive = primitive_of(piece.placement);
      // Far from zero, digits are lost by adding the translation: take the origin off it first.
      Affine world = placements[piece.placement].object.to_world;
      world.t = world.t - scene.origin;
      const std::size_t base = first_vertex[piece.placement];
      for (std::size_t v = piece.begin; v < piece.end; ++v) {
        scene.positions[base + v] = to_float(world.point(to_double(primitive.positions[v])));
        if (uv0 && !primitive.uv0.empty()) scene.uv0[base + v] = primitive.uv0[v];
        if (uv1 && !primitive.uv1.empty()) scene.uv1[base + v] = primitive.uv1[v];
        if (!primitive.colors.empty()) scene.colors[base + v] = primitive.colors[v];
      }
    }
  });

  // Triangles: count those with an area, then write each piece where it belongs.
  const std::vector<Piece> pieces =
      cut(placements, [&](std::uint32_t p) { return primitive_of(p).triangles.size(); });
  const auto keep = [&](const Piece& piece, std::size_t t) {
    const auto& corners = primitive_of(piece.placement).triangles[t];
    const std::size_t base = first_vertex[piece.placement];
    return has_area(scene.positions[base + corners[0]], scene.positions[base + corners[1]],
                    scene.positions[base + corners[2]]);
  };
  std::vector<std::uint32_t> kept(pieces.size(), 0);
  parallel_for(pieces.size(), 1, [&](std::size_t first, std::size_t last) {
    for (std::size_t i = first; i < last; ++i) {
      for (std::size_t t = pieces[i].begin; t < pieces[i].end; ++t) {
        kept[i] += keep(pieces[i], t) ? 1u : 0u;
      }
    }
  });

  std::vector<std::uint32_t> triangles_of(placements.size(), 0);
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    triangles_of[pieces[i].placement] += kept[i];
    scene.counts.zero_area_triangles += pieces[i].end - pieces[i].begin - kept[i];
  }
  std::vector<std::uint32_t> object_of(placements.size(), scene::kNone);
  std::uint32_t total = 0;
  for (std::uint32_t p = 0; p < placements.size(); ++p) {
    if (triangles_of[p] == 0) continue;
    object_of[p] = static_cast<std::uint32_t>(scene.objects.size());
    scene::Object& object = scene.objects.emplace_back(placements[p].object);
    object.first_triangle = total;
    object.triangle_count = triangles_of[p];
    total += triangles_of[p];
  }
  std::vector<std::uint32_t> offset(pieces.size() + 1, 0);
  for (std::size_t i = 0; i < pieces.size(); ++i) offset[i + 1] = offset[i] + kept[i];
  scene.triangles.resize(total);
  parallel_for(pieces.size(), 1, [&](std::size_t first, std::size_t last) {
    for (std::size_t i = first; i < last; ++i) {
      const Piece& piece = pieces[i];
      const Primitive& primitive = primitive_of(piece.placement);
      const std::uint32_t base = first_vertex[piece.placement];
      const bool mirrored = placements[piece.placement].object.mirrored;
      std::uint32_t out = offset[i];
      for (std::size_t t = piece.begin; t < piece.end; ++t) {
        if (!keep(piece, t)) continue;
        const auto& corners = primitive.triangles[t];
        scene::Triangle& triangle = scene.triangles[out++];
        triangle.vertex = {base + corners[0], base + corners[mirrored ? 2 : 1],
                           base + corners[mirrored ? 1 : 2]};
        triangle.object = object_of[piece.placement];
        triangle.source = static_cast<std::uint32_t>(t);
      }
    }
  });
  for (const Vec3f& position : scene.positions) scene.box.add(position);
}

}  // namespace lightbatch::scene_in
