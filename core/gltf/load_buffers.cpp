#include "core/gltf/load_buffers.h"

#include <algorithm>

#include "core/gltf/fields.h"

namespace lightbatch::gltf {
namespace {

constexpr const char* kMeshopt = "EXT_meshopt_compression";

bool is_fallback(const Json& buffer) {
  const Json* extension = extension_of(buffer, kMeshopt);
  return extension != nullptr && bool_field(*extension, "fallback");
}

/// Buffers that a bufferView, compressed or not, points into.
std::vector<bool> used_buffers(const Json& json) {
  std::vector<bool> used(list_field(json, "buffers").size(), false);
  for (const Json& view : list_field(json, "bufferViews")) {
    used[view["buffer"].get<std::size_t>()] = true;
    if (const Json* extension = extension_of(view, kMeshopt)) {
      used[(*extension)["buffer"].get<std::size_t>()] = true;
    }
  }
  return used;
}

}  // namespace

ResourceLoader::ResourceLoader(const FileMap& files, const std::string& main, std::uint64_t budget)
    : files_(files), budget_(budget) {
  const std::size_t slash = main.rfind('/');
  if (slash != std::string::npos) folder_ = main.substr(0, slash);
}

Status ResourceLoader::spend(std::uint64_t bytes, const std::string& place) {
  if (bytes > budget_ - spent_) {
    return over_budget(place, "the scene takes more than " + std::to_string(budget_) +
                                  " bytes when it is unpacked");
  }
  spent_ += bytes;
  return {};
}

Result<Bytes> ResourceLoader::load(const std::string& uri, const JsonPath& path,
                                   std::string* media_type) {
  const std::string place = path.text();
  LB_ASSIGN_OR_RETURN(const UriKind kind, classify_uri(uri, place));
  if (kind == UriKind::kData) {
    LB_ASSIGN_OR_RETURN(DataUri data, decode_data_uri(uri, place));
    LB_RETURN_IF_ERROR(spend(data.bytes.size(), place));
    *media_type = std::move(data.media_type);
    return std::move(data.bytes);
  }
  if (kind == UriKind::kAbsolute) {
    return uri_forbidden(place,
                         "the uri \"" + uri.substr(0, 200) +
                             "\" is not relative; only files handed over with the scene are read");
  }
  LB_ASSIGN_OR_RETURN(const std::string name, resolve_uri(uri, folder_, place));
  const auto found = files_.find(name);
  if (found == files_.end()) {
    return uri_forbidden(place, "the file \"" + name + "\" was not handed over with the scene");
  }
  LB_ASSIGN_OR_RETURN(Bytes bytes, read_file(found->second));
  file_bytes_ += bytes.size();
  LB_RETURN_IF_ERROR(spend(bytes.size(), place));
  return bytes;
}

Status load_buffers(Document& document, const JsonPath& root, std::optional<Bytes> binary, bool glb,
                    ResourceLoader& loader) {
  const Json& buffers = list_field(document.json, "buffers");
  const std::vector<bool> used = used_buffers(document.json);
  document.buffers.resize(buffers.size());
  const JsonPath list(root, "buffers");
  for (std::size_t i = 0; i < buffers.size(); ++i) {
    const Json& buffer = buffers[i];
    const JsonPath path(list, i);
    const std::uint64_t length = unsigned_field(buffer, "byteLength");
    Bytes& bytes = document.buffers[i];
    if (is_fallback(buffer)) continue;
    if (const auto uri = buffer.find("uri"); uri != buffer.end()) {
      const std::string& text = uri->get_ref<const std::string&>();
      std::string media_type;
      Result<Bytes> loaded = loader.load(text, JsonPath(path, "uri"), &media_type);
      if (!loaded.ok()) {
        const Result<UriKind> kind = classify_uri(text, {});
        if (used[i] || !kind.ok() || *kind != UriKind::kAbsolute) return loaded.status();
        document.warnings.push_back(path.text() +
                                    ": not loaded: nothing uses it, and its uri is not relative");
        continue;
      }
      bytes = std::move(loaded).value();
      if (text.size() > 5 && text[4] == ':' && media_type != "application/octet-stream" &&
          media_type != "application/gltf-buffer") {
        document.warnings.push_back(path.text() + ": unusual media type of a buffer: \"" +
                                    media_type.substr(0, 80) + "\"");
      }
    } else if (glb && i == 0) {
      if (!binary) return malformed(path.text(), "the GLB has no BIN chunk for its buffer");
      bytes = std::move(*binary);
    } else {
      continue;
    }
    if (bytes.size() < length) {
      return malformed(path.text(), "the buffer says " + std::to_string(length) +
                                        " bytes, but has " + std::to_string(bytes.size()));
    }
  }
  return {};
}

}  // namespace lightbatch::gltf
