#include "core/scene_in/textures.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "core/base/parallel.h"
#include "core/image/codecs.h"

namespace lightbatch::scene_in {
namespace {

/// Pixels that the images of a scene may have together: some for nothing (plain colours pack to
/// almost no bytes), and in proportion to their encoded size.
constexpr std::uint64_t kFreePixels = std::uint64_t{1} << 26;
constexpr std::uint64_t kPixelsPerByte = 128;

scene::Wrap wrap_of(int value) {
  switch (value) {
    case 33071:
      return scene::Wrap::kClamp;
    case 33648:
      return scene::Wrap::kMirror;
    default:
      return scene::Wrap::kRepeat;
  }
}

/// KHR_texture_transform: scale, then rotate, then offset. Rotation is counter-clockwise as seen on
/// the image (v points down), which is what the extension's own example and viewers do.
void set_transform(const tinygltf::Value& transform, scene::TextureSlot& slot) {
  const double rotation = number(transform, "rotation", 0);
  const double c = std::cos(rotation);
  const double s = std::sin(rotation);
  const double su = number(transform, "scale", 0, 1);
  const double sv = number(transform, "scale", 1, 1);
  slot.m00 = static_cast<float>(c * su);
  slot.m01 = static_cast<float>(s * sv);
  slot.m10 = static_cast<float>(-s * su);
  slot.m11 = static_cast<float>(c * sv);
  slot.tu = static_cast<float>(number(transform, "offset", 0, 0));
  slot.tv = static_cast<float>(number(transform, "offset", 1, 0));
}

bool is_finite_slot(const scene::TextureSlot& slot) {
  return std::isfinite(slot.m00) && std::isfinite(slot.m01) && std::isfinite(slot.m10) &&
         std::isfinite(slot.m11) && std::isfinite(slot.tu) && std::isfinite(slot.tv);
}

}  // namespace

TextureReader::TextureReader(const gltf::Document& document, const tinygltf::Model& model,
                             const gltf::ReadLimits& limits)
    : document_(document), model_(model), limits_(limits) {}

std::string TextureReader::place_of(std::uint32_t image) const {
  return document_.name + "#/images/" + std::to_string(image);
}

std::uint32_t TextureReader::image_of(const tinygltf::Texture& texture) const {
  // WebP is decoded here, so it comes before the core image; Basis and DDS are not, so they come
  // last, to say what could not be read.
  double source = texture.source;
  if (const auto* webp = extension(texture.extensions, "EXT_texture_webp")) {
    source = number(*webp, "source", source);
  }
  for (const char* name : {"KHR_texture_basisu", "MSFT_texture_dds"}) {
    const auto* other = extension(texture.extensions, name);
    if (source < 0 && other != nullptr) source = number(*other, "source", source);
  }
  return source < 0 ? scene::kNone : static_cast<std::uint32_t>(source);
}

scene::TextureSlot TextureReader::make(int texture, double texcoord,
                                       const tinygltf::Value* transform, const std::string& place) {
  scene::TextureSlot slot;
  if (texture < 0) return slot;
  const tinygltf::Texture& source = model_.textures[static_cast<std::size_t>(texture)];
  if (transform != nullptr) {
    set_transform(*transform, slot);
    texcoord = number(*transform, "texCoord", texcoord);
  }
  if (texcoord > 1 || !is_finite_slot(slot)) {
    warnings_.push_back(
        place + (texcoord > 1 ? ": texture left out: only TEXCOORD_0 and TEXCOORD_1 are read"
                              : ": texture left out: its KHR_texture_transform is too large"));
    ++not_decoded_;
    return {};
  }
  slot.uv_set = texcoord == 1 ? 1 : 0;
  if (source.sampler >= 0) {
    const tinygltf::Sampler& sampler = model_.samplers[static_cast<std::size_t>(source.sampler)];
    slot.wrap_u = wrap_of(sampler.wrapS);
    slot.wrap_v = wrap_of(sampler.wrapT);
    constexpr int kNearest = 9728;
    if (sampler.magFilter == kNearest) slot.filter = scene::Filter::kNearest;
  }
  slot.image = image_of(source);
  if (slot.image == scene::kNone) {
    warnings_.push_back(place + ": texture without an image; its factor is used");
    ++not_decoded_;
  }
  return slot;
}

scene::TextureSlot TextureReader::slot(int texture, int texcoord,
                                       const tinygltf::ExtensionMap& extensions,
                                       const std::string& place) {
  return make(texture, texcoord, extension(extensions, "KHR_texture_transform"), place);
}

scene::TextureSlot TextureReader::slot(const tinygltf::Value& owner, const char* name,
                                       const std::string& place) {
  if (!owner.Has(name)) return {};
  const tinygltf::Value& info = owner.Get(name);
  const tinygltf::Value* transform = nullptr;
  if (info.Has("extensions") && info.Get("extensions").Has("KHR_texture_transform")) {
    transform = &info.Get("extensions").Get("KHR_texture_transform");
  }
  return make(static_cast<int>(number(info, "index", -1)), number(info, "texCoord", 0), transform,
              place);
}

void TextureReader::warn_of_unreadable(const std::map<std::uint32_t, std::uint32_t>& wanted) {
  for (std::uint32_t i = 0; i < document_.images.size(); ++i) {
    if (wanted.contains(i)) continue;  // decoding will tell
    const image::Format format = image::detect_format(document_.images[i]);
    const bool known = format == image::Format::kPng || format == image::Format::kJpeg ||
                       format == image::Format::kWebp;
    if (!known) continue;
    const auto size = image::read_image8_size(document_.images[i], place_of(i));
    if (!size.ok()) warnings_.push_back("image passed on as it is: " + size.status().to_string());
  }
}

void TextureReader::decode(scene::Scene& scene) {
  // glTF image index -> index into scene.images, or kNone when it cannot be decoded.
  std::map<std::uint32_t, std::uint32_t> wanted;
  for (const scene::Material& material : scene.materials) {
    for (const scene::TextureSlot* slot : material.texture_slots()) {
      if (slot->present()) wanted.emplace(slot->image, scene::kNone);
    }
  }
  warn_of_unreadable(wanted);
  std::vector<std::uint32_t> order;
  std::uint64_t encoded_bytes = 0;
  for (const auto& [image, place] : wanted) {
    order.push_back(image);
    encoded_bytes += document_.images[image].size();
  }
  // Headers first: what all images together take is known before any is decoded.
  std::uint64_t pixels_left =
      std::min(limits_.decoded_bytes / 4, kFreePixels + kPixelsPerByte * encoded_bytes);
  std::vector<Result<image::Image8>> decoded(order.size(), Result<image::Image8>(image::Image8{}));
  std::vector<std::size_t> tasks;
  for (std::size_t i = 0; i < order.size(); ++i) {
    const auto size = image::read_image8_size(document_.images[order[i]], place_of(order[i]));
    const std::uint64_t pixels = size.ok() ? size->pixels() : 0;
    if (!size.ok()) {
      decoded[i] = size.status();
    } else if (pixels > limits_.image_pixels || pixels > pixels_left) {
      decoded[i] = over_budget(place_of(order[i]),
                               "the image, or all of them together, has too many pixels");
    } else {
      pixels_left -= pixels;
      tasks.push_back(i);
    }
  }
  parallel_for(tasks.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t t = begin; t < end; ++t) {
      const std::uint32_t index = order[tasks[t]];
      decoded[tasks[t]] =
          image::decode_image8(document_.images[index], place_of(index), limits_.image_pixels);
    }
  });
  for (std::size_t i = 0; i < order.size(); ++i) {
    if (!decoded[i].ok()) {
      warnings_.push_back("image not decoded, the factor of its textures is used: " +
                          decoded[i].status().to_string());
      ++not_decoded_;
      continue;
    }
    wanted[order[i]] = static_cast<std::uint32_t>(scene.images.size());
    scene.images.push_back(std::make_shared<const image::Image8>(std::move(decoded[i]).value()));
  }
  for (scene::Material& material : scene.materials) {
    for (scene::TextureSlot* slot : material.texture_slots()) {
      if (slot->present()) slot->image = wanted[slot->image];
    }
  }
  scene.counts.textures_not_decoded += not_decoded_;
  scene.warnings.insert(scene.warnings.end(), warnings_.begin(), warnings_.end());
}

}  // namespace lightbatch::scene_in
