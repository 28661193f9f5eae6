#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>

#include "core/gltf/schema.h"

/// The words in which the tables of properties are written.
namespace lightbatch::gltf::schema_terms {

inline constexpr double kPi = 3.14159265358979323846;
inline constexpr double kLargest = std::numeric_limits<double>::max();
inline constexpr double kLargestInteger = 9007199254740991;  // 2^53 - 1: exact as a JSON number

constexpr Property index(const char* name, const char* list) {
  return {.name = name, .kind = Kind::kIndex, .list = list};
}
constexpr Property indices(const char* name, const char* list, std::size_t least = 1) {
  return {.name = name, .kind = Kind::kIndices, .list = list, .least = least};
}
constexpr Property index_map(const char* name, const char* list) {
  return {.name = name, .kind = Kind::kIndexMap, .list = list};
}
constexpr Property index_maps(const char* name, const char* list) {
  return {.name = name, .kind = Kind::kIndexMaps, .list = list};
}
constexpr Property count(const char* name, double low = 0, double high = kLargestInteger) {
  return {.name = name, .kind = Kind::kUnsigned, .low = low, .high = high, .range_is_error = true};
}
/// A count whose range is only worth a warning.
constexpr Property loose_count(const char* name, double low, double high = kLargestInteger) {
  return {.name = name, .kind = Kind::kUnsigned, .low = low, .high = high};
}
constexpr Property choice(const char* name, std::span<const std::uint32_t> choices,
                          bool range_is_error = true) {
  return {
      .name = name, .kind = Kind::kChoice, .choices = choices, .range_is_error = range_is_error};
}
constexpr Property number(const char* name, double low = -kLargest, double high = kLargest) {
  return {.name = name, .kind = Kind::kNumber, .low = low, .high = high};
}
constexpr Property numbers(const char* name, std::size_t length, double low = -kLargest,
                           double high = kLargest) {
  return {.name = name,
          .kind = Kind::kNumbers,
          .low = low,
          .high = high,
          .least = length,
          .most = length};
}
constexpr Property some_numbers(const char* name, std::size_t most) {
  return {.name = name, .kind = Kind::kNumbers, .most = most};
}
constexpr Property boolean(const char* name) { return {.name = name, .kind = Kind::kBoolean}; }
constexpr Property text(const char* name) { return {.name = name, .kind = Kind::kText}; }
constexpr Property texts(const char* name) { return {.name = name, .kind = Kind::kTexts}; }
constexpr Property object(const char* name, const ObjectSchema& schema) {
  return {.name = name, .kind = Kind::kObject, .schema = &schema};
}
constexpr Property objects(const char* name, const ObjectSchema& schema) {
  return {.name = name, .kind = Kind::kObjects, .schema = &schema};
}
constexpr Property required(Property property) {
  property.required = true;
  return property;
}

}  // namespace lightbatch::gltf::schema_terms
