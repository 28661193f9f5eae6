#pragma once

#include <cstdint>
#include <vector>

#include "core/batches/viewpoints.h"

namespace lightbatch::batches {

/// Chances of being in the view: of all views, and of views from inside (of all where there are
/// none).
struct Chance {
  double any = 0, inside = 0;
};

/// The chance that a box is in the frustum of a random view: of the caller's cameras (256 at most,
/// drawn evenly by weight), or from a standing point any way round (pitch within 20 degrees), or
/// from outside towards the scene. Means over a few eyes; over the
/// directions exact for the box's horizontal and vertical angular extents taken as independent, so
/// that the chance grows smoothly with the box.
class ViewDistribution {
 public:
  explicit ViewDistribution(const Viewpoints& viewpoints);
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
  static constexpr std::size_t kCameraEyes = 256;
  void add_cameras(const std::vector<View>& cameras);

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
  static constexpr std::uint32_t kAllPlanes = 0b11111;
  /// Wholly outside one plane (four sides and the eye's plane).
  bool outside(const Aabb& box) const {
    std::uint32_t planes = kAllPlanes;
    return outside(box, planes);
  }
  /// The same of some planes; those that the box is wholly inside of are taken from the set. None
  /// is left: so is the box and all in it.
  bool outside(const Aabb& box, std::uint32_t& planes) const;
  bool outside(const Vec3d& a, const Vec3d& b, const Vec3d& c) const;

 private:
  struct Plane {
    Vec3d normal;
    double offset = 0;  // inside: dot(normal, p) >= offset
  };
  Plane planes_[5];
};

}  // namespace lightbatch::batches
