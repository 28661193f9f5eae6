#include "core/scene_out/mend_decoded.h"

#include <cstring>
#include <set>

#include "core/gltf/accessor.h"

namespace lightbatch::scene_out {
namespace {

/// Four weights to each vertex, floats: summing to 1 within what readers ask.
void normalise_weights(Bytes& bytes) {
  for (std::size_t at = 0; at + 16 <= bytes.size(); at += 16) {
    float w[4];
    std::memcpy(w, bytes.data() + at, sizeof(w));
    double sum = 0;
    for (const float v : w) sum += static_cast<double>(v);
    if (!(sum > 0)) continue;
    for (float& v : w) v = static_cast<float>(static_cast<double>(v) / sum);
    std::memcpy(bytes.data() + at, w, sizeof(w));
  }
}

void clear_unused_joints(const AttributeType& joints, const Bytes& weights, Bytes& bytes) {
  const std::size_t size = joints.component_bytes();
  for (std::size_t i = 0; i * sizeof(float) < weights.size() && (i + 1) * size <= bytes.size();
       ++i) {
    float weight = 0;
    std::memcpy(&weight, weights.data() + i * sizeof(float), sizeof(float));
    if (weight == 0) std::memset(bytes.data() + i * size, 0, size);
  }
}

}  // namespace

Status mend_decoded(Writer& w) {
  const std::uint32_t original = count_of(w.document.json, "accessors");
  std::set<std::uint32_t> done;
  for (std::uint32_t m = 0; m < count_of(w.root, "meshes"); ++m) {
    for (std::uint32_t p = 0; p < w.root["meshes"][m]["primitives"].size(); ++p) {
      const Json primitive = w.root["meshes"][m]["primitives"][p];
      const Json* attributes = member(primitive, "attributes");
      if (attributes == nullptr) continue;
      for (const AttributeType& type : attribute_types(w.root, primitive)) {
        const std::uint32_t accessor = index_at(*attributes, type.name);
        if (accessor >= original || !done.insert(accessor).second) continue;
        if (w.root["accessors"][accessor].contains("sparse")) continue;
        LB_ASSIGN_OR_RETURN(Bytes bytes, gltf::read_packed(w.document, accessor));
        const bool four_floats = type.component_type == 5126 && type.components == 4;
        if (type.name.starts_with("WEIGHTS_") && four_floats) {
          normalise_weights(bytes);
        } else if (type.name.starts_with("JOINTS_")) {
          const std::uint32_t weights = index_at(*attributes, "WEIGHTS_" + type.name.substr(7));
          if (weights < original &&
              w.document.json["accessors"][weights].value("componentType", 0) == 5126) {
            LB_ASSIGN_OR_RETURN(const Bytes values, gltf::read_packed(w.document, weights));
            clear_unused_joints(type, values, bytes);
          }
        }
        const std::uint32_t mended = w.binary.add_attribute(type, bytes);
        Json json = std::move(w.root["accessors"][mended]);
        w.root["accessors"].erase(mended);
        for (const char* key : {"name", "extras", "extensions"})
          if (const Json* value = member(w.root["accessors"][accessor], key)) json[key] = *value;
        w.root["accessors"][accessor] = std::move(json);
      }
    }
  }
  return {};
}

}  // namespace lightbatch::scene_out
