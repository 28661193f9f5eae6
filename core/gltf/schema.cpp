#include "core/gltf/schema.h"

#include <cmath>
#include <cstring>
#include <string_view>
#include <unordered_set>

namespace lightbatch::gltf {
namespace {

/// Lists that sit in an extension of the root.
constexpr const char* kLightList = "lights";
constexpr const char* kVariantList = "variants";

class Checker {
 public:
  Checker(const Json& root, std::vector<std::string>& warnings) : root_(root), warnings_(warnings) {
    if (const auto used = root.find("extensionsUsed"); used != root.end() && used->is_array()) {
      for (const Json& name : *used) {
        if (name.is_string()) declared_.insert(name.get<std::string>());
      }
    }
  }

  Status check_object(Json& json, const ObjectSchema& schema, const JsonPath& path) {
    if (!json.is_object()) return malformed(path.text(), "must be an object");
    for (const Property& property : schema.properties) {
      const auto found = json.find(property.name);
      if (found != json.end()) {
        LB_RETURN_IF_ERROR(check_property(*found, property, JsonPath(path, property.name)));
      } else if (property.required) {
        return malformed(path.text(),
                         std::string(schema.name) + " needs \"" + property.name + "\"");
      }
    }
    const auto extensions = json.find("extensions");
    if (extensions == json.end()) return {};
    return check_extensions(*extensions, schema, JsonPath(path, "extensions"));
  }

 private:
  void warn(const JsonPath& path, const std::string& message) {
    warnings_.push_back(path.text() + ": " + message);
  }

  std::uint64_t list_size(const char* list) const {
    const Json* holder = &root_;
    const bool light = std::strcmp(list, kLightList) == 0;
    if (light || std::strcmp(list, kVariantList) == 0) {
      for (const char* name :
           {"extensions", light ? "KHR_lights_punctual" : "KHR_materials_variants"}) {
        const auto part = holder->find(name);
        if (part == holder->end() || !part->is_object()) return 0;
        holder = &*part;
      }
    }
    const auto found = holder->find(list);
    return found == holder->end() || !found->is_array() ? 0 : found->size();
  }

  /// A non-negative integer, in whatever way it is written; becomes an integer in the tree.
  static bool as_unsigned(Json& json, std::uint64_t* value) {
    if (json.is_number_float()) {
      const double number = json.get<double>();
      if (!(number >= 0 && number <= 0x1p53) || number != std::floor(number)) return false;
      json = static_cast<std::uint64_t>(number);
    }
    if (json.is_number_unsigned()) {
      *value = json.get<std::uint64_t>();
      return true;
    }
    return false;
  }

  Status check_index(Json& json, const char* list, const JsonPath& path) const {
    std::uint64_t value = 0;
    if (!as_unsigned(json, &value)) return malformed(path.text(), "must be an index");
    if (list == nullptr) {
      if (value > 0xffffffffu) return malformed(path.text(), "must be a 32-bit number");
      return {};
    }
    const std::uint64_t size = list_size(list);
    if (value >= size) {
      return malformed(path.text(),
                       "index " + std::to_string(value) + " is out of range: there " +
                           (size == 1 ? "is 1 entry" : "are " + std::to_string(size) + " entries") +
                           " in \"" + list + "\"");
    }
    return {};
  }

  Status check_number(const Json& json, const Property& property, const JsonPath& path) {
    if (!json.is_number()) return malformed(path.text(), "must be a number");
    return check_range(json.get<double>(), property, path);
  }

  Status check_range(double value, const Property& property, const JsonPath& path) {
    if (value >= property.low && value <= property.high) return {};
    const std::string message = "value " + Json(value).dump() + " is out of range";
    if (property.range_is_error) return malformed(path.text(), message);
    warn(path, message);
    return {};
  }

  Status check_length(const Json& json, const Property& property, const JsonPath& path) const {
    if (!json.is_array()) return malformed(path.text(), "must be an array");
    if (json.size() >= property.least && json.size() <= property.most) return {};
    if (json.empty()) return malformed(path.text(), "must not be empty (leave it out instead)");
    return malformed(path.text(), "has " + std::to_string(json.size()) + " items, needs " +
                                      (json.size() < property.least
                                           ? std::to_string(property.least)
                                           : "at most " + std::to_string(property.most)));
  }

  Status check_property(Json& json, const Property& property, const JsonPath& path) {
    switch (property.kind) {
      case Kind::kIndex:
        return check_index(json, property.list, path);
      case Kind::kIndices:
        return check_indices(json, property, path);
      case Kind::kIndexMap:
        return check_index_map(json, property, path);
      case Kind::kIndexMaps:
        LB_RETURN_IF_ERROR(check_length(json, property, path));
        for (std::size_t i = 0; i < json.size(); ++i) {
          LB_RETURN_IF_ERROR(check_index_map(json[i], property, JsonPath(path, i)));
        }
        return {};
      case Kind::kUnsigned: {
        std::uint64_t value = 0;
        if (!as_unsigned(json, &value)) {
          return malformed(path.text(), "must be a non-negative integer");
        }
        return check_range(static_cast<double>(value), property, path);
      }
      case Kind::kChoice:
        return check_choice(json, property, path);
      case Kind::kNumber:
        return check_number(json, property, path);
      case Kind::kNumbers:
        LB_RETURN_IF_ERROR(check_length(json, property, path));
        for (std::size_t i = 0; i < json.size(); ++i) {
          LB_RETURN_IF_ERROR(check_number(json[i], property, JsonPath(path, i)));
        }
        return {};
      case Kind::kBoolean:
        if (!json.is_boolean()) return malformed(path.text(), "must be true or false");
        return {};
      case Kind::kText:
        if (!json.is_string()) return malformed(path.text(), "must be a string");
        return {};
      case Kind::kTexts:
        if (!json.is_array()) return malformed(path.text(), "must be an array");
        for (std::size_t i = 0; i < json.size(); ++i) {
          if (!json[i].is_string()) return malformed(JsonPath(path, i).text(), "must be a string");
        }
        if (json.empty()) warn(path, "is empty");
        return {};
      case Kind::kObject:
        return check_object(json, *property.schema, path);
      case Kind::kObjects:
        LB_RETURN_IF_ERROR(check_length(json, property, path));
        for (std::size_t i = 0; i < json.size(); ++i) {
          LB_RETURN_IF_ERROR(check_object(json[i], *property.schema, JsonPath(path, i)));
        }
        return {};
    }
    return {};
  }

  Status check_indices(Json& json, const Property& property, const JsonPath& path) {
    LB_RETURN_IF_ERROR(check_length(json, property, path));
    if (json.empty()) warn(path, "is empty");
    std::unordered_set<std::uint64_t> seen;
    for (std::size_t i = 0; i < json.size(); ++i) {
      const JsonPath item(path, i);
      LB_RETURN_IF_ERROR(check_index(json[i], property.list, item));
      if (!seen.insert(json[i].get<std::uint64_t>()).second) {
        return malformed(item.text(), "index " + json[i].dump() + " occurs twice");
      }
    }
    return {};
  }

  Status check_index_map(Json& json, const Property& property, const JsonPath& path) const {
    if (!json.is_object()) return malformed(path.text(), "must be an object");
    if (json.empty()) return malformed(path.text(), "must not be empty");
    for (auto& [name, value] : json.items()) {
      LB_RETURN_IF_ERROR(check_index(value, property.list, JsonPath(path, name)));
    }
    return {};
  }

  Status check_choice(Json& json, const Property& property, const JsonPath& path) {
    std::uint64_t value = 0;
    if (!as_unsigned(json, &value)) return malformed(path.text(), "must be an integer");
    for (const std::uint32_t allowed : property.choices) {
      if (value == allowed) return {};
    }
    const std::string message = "value " + std::to_string(value) + " is not one of those allowed";
    if (property.range_is_error) return malformed(path.text(), message);
    warn(path, message);
    return {};
  }

  Status check_extensions(Json& json, const ObjectSchema& host, const JsonPath& path) {
    if (!json.is_object()) return malformed(path.text(), "must be an object");
    for (auto& [name, value] : json.items()) {
      const JsonPath here(path, name);
      bool known = false;
      const ExtensionSchema* found = nullptr;
      for (const ExtensionSchema& candidate : extension_schemas()) {
        if (name != candidate.extension) continue;
        known = true;
        // Texture slots come in several shapes of the same name.
        if (candidate.host != nullptr && std::strcmp(candidate.host->name, host.name) == 0) {
          found = &candidate;
        }
      }
      if (known && found == nullptr) {
        return malformed(here.text(), name + " does not belong on this object");
      }
      if (!declared_.contains(name)) {
        return malformed(here.text(), name.substr(0, 80) + " is not listed in extensionsUsed");
      }
      if (known && !value.is_object()) return malformed(here.text(), "must be an object");
      if (found != nullptr && found->schema != nullptr) {
        LB_RETURN_IF_ERROR(check_object(value, *found->schema, here));
      } else if (!known && std::strcmp(host.name, "material") == 0 && value.is_object()) {
        LB_RETURN_IF_ERROR(check_texture_slots(value, here));
      }
    }
    return {};
  }

  /// Material extensions passed through unread: their texture slots still hold indices that a
  /// writer may have to follow.
  Status check_texture_slots(Json& json, const JsonPath& path) {
    for (auto& [name, value] : json.items()) {
      if (!name.ends_with("Texture") || !value.is_object() || !value.contains("index")) continue;
      LB_RETURN_IF_ERROR(check_object(value, kTextureInfoSchema, JsonPath(path, name)));
    }
    return {};
  }

  const Json& root_;
  std::vector<std::string>& warnings_;
  std::unordered_set<std::string> declared_;
};

}  // namespace

Status check_schema(Json& json, const JsonPath& root, std::vector<std::string>& warnings) {
  if (!json.is_object()) return malformed(root.text(), "a glTF file is a JSON object");
  return Checker(json, warnings).check_object(json, kRootSchema, root);
}

}  // namespace lightbatch::gltf
