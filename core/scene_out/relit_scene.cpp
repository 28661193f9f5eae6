#include "core/scene_out/relit_scene.h"

#include <algorithm>

#include "core/gltf/document.h"
#include "core/gltf/glb_container.h"
#include "core/gltf/glb_writer.h"
#include "core/gltf/json_text.h"
#include "core/scene_out/json_access.h"
#include "core/scene_out/write_scene.h"

namespace lightbatch::scene_out {
namespace {

constexpr const char* kLightmap = "MOZ_lightmap";
constexpr const char* kLights = "KHR_lights_punctual";
constexpr const char* kStrength = "KHR_materials_emissive_strength";
/// What is moved in the file keeps its address modulo this, so that no alignment breaks.
constexpr std::size_t kAlignment = 16;

/// Bytes of the file that give way to others.
struct Slot {
  std::size_t begin = 0, end = 0;
  const Bytes* bytes = nullptr;
  std::size_t shift = 0;  // of what follows, modulo 2^64
};

/// What write_scene() left word of in extras.lightbatch, of the scene or else of the file.
const Json& about_of(const Json& root) {
  static const Json kNothing = Json::object();
  const std::uint32_t named = index_at(root, "scene");
  const std::uint32_t scene = named == kNone ? 0 : named;
  const Json* holders[] = {scene < count_of(root, "scenes") ? &root["scenes"][scene] : &root,
                           &root};
  for (const Json* holder : holders) {
    const Json* extras = member(*holder, "extras");
    const Json* about = extras == nullptr ? nullptr : member(*extras, "lightbatch");
    if (about != nullptr && about->is_object()) return *about;
  }
  return kNothing;
}

/// Numbers in a list; kNone for what is none.
std::vector<std::uint32_t> numbers_in(const Json& holder, std::string_view key) {
  std::vector<std::uint32_t> numbers;
  const Json* list = member(holder, key);
  if (list == nullptr || !list->is_array()) return numbers;
  for (const Json& number : *list) {
    numbers.push_back(number.is_number_unsigned() && number.get<std::uint64_t>() < kNone
                          ? number.get<std::uint32_t>()
                          : kNone);
  }
  return numbers;
}

/// Whatever names a place in the binary chunk: buffer views, and what compresses them.
template <typename Visit>
void for_each_range(Json& root, const Visit& visit) {
  Json* views = member(root, "bufferViews");
  if (views == nullptr || !views->is_array()) return;
  for (Json& view : *views) {
    if (index_at(view, "buffer") == 0) visit(view);
    Json* extensions = member(view, "extensions");
    if (extensions == nullptr || !extensions->is_object()) continue;
    for (auto& [name, range] : extensions->items()) {
      if (index_at(range, "buffer") == 0) visit(range);
    }
  }
}

std::size_t offset_of(const Json& range) {
  const std::uint32_t offset = index_at(range, "byteOffset");
  return offset == kNone ? 0 : offset;
}

/// images[k]: the number of the image of page k.
Result<std::vector<Slot>> find_slots(const Json& root, const std::vector<std::uint32_t>& images,
                                     std::span<const RelitPage> pages, std::size_t binary_size,
                                     const std::string& place) {
  const auto refused = [&] {
    return malformed(place, "does not hold the " + std::to_string(pages.size()) +
                                " lightmap pages of its bake; give the files as they were made");
  };
  if (images.size() != pages.size()) return refused();
  std::vector<Slot> slots;
  for (std::size_t page = 0; page < pages.size(); ++page) {
    if (images[page] >= count_of(root, "images")) return refused();
    const std::uint32_t view = index_at(root["images"][images[page]], "bufferView");
    if (view >= count_of(root, "bufferViews")) return refused();
    const Json& range = root["bufferViews"][view];
    const std::uint32_t length = index_at(range, "byteLength");
    const std::size_t begin = offset_of(range);
    if (index_at(range, "buffer") != 0 || length == kNone || begin > binary_size ||
        length > binary_size - begin) {
      return malformed(place + "#/bufferViews/" + std::to_string(view), "lies outside the file");
    }
    slots.push_back({begin, begin + length, &pages[page].png, 0});
  }
  std::sort(slots.begin(), slots.end(),
            [](const Slot& a, const Slot& b) { return a.begin < b.begin; });
  for (std::size_t k = 1; k < slots.size(); ++k) {
    if (slots[k].begin < slots[k - 1].end || slots[k].begin == slots[k - 1].begin)
      return malformed(place, "lightmap pages overlap");
  }
  return slots;
}

/// The binary chunk with the slots filled anew; what follows them is moved.
Bytes refill(std::span<const std::byte> binary, std::vector<Slot>& slots) {
  Bytes out;
  std::size_t at = 0;
  for (Slot& slot : slots) {
    out.insert(out.end(), binary.begin() + static_cast<std::ptrdiff_t>(at),
               binary.begin() + static_cast<std::ptrdiff_t>(slot.begin));
    out.insert(out.end(), slot.bytes->begin(), slot.bytes->end());
    while (out.size() % kAlignment != slot.end % kAlignment) out.push_back(std::byte{0});
    slot.shift = out.size() - slot.end;
    at = slot.end;
  }
  out.insert(out.end(), binary.begin() + static_cast<std::ptrdiff_t>(at), binary.end());
  return out;
}

void move_ranges(Json& root, const std::vector<Slot>& slots) {
  for_each_range(root, [&](Json& range) {
    const std::size_t offset = offset_of(range);
    std::size_t shift = 0;
    for (const Slot& slot : slots) {
      if (slot.end <= offset) shift = slot.shift;
      if (slot.begin == offset && index_at(range, "byteLength") == slot.end - slot.begin) {
        range["byteLength"] = slot.bytes->size();
      }
    }
    if (range.contains("byteOffset") || shift != 0) range["byteOffset"] = offset + shift;
  });
}

void set_intensities(Json& root, const std::vector<std::uint32_t>& images,
                     std::span<const RelitPage> pages) {
  Json* materials = member(root, "materials");
  if (materials == nullptr || !materials->is_array()) return;
  for (Json& material : *materials) {
    Json* extensions = member(material, "extensions");
    Json* lightmap = extensions == nullptr ? nullptr : member(*extensions, kLightmap);
    if (lightmap == nullptr) continue;
    const std::uint32_t texture = index_at(*lightmap, "index");
    if (texture >= count_of(root, "textures")) continue;
    const std::uint32_t image = index_at(root["textures"][texture], "source");
    const auto page =
        static_cast<std::size_t>(std::find(images.begin(), images.end(), image) - images.begin());
    if (page < pages.size()) (*lightmap)["intensity"] = pages[page].intensity;
  }
}

void set_light(Json& definition, const RelitLight& light) {
  definition["color"] = light.color;
  definition["intensity"] = light.intensity;
}

/// Lights that were taken out of the scene, in the extras of a scene or of the file.
void set_taken(Json& holder, std::span<const RelitLight> lights) {
  Json* extras = member(holder, "extras");
  Json* about = extras == nullptr ? nullptr : member(*extras, "lightbatch");
  Json* taken = about == nullptr ? nullptr : member(*about, "lights");
  if (taken == nullptr || !taken->is_array()) return;
  for (Json& entry : *taken) {
    Json* definition = member(entry, "light");
    if (definition == nullptr || !definition->is_object()) continue;
    for (const RelitLight& light : lights) {
      if (index_at(entry, "index") == light.index) set_light(*definition, light);
    }
  }
}

void set_lights(Json& root, std::span<const RelitLight> lights) {
  set_taken(root, lights);
  if (Json* scenes = member(root, "scenes"); scenes != nullptr && scenes->is_array()) {
    for (Json& scene : *scenes) set_taken(scene, lights);
  }
  Json* extensions = member(root, "extensions");
  Json* punctual = extensions == nullptr ? nullptr : member(*extensions, kLights);
  Json* definitions = punctual == nullptr ? nullptr : member(*punctual, "lights");
  if (definitions == nullptr || !definitions->is_array()) return;
  for (const RelitLight& light : lights) {
    if (light.index < definitions->size() && (*definitions)[light.index].is_object()) {
      set_light((*definitions)[light.index], light);
    }
  }
}

/// Files of light that are no sums over light groups hold the old light: the scene names them no
/// more.
void forget_files(Json& root) {
  const auto forget = [](Json& holder) {
    Json* extras = member(holder, "extras");
    Json* about = extras == nullptr ? nullptr : member(*extras, "lightbatch");
    if (about == nullptr || !about->is_object()) return;
    for (const char* key : {"probes", "directional"}) about->erase(key);
  };
  forget(root);
  if (Json* scenes = member(root, "scenes"); scenes != nullptr && scenes->is_array()) {
    for (Json& scene : *scenes) forget(scene);
  }
}

/// The material and its clones on other pages.
void set_emission(Json& root, std::vector<std::uint32_t> clones, const RelitMaterial& relit) {
  Json* materials = member(root, "materials");
  clones.push_back(relit.index);
  for (const std::uint32_t index : clones) {
    if (index >= count_of(root, "materials") || !(*materials)[index].is_object()) continue;
    Json& material = (*materials)[index];
    material["emissiveFactor"] = relit.emissive_factor;
    if (relit.emissive_strength != 1) {
      material["extensions"][kStrength] = {{"emissiveStrength", relit.emissive_strength}};
      declare_extension(root, "extensionsUsed", kStrength);
    } else {
      erase_extension(material, kStrength);
    }
  }
}

}  // namespace

Result<Bytes> relit_scene(std::span<const std::byte> glb, const std::string& place,
                          std::span<const RelitPage> pages, std::span<const RelitLight> lights,
                          std::span<const RelitMaterial> materials) {
  if (!gltf::is_glb(glb)) return malformed(place, "is no .glb");
  LB_ASSIGN_OR_RETURN(const gltf::GlbChunks chunks, gltf::split_glb(glb, place));
  const gltf::ReadLimits limits;
  LB_ASSIGN_OR_RETURN(
      Json root, gltf::parse_json(chunks.json, place, limits.json_depth, limits.decoded_bytes));
  const auto binary = chunks.binary.value_or(std::span<const std::byte>{});
  const Json about = about_of(root);
  const std::vector<std::uint32_t> images = numbers_in(about, kPageImages);
  LB_ASSIGN_OR_RETURN(auto slots, find_slots(root, images, pages, binary.size(), place));
  const Bytes filled = refill(binary, slots);
  move_ranges(root, slots);
  set_intensities(root, images, pages);
  set_lights(root, lights);
  forget_files(root);
  const Json* emitters = member(about, kEmitters);
  for (const RelitMaterial& material : materials) {
    const auto clones = emitters == nullptr ? std::vector<std::uint32_t>{}
                                            : numbers_in(*emitters, std::to_string(material.index));
    set_emission(root, clones, material);
  }
  return gltf::write_glb(std::move(root), filled);
}

}  // namespace lightbatch::scene_out
