#pragma once

#include <cstdint>
#include <vector>

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
};

/// Points where a person's eye can be: above triangles that face up, area-weighted, low-discrepancy
/// order, so that any prefix is spread evenly. Empty when nothing faces up.
std::vector<Vec3d> standing_eyes(const scene::Scene& scene, const Profile& profile,
                                 std::uint32_t count, std::uint32_t skip);

/// Where views start in their sequences, far from ViewDistribution's: those that plans are checked
/// with, and those that measures are taken over.
inline constexpr std::uint32_t kPlanningViews = 5000, kMeasuringViews = 10000;
/// Views from where people stand and from outside, fixed for a scene and profile.
std::vector<View> sampled_views(const scene::Scene& scene, const Profile& profile,
                                std::uint32_t inside, std::uint32_t outside,
                                std::uint32_t start = kMeasuringViews);

/// Chances of being in the view: of all views, and of views from inside (of all where there are
/// none).
struct Chance {
  double any = 0, inside = 0;
};

/// The chance that a box is in the frustum of a random view: from a standing point any way round
/// (pitch within 20 degrees), or from outside towards the scene. Means over a few eyes; over the
/// directions exact for the box's horizontal and vertical angular extents taken as independent, so
/// that the chance grows smoothly with the box.
class ViewDistribution {
 public:
  ViewDistribution(const scene::Scene& scene, const Profile& profile);
  /// In [0, 1]; 0 for an empty box.
  Chance chance(const Aabb& box) const;
  double visible(const Aabb& box) const { return chance(box).any; }

 private:
  struct Eye {
    Vec3d position;
    double weight = 0;
    double yaw = 0, yaw_spread = 0;      // directions: yaw +- yaw_spread
    double pitch = 0, pitch_spread = 0;  // pitch +- pitch_spread
    bool inside = false;
  };
  static constexpr std::uint32_t kInsideEyes = 32;
  static constexpr std::uint32_t kOutsideEyes = 8;

  std::vector<Eye> eyes_;
  double inside_weight_ = 0;
  double half_yaw_ = 0;    // half the horizontal field of view
  double half_pitch_ = 0;  // half the vertical field of view
  double flattening_ = 1;  // of elevations at the sides of a view
};

/// The part of a box that one view submits.
class Frustum {
 public:
  Frustum(const View& view, const Profile& profile);
  /// Wholly outside one plane (four sides and the eye's plane).
  bool outside(const Aabb& box) const;
  /// Wholly inside every plane.
  bool holds(const Aabb& box) const;
  bool outside(const Vec3d& a, const Vec3d& b, const Vec3d& c) const;

 private:
  struct Plane {
    Vec3d normal;
    double offset = 0;  // inside: dot(normal, p) >= offset
  };
  Plane planes_[5];
};

}  // namespace lightbatch::batches
