#pragma once

#include <cstdint>
#include <limits>
#include <string>

#include "core/gltf/document.h"

/// Reading properties of a tree that check_schema() has accepted: types are right, defaults are
/// filled in here.
namespace lightbatch::gltf {

inline constexpr std::uint32_t kAbsent = std::numeric_limits<std::uint32_t>::max();

inline std::uint64_t unsigned_field(const Json& object, const char* name,
                                    std::uint64_t fallback = 0) {
  const auto found = object.find(name);
  return found == object.end() ? fallback : found->get<std::uint64_t>();
}
/// kAbsent when the property is not there.
inline std::uint32_t index_field(const Json& object, const char* name) {
  const auto found = object.find(name);
  return found == object.end() ? kAbsent : found->get<std::uint32_t>();
}
inline double number_field(const Json& object, const char* name, double fallback) {
  const auto found = object.find(name);
  return found == object.end() ? fallback : found->get<double>();
}
inline bool bool_field(const Json& object, const char* name) {
  const auto found = object.find(name);
  return found != object.end() && found->get<bool>();
}
inline std::string text_field(const Json& object, const char* name, const char* fallback = "") {
  const auto found = object.find(name);
  return found == object.end() ? fallback : found->get<std::string>();
}
/// The object's extension of that name, or nullptr.
inline const Json* extension_of(const Json& object, const char* name) {
  const auto extensions = object.find("extensions");
  if (extensions == object.end()) return nullptr;
  const auto found = extensions->find(name);
  return found == extensions->end() ? nullptr : &*found;
}
/// Items of an optional top-level list; empty when it is absent.
inline const Json& list_field(const Json& object, const char* name) {
  static const Json kEmpty = Json::array();
  const auto found = object.find(name);
  return found == object.end() ? kEmpty : *found;
}

}  // namespace lightbatch::gltf
