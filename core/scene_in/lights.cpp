#include "core/scene_in/lights.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <numbers>
#include <set>
#include <string>
#include <string_view>

#include "core/gltf/fields.h"
#include "core/scene_in/place.h"

namespace lightbatch::scene_in {
namespace {

constexpr double kThinnestCone = 1e-6;      // radians
constexpr double kLargestIntensity = 1e30;  // candela or lux; keeps every product of light finite

/// Spot angles with 0 <= inner < outer <= pi/2, as the extension demands; false when mended.
bool set_cone(const tinygltf::SpotLight& spot, scene::Light& light) {
  constexpr double kHalfPi = std::numbers::pi / 2;
  const double outer = std::clamp(spot.outerConeAngle, kThinnestCone, kHalfPi);
  const double inner = std::clamp(spot.innerConeAngle, 0.0, outer);
  light.cos_inner = std::cos(inner);
  light.cos_outer = std::cos(outer);
  return outer == spot.outerConeAngle && inner == spot.innerConeAngle && inner < outer;
}

bool set_light(const tinygltf::Light& source, scene::Light& light) {
  bool good = true;
  const auto clamp = [&good](double value, double low, double high) {
    const double clamped = std::clamp(value, low, high);
    good = good && clamped == value;
    return clamped;
  };
  const double intensity = clamp(source.intensity, 0, kLargestIntensity);
  const auto channel = [&](std::size_t i) {
    return i < source.color.size() ? clamp(source.color[i], 0, 1) * intensity : intensity;
  };
  light.intensity = to_float(Rgbd{channel(0), channel(1), channel(2)});
  light.range =
      light.kind == scene::LightKind::kDirectional ? 0 : clamp(source.range, 0, kLargestIntensity);
  if (light.kind == scene::LightKind::kSpot) good = set_cone(source.spot, light) && good;
  return good;
}

/// Lights whose colour or intensity an animation changes by KHR_animation_pointer.
std::set<std::uint32_t> changing_lights(const gltf::Json& json) {
  constexpr std::string_view kLights = "/extensions/KHR_lights_punctual/lights/";
  std::set<std::uint32_t> changing;
  for (const gltf::Json& animation : gltf::list_field(json, "animations")) {
    for (const gltf::Json& channel : animation["channels"]) {
      const gltf::Json* target = gltf::extension_of(channel["target"], "KHR_animation_pointer");
      if (target == nullptr) continue;
      const std::string pointer = gltf::text_field(*target, "pointer");
      std::uint32_t light = 0;
      if (pointer.starts_with(kLights) &&
          std::from_chars(pointer.data() + kLights.size(), pointer.data() + pointer.size(), light)
                  .ec == std::errc()) {
        changing.insert(light);
      }
    }
  }
  return changing;
}

}  // namespace

Status read_lights(const gltf::Document& document, const tinygltf::Model& model,
                   const NodeTree& tree, scene::Scene& scene) {
  const std::set<std::uint32_t> changing = changing_lights(document.json);
  for (const PlacedNode& placed : tree.placed) {
    const gltf::Json& node = document.json["nodes"][placed.node];
    const gltf::Json* found = gltf::extension_of(node, "KHR_lights_punctual");
    if (found == nullptr) continue;
    if (placed.hidden) {
      scene.skipped.push_back({.node = placed.node, .reason = "hidden"});
      continue;
    }
    scene::Light light;
    light.node = placed.node;
    light.gltf_index = gltf::index_field(*found, "light");
    const tinygltf::Light& source = model.lights[light.gltf_index];
    const std::string place = document.name + "#/extensions/KHR_lights_punctual/lights/" +
                              std::to_string(light.gltf_index);
    if (source.type == "point") {
      light.kind = scene::LightKind::kPoint;
    } else if (source.type == "spot") {
      light.kind = scene::LightKind::kSpot;
    } else if (source.type == "directional") {
      light.kind = scene::LightKind::kDirectional;
    } else {
      scene.warnings.push_back(place + ": unknown type of light, left out");
      continue;
    }
    if (placed.animated || changing.contains(light.gltf_index)) {
      scene.skipped.push_back({.node = placed.node, .reason = "animated"});
      scene.warnings.push_back(place + (placed.animated ? ": a moving light is not baked"
                                                        : ": a changing light is not baked"));
      continue;
    }
    light.name = source.name.empty() ? gltf::text_field(node, "name") : source.name;
    const gltf::Json& stated =
        document.json["extensions"]["KHR_lights_punctual"]["lights"][light.gltf_index];
    if (stated.contains("range") && source.range == 0) {
      scene.warnings.push_back(place + ": a range of 0 is taken as no limit");
    }
    if (!set_light(source, light)) {
      scene.warnings.push_back(place + ": a value was out of its range and is clamped");
    }
    const Affine& world = tree.world[placed.node];
    if (light.kind != scene::LightKind::kDirectional) {
      light.position = world.t - scene.origin;
      if (!(length(light.position) <= kLargestScene)) {
        return malformed(document.name + "#/nodes/" + std::to_string(placed.node),
                         "the light is farther than 1e15 metres from the scene");
      }
    }
    light.direction = normalized(world.vector({0, 0, -1}));
    if (length(light.direction) == 0) light.direction = {0, 0, -1};
    scene.lights.push_back(light);
  }
  return {};
}

}  // namespace lightbatch::scene_in
