#include "core/scene_in/place.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/base/parallel.h"

namespace lightbatch::scene_in {
namespace {

/// A triangle is collinear when its height is below this part of its longest edge: a float
/// coordinate's own rounding.
constexpr double kCollinear = 1e-7;

/// Blocks of this many triangles or vertices; large enough to hide the cost of a task.
constexpr std::size_t kGrain = 16384;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

double largest_part(const Vec3d& v) {
  return std::max({std::fabs(v.x), std::fabs(v.y), std::fabs(v.z)});
}

/// Edges from one corner to the two others. What is longer than any scene may be counts as an area.
bool has_area(const Vec3d& edge0, const Vec3d& edge1) {
  const double size = std::max(largest_part(edge0), largest_part(edge1));
  if (size == 0) return false;
  if (!(size <= kLargestScene)) return true;
  const Vec3d e0 = edge0 / size, e1 = edge1 / size;
  if (!is_finite(e0) || !is_finite(e1)) return true;
  const Vec3d e2 = e1 - e0;
  const double longest = std::max(dot(e0, e0), std::max(dot(e1, e1), dot(e2, e2)));
  const double limit = kCollinear * longest;
  const Vec3d normal = cross(e0, e1);
  return dot(normal, normal) > limit * limit;
}

/// A piece of one placement's vertices or triangles: the unit of parallel work.
struct Piece {
  std::uint32_t placement = 0;
  std::uint32_t begin = 0;
  std::uint32_t end = 0;
  std::uint32_t first = 0;  // number of `begin` over all placements
};

template <typename Size>
std::vector<Piece> cut(const std::vector<Placement>& placements, Size size_of) {
  std::vector<Piece> pieces;
  std::uint32_t first = 0;
  for (std::uint32_t p = 0; p < placements.size(); ++p) {
    const std::size_t size = size_of(p);
    for (std::size_t begin = 0; begin < size; begin += kGrain) {
      pieces.push_back({p, static_cast<std::uint32_t>(begin),
                        static_cast<std::uint32_t>(std::min(size, begin + kGrain)),
                        first + static_cast<std::uint32_t>(begin)});
    }
    first += static_cast<std::uint32_t>(size);
  }
  return pieces;
}

class Placer {
 public:
  Placer(const std::vector<Placement>& placements, const std::vector<Primitive>& primitives,
         scene::Scene& scene)
      : placements_(placements), primitives_(primitives), scene_(scene) {
    pieces_ = cut(placements, [&](std::uint32_t p) { return primitive_of(p).triangles.size(); });
    if (!pieces_.empty()) {
      kept_.resize(pieces_.back().first + pieces_.back().end - pieces_.back().begin);
    }
    first_vertex_.resize(placements.size() + 1);
    for (std::uint32_t p = 0; p < placements.size(); ++p) {
      first_vertex_[p + 1] =
          first_vertex_[p] + static_cast<std::uint32_t>(primitive_of(p).positions.size());
    }
  }

  Status choose_origin(const std::string& file) {
    const std::vector<Aabbd> boxes = boxes_of_areas();
    Aabbd box;
    for (const Aabbd& part : boxes) box.add(part);
    if (box.is_empty()) return {};
    const double size = box.diagonal();
    if (!std::isfinite(size) || size > kLargestScene || !is_finite(box.centre())) {
      return malformed(file + "#/nodes/" + std::to_string(farthest_node(boxes)),
                       "the scene is larger than 1e15 metres or not finite; this node reaches "
                       "farthest: check its transform, those above it and its positions");
    }
    const double grid = std::ldexp(1.0, std::max(-300, std::ilogb(std::max(size, 1e-300)) - 3));
    const Vec3d centre = box.centre();
    scene_.origin = {std::round(centre.x / grid) * grid, std::round(centre.y / grid) * grid,
                     std::round(centre.z / grid) * grid};
    return {};
  }

  /// Each placement its own, in order.
  void place_vertices(bool uv0, bool uv1) {
    scene_.positions.resize(first_vertex_.back());
    if (uv0) scene_.uv0.resize(first_vertex_.back());
    if (uv1) scene_.uv1.resize(first_vertex_.back());
    const bool coloured = std::any_of(primitives_.begin(), primitives_.end(),
                                      [](const Primitive& p) { return !p.colors.empty(); });
    if (coloured) scene_.colors.resize(first_vertex_.back());
    const std::vector<Piece> pieces =
        cut(placements_, [&](std::uint32_t p) { return primitive_of(p).positions.size(); });
    parallel_for(pieces.size(), 1, [&](std::size_t first, std::size_t last) {
      for (std::size_t i = first; i < last; ++i) {
        const Piece& piece = pieces[i];
        const Primitive& primitive = primitive_of(piece.placement);
        // Far from zero, digits are lost by adding the translation: take the origin off it first.
        Affine world = placements_[piece.placement].object.to_world;
        world.t = world.t - scene_.origin;
        const std::size_t base = first_vertex_[piece.placement];
        for (std::size_t v = piece.begin; v < piece.end; ++v) {
          scene_.positions[base + v] = to_float(world.point(to_double(primitive.positions[v])));
          if (uv0 && !primitive.uv0.empty()) scene_.uv0[base + v] = primitive.uv0[v];
          if (uv1 && !primitive.uv1.empty()) scene_.uv1[base + v] = primitive.uv1[v];
          if (!primitive.colors.empty()) scene_.colors[base + v] = primitive.colors[v];
        }
      }
    });
  }

  /// Counts those with an area, then writes each piece where it belongs.
  void place_triangles() {
    std::vector<std::uint32_t> kept(pieces_.size(), 0);
    for_each_triangle([&](std::size_t i, std::size_t t, std::uint8_t& keep) {
      const Piece& piece = pieces_[i];
      const auto& corners = primitive_of(piece.placement).triangles[t];
      const auto corner = [&](std::size_t k) {
        return to_double(scene_.positions[first_vertex_[piece.placement] + corners[k]]);
      };
      // Positions are rounded: what had an area may have lost it.
      keep = keep != 0 && has_area(corner(1) - corner(0), corner(2) - corner(0)) ? 1 : 0;
      kept[i] += keep;
    });
    std::vector<std::uint32_t> triangles_of(placements_.size(), 0);
    std::vector<std::uint32_t> offset(pieces_.size() + 1, 0);
    for (std::size_t i = 0; i < pieces_.size(); ++i) {
      offset[i + 1] = offset[i] + kept[i];
      triangles_of[pieces_[i].placement] += kept[i];
      scene_.counts.zero_area_triangles += pieces_[i].end - pieces_[i].begin - kept[i];
    }
    std::vector<std::uint32_t> object_of(placements_.size(), scene::kNone);
    std::uint32_t total = 0;
    for (std::uint32_t p = 0; p < placements_.size(); ++p) {
      if (triangles_of[p] == 0) continue;
      object_of[p] = static_cast<std::uint32_t>(scene_.objects.size());
      scene::Object& object = scene_.objects.emplace_back(placements_[p].object);
      object.first_triangle = total;
      object.triangle_count = triangles_of[p];
      total += triangles_of[p];
    }
    scene_.triangles.resize(total);
    for_each_triangle([&](std::size_t i, std::size_t t, const std::uint8_t& keep) {
      if (keep == 0) return;
      const std::uint32_t placement = pieces_[i].placement;
      const auto& corners = primitive_of(placement).triangles[t];
      const std::uint32_t base = first_vertex_[placement];
      const bool mirrored = placements_[placement].object.mirrored;
      scene::Triangle& triangle = scene_.triangles[offset[i]++];
      triangle.vertex = {base + corners[0], base + corners[mirrored ? 2 : 1],
                         base + corners[mirrored ? 1 : 2]};
      triangle.object = object_of[placement];
      triangle.source = static_cast<std::uint32_t>(t);
    });
  }

  /// Takes out the vertices of dropped triangles: they may lie anywhere.
  void drop_unused_vertices() {
    if (scene_.counts.zero_area_triangles == 0) return;
    std::vector<std::uint32_t> number(scene_.positions.size(), scene::kNone);
    for (const scene::Triangle& triangle : scene_.triangles) {
      for (const std::uint32_t v : triangle.vertex) number[v] = 0;
    }
    std::uint32_t used = 0;
    for (std::uint32_t& n : number) {
      if (n != scene::kNone) n = used++;
    }
    const auto keep_used = [&](auto& values) {
      if (values.empty()) return;
      for (std::size_t v = 0; v < number.size(); ++v) {
        if (number[v] != scene::kNone) values[number[v]] = values[v];
      }
      values.resize(used);
    };
    keep_used(scene_.positions);
    keep_used(scene_.uv0);
    keep_used(scene_.uv1);
    keep_used(scene_.colors);
    for (scene::Triangle& triangle : scene_.triangles) {
      for (std::uint32_t& v : triangle.vertex) v = number[v];
    }
  }

 private:
  const Primitive& primitive_of(std::uint32_t placement) const {
    return primitives_[placements_[placement].primitive];
  }

  /// visit(piece, triangle of its primitive, whether it is kept)
  template <typename Visit>
  void for_each_triangle(Visit visit) {
    parallel_for(pieces_.size(), 1, [&](std::size_t first, std::size_t last) {
      for (std::size_t i = first; i < last; ++i) {
        for (std::size_t t = pieces_[i].begin; t < pieces_[i].end; ++t) {
          visit(i, t, kept_[pieces_[i].first + (t - pieces_[i].begin)]);
        }
      }
    });
  }

  /// World box of the triangles that have an area; these are kept.
  /// Of each piece.
  std::vector<Aabbd> boxes_of_areas() {
    std::vector<Aabbd> boxes(pieces_.size());
    for_each_triangle([&](std::size_t i, std::size_t t, std::uint8_t& keep) {
      const Primitive& primitive = primitive_of(pieces_[i].placement);
      const Affine& world = placements_[pieces_[i].placement].object.to_world;
      const auto& corners = primitive.triangles[t];
      const Vec3d a = to_double(primitive.positions[corners[0]]);
      const Vec3d e0 = world.vector(to_double(primitive.positions[corners[1]]) - a);
      const Vec3d e1 = world.vector(to_double(primitive.positions[corners[2]]) - a);
      keep = has_area(e0, e1) ? 1 : 0;
      if (keep == 0) return;
      const Vec3d at = world.point(a);
      for (const Vec3d& p : {at, at + e0, at + e1}) {
        boxes[i].add(is_finite(p) ? p : Vec3d{kInfinity, kInfinity, kInfinity});
      }
    });
    return boxes;
  }

  std::uint32_t farthest_node(const std::vector<Aabbd>& boxes) const {
    const auto reach = [](const Aabbd& box) {
      return box.is_empty() ? 0.0 : std::max(largest_part(box.lower), largest_part(box.upper));
    };
    const auto farthest = std::ranges::max_element(boxes, {}, reach);
    const auto piece = static_cast<std::size_t>(farthest - boxes.begin());
    return placements_[pieces_[piece].placement].object.node;
  }

  const std::vector<Placement>& placements_;
  const std::vector<Primitive>& primitives_;
  scene::Scene& scene_;
  std::vector<Piece> pieces_;       // of triangles
  std::vector<std::uint8_t> kept_;  // a triangle each, over all placements
  std::vector<std::uint32_t> first_vertex_;
};

}  // namespace

Status place_objects(const std::vector<Placement>& placements,
                     const std::vector<Primitive>& primitives, bool uv0, bool uv1,
                     const std::string& file, scene::Scene& scene) {
  Placer placer(placements, primitives, scene);
  LB_RETURN_IF_ERROR(placer.choose_origin(file));
  placer.place_vertices(uv0, uv1);
  placer.place_triangles();
  placer.drop_unused_vertices();
  for (const Vec3f& position : scene.positions) scene.box.add(position);
  return {};
}

}  // namespace lightbatch::scene_in
