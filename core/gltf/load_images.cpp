#include "core/gltf/load_images.h"

#include <string>
#include <string_view>
#include <vector>

#include "core/gltf/fields.h"

namespace lightbatch::gltf {
namespace {

/// Images that a texture, in whatever format, points at.
std::vector<bool> used_images(const Json& json) {
  std::vector<bool> used(list_field(json, "images").size(), false);
  for (const Json& texture : list_field(json, "textures")) {
    const std::uint32_t source = index_field(texture, "source");
    if (source != kAbsent) used[source] = true;
    for (const char* name : {"EXT_texture_webp", "KHR_texture_basisu", "MSFT_texture_dds"}) {
      if (const Json* extension = extension_of(texture, name)) {
        const std::uint32_t other = index_field(*extension, "source");
        if (other != kAbsent) used[other] = true;
      }
    }
  }
  return used;
}

/// Media type by the first bytes; empty when unknown.
std::string_view media_type_of(std::span<const std::byte> bytes) {
  const std::string_view text = as_text(bytes);
  if (text.starts_with("\x89PNG\r\n\x1a\n")) return "image/png";
  if (text.starts_with("\xff\xd8\xff")) return "image/jpeg";
  if (text.starts_with("\xabKTX 20\xbb")) return "image/ktx2";
  if (text.starts_with("RIFF") && text.size() >= 12 && text.substr(8, 4) == "WEBP") {
    return "image/webp";
  }
  return {};
}

/// Encoded bytes of an image in a bufferView.
Status copy_from_view(Document& document, std::size_t index, const JsonPath& path,
                      ResourceLoader& loader) {
  const Json& image = document.json["images"][index];
  const Json& view = document.json["bufferViews"][index_field(image, "bufferView")];
  if (!image.contains("mimeType")) {
    return malformed(path.text(), "an image in a bufferView needs its mimeType");
  }
  if (view.contains("byteStride")) {
    return malformed(path.text(), "the image lies in a bufferView with a byteStride");
  }
  if (image.contains("uri")) {
    document.warnings.push_back(path.text() + ": has a uri and a bufferView; the view is used");
  }
  const Bytes& buffer = document.buffers[view["buffer"].get<std::size_t>()];
  const std::uint64_t offset = unsigned_field(view, "byteOffset");
  const std::uint64_t length = unsigned_field(view, "byteLength");
  if (buffer.size() < offset + length) {
    document.warnings.push_back(path.text() + ": the image's buffer has no data");
    return {};
  }
  LB_RETURN_IF_ERROR(loader.spend(length, path.text()));
  const auto first = buffer.begin() + static_cast<std::ptrdiff_t>(offset);
  document.images[index].assign(first, first + static_cast<std::ptrdiff_t>(length));
  return {};
}

Status load_from_uri(Document& document, std::size_t index, bool used, const JsonPath& path,
                     ResourceLoader& loader) {
  const std::string& uri = document.json["images"][index]["uri"].get_ref<const std::string&>();
  std::string media_type;
  Result<Bytes> loaded = loader.load(uri, JsonPath(path, "uri"), &media_type);
  if (loaded.ok()) {
    document.images[index] = std::move(loaded).value();
    return {};
  }
  const Result<UriKind> kind = classify_uri(uri, {});
  if (used || !kind.ok() || *kind != UriKind::kAbsolute) return loaded.status();
  document.warnings.push_back(path.text() +
                              ": not loaded: nothing uses it, and its uri is not relative");
  return {};
}

}  // namespace

Status load_images(Document& document, const JsonPath& root, ResourceLoader& loader) {
  const Json& images = list_field(document.json, "images");
  const std::vector<bool> used = used_images(document.json);
  document.images.resize(images.size());
  const JsonPath list(root, "images");
  for (std::size_t i = 0; i < images.size(); ++i) {
    const JsonPath path(list, i);
    if (images[i].contains("bufferView")) {
      LB_RETURN_IF_ERROR(copy_from_view(document, i, path, loader));
    } else if (images[i].contains("uri")) {
      LB_RETURN_IF_ERROR(load_from_uri(document, i, used[i], path, loader));
    } else {
      document.warnings.push_back(path.text() + ": the image has neither a uri nor a bufferView");
    }
    const std::string_view found = media_type_of(document.images[i]);
    const std::string stated = text_field(images[i], "mimeType");
    if (!stated.empty() && !found.empty() && stated != found) {
      document.warnings.push_back(path.text() + "/mimeType: the image is " + std::string(found));
    }
  }
  return {};
}

}  // namespace lightbatch::gltf
