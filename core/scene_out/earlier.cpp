#include "core/scene_out/earlier.h"

#include <string>

#include "core/scene_out/json_access.h"
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

}  // namespace

void rename_earlier_pages(Json& root, std::uint32_t scene_index) {
  if (scene_index >= count_of(root, "scenes")) return;
  for (const Json* about : {note_of(root["scenes"][scene_index]), note_of(root)}) {
    const Json* pages = about == nullptr ? nullptr : member(*about, kPageImages);
    if (pages == nullptr || !pages->is_array()) continue;
    for (const Json& page : *pages) {
      if (!page.is_number_unsigned() || page.get<std::uint64_t>() >= count_of(root, "images"))
        continue;
      rename(root["images"][page.get<std::size_t>()]);
      if (Json* textures = member(root, "textures"))
        for (Json& texture : *textures)
          if (index_at(texture, "source") == page.get<std::uint32_t>()) rename(texture);
    }
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
