#pragma once

#include <cstdint>
#include <numbers>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/status.h"
#include "core/batches/profile.h"
#include "core/math/aabb.h"
#include "core/scene/scene.h"

namespace lightbatch::batches {

/// A view: what a frustum culler gets. Recentred coordinates (world minus Scene::origin).
struct View {
  Vec3d eye;
  double yaw = 0;    // radians about +y; 0 looks along +z, growing towards +x
  double pitch = 0;  // radians; positive looks up
  bool inside = false;
  double weight = 1;  // of a caller's camera: how often it is looked through, beside the others
};

/// People look this far up and down, radians.
inline constexpr double kPitch = 20 * std::numbers::pi / 180;

/// The unit vector of a direction.
Vec3d direction(double yaw, double pitch);

/// A caller's cameras as JSON text: a list of objects with `eye` and `target` (world coordinates,
/// three numbers each), optionally `weight` (above 0, default 1). All count as views from inside.
/// Anything else is INPUT_MALFORMED with a pointer.
Result<std::vector<View>> read_cameras(std::string_view json, const std::string& place,
                                       const Vec3d& origin);

/// Where the views that measures are taken over start in their sequences, far from
/// ViewDistribution's.
inline constexpr std::uint32_t kMeasuringViews = 10000;

/// Where a scene is looked at from: a caller's cameras, or else points where people can stand and
/// points outside. The scene's triangles are read once, here.
class Viewpoints {
 public:
  Viewpoints(const scene::Scene& scene, const Profile& profile, std::vector<View> cameras = {});

  /// Points where a person's eye can be: above triangles that face up, area-weighted,
  /// low-discrepancy order, so that any prefix is spread evenly. Empty when nothing faces up.
  std::vector<Vec3d> standing_eyes(std::uint32_t count, std::uint32_t skip) const;
  /// Eyes outside, on a sphere above the horizon from which all of the scene is in sight.
  Vec3d outside_eye(std::uint32_t index) const;
  /// The cameras; without any, views from where people stand and from outside, fixed for a scene
  /// and profile.
  std::vector<View> sample(std::uint32_t inside, std::uint32_t outside,
                           std::uint32_t start = kMeasuringViews) const;

  /// Above the ground, metres: the profile's, less in scenes that are small against it.
  double eye_height() const;
  const Profile& profile() const { return profile_; }
  const std::vector<View>& cameras() const { return cameras_; }
  const Aabb& box() const { return box_; }

 private:
  const scene::Scene& scene_;
  Profile profile_;
  std::vector<View> cameras_;
  Aabb box_;
  std::vector<double> area_;             // running sum over the triangles that face up
  std::vector<std::uint32_t> triangle_;  // of area_
};

}  // namespace lightbatch::batches
