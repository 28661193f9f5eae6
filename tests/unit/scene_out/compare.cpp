#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <unordered_map>

#include "core/scene_out/source_mesh.h"
#include "tests/unit/scene_out/files.h"

namespace lightbatch::scene_out::testing {

namespace {

/// COLOR_0 at the first corner of triangles, primitive by primitive; white where there is none.
class Colours {
 public:
  explicit Colours(const gltf::Document& document) : document_(document), sources_(document) {}
  Rgb at(const scene::Object& object, std::uint32_t triangle) {
    const Json& primitive =
        document_.json["meshes"][object.mesh]["primitives"][object.primitive]["attributes"];
    if (!primitive.contains("COLOR_0")) return {1, 1, 1};
    auto& values = values_[{object.mesh, object.primitive}];
    if (values.data.empty())
      values = *gltf::read_values(document_, primitive["COLOR_0"].get<std::uint32_t>());
    const SourcePrimitive& source = **sources_.get(object.mesh, object.primitive);
    const float* v = values.data.data() + source.corners[3 * std::size_t{triangle}] *
                                              static_cast<std::size_t>(values.components);
    return {v[0], v[1], v[2]};
  }

 private:
  const gltf::Document& document_;
  SourceMeshes sources_;
  std::map<std::pair<std::uint32_t, std::uint32_t>, gltf::Values> values_;
};

std::string look_of(const scene::Material& m, const Rgb& colour) {
  char text[200];
  const Rgb base = m.base_color * colour;
  std::snprintf(text, sizeof text, "%.4f %.4f %.4f %.4f m%.3f t%u e%.3g/%u a%d/%.2f %d%d",
                static_cast<double>(base.r), static_cast<double>(base.g),
                static_cast<double>(base.b), static_cast<double>(m.alpha),
                static_cast<double>(m.metallic), m.base_color_texture.image,
                static_cast<double>(luminance(m.emission)), m.emission_texture.image,
                static_cast<int>(m.alpha_mode), static_cast<double>(m.alpha_cutoff),
                m.double_sided ? 1 : 0, m.unlit ? 1 : 0);
  return text;
}

}  // namespace

std::vector<WorldTriangle> world_triangles(const Loaded& file) {
  const scene::Scene& scene = file.scene;
  Colours colours(file.document);
  std::vector<WorldTriangle> result;
  result.reserve(scene.triangles.size());
  for (std::uint32_t t = 0; t < scene.triangles.size(); ++t) {
    WorldTriangle w;
    const auto corners = scene.corners(t);
    for (std::size_t c = 0; c < 3; ++c) w.corner[c] = scene.origin + to_double(corners[c]);
    const scene::Triangle& triangle = scene.triangles[t];
    w.material =
        look_of(scene.material_of(t), colours.at(scene.objects[triangle.object], triangle.source));
    result.push_back(std::move(w));
  }
  return result;
}

double largest_distance(const std::vector<WorldTriangle>& a, const std::vector<WorldTriangle>& b,
                        double reach) {
  constexpr double kNone = std::numeric_limits<double>::infinity();
  if (a.size() != b.size()) return kNone;
  // Cells of twice the reach by centroid: a partner lies in one of eight.
  const auto cell = [&](const Vec3d& p, int dx, int dy, int dz) {
    const auto at = [&](double v, int d) {
      return static_cast<std::int64_t>(std::floor(v / (2 * reach) + 0.5 * d));
    };
    std::uint64_t h = 0;
    for (const std::int64_t v : {at(p.x, dx), at(p.y, dy), at(p.z, dz)})
      h = (h ^ static_cast<std::uint64_t>(v)) * 0x9e3779b97f4a7c15ULL + 1;
    return h;
  };
  const auto centroid = [](const WorldTriangle& t) {
    return (t.corner[0] + t.corner[1] + t.corner[2]) / 3.0;
  };
  std::unordered_multimap<std::uint64_t, std::uint32_t> table;
  for (std::uint32_t i = 0; i < b.size(); ++i) table.emplace(cell(centroid(b[i]), 0, 0, 0), i);
  std::vector<bool> taken(b.size(), false);
  double largest = 0;
  for (const WorldTriangle& t : a) {
    double best = reach;
    std::uint32_t partner = scene::kNone;
    std::vector<std::uint64_t> looked;
    for (int dx = -1; dx <= 1; ++dx)
      for (int dy = -1; dy <= 1; ++dy)
        for (int dz = -1; dz <= 1; ++dz) {
          const std::uint64_t h = cell(centroid(t), dx, dy, dz);
          if (std::find(looked.begin(), looked.end(), h) != looked.end()) continue;
          looked.push_back(h);
          const auto [first, last] = table.equal_range(h);
          for (auto it = first; it != last; ++it) {
            const WorldTriangle& other = b[it->second];
            if (taken[it->second] || other.material != t.material) continue;
            for (std::size_t shift = 0; shift < 3; ++shift) {
              double distance = 0;
              for (std::size_t c = 0; c < 3; ++c)
                distance = std::max(distance, length(t.corner[c] - other.corner[(c + shift) % 3]));
              if (distance < best || (distance == best && partner == scene::kNone)) {
                best = distance;
                partner = it->second;
              }
            }
          }
        }
    if (partner == scene::kNone) return kNone;
    taken[partner] = true;
    largest = std::max(largest, best);
  }
  return largest;
}

}  // namespace lightbatch::scene_out::testing
