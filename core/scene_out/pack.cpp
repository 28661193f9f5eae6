#include "core/scene_out/pack.h"

#include <algorithm>
#include <functional>
#include <set>

#include "core/scene_out/json_access.h"
#include "core/scene_out/references.h"
#include "core/scene_out/source_mesh.h"
#include "core/scene_out/view_ranges.h"

namespace lightbatch::scene_out {
namespace {

std::vector<bool> meshes_drawn(const Json& root) {
  std::vector<bool> drawn(count_of(root, "meshes"), false);
  if (const Json* nodes = member(root, "nodes"))
    for (const Json& node : *nodes)
      if (const std::uint32_t mesh = index_at(node, "mesh"); mesh < drawn.size())
        drawn[mesh] = true;
  return drawn;
}

/// Accessors that something reads.
std::vector<bool> accessors_read(Json& root) {
  std::vector<bool> read(count_of(root, "accessors"), false);
  const auto mark = [&](Json& slot) {
    const auto index = slot.get<std::size_t>();
    if (index < read.size()) read[index] = true;
  };
  for_each_accessor_outside_meshes(root, mark);
  if (Json* meshes = member(root, "meshes"))
    for (Json& mesh : *meshes) for_each_accessor_of_mesh(mesh, mark);
  return read;
}

/// Removes dead entries of a list and returns the new number of each. Entries below `original` keep
/// theirs when `stable`: the last new ones fill the gaps, and `filler` those that stay open.
std::vector<std::uint32_t> compact(Json& list, const std::vector<bool>& dead, bool stable,
                                   std::uint32_t original, const std::function<Json()>& filler) {
  std::vector<std::uint32_t> number(list.size(), kNone);
  Json kept = Json::array();
  if (!stable) {
    for (std::uint32_t i = 0; i < list.size(); ++i) {
      if (dead[i]) continue;
      number[i] = static_cast<std::uint32_t>(kept.size());
      kept.push_back(std::move(list[i]));
    }
  } else {
    auto last = static_cast<std::uint32_t>(list.size());
    for (std::uint32_t i = 0; i < last; ++i) {
      std::uint32_t from = i;
      if (dead[i]) {
        while (last > original && dead[last - 1]) --last;
        if (last > std::max(original, i + 1)) {
          from = --last;
        } else if (i < original) {
          kept.push_back(filler());
          continue;
        } else {
          break;
        }
      }
      number[from] = static_cast<std::uint32_t>(kept.size());
      kept.push_back(std::move(list[from]));
    }
  }
  list = std::move(kept);
  return number;
}

void renumber(Json& slot, const std::vector<std::uint32_t>& number) {
  const auto index = slot.get<std::size_t>();
  if (index < number.size() && number[index] != kNone) slot = number[index];
}

void drop_if_empty(Json& root, const char* key) {
  if (Json* list = member(root, key); list != nullptr && list->empty()) root.erase(key);
}

/// Buffer views whose buffer came without its data, as the format allows where nothing is drawn
/// from them.
std::vector<bool> views_without_data(const Json& root, std::span<const Bytes* const> buffers) {
  std::vector<bool> absent;
  for (const Json& view : root["bufferViews"]) {
    const std::uint32_t b = index_at(view, "buffer");
    const std::uint64_t end =
        view.value("byteOffset", std::uint64_t{0}) + view.value("byteLength", std::uint64_t{0});
    absent.push_back(b >= buffers.size() || buffers[b]->size() < end);
  }
  return absent;
}

/// Accessors and images let go of such views.
void detach(Json& root, const std::vector<bool>& absent) {
  const auto is_absent = [&](const Json& json) {
    const std::uint32_t view = index_at(json, "bufferView");
    return view < absent.size() && absent[view];
  };
  for (Json& accessor : root["accessors"]) {
    if (is_absent(accessor)) {
      accessor.erase("bufferView");
      accessor.erase("byteOffset");
    }
    const Json* sparse = member(accessor, "sparse");
    if (sparse != nullptr && (is_absent((*sparse)["indices"]) || is_absent((*sparse)["values"])))
      accessor.erase("sparse");
  }
  if (Json* images = member(root, "images"))
    for (Json& image : *images)
      if (is_absent(image)) image.erase("bufferView");
}

}  // namespace

void drop_meshes(Json& root, const Json& before) {
  Json* meshes = member(root, "meshes");
  if (meshes == nullptr) return;
  const Pins pins = find_pins(before);
  const std::vector<bool> drawn_before = meshes_drawn(before), drawn = meshes_drawn(root);
  std::vector<bool> dead(drawn.size(), false);
  for (std::uint32_t m = 0; m < drawn_before.size(); ++m)
    dead[m] = drawn_before[m] && !drawn[m] && !pins.meshes.contains(m);
  // A gap among pinned meshes is filled with a single point.
  const auto filler = [&] {
    const std::uint32_t a = append(root, "accessors",
                                   Json{{"componentType", 5126},
                                        {"count", 1},
                                        {"type", "VEC3"},
                                        {"min", {0, 0, 0}},
                                        {"max", {0, 0, 0}}});
    Json primitive{{"attributes", {{"POSITION", a}}}, {"mode", 0}};
    return Json{{"primitives", Json::array({std::move(primitive)})}};
  };
  const auto number =
      compact(*meshes, dead, !pins.meshes.empty(), count_of(before, "meshes"), filler);
  if (Json* nodes = member(root, "nodes"))
    for (Json& node : *nodes)
      if (Json* mesh = member(node, "mesh")) renumber(*mesh, number);
  drop_if_empty(root, "meshes");
}

Bytes pack(Json& root, const Json& before, std::span<const Bytes* const> buffers) {
  const Pins pins = find_pins(before);
  for (const char* key : {"accessors", "bufferViews"})
    if (!root.contains(key)) root[key] = Json::array();
  Json before_copy = before;
  const std::vector<bool> read_before = accessors_read(before_copy), read = accessors_read(root);
  std::vector<bool> accessor_dead(read.size(), false);
  for (std::uint32_t a = 0; a < read_before.size(); ++a)
    accessor_dead[a] = read_before[a] && !read[a] && !pins.accessors.contains(a);

  const auto accessor_number = compact(
      root["accessors"], accessor_dead, !pins.accessors.empty(), count_of(before, "accessors"), [] {
        return Json{{"componentType", 5126}, {"count", 1}, {"type", "SCALAR"}};
      });
  const auto move = [&](Json& slot) { renumber(slot, accessor_number); };
  for_each_accessor_outside_meshes(root, move);
  if (Json* meshes = member(root, "meshes"))
    for (Json& mesh : *meshes) for_each_accessor_of_mesh(mesh, move);

  const std::vector<bool> absent = views_without_data(root, buffers);
  detach(root, absent);
  std::set<std::uint32_t> pinned = pins.views;
  std::erase_if(pinned, [&](std::uint32_t v) { return v < absent.size() && absent[v]; });
  ViewUses uses(root, pinned);
  std::vector<bool> view_dead(root["bufferViews"].size());
  for (std::uint32_t v = 0; v < view_dead.size(); ++v) view_dead[v] = !uses.is_used(v);
  Bytes binary = uses.copy_ranges(root, buffers);
  const auto view_number = compact(root["bufferViews"], view_dead, !pins.views.empty(),
                                   count_of(before, "bufferViews"), [] {
                                     return Json{{"buffer", 0}, {"byteLength", 1}};
                                   });
  for_each_view(root, [&](Json& slot) { renumber(slot, view_number); });

  for (const char* key : {"accessors", "bufferViews"}) drop_if_empty(root, key);
  // Views that only unread extensions name need a buffer to lie in.
  if (binary.empty() && count_of(root, "bufferViews") > 0) binary.resize(4);
  Json buffer{{"byteLength", binary.size()}};
  if (count_of(root, "buffers") > 0)
    for (const char* key : {"name", "extras"})
      if (const Json* value = member(root["buffers"][0], key)) buffer[key] = *value;
  root.erase("buffers");
  if (!binary.empty()) root["buffers"] = Json::array({std::move(buffer)});
  return binary;
}

}  // namespace lightbatch::scene_out
