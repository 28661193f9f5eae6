#include <cmath>
#include <nlohmann/json.hpp>

#include "core/batches/viewpoints.h"

namespace lightbatch::batches {
namespace {

using Json = nlohmann::json;

Result<Vec3d> read_point(const Json& camera, const char* key, const std::string& place) {
  const std::string where = place + "/" + key;
  const auto it = camera.find(key);
  if (it == camera.end() || !it->is_array() || it->size() != 3)
    return malformed(where, "must be a list of three numbers");
  Vec3d point;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const Json& number = it->at(axis);
    if (!number.is_number() || !std::isfinite(number.get<double>()))
      return malformed(where, "must be a list of three numbers");
    point[axis] = number.get<double>();
  }
  return point;
}

Result<View> read_camera(const Json& camera, const std::string& place, const Vec3d& origin) {
  if (!camera.is_object()) return malformed(place, "a camera must be an object");
  for (const auto& [key, value] : camera.items())
    if (key != "eye" && key != "target" && key != "weight")
      return malformed(place + "/" + key, "unknown member: a camera has eye, target and weight");
  LB_ASSIGN_OR_RETURN(const Vec3d eye, read_point(camera, "eye", place));
  LB_ASSIGN_OR_RETURN(const Vec3d target, read_point(camera, "target", place));
  const Vec3d to = target - eye;
  if (!(length(to) > 0)) return malformed(place + "/target", "must differ from the eye");
  View view;
  view.eye = eye - origin;
  view.yaw = std::atan2(to.x, to.z);
  view.pitch = std::atan2(to.y, std::hypot(to.x, to.z));
  view.inside = true;
  if (const auto it = camera.find("weight"); it != camera.end()) {
    view.weight = it->is_number() ? it->get<double>() : 0;
    constexpr double kLargest = 1e12;
    if (!(view.weight > 0 && view.weight <= kLargest))
      return malformed(place + "/weight", "must be a number above 0");
  }
  return view;
}

}  // namespace

Result<std::vector<View>> read_cameras(std::string_view json, const std::string& place,
                                       const Vec3d& origin) {
  const Json root = Json::parse(json, nullptr, false);
  if (!root.is_array() || root.empty())
    return malformed(place, "cameras must be a JSON list of objects with eye and target");
  std::vector<View> cameras;
  for (std::size_t i = 0; i < root.size(); ++i) {
    LB_ASSIGN_OR_RETURN(View view, read_camera(root[i], place + "#/" + std::to_string(i), origin));
    cameras.push_back(view);
  }
  return cameras;
}

}  // namespace lightbatch::batches
