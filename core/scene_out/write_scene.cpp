#include "core/scene_out/write_scene.h"

#include <algorithm>
#include <cctype>
#include <string>

#include "core/gltf/glb_writer.h"
#include "core/image/codecs.h"
#include "core/scene_out/batch_meshes.h"
#include "core/scene_out/draco_encode.h"
#include "core/scene_out/earlier.h"
#include "core/scene_out/in_place.h"
#include "core/scene_out/lights.h"
#include "core/scene_out/mend_decoded.h"
#include "core/scene_out/meshopt_encode.h"
#include "core/scene_out/pack.h"
#include "core/scene_out/vertex_light.h"
#include "core/scene_out/writer.h"

namespace lightbatch::scene_out {
namespace {

/// Numbers of the pages' images.
Json add_pages(Writer& w, const LightmapImages& images) {
  Json numbers = Json::array();
  const std::uint32_t sampler =
      append(w.root, "samplers",
             Json{{"magFilter", 9729}, {"minFilter", 9729}, {"wrapS", 33071}, {"wrapT", 33071}});
  std::vector<std::uint32_t> textures;
  for (std::size_t k = 0; k < images.png.size(); ++k) {
    const std::string name = "lightmap_" + std::to_string(k);
    const std::uint32_t view = w.binary.add_file(images.png[k]);
    const std::uint32_t image = append(
        w.root, "images", Json{{"bufferView", view}, {"mimeType", "image/png"}, {"name", name}});
    numbers.push_back(image);
    textures.push_back(
        append(w.root, "textures", Json{{"sampler", sampler}, {"source", image}, {"name", name}}));
  }
  w.materials.set_pages(std::move(textures), images.intensity);
  declare_extension(w.root, "extensionsUsed", "MOZ_lightmap");
  return numbers;
}

/// By what the file is, says, or is called; empty for a data URI of nothing known.
std::string mime_type(const Json& image, const Bytes& bytes) {
  switch (image::detect_format(bytes)) {
    case image::Format::kPng:
      return "image/png";
    case image::Format::kJpeg:
      return "image/jpeg";
    case image::Format::kWebp:
      return "image/webp";
    case image::Format::kKtx2:
      return "image/ktx2";
    default:
      break;
  }
  if (const Json* stated = member(image, "mimeType")) return *stated;
  const std::string uri = image.at("uri");
  if (uri.starts_with("data:")) return {};
  std::string kind = uri.substr(std::min(uri.find_last_of("./") + 1, uri.size()));
  for (char& c : kind) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return kind == "dds" ? "image/vnd-ms.dds" : "image/" + kind;
}

/// Images from other files and data URIs move into the file.
void embed_images(Writer& w) {
  Json* images = member(w.root, "images");
  if (images == nullptr) return;
  for (std::uint32_t i = 0; i < w.document.images.size() && i < images->size(); ++i) {
    Json& image = (*images)[i];
    const Bytes& bytes = w.document.images[i];
    if (!image.contains("uri") || bytes.empty()) continue;
    std::string type = mime_type(image, bytes);
    if (type.empty()) continue;
    image["bufferView"] = w.binary.add_file(bytes);
    image["mimeType"] = std::move(type);
    image.erase("uri");
  }
}

/// Extras of the scene, or of the file when the scene's are no object.
void add_extras(Json& root, std::uint32_t scene_index, Json about) {
  for (Json* at : {&root["scenes"][scene_index], &root}) {
    Json& extras = (*at)["extras"];
    if (!extras.is_null() && !extras.is_object()) continue;
    extras["lightbatch"] = std::move(about);
    return;
  }
}

bool any_instancing(const Json& root) {
  if (const Json* nodes = member(root, "nodes"))
    for (const Json& node : *nodes)
      if (extension(node, "EXT_mesh_gpu_instancing") != nullptr) return true;
  return false;
}

/// Whether meshes need a decoder; decoded documents say so no more.
bool is_compressed(const Json& root) {
  const Json* required = member(root, "extensionsRequired");
  return required != nullptr &&
         std::any_of(required->begin(), required->end(), [](const Json& name) {
           return name == "KHR_draco_mesh_compression" || name == "EXT_meshopt_compression";
         });
}

}  // namespace

Result<Bytes> write_scene(const gltf::Document& document, const scene::Scene& scene,
                          const batches::BatchPlan* plan, const atlas::Layout* layout,
                          const LightmapImages* images, const WriteOptions& options,
                          WriteFacts* facts) {
  LB_CHECK((layout == nullptr) == (images == nullptr), "an atlas comes with its pages");
  Writer w(document, scene, layout, options);
  const std::uint32_t named = index_at(w.root, "scene");
  const std::uint32_t scene_index = named == kNone ? 0 : named;
  Json about = Json::object();
  about["version"] = 1;
  std::vector<std::uint32_t> earlier_pages;
  if (images != nullptr) {
    LB_CHECK(images->png.size() == layout->pages.size() &&
                 images->intensity.size() == images->png.size(),
             "one picture and one intensity for each page");
    about["carrier"] = "lightmap";
    earlier_pages = rename_earlier_pages(w.root, scene_index);
    if (!images->png.empty()) about[kPageImages] = add_pages(w, *images);
  }
  if (w.portable()) {
    w.exposure = choose_exposure(scene, options);
    about["carrier"] = "portable";
    about["exposure"] = w.exposure;
    declare_extension(w.root, "extensionsUsed", "KHR_materials_unlit");
  }
  embed_images(w);
  LB_RETURN_IF_ERROR(rewrite_nodes(w, plan));
  clear_earlier_nodes(w.root, count_of(document.json, "nodes"));
  if (scene_index < count_of(w.root, "scenes")) {
    if (plan != nullptr) LB_RETURN_IF_ERROR(add_batches(w, *plan, scene_index));
    if ((images != nullptr || w.portable()) && options.remove_lights)
      if (Json lights = remove_lights(w); !lights.is_null()) about["lights"] = std::move(lights);
    if (options.extras.is_object()) about.update(options.extras);
  }
  if (!any_instancing(w.root)) undeclare_extension(w.root, "EXT_mesh_gpu_instancing");

  // Meshes that lost their use still name original materials: they go first.
  drop_meshes(w.root, document.json);
  const Clones clones =
      settle_materials(w.root, count_of(document.json, "materials"), w.materials.clones());
  animate_clones(w.root, clones);
  empty_earlier_pages(w, earlier_pages);
  if (scene_index < count_of(w.root, "scenes")) {
    if (images != nullptr)
      if (Json emitters = clones_of_emitters(w.root, clones); !emitters.empty())
        about[kEmitters] = std::move(emitters);
    add_extras(w.root, scene_index, std::move(about));
  }
  if (document.had_draco) LB_RETURN_IF_ERROR(mend_decoded(w));

  Bytes binary;
  {
    const std::vector<Bytes> fresh = w.binary.finish();
    std::vector<const Bytes*> buffers;
    for (const Bytes& b : document.buffers) buffers.push_back(&b);
    for (const Bytes& b : fresh) buffers.push_back(&b);
    binary = pack(w.root, document.json, buffers);
  }
  if (options.compression == Compression::kMeshopt)
    binary = compress_views(w.root, document.json, std::move(binary));
  if (options.compression == Compression::kDraco) {
    LB_ASSIGN_OR_RETURN(binary, compress_draco(w.root, std::move(binary)));
  }
  if (facts != nullptr) {
    *facts = w.facts;
    facts->compressed = is_compressed(w.root);
  }
  return gltf::write_glb(std::move(w.root), binary);
}

}  // namespace lightbatch::scene_out
