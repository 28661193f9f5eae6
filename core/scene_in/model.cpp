#define TINYGLTF_IMPLEMENTATION
#include "core/scene_in/model.h"

#include <exception>
#include <limits>
#include <string>

#include "core/gltf/json_text.h"

namespace lightbatch::scene_in {

Result<tinygltf::Model> read_model(const gltf::Document& document) {
  gltf::Json part;
  for (const char* name : {"asset", "extensionsUsed", "materials", "samplers", "textures"}) {
    const auto found = document.json.find(name);
    if (found != document.json.end()) part[name] = *found;
  }
  const auto extensions = document.json.find("extensions");
  if (extensions != document.json.end()) {
    const auto lights = extensions->find("KHR_lights_punctual");
    if (lights != extensions->end()) part["extensions"]["KHR_lights_punctual"] = *lights;
  }
  LB_ASSIGN_OR_RETURN(const std::string text, gltf::write_json(part));
  if (text.size() > std::numeric_limits<unsigned int>::max()) {
    return over_budget(document.name, "the materials take more than 4 GiB of JSON");
  }
  try {
    tinygltf::TinyGLTF loader;
    tinygltf::Model model;
    std::string error;
    std::string warning;
    if (!loader.LoadASCIIFromString(&model, &error, &warning, text.data(),
                                    static_cast<unsigned int>(text.size()), "",
                                    tinygltf::NO_REQUIRE)) {
      return malformed(document.name, "materials or lights cannot be read: " + error);
    }
    return model;
  } catch (const std::exception& error) {
    return malformed(document.name,
                     std::string("materials or lights cannot be read: ") + error.what());
  }
}

const tinygltf::Value* extension(const tinygltf::ExtensionMap& extensions, const char* name) {
  const auto found = extensions.find(name);
  return found == extensions.end() || !found->second.IsObject() ? nullptr : &found->second;
}

double number(const tinygltf::Value& object, const char* name, double fallback) {
  if (!object.Has(name) || !object.Get(name).IsNumber()) return fallback;
  return object.Get(name).GetNumberAsDouble();
}

double number(const tinygltf::Value& object, const char* name, int i, double fallback) {
  if (!object.Has(name)) return fallback;
  const tinygltf::Value& array = object.Get(name);
  if (!array.IsArray() || static_cast<std::size_t>(i) >= array.ArrayLen()) return fallback;
  const tinygltf::Value& value = array.Get(i);
  return value.IsNumber() ? value.GetNumberAsDouble() : fallback;
}

}  // namespace lightbatch::scene_in
