#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <string>
#include <vector>

#include "core/gltf/document.h"
#include "core/gltf/json_path.h"

namespace lightbatch::gltf {

enum class Kind : std::uint8_t {
  kIndex,      // into the top-level list named by Property::list
  kIndices,    // array of them
  kIndexMap,   // object of them (attributes)
  kIndexMaps,  // array of such objects (morph targets)
  kUnsigned,   // integer in [low, high]
  kChoice,     // one of Property::choices
  kNumber,     // in [low, high]
  kNumbers,    // array of `least`..`most` numbers, each in [low, high]
  kBoolean,
  kText,
  kTexts,    // array of strings
  kObject,   // of Property::schema
  kObjects,  // array of `least` or more objects of Property::schema
};

struct ObjectSchema;

/// One property of an object of the glTF 2.0 specification (or of an extension we understand).
struct Property {
  const char* name;
  Kind kind;
  bool required = false;
  const char* list = nullptr;
  const ObjectSchema* schema = nullptr;
  std::span<const std::uint32_t> choices = {};
  double low = -std::numeric_limits<double>::max();
  double high = std::numeric_limits<double>::max();
  /// Out of [low, high] or not one of choices: an error, or only a warning.
  bool range_is_error = false;
  std::size_t least = 1;
  std::size_t most = std::numeric_limits<std::size_t>::max();
};

struct ObjectSchema {
  const char* name;
  std::span<const Property> properties;
};

/// An extension and the object it may sit on; schema nullptr: content is not looked at.
struct ExtensionSchema {
  const char* extension;
  const ObjectSchema* host;
  const ObjectSchema* schema;
};

extern const ObjectSchema kRootSchema;
extern const ObjectSchema kNodeSchema;
extern const ObjectSchema kMaterialSchema;
extern const ObjectSchema kPrimitiveSchema;
extern const ObjectSchema kTextureSchema;
extern const ObjectSchema kTextureInfoSchema;
extern const ObjectSchema kNormalTextureSchema;
extern const ObjectSchema kBufferSchema;
extern const ObjectSchema kBufferViewSchema;
extern const ObjectSchema kChannelTargetSchema;
std::span<const ExtensionSchema> extension_schemas();

/// Checks the whole tree against the tables: types, required properties, empty lists, indices,
/// lengths, and known extensions on objects they do not belong to. Integers written as floats (1.0)
/// become integers, so that later steps meet one form only. Values out of their range that harm
/// nobody who does not read them become warnings. What the tables do not name is left alone.
Status check_schema(Json& json, const JsonPath& root, std::vector<std::string>& warnings);

}  // namespace lightbatch::gltf
