#include <algorithm>
#include <cmath>
#include <map>

#include "core/batches/assignment.h"

namespace lightbatch::batches {

KeyMap map_keys(const scene::Scene& scene, const BatchOptions& options) {
  KeyMap result;
  const auto key_of = [&](std::uint32_t triangle) {
    const std::uint32_t object = scene.triangles[triangle].object;
    Key key;
    key.material = scene.objects[object].material;
    if (is_blended(scene, object)) key.object = object;
    if (!options.traits.empty()) {
      key.layout = options.traits[object].layout;
      if (const std::uint32_t m = options.traits[object].material_class; m != scene::kNone)
        key.material = m;
    }
    if (!options.page_of_triangle.empty()) key.page = options.page_of_triangle[triangle];
    return key;
  };
  std::map<Key, std::uint32_t> ids;
  const auto count = static_cast<std::uint32_t>(scene.triangles.size());
  Key last;
  for (std::uint32_t i = 0; i < count; ++i) {
    const Key key = key_of(i);
    if (i > 0 && key == last) continue;
    ids.emplace(key, 0);
    last = key;
  }
  for (auto& [key, id] : ids) {
    id = static_cast<std::uint32_t>(result.keys.size());
    result.keys.push_back(key);
  }
  result.of_triangle.resize(count);
  std::uint32_t last_id = 0;
  for (std::uint32_t i = 0; i < count; ++i) {
    const Key key = key_of(i);
    if (i == 0 || key != last) last_id = ids.at(key);
    result.of_triangle[i] = last_id;
    last = key;
  }

  std::vector<std::uint32_t> seen(scene.positions.size(), scene::kNone);
  result.vertices_of_object.resize(scene.objects.size());
  for (std::uint32_t o = 0; o < scene.objects.size(); ++o) {
    const scene::Object& object = scene.objects[o];
    std::uint64_t vertices = 0;
    for (std::uint32_t t = 0; t < object.triangle_count; ++t)
      for (const std::uint32_t v : scene.triangles[object.first_triangle + t].vertex)
        if (seen[v] != o) {
          seen[v] = o;
          ++vertices;
        }
    result.vertices_of_object[o] =
        static_cast<double>(vertices) / std::max(1.0, static_cast<double>(object.triangle_count));
  }
  return result;
}

Frame frame_of(const Share& share, const Chance& chance, std::uint32_t max_vertices) {
  const double calls = std::max(1.0, std::ceil(share.vertices / max_vertices));
  Frame frame;
  frame.draws = chance.any * calls;
  frame.inside_draws = chance.inside * calls;
  frame.vertices = chance.any * share.vertices;
  frame.triangles = chance.any * static_cast<double>(share.triangles);
  return frame;
}

}  // namespace lightbatch::batches
