#include "core/gltf/check_cameras_lights.h"

#include <numbers>

#include "core/gltf/fields.h"

namespace lightbatch::gltf {
namespace {

void check_camera_values(const Json& camera, const JsonPath& path,
                         std::vector<std::string>& warnings) {
  for (const char* type : {"perspective", "orthographic"}) {
    const auto values = camera.find(type);
    if (values == camera.end()) continue;
    const JsonPath here(path, type);
    if (values->contains("zfar") &&
        number_field(*values, "zfar", 0) <= number_field(*values, "znear", 0)) {
      warnings.push_back(here.text() + ": zfar is not greater than znear");
    }
    if (number_field(*values, "xmag", 1) == 0 || number_field(*values, "ymag", 1) == 0) {
      warnings.push_back(here.text() + ": a magnification is zero");
    }
  }
}

}  // namespace

Status check_cameras(const Json& json, const JsonPath& root, std::vector<std::string>& warnings) {
  const Json& cameras = list_field(json, "cameras");
  const JsonPath list(root, "cameras");
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    const JsonPath path(list, i);
    const std::string type = text_field(cameras[i], "type");
    const bool perspective = cameras[i].contains("perspective");
    const bool orthographic = cameras[i].contains("orthographic");
    if ((type == "perspective" && !perspective) || (type == "orthographic" && !orthographic)) {
      return malformed(path.text(), "a camera of type " + type + " needs the object of that name");
    }
    if (type != "perspective" && type != "orthographic") {
      warnings.push_back(path.text() + ": unknown type of camera");
    }
    if (perspective && orthographic) {
      warnings.push_back(path.text() + ": is both perspective and orthographic");
    }
    check_camera_values(cameras[i], path, warnings);
  }
  return {};
}

Status check_lights(const Json& json, const JsonPath& root, std::vector<std::string>& warnings) {
  const Json* extension = extension_of(json, "KHR_lights_punctual");
  if (extension == nullptr) return {};
  const Json& lights = (*extension)["lights"];
  const std::string list = root.text() + "/extensions/KHR_lights_punctual/lights/";
  for (std::size_t i = 0; i < lights.size(); ++i) {
    if (text_field(lights[i], "type") != "spot") continue;
    const std::string place = list + std::to_string(i);
    const auto spot = lights[i].find("spot");
    if (spot == lights[i].end()) return malformed(place, "a light of type spot needs \"spot\"");
    if (number_field(*spot, "innerConeAngle", 0) >=
        number_field(*spot, "outerConeAngle", std::numbers::pi / 4)) {
      warnings.push_back(place + ": the inner cone angle is not smaller than the outer one");
    }
  }
  return {};
}

}  // namespace lightbatch::gltf
