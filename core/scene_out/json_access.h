#pragma once

#include <cstdint>
#include <string_view>

#include "core/gltf/document.h"
#include "core/scene/scene.h"

namespace lightbatch::scene_out {

using gltf::Json;
using scene::kNone;

/// The member, or null when there is none (or `json` is no object).
inline const Json* member(const Json& json, std::string_view key) {
  if (!json.is_object()) return nullptr;
  const auto it = json.find(key);
  return it == json.end() ? nullptr : &*it;
}
inline Json* member(Json& json, std::string_view key) {
  if (!json.is_object()) return nullptr;
  const auto it = json.find(key);
  return it == json.end() ? nullptr : &*it;
}

/// The index under a key, or kNone.
inline std::uint32_t index_at(const Json& json, std::string_view key) {
  const Json* value = member(json, key);
  if (value == nullptr || !value->is_number_integer()) return kNone;
  const auto index = value->get<std::int64_t>();
  return index >= 0 && index < std::int64_t{kNone} ? static_cast<std::uint32_t>(index) : kNone;
}

/// Entries of a top-level array; 0 when there is none.
inline std::uint32_t count_of(const Json& root, std::string_view key) {
  const Json* array = member(root, key);
  return array != nullptr && array->is_array() ? static_cast<std::uint32_t>(array->size()) : 0;
}

/// Appends to a top-level array, made when missing; returns the new index.
inline std::uint32_t append(Json& root, const char* key, Json value) {
  Json& array = root[key];
  if (!array.is_array()) array = Json::array();
  array.push_back(std::move(value));
  return static_cast<std::uint32_t>(array.size() - 1);
}

/// The extension object of that name, or null.
inline const Json* extension(const Json& json, std::string_view name) {
  const Json* all = member(json, "extensions");
  return all == nullptr ? nullptr : member(*all, name);
}

/// Takes an extension away, and the "extensions" object with it when nothing is left.
inline void erase_extension(Json& json, const char* name) {
  Json* all = member(json, "extensions");
  if (all == nullptr || !all->is_object()) return;
  all->erase(name);
  if (all->empty()) json.erase("extensions");
}

/// Adds a name to extensionsUsed or extensionsRequired, once.
inline void declare_extension(Json& root, const char* list, const char* name) {
  Json& names = root[list];
  if (!names.is_array()) names = Json::array();
  for (const Json& n : names)
    if (n == name) return;
  names.push_back(name);
}

/// Takes a name out of extensionsUsed and extensionsRequired; empty lists go.
inline void undeclare_extension(Json& root, const char* name) {
  for (const char* list : {"extensionsUsed", "extensionsRequired"}) {
    Json* names = member(root, list);
    if (names == nullptr || !names->is_array()) continue;
    Json kept = Json::array();
    for (Json& n : *names)
      if (n != name) kept.push_back(std::move(n));
    if (kept.empty())
      root.erase(list);
    else
      *names = std::move(kept);
  }
}

/// The node's property that holds an attribute of GPU instances; null: none does.
inline const char* property_of_attribute(const std::string& name) {
  if (name == "TRANSLATION") return "translation";
  if (name == "ROTATION") return "rotation";
  return name == "SCALE" ? "scale" : nullptr;
}

}  // namespace lightbatch::scene_out
