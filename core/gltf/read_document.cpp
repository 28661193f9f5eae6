#include <optional>
#include <string_view>

#include "core/base/hash.h"
#include "core/gltf/check_animation.h"
#include "core/gltf/check_cameras_lights.h"
#include "core/gltf/check_meshes.h"
#include "core/gltf/check_nodes.h"
#include "core/gltf/check_skins.h"
#include "core/gltf/check_version.h"
#include "core/gltf/document.h"
#include "core/gltf/draco_decode.h"
#include "core/gltf/draco_header.h"
#include "core/gltf/elements.h"
#include "core/gltf/extensions.h"
#include "core/gltf/fields.h"
#include "core/gltf/glb_container.h"
#include "core/gltf/json_text.h"
#include "core/gltf/layout.h"
#include "core/gltf/load_buffers.h"
#include "core/gltf/load_images.h"
#include "core/gltf/meshopt_decode.h"
#include "core/gltf/scan_values.h"
#include "core/gltf/schema.h"

namespace lightbatch::gltf {
namespace {

/// Memory of the JSON tree, whatever the text's size.
constexpr std::uint64_t kJsonMemory = std::uint64_t{1} << 30;
/// Accessors without a bufferView stand for zeros; a file may ask for this much, or more in
/// proportion to what it holds.
constexpr std::uint64_t kFreeZeroBytes = std::uint64_t{16} << 20;
constexpr std::uint64_t kZeroBytesPerByte = 16;

/// A broken file must not turn into an endless report.
constexpr std::size_t kMostWarnings = 100;

bool looks_like_json(std::string_view text) {
  const std::size_t first = text.find_first_not_of(" \t\r\n");
  return first != std::string_view::npos && text[first] == '{';
}

/// A clear word for files that are something else altogether.
Status refuse_other_formats(std::span<const std::byte> file, const std::string& name) {
  if (file.empty()) return malformed(name + "@0", "the file is empty");
  const std::string_view text = as_text(file);
  if (is_draco(file)) {
    return unsupported(name + "@0", "this is a bare Draco file; put the mesh into a glTF scene");
  }
  if (text.starts_with("\xef\xbb\xbf") || looks_like_json(text)) return {};
  return malformed(name + "@0", "the file is neither .glb nor glTF JSON");
}

Status check_zero_bytes(std::uint64_t zero_bytes, const Document& document, const JsonPath& root) {
  std::uint64_t allowed = kFreeZeroBytes;
  for (const Bytes& buffer : document.buffers) allowed += kZeroBytesPerByte * buffer.size();
  if (zero_bytes <= allowed) return {};
  return over_budget(
      root.text() + "/accessors",
      "accessors without a bufferView stand for " + std::to_string(zero_bytes) + " bytes of zeros");
}

/// From JSON and binary chunk to the plain, checked document.
Status unpack(Document& document, std::optional<Bytes> binary, bool glb, ResourceLoader& loader,
              const ReadLimits& limits) {
  const JsonPath root(document.name);
  std::vector<std::string>& warnings = document.warnings;
  LB_RETURN_IF_ERROR(check_version(document.json, root, warnings));
  LB_RETURN_IF_ERROR(check_schema(document.json, root, warnings));
  LB_RETURN_IF_ERROR(check_cameras(document.json, root, warnings));
  LB_RETURN_IF_ERROR(check_lights(document.json, root, warnings));
  LB_RETURN_IF_ERROR(check_required_extensions(document.json, root, warnings));
  LB_RETURN_IF_ERROR(check_nodes(document.json, root, limits.nodes, warnings));
  LB_RETURN_IF_ERROR(check_buffer_views(document.json, root, warnings));

  LB_RETURN_IF_ERROR(load_buffers(document, root, std::move(binary), glb, loader));
  LB_RETURN_IF_ERROR(decode_meshopt(document, root, loader));
  std::vector<std::uint32_t> decoded;
  LB_RETURN_IF_ERROR(decode_draco(document, root, limits.triangles, loader, decoded));
  undeclare_extension(document.json, "EXT_meshopt_compression");
  undeclare_extension(document.json, "KHR_draco_mesh_compression");

  std::uint64_t zero_bytes = 0;
  LB_RETURN_IF_ERROR(check_accessors(document.json, root, &zero_bytes, warnings));
  LB_RETURN_IF_ERROR(check_zero_bytes(zero_bytes, document, root));
  LB_RETURN_IF_ERROR(check_sparse_indices(document, 3 * limits.triangles));
  LB_RETURN_IF_ERROR(scan_values(document, root, decoded, warnings));
  LB_RETURN_IF_ERROR(check_meshes(document, root, limits.triangles, warnings));
  LB_RETURN_IF_ERROR(check_instancing(document, root));
  LB_RETURN_IF_ERROR(check_animations(document, root, warnings));
  LB_RETURN_IF_ERROR(check_skins(document, root, warnings));
  return load_images(document, root, loader);
}

}  // namespace

Result<Document> read_document(const FileMap& files, const std::string& main,
                               const ReadLimits& limits) {
  const auto found = files.find(main);
  if (found == files.end()) {
    return uri_forbidden(main, "the file \"" + main + "\" was not handed over");
  }
  LB_ASSIGN_OR_RETURN(Bytes file, read_file(found->second));
  Document document;
  document.name = main;
  document.sha256 = sha256_hex(file);
  ResourceLoader loader(files, main, limits.decoded_bytes);
  LB_RETURN_IF_ERROR(loader.spend(file.size(), main));

  const bool glb = is_glb(file);
  GlbChunks chunks;
  if (glb) {
    LB_ASSIGN_OR_RETURN(chunks, split_glb(file, main));
  } else {
    LB_RETURN_IF_ERROR(refuse_other_formats(file, main));
    chunks.json = as_text(file);
  }
  if (chunks.json.size() > limits.json_bytes) {
    return over_budget(main, "the JSON text has " + std::to_string(chunks.json.size()) +
                                 " bytes; at most " + std::to_string(limits.json_bytes) +
                                 " are read");
  }
  LB_ASSIGN_OR_RETURN(document.json, parse_json(chunks.json, main, limits.json_depth, kJsonMemory,
                                                chunks.json_offset));
  document.input_bytes = file.size();
  std::optional<Bytes> binary;
  if (chunks.binary) {
    // The file's own memory becomes the buffer: large scenes are held once.
    const auto first = chunks.binary->data() - file.data();
    const std::size_t size = chunks.binary->size();
    file.erase(file.begin(), file.begin() + first);
    file.resize(size);
    binary = std::move(file);
  }
  LB_RETURN_IF_ERROR(unpack(document, std::move(binary), glb, loader, limits));
  document.input_bytes += loader.file_bytes();
  if (document.warnings.size() > kMostWarnings) {
    const std::size_t more = document.warnings.size() - kMostWarnings;
    document.warnings.resize(kMostWarnings);
    document.warnings.push_back("and " + std::to_string(more) + " more warnings");
  }
  return document;
}

}  // namespace lightbatch::gltf
