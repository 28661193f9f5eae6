#include "core/atlas/shapes.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <utility>

namespace lightbatch::atlas {
namespace {

using scene::kNone;

/// The objects of one node and GPU instance.
struct Unit {
  std::vector<std::uint32_t> objects;
  std::vector<std::uint32_t> triangles;  // lit ones, by object, in source order
};

std::vector<Unit> find_units(const scene::Scene& scene, const std::vector<std::uint8_t>& lit) {
  std::vector<Unit> units;
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::size_t> of_node;
  for (std::uint32_t o = 0; o < scene.objects.size(); ++o) {
    const scene::Object& object = scene.objects[o];
    std::size_t unit = units.size();
    if (object.node != kNone) {
      unit = of_node.try_emplace({object.node, object.instance}, unit).first->second;
    }
    if (unit == units.size()) units.emplace_back();
    units[unit].objects.push_back(o);
    for (std::uint32_t i = 0; i < object.triangle_count; ++i) {
      const std::uint32_t t = object.first_triangle + i;
      if (lit[t] != 0) units[unit].triangles.push_back(t);
    }
  }
  std::erase_if(units, [](const Unit& u) { return u.triangles.empty(); });
  return units;
}

/// What a unit shows: equal keys are candidates for one shape. Empty: cannot be shared.
std::vector<std::uint32_t> content_key(const scene::Scene& scene, const Unit& unit) {
  std::vector<std::uint32_t> key;
  for (const std::uint32_t o : unit.objects) {
    if (scene.objects[o].mesh == kNone) return {};
    key.push_back(scene.objects[o].mesh);
    key.push_back(scene.objects[o].primitive);
  }
  return key;
}

std::optional<Affine> inverse(const Affine& m) {
  const double det = m.determinant();
  if (!(std::abs(det) > 0) || !std::isfinite(1 / det)) return std::nullopt;
  const Vec3d a = cross(m.y, m.z) / det, b = cross(m.z, m.x) / det, c = cross(m.x, m.y) / det;
  Affine inv{{a.x, b.x, c.x}, {a.y, b.y, c.y}, {a.z, b.z, c.z}, {}};
  inv.t = -inv.vector(m.t);
  return inv;
}

/// Uniform scale of a similarity (rotation, mirroring, scale), or nothing for any other transform.
std::optional<double> similarity_scale(const Affine& m) {
  const double x = length(m.x), y = length(m.y), z = length(m.z);
  const double size = std::cbrt(x * y * z);
  constexpr double kSlack = 1e-4;
  if (!(size > 0) || !std::isfinite(size)) return std::nullopt;
  for (const double axis : {x, y, z}) {
    if (std::abs(axis / size - 1) > kSlack) return std::nullopt;
  }
  const double skew =
      std::max({std::abs(dot(m.x, m.y)), std::abs(dot(m.y, m.z)), std::abs(dot(m.z, m.x))});
  if (skew > kSlack * size * size) return std::nullopt;
  return size;
}

/// Object within its unit and place in the primitive: names a triangle in every use of the mesh.
std::pair<std::uint32_t, std::uint32_t> triangle_name(const scene::Scene& scene,
                                                      std::uint32_t triangle) {
  const scene::Triangle& t = scene.triangles[triangle];
  return {scene.objects[t.object].primitive, t.source};
}

/// The positions of both triangles agree under the transform, to rounding.
bool same_place(const scene::Scene& scene, const Affine& move, double slack, std::uint32_t from,
                std::uint32_t to, const std::array<std::uint8_t, 3>& order) {
  const auto a = scene.corners(from), b = scene.corners(to);
  for (std::size_t k = 0; k < 3; ++k) {
    if (!(length(move.point(to_double(a[k])) - to_double(b[order[k]])) <= slack)) return false;
  }
  return true;
}

/// The order of corners in which all triangles of the instance lie where they should.
bool find_order(const scene::Scene& scene, const Shape& shape, double slack, Instance& use) {
  constexpr std::array<std::array<std::uint8_t, 3>, 4> kOrders{
      {{0, 1, 2}, {0, 2, 1}, {2, 1, 0}, {1, 0, 2}}};
  for (const auto& order : kOrders) {
    bool fits = true;
    for (std::size_t i = 0; i < use.triangles.size() && fits; ++i) {
      fits = use.triangles[i] == kNone ||
             same_place(scene, use.move, slack, shape.triangles[i], use.triangles[i], order);
    }
    if (!fits) continue;
    use.order = order;
    return true;
  }
  return false;
}

/// Tries to see `unit` as a use of `shape`; triangles without a partner are returned in `rest`.
std::optional<Instance> as_instance(const scene::Scene& scene, const Shape& shape,
                                    const Affine& frame, const Unit& unit,
                                    std::vector<std::uint32_t>& rest) {
  const std::optional<Affine> back = inverse(shape.frame);
  if (!back) return std::nullopt;
  Affine move = frame * *back;
  const std::optional<double> scale = similarity_scale(move);
  if (!scale) return std::nullopt;
  move.t = move.point(scene.origin) - scene.origin;  // positions have the origin taken off
  const Vec3d size = to_double(scene.box.extent());
  const double slack = 1e-5 * length(size) + 1e-6 * length(to_double(scene.box.upper));

  Instance use;
  use.scale = *scale;
  use.move = move;
  use.triangles.assign(shape.triangles.size(), kNone);
  std::size_t i = 0;
  for (const std::uint32_t t : unit.triangles) {
    const auto name = triangle_name(scene, t);
    while (i < shape.triangles.size() && triangle_name(scene, shape.triangles[i]) < name) ++i;
    if (i < shape.triangles.size() && triangle_name(scene, shape.triangles[i]) == name) {
      use.triangles[i++] = t;
    } else {
      rest.push_back(t);
    }
  }
  // A use that shares little is better charted alone.
  if (rest.size() * 16 > unit.triangles.size()) return std::nullopt;
  if (!find_order(scene, shape, slack, use)) return std::nullopt;
  return use;
}

Shape own_shape(const Affine& frame, std::vector<std::uint32_t> triangles) {
  Shape shape;
  shape.frame = frame;
  shape.instances.push_back({1.0, {}, triangles, {0, 1, 2}});
  shape.triangles = std::move(triangles);
  return shape;
}

}  // namespace

std::vector<Shape> find_shapes(const scene::Scene& scene, const std::vector<std::uint8_t>& lit) {
  std::vector<Shape> shapes;
  // A key keeps at most this many different shapes to compare with.
  constexpr std::size_t kMaxCandidates = 8;
  std::map<std::vector<std::uint32_t>, std::vector<std::size_t>> known;
  for (Unit& unit : find_units(scene, lit)) {
    const Affine& frame = scene.objects[unit.objects.front()].to_world;
    const auto by_name = [&](std::uint32_t a, std::uint32_t b) {
      return triangle_name(scene, a) < triangle_name(scene, b);
    };
    const std::vector<std::uint32_t> key = content_key(scene, unit);
    bool placed = false;
    if (!key.empty() && std::is_sorted(unit.triangles.begin(), unit.triangles.end(), by_name)) {
      std::vector<std::size_t>& candidates = known[key];
      for (const std::size_t c : candidates) {
        std::vector<std::uint32_t> rest;
        std::optional<Instance> use = as_instance(scene, shapes[c], frame, unit, rest);
        if (!use) continue;
        shapes[c].instances.push_back(std::move(*use));
        if (!rest.empty()) shapes.push_back(own_shape(frame, std::move(rest)));
        placed = true;
        break;
      }
      if (!placed && candidates.size() < kMaxCandidates) candidates.push_back(shapes.size());
    }
    if (!placed) shapes.push_back(own_shape(frame, std::move(unit.triangles)));
  }
  return shapes;
}

}  // namespace lightbatch::atlas
