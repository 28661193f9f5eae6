#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "core/gltf/document.h"
#include "core/scene/scene.h"
#include "core/scene_in/model.h"

namespace lightbatch::scene_in {

/// The texture slots of materials: collects which images are wanted, decodes each once, and puts
/// the result into the slots.
class TextureReader {
 public:
  TextureReader(const gltf::Document& document, const tinygltf::Model& model,
                const gltf::ReadLimits& limits);

  /// Fills a slot from a textureInfo; the image is still its glTF index until decode().
  /// Texture coordinate sets above 1 count as absent.
  scene::TextureSlot slot(int texture, int texcoord, const tinygltf::ExtensionMap& extensions,
                          const std::string& place);
  /// The same for a textureInfo inside a material extension.
  scene::TextureSlot slot(const tinygltf::Value& extension, const char* name,
                          const std::string& place);

  /// Decodes what slots of `scene.materials` point at into scene.images and renumbers the slots.
  void decode(scene::Scene& scene);

 private:
  scene::TextureSlot make(int texture, double texcoord, const tinygltf::Value* transform,
                          const std::string& place);
  std::uint32_t image_of(const tinygltf::Texture& texture) const;
  std::string place_of(std::uint32_t image) const;
  /// Images that light does not need are passed on; a broken header is worth a word all the same.
  void warn_of_unreadable(const std::map<std::uint32_t, std::uint32_t>& wanted);

  const gltf::Document& document_;
  const tinygltf::Model& model_;
  const gltf::ReadLimits& limits_;
  std::vector<std::string> warnings_;
  std::uint64_t not_decoded_ = 0;
};

}  // namespace lightbatch::scene_in
