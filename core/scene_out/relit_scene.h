#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "core/base/bytes.h"
#include "core/base/status.h"

namespace lightbatch::scene_out {

/// A page as in LightmapImages.
struct RelitPage {
  Bytes png;
  float intensity = 1;
};

/// New values of a light of KHR_lights_punctual, by its index in the scene that was baked.
struct RelitLight {
  std::uint32_t index = 0;
  std::array<double, 3> color{1, 1, 1};
  double intensity = 1;  // cd or lux
};

/// New emission of a material, by its index in the scene that was baked.
struct RelitMaterial {
  std::uint32_t index = 0;
  std::array<double, 3> emissive_factor{};
  double emissive_strength = 1;
};

/// A scene.glb that write_scene() made, with other pictures in its lightmap pages and other values
/// in its lights and emitting materials; all else byte for byte, but for the names of probes.json
/// and of directional pages, whose light is the old one. Deterministic bytes. INPUT_MALFORMED where
/// the file is not such a scene.
Result<Bytes> relit_scene(std::span<const std::byte> glb, const std::string& place,
                          std::span<const RelitPage> pages, std::span<const RelitLight> lights,
                          std::span<const RelitMaterial> materials);

}  // namespace lightbatch::scene_out
