#pragma once

#include "core/base/status.h"
#include "core/gltf/document.h"
#include "core/scene_in/tinygltf.h"

namespace lightbatch::scene_in {

/// Materials, textures, samplers and punctual lights of a document as tinygltf sees them, defaults
/// filled in. Geometry, nodes and images stay with the document's JSON: tinygltf refuses some valid
/// accessors, and its images are decoded here.
Result<tinygltf::Model> read_model(const gltf::Document& document);

/// The member of an extension object, or nullptr.
const tinygltf::Value* extension(const tinygltf::ExtensionMap& extensions, const char* name);
double number(const tinygltf::Value& object, const char* name, double fallback);
/// Component i of an array member.
double number(const tinygltf::Value& object, const char* name, int i, double fallback);

}  // namespace lightbatch::scene_in
