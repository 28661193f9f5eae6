#include "core/scene_out/lights.h"

#include <algorithm>

namespace lightbatch::scene_out {
namespace {

constexpr const char* kLights = "KHR_lights_punctual";

/// Whether anything but the definitions still speaks of lights: a node of another scene, or an
/// animation that points at them.
bool still_used(const Json& root) {
  if (const Json* nodes = member(root, "nodes"))
    for (const Json& node : *nodes)
      if (extension(node, kLights) != nullptr) return true;
  const Json* animations = member(root, "animations");
  return animations != nullptr && animations->dump().find(kLights) != std::string::npos;
}

}  // namespace

Json remove_lights(Writer& w) {
  const Json* definitions = extension(w.document.json, kLights);
  if (definitions == nullptr || w.scene.lights.empty()) return nullptr;
  const Json* lights = member(*definitions, "lights");
  Json taken = Json::array();
  for (const scene::Light& light : w.scene.lights) {
    if (light.node == kNone || lights == nullptr || light.gltf_index >= lights->size()) continue;
    taken.push_back({{"node", light.node}, {"index", light.gltf_index}, {"light", lights->at(light.gltf_index)}});
    erase_extension(w.root["nodes"][light.node], kLights);
  }
  if (taken.empty()) return nullptr;
  if (!still_used(w.root)) {
    erase_extension(w.root, kLights);
    undeclare_extension(w.root, kLights);
  }
  return taken;
}

}  // namespace lightbatch::scene_out
