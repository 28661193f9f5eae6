#include "core/scene_out/earlier.h"

#include <set>
#include <string>

#include "core/image/codecs.h"
#include "core/scene_out/references.h"
#include "core/scene_out/write_scene.h"

namespace lightbatch::scene_out {
namespace {

constexpr const char* kNote = "lightbatch";

const Json* note_of(const Json& json) {
  const Json* extras = member(json, "extras");
  return extras == nullptr ? nullptr : member(*extras, kNote);
}

void rename(Json& entry) {
  Json* name = member(entry, "name");
  if (name != nullptr && name->is_string() && name->get<std::string>().starts_with("lightmap_"))
    *name = "earlier_" + name->get<std::string>();
}

/// Textures that a material or anything in it names.
void add_textures(const Json& json, std::set<std::uint32_t>& textures) {
  if (!json.is_structured()) return;
  if (const std::uint32_t index = index_at(json, "index"); index != kNone) textures.insert(index);
  for (const Json& value : json) add_textures(value, textures);
}

}  // namespace

std::vector<std::uint32_t> rename_earlier_pages(Json& root, std::uint32_t scene_index) {
  std::vector<std::uint32_t> renamed;
  if (scene_index >= count_of(root, "scenes")) return renamed;
  for (const Json* about : {note_of(root["scenes"][scene_index]), note_of(root)}) {
    const Json* pages = about == nullptr ? nullptr : member(*about, kPageImages);
    if (pages == nullptr || !pages->is_array()) continue;
    for (const Json& page : *pages) {
      if (!page.is_number_unsigned() || page.get<std::uint64_t>() >= count_of(root, "images"))
        continue;
      rename(root["images"][page.get<std::size_t>()]);
      renamed.push_back(page.get<std::uint32_t>());
      if (Json* textures = member(root, "textures"))
        for (Json& texture : *textures)
          if (index_at(texture, "source") == page.get<std::uint32_t>()) rename(texture);
    }
  }
  return renamed;
}

void empty_earlier_pages(Writer& w, const std::vector<std::uint32_t>& images) {
  // Whether another extension shows them is not known.
  const Pins pins = find_pins(w.document.json);
  if (extension(w.root, "EXT_lights_image_based") != nullptr) return;
  std::set<std::uint32_t> shown;  // textures
  if (const Json* materials = member(w.root, "materials"))
    for (const Json& material : *materials) add_textures(material, shown);
  std::set<std::uint32_t> needed;  // images
  const Json* textures = member(w.root, "textures");
  for (std::uint32_t t = 0; textures != nullptr && t < textures->size(); ++t) {
    const Json& texture = (*textures)[t];
    if (!shown.contains(t) && !pins.accessors.contains(t)) continue;
    needed.insert(index_at(texture, "source"));
    if (const Json* all = member(texture, "extensions"))
      for (const auto& [name, content] : all->items()) needed.insert(index_at(content, "source"));
  }
  std::uint32_t view = kNone;
  for (const std::uint32_t i : images) {
    Json& image = w.root["images"][i];
    if (needed.contains(i) || pins.accessors.contains(i) || !image.contains("bufferView")) continue;
    if (view == kNone) view = w.binary.add_file(image::encode_png({1, 1, {0, 0, 0, 255}}, false));
    image["bufferView"] = view;
    image["mimeType"] = "image/png";
  }
}

void clear_earlier_nodes(Json& root, std::uint32_t count) {
  for (std::uint32_t n = 0; n < count; ++n) {
    Json& node = root["nodes"][n];
    const Json* note = note_of(node);
    if (note == nullptr || !note->is_object() || !note->contains("box") || node.contains("mesh"))
      continue;
    node["extras"].erase(kNote);
    if (node["extras"].empty()) node.erase("extras");
    const std::string name = node.value("name", "");
    if (name.starts_with("batch_") || name.starts_with("cell_")) node.erase("name");
  }
}

}  // namespace lightbatch::scene_out
