#pragma once

#include <gtest/gtest.h>
#include <stdlib.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/bytes.h"
#include "core/gltf/document.h"
#include "core/gltf/glb_writer.h"

/// Small scenes built in code, written to a folder of their own that goes with the object.
namespace lightbatch::gltf {

class SceneFiles {
 public:
  SceneFiles() {
    // Memory rather than disk where there is such a folder: thousands of small files.
    const std::filesystem::path memory = "/dev/shm";
    const std::filesystem::path base =
        std::filesystem::exists(memory) ? memory : std::filesystem::temp_directory_path();
    std::string pattern = (base / "lightbatch-XXXXXX").string();
    folder_ = ::mkdtemp(pattern.data());
  }
  ~SceneFiles() { std::filesystem::remove_all(folder_); }
  SceneFiles(const SceneFiles&) = delete;
  SceneFiles& operator=(const SceneFiles&) = delete;

  void add(const std::string& name, std::span<const std::byte> bytes) {
    const std::filesystem::path path = folder_ / name;
    std::filesystem::create_directories(path.parent_path());
    // Not write_file(): thousands of small scenes need no flush to the disk.
    std::ofstream(path, std::ios::binary | std::ios::trunc)
        .write(reinterpret_cast<const char*>(bytes.data()),
               static_cast<std::streamsize>(bytes.size()));
    map_[name] = path;
  }
  void add(const std::string& name, std::string_view text) { add(name, as_bytes(text)); }
  const FileMap& map() const { return map_; }

  Result<Document> read(const std::string& main, const ReadLimits& limits = {}) const {
    return read_document(map_, main, limits);
  }

 private:
  std::filesystem::path folder_;
  FileMap map_;
};

/// A scene whose accessors are added from values, all in one binary buffer.
class SceneBuilder {
 public:
  SceneBuilder() {
    json["asset"] = {{"version", "2.0"}};
    json["scene"] = 0;
    json["scenes"] = Json::array({{{"nodes", Json::array({0})}}});
    json["nodes"] = Json::array({{{"mesh", 0}}});
  }

  template <typename T>
  std::size_t view(const std::vector<T>& values) {
    binary.resize((binary.size() + 3) / 4 * 4);
    const std::size_t offset = binary.size();
    binary.resize(offset + values.size() * sizeof(T));
    std::memcpy(binary.data() + offset, values.data(), values.size() * sizeof(T));
    json["bufferViews"].push_back(
        {{"buffer", 0}, {"byteOffset", offset}, {"byteLength", values.size() * sizeof(T)}});
    return json["bufferViews"].size() - 1;
  }
  template <typename T>
  std::size_t accessor(const std::vector<T>& values, const char* type, std::size_t components) {
    json["accessors"].push_back({{"bufferView", view(values)},
                                 {"componentType", component_type<T>()},
                                 {"count", values.size() / components},
                                 {"type", type}});
    return json["accessors"].size() - 1;
  }
  /// Sets an accessor's min and max to those of its values.
  void bound(std::size_t index, const std::vector<float>& values, std::size_t components) {
    std::vector<float> low(values.begin(),
                           values.begin() + static_cast<std::ptrdiff_t>(components));
    std::vector<float> high = low;
    for (std::size_t i = 0; i < values.size(); ++i) {
      low[i % components] = std::min(low[i % components], values[i]);
      high[i % components] = std::max(high[i % components], values[i]);
    }
    const auto finite = [](const std::vector<float>& bounds) {
      return std::all_of(bounds.begin(), bounds.end(), [](float v) { return std::isfinite(v); });
    };
    if (!finite(low) || !finite(high)) return;
    json["accessors"][index]["min"] = low;
    json["accessors"][index]["max"] = high;
  }
  /// A mesh of one primitive with the corners given; returns its index.
  std::size_t mesh(const std::vector<float>& positions, const std::vector<std::uint16_t>& indices) {
    const std::size_t position = accessor(positions, "VEC3", 3);
    bound(position, positions, 3);
    Json primitive = {{"attributes", {{"POSITION", position}}}};
    if (!indices.empty()) primitive["indices"] = accessor(indices, "SCALAR", 1);
    json["meshes"].push_back({{"primitives", Json::array({primitive})}});
    return json["meshes"].size() - 1;
  }
  /// The unit square in the xy plane, two triangles, front towards +z.
  std::size_t square() { return mesh({0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0}, {0, 1, 2, 0, 2, 3}); }
  Json& primitive() { return json["meshes"][0]["primitives"][0]; }

  Bytes glb() const {
    Json copy = json;
    if (!binary.empty() && !copy.contains("buffers")) {
      copy["buffers"] = Json::array({Json::object()});
    }
    auto bytes = write_glb(copy, binary);
    EXPECT_TRUE(bytes.ok());
    return std::move(bytes).value();
  }
  Result<Document> read(const ReadLimits& limits = {}) const {
    SceneFiles files;
    files.add("scene.glb", glb());
    return files.read("scene.glb", limits);
  }

  Json json;
  Bytes binary;

 private:
  template <typename T>
  static int component_type() {
    if constexpr (std::is_same_v<T, std::int8_t>) return 5120;
    if constexpr (std::is_same_v<T, std::uint8_t>) return 5121;
    if constexpr (std::is_same_v<T, std::int16_t>) return 5122;
    if constexpr (std::is_same_v<T, std::uint16_t>) return 5123;
    if constexpr (std::is_same_v<T, std::uint32_t>) return 5125;
    return 5126;
  }
};

}  // namespace lightbatch::gltf
