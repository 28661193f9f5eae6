#include "core/pipeline/boxes_glb.h"

#include <array>
#include <cstdint>
#include <cstring>

#include "core/gltf/glb_writer.h"

namespace lightbatch::pipeline {
namespace {

using gltf::Json;

constexpr std::array<std::array<std::uint32_t, 2>, 12> kEdges{{{0, 1},
                                                               {2, 3},
                                                               {4, 5},
                                                               {6, 7},
                                                               {0, 2},
                                                               {1, 3},
                                                               {4, 6},
                                                               {5, 7},
                                                               {0, 4},
                                                               {1, 5},
                                                               {2, 6},
                                                               {3, 7}}};

template <typename T>
std::size_t append(Bytes& binary, const std::vector<T>& values) {
  const std::size_t offset = binary.size();
  const std::size_t size = values.size() * sizeof(T);
  binary.resize(offset + size);
  std::memcpy(binary.data() + offset, values.data(), size);
  return offset;
}

}  // namespace

Result<Bytes> boxes_glb(std::span<const BoxLevel> levels, const Vec3d& origin) {
  Json json;
  json["asset"] = {{"version", "2.0"}, {"generator", "lightbatch"}};
  json["scene"] = 0;
  Json roots = Json::array();
  Bytes binary;
  for (const BoxLevel& level : levels) {
    if (level.boxes.empty()) continue;
    std::vector<float> positions;
    std::vector<std::uint32_t> indices;
    Aabb all;
    for (const Aabb& box : level.boxes) {
      const auto first = static_cast<std::uint32_t>(positions.size() / 3);
      all.add(box);
      for (int corner = 0; corner < 8; ++corner) {
        positions.push_back(corner & 1 ? box.upper.x : box.lower.x);
        positions.push_back(corner & 2 ? box.upper.y : box.lower.y);
        positions.push_back(corner & 4 ? box.upper.z : box.lower.z);
      }
      for (const auto& edge : kEdges) {
        indices.push_back(first + edge[0]);
        indices.push_back(first + edge[1]);
      }
    }
    const auto view = [&](std::size_t offset, std::size_t bytes, int target) {
      json["bufferViews"].push_back(
          {{"buffer", 0}, {"byteOffset", offset}, {"byteLength", bytes}, {"target", target}});
      return json["bufferViews"].size() - 1;
    };
    const std::size_t position_view =
        view(append(binary, positions), positions.size() * sizeof(float), 34962);
    const std::size_t index_view =
        view(append(binary, indices), indices.size() * sizeof(std::uint32_t), 34963);
    const std::size_t position = json["accessors"].size();
    json["accessors"].push_back({{"bufferView", position_view},
                                 {"componentType", 5126},
                                 {"count", positions.size() / 3},
                                 {"type", "VEC3"},
                                 {"min", {all.lower.x, all.lower.y, all.lower.z}},
                                 {"max", {all.upper.x, all.upper.y, all.upper.z}}});
    json["accessors"].push_back({{"bufferView", index_view},
                                 {"componentType", 5125},
                                 {"count", indices.size()},
                                 {"type", "SCALAR"}});
    const std::string name = "level " + std::to_string(level.level);
    roots.push_back(json["nodes"].size());
    json["nodes"].push_back({{"name", name},
                             {"mesh", json["meshes"].size()},
                             {"translation", {origin.x, origin.y, origin.z}}});
    json["meshes"].push_back({{"name", name},
                              {"primitives", Json::array({{{"attributes", {{"POSITION", position}}},
                                                           {"indices", position + 1},
                                                           {"mode", 1}}})}});
  }
  json["scenes"] = Json::array({Json::object()});
  if (!roots.empty()) {
    json["scenes"][0]["nodes"] = roots;
    json["buffers"] = Json::array({{{"byteLength", binary.size()}}});
  }
  return gltf::write_glb(std::move(json), binary);
}

}  // namespace lightbatch::pipeline
