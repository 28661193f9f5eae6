#pragma once

/// One fault per scene: each must be refused, with the reason and the place named.
#include <gtest/gtest.h>

#include <functional>

#include "tests/unit/gltf/scene_files.h"

namespace lightbatch::gltf {
namespace {

constexpr const char* kMalformed = "INPUT_MALFORMED";
constexpr const char* kOverBudget = "INPUT_OVER_BUDGET";
constexpr const char* kUnsupported = "INPUT_UNSUPPORTED";
constexpr const char* kForbidden = "SCENE_URI_FORBIDDEN";

struct Fault {
  const char* name;
  std::function<void(Json&)> make;
  const char* reason;
  const char* place;  // part of it
};

void use(Json& json, const char* extension, bool required = false) {
  json["extensionsUsed"].push_back(extension);
  if (required) json["extensionsRequired"].push_back(extension);
}

/// Node 0 by accessors 2 (two times) and 3 (two values), both without data of their own.
void animate(Json& json, const char* path, const char* type) {
  json["accessors"].push_back({{"componentType", 5126}, {"count", 2}, {"type", "SCALAR"}});
  json["accessors"].push_back({{"componentType", 5126}, {"count", 2}, {"type", type}});
  json["animations"] = {
      {{"channels", {{{"sampler", 0}, {"target", {{"node", 0}, {"path", path}}}}}},
       {"samplers", {{{"input", 2}, {"output", 3}}}}}};
}

/// Accessor 0: four positions (view 0); accessor 1: six indices (view 1).
const std::vector<Fault>& faults() {
  static const std::vector<Fault> kFaults = {
      {"index", [](Json& j) { j["nodes"][0]["mesh"] = 5; }, kMalformed, "#/nodes/0/mesh"},
      {"negative index", [](Json& j) { j["nodes"][0]["mesh"] = -1; }, kMalformed, "mesh"},
      {"fractional index", [](Json& j) { j["scene"] = 0.5; }, kMalformed, "#/scene"},
      {"huge index", [](Json& j) { j["scene"] = 1e300; }, kMalformed, "#/scene"},
      {"wrong type", [](Json& j) { j["scene"] = "0"; }, kMalformed, "#/scene"},
      {"list is no array", [](Json& j) { j["nodes"] = 3; }, kMalformed, "#/nodes"},
      {"empty list", [](Json& j) { j["materials"] = Json::array(); }, kMalformed, "#/materials"},
      {"null", [](Json& j) { j["nodes"][0] = nullptr; }, kMalformed, "#/nodes/0"},
      {"no version", [](Json& j) { j["asset"].erase("version"); }, kMalformed, "#/asset"},
      {"glTF 1", [](Json& j) { j["asset"]["version"] = "1.0"; }, kUnsupported, "asset/version"},
      {"version text", [](Json& j) { j["asset"]["version"] = "two"; }, kMalformed, "asset"},
      {"minVersion", [](Json& j) { j["asset"]["minVersion"] = "3.0"; }, kUnsupported, "asset"},
      {"required extension", [](Json& j) { use(j, "ACME_magic", true); }, kUnsupported,
       "#/extensionsRequired/0"},
      {"extension in the wrong place",
       [](Json& j) {
         use(j, "KHR_lights_punctual");
         j["scenes"][0]["extensions"]["KHR_lights_punctual"]["light"] = 0;
       },
       kMalformed, "#/scenes/0/extensions/KHR_lights_punctual"},
      {"undeclared extension",
       [](Json& j) { j["nodes"][0]["extensions"]["KHR_lights_punctual"]["light"] = 0; }, kMalformed,
       "#/nodes/0/extensions"},
      {"light out of range",
       [](Json& j) {
         use(j, "KHR_lights_punctual");
         j["extensions"]["KHR_lights_punctual"]["lights"] = {{{"type", "point"}}};
         j["nodes"][0]["extensions"]["KHR_lights_punctual"]["light"] = 1;
       },
       kMalformed, "light"},
      {"spot without cone",
       [](Json& j) {
         use(j, "KHR_lights_punctual");
         j["extensions"]["KHR_lights_punctual"]["lights"] = {{{"type", "spot"}}};
       },
       kMalformed, "lights/0"},
      {"self cycle", [](Json& j) { j["nodes"][0]["children"] = {0}; }, kMalformed, "#/nodes/0"},
      {"cycle beside the scene",
       [](Json& j) {
         j["nodes"].push_back({{"children", {2}}});
         j["nodes"].push_back({{"children", {1}}});
       },
       kMalformed, "#/nodes/1"},
      {"two parents",
       [](Json& j) {
         j["nodes"][0]["children"] = {2};
         j["nodes"].push_back({{"children", {2}}});
         j["nodes"].push_back(Json::object());
       },
       kMalformed, "#/nodes/1/children/0"},
      {"child twice",
       [](Json& j) {
         j["nodes"].push_back(Json::object());
         j["nodes"][0]["children"] = {1, 1};
       },
       kMalformed, "#/nodes/0/children/1"},
      {"scene of a child",
       [](Json& j) {
         j["nodes"][0]["children"] = {1};
         j["nodes"].push_back(Json::object());
         j["scenes"][0]["nodes"] = {1};
       },
       kMalformed, "#/scenes/0/nodes"},
      {"matrix and translation",
       [](Json& j) {
         j["nodes"][0]["matrix"] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
         j["nodes"][0]["translation"] = {0, 0, 0};
       },
       kMalformed, "#/nodes/0"},
      {"projective matrix",
       [](Json& j) { j["nodes"][0]["matrix"] = {1, 0, 0, 1, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}; },
       kMalformed, "#/nodes/0"},
      {"short translation",
       [](Json& j) {
         j["nodes"][0]["translation"] = {0, 0};
       },
       kMalformed, "translation"},
      {"count 0", [](Json& j) { j["accessors"][0]["count"] = 0; }, kMalformed, "#/accessors/0"},
      {"count past the view", [](Json& j) { j["accessors"][0]["count"] = 5; }, kMalformed,
       "#/accessors/0"},
      {"count that overflows 64 bits",
       [](Json& j) { j["accessors"][0]["count"] = 9007199254740991; }, kMalformed, "#/accessors/0"},
      {"offset that overflows", [](Json& j) { j["accessors"][0]["byteOffset"] = 9007199254740988; },
       kMalformed, "#/accessors/0"},
      {"number beyond 2^53",
       [](Json& j) { j["accessors"][0]["byteOffset"] = 18446744073709551612ull; }, kMalformed,
       "byteOffset"},
      {"stride that overflows",
       [](Json& j) { j["bufferViews"][0]["byteStride"] = 9007199254740988; }, kMalformed,
       "#/accessors/0"},
      {"stride 0", [](Json& j) { j["bufferViews"][0]["byteStride"] = 0; }, kMalformed,
       "#/accessors/0"},
      {"small stride", [](Json& j) { j["bufferViews"][0]["byteStride"] = 8; }, kMalformed,
       "#/accessors/0"},
      {"misaligned", [](Json& j) { j["accessors"][1]["byteOffset"] = 1; }, kMalformed,
       "#/accessors/1"},
      {"component type", [](Json& j) { j["accessors"][0]["componentType"] = 5124; }, kMalformed,
       "componentType"},
      {"view past its buffer", [](Json& j) { j["bufferViews"][0]["byteLength"] = 4096; },
       kMalformed, "#/bufferViews/0"},
      {"view offset overflow",
       [](Json& j) { j["bufferViews"][0]["byteOffset"] = 9007199254740991; }, kMalformed,
       "#/bufferViews/0"},
      {"buffer longer than its data",
       [](Json& j) {
         j["buffers"] = {{{"byteLength", 1000000000}, {"uri", "data:,x"}}};
       },
       kMalformed, "#/buffers/0"},
      {"buffer without data that is used",
       [](Json& j) {
         j["buffers"].push_back({{"byteLength", 1000}});
         j["bufferViews"][0]["buffer"] = 1;
       },
       kMalformed, "POSITION"},
      {"position of the wrong type",
       [](Json& j) {
         j["accessors"][0] = {{"componentType", 5126}, {"count", 4}, {"type", "VEC2"}};
       },
       kMalformed, "POSITION"},
      {"position of unknown type", [](Json& j) { j["accessors"][0]["type"] = "VEC9"; }, kMalformed,
       "POSITION"},
      {"quantised without the extension",
       [](Json& j) { j["accessors"][0]["componentType"] = 5123; }, kMalformed, "POSITION"},
      {"indices of floats", [](Json& j) { j["meshes"][0]["primitives"][0]["indices"] = 0; },
       kMalformed, "indices"},
      {"unequal attribute counts",
       [](Json& j) {
         j["accessors"].push_back({{"componentType", 5126}, {"count", 3}, {"type", "VEC3"}});
         j["meshes"][0]["primitives"][0]["attributes"]["NORMAL"] = 2;
       },
       kMalformed, "NORMAL"},
      {"index beyond the vertices", [](Json& j) { j["accessors"][0]["count"] = 3; }, kMalformed,
       "indices"},
      {"texture without coordinates",
       [](Json& j) {
         j["textures"] = {Json::object()};
         j["materials"] = {{{"emissiveTexture", {{"index", 0}}}}};
         j["meshes"][0]["primitives"][0]["material"] = 0;
       },
       kMalformed, "#/meshes/0/primitives/0"},
      {"texture of an unread extension",
       [](Json& j) {
         use(j, "KHR_materials_sheen");
         j["materials"] = {
             {{"extensions", {{"KHR_materials_sheen", {{"sheenColorTexture", {{"index", 7}}}}}}}}};
       },
       kMalformed, "sheenColorTexture"},
      {"zeros without end",
       [](Json& j) {
         j["accessors"].push_back(
             {{"componentType", 5126}, {"count", 2000000000}, {"type", "VEC3"}});
       },
       kOverBudget, "#/accessors"},
      {"zeros that overflow",
       [](Json& j) {
         for (int i = 0; i < 3000; ++i) {
           j["accessors"].push_back(
               {{"componentType", 5126}, {"count", 9007199254740991}, {"type", "MAT4"}});
         }
       },
       kOverBudget, "#/accessors"},
      {"sparse longer than its accessor",
       [](Json& j) {
         j["accessors"][0]["sparse"] = {{"count", 5},
                                        {"indices", {{"bufferView", 1}, {"componentType", 5123}}},
                                        {"values", {{"bufferView", 0}}}};
       },
       kMalformed, "#/accessors/0"},
      {"sparse indices do not ascend",
       [](Json& j) {
         j["accessors"][0]["sparse"] = {{"count", 4},
                                        {"indices", {{"bufferView", 1}, {"componentType", 5123}}},
                                        {"values", {{"bufferView", 0}}}};
       },
       kMalformed, "sparse"},
      {"animation sampler",
       [](Json& j) {
         j["animations"] = {{{"channels", {{{"sampler", 1}, {"target", {{"path", "scale"}}}}}},
                             {"samplers", {{{"input", 2}, {"output", 2}}}}}};
         j["accessors"].push_back({{"componentType", 5126}, {"count", 1}, {"type", "SCALAR"}});
       },
       kMalformed, "#/animations/0/channels/0"},
      {"animation of a matrix",
       [](Json& j) {
         j["nodes"][0]["matrix"] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
         animate(j, "translation", "VEC3");
       },
       kMalformed, "#/animations/0/channels/0"},
      {"animation without morph targets", [](Json& j) { animate(j, "weights", "SCALAR"); },
       kMalformed, "#/animations/0/channels/0"},
      {"animation output type", [](Json& j) { animate(j, "rotation", "VEC3"); }, kMalformed,
       "#/animations/0/channels/0"},
      {"animation output count",
       [](Json& j) {
         animate(j, "scale", "VEC3");
         j["accessors"][3]["count"] = 3;
       },
       kMalformed, "#/animations/0/channels/0"},
      {"animated twice",
       [](Json& j) {
         animate(j, "scale", "VEC3");
         const Json channel = j["animations"][0]["channels"][0];
         j["animations"][0]["channels"].push_back(channel);
       },
       kMalformed, "#/animations/0/channels/1"},
      {"skin without mesh",
       [](Json& j) {
         j["skins"] = {{{"joints", {0}}}};
         j["nodes"].push_back({{"skin", 0}});
       },
       kMalformed, "#/nodes/1"},
      {"skinned mesh without joints",
       [](Json& j) {
         j["skins"] = {{{"joints", {0}}}};
         j["nodes"][0]["skin"] = 0;
       },
       kMalformed, "#/nodes/0"},
      {"skeleton beside its joints",
       [](Json& j) {
         j["nodes"][0]["children"] = {1, 2};
         j["nodes"].push_back(Json::object());
         j["nodes"].push_back(Json::object());
         j["skins"] = {{{"joints", {1}}, {"skeleton", 2}}};
       },
       kMalformed, "#/skins/0"},
      {"joints without weights",
       [](Json& j) {
         j["accessors"].push_back({{"componentType", 5121}, {"count", 4}, {"type", "VEC4"}});
         j["meshes"][0]["primitives"][0]["attributes"]["JOINTS_0"] = 2;
       },
       kMalformed, "JOINTS_0"},
      {"colours of the wrong kind",
       [](Json& j) {
         j["accessors"].push_back({{"componentType", 5122}, {"count", 4}, {"type", "VEC4"}});
         j["meshes"][0]["primitives"][0]["attributes"]["COLOR_0"] = 2;
       },
       kMalformed, "COLOR_0"},
      {"morph target of an attribute that is not there",
       [](Json& j) {
         j["meshes"][0]["primitives"][0]["targets"] = {{{"NORMAL", 0}}};
       },
       kMalformed, "#/meshes/0/primitives/0/targets/0/NORMAL"},
      {"image without media type",
       [](Json& j) {
         j["images"] = {{{"bufferView", 0}}};
       },
       kMalformed, "#/images/0"},
      {"variant out of range",
       [](Json& j) {
         use(j, "KHR_materials_variants");
         j["materials"] = {Json::object()};
         j["extensions"]["KHR_materials_variants"]["variants"] = {{{"name", "a"}}};
         j["meshes"][0]["primitives"][0]["extensions"]["KHR_materials_variants"]["mappings"] = {
             {{"material", 0}, {"variants", {1}}}};
       },
       kMalformed, "variants/0"},
      {"required but not used", [](Json& j) { j["extensionsRequired"] = {"KHR_materials_unlit"}; },
       kMalformed, "#/extensionsRequired/0"},
      {"instance counts differ",
       [](Json& j) {
         use(j, "EXT_mesh_gpu_instancing");
         j["accessors"].push_back({{"componentType", 5126}, {"count", 2}, {"type", "VEC3"}});
         j["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"] = {{"TRANSLATION", 0},
                                                                                 {"SCALE", 2}};
       },
       kMalformed, "EXT_mesh_gpu_instancing"},
      {"http", [](Json& j) { j["buffers"][0]["uri"] = "http://127.0.0.1:9/x.bin"; }, kForbidden,
       "#/buffers/0/uri"},
      {"traversal", [](Json& j) { j["buffers"][0]["uri"] = "../../../etc/passwd"; }, kForbidden,
       "#/buffers/0/uri"},
      {"absent file", [](Json& j) { j["buffers"][0]["uri"] = "absent.bin"; }, kForbidden,
       "#/buffers/0/uri"},
      {"image traversal",
       [](Json& j) {
         j["images"] = {{{"uri", "%2e%2e/x.png"}}};
         j["textures"] = {{{"source", 0}}};
       },
       kForbidden, "#/images/0/uri"},
  };
  return kFaults;
}

}  // namespace
}  // namespace lightbatch::gltf
