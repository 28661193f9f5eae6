// A triangle can only stand between two points that lie on opposite sides of its plane. When all
// vertices and all lamps lie on one side of every triangle's plane, nothing shadows anything.

#include <algorithm>
#include <cmath>

#include "core/plan/effect_plan.h"

namespace lightbatch::plan {
namespace {

constexpr std::size_t kLargestScene = 400;
/// Vertices this near to a plane (relative to the scene's diagonal) count as in it: the rounding
/// of recentred floats.
constexpr double kPlaneSlack = 1e-6;

struct Sides {
  bool front = false;
  bool back = false;
};

}  // namespace

bool can_shadow(const scene::Scene& scene, bool light_from_outside) {
  if (scene.triangles.size() > kLargestScene) return true;
  const double slack = kPlaneSlack * static_cast<double>(scene.box.diagonal());
  for (std::uint32_t i = 0; i < scene.triangles.size(); ++i) {
    const auto c = scene.corners(i);
    const Vec3d a = to_double(c[0]);
    const Vec3d n = normalized(cross(to_double(c[1]) - a, to_double(c[2]) - a));
    Sides sides;
    const auto add = [&](const Vec3d& p) {
      const double height = dot(n, p - a);
      sides.front = sides.front || height > slack;
      sides.back = sides.back || height < -slack;
    };
    for (const Vec3f& p : scene.positions) add(to_double(p));
    for (const scene::MovingMesh& moving : scene.moving) {
      for (unsigned k = 0; k < 8; ++k) add(moving.swept.corner(k) - scene.origin);
    }
    for (const scene::Light& light : scene.lights) {
      if (light.kind != scene::LightKind::kDirectional) add(light.position);
    }
    if (sides.front && sides.back) return true;
    if (!sides.front && !sides.back) continue;
    // Light from infinitely far on the empty side meets this triangle first.
    if (light_from_outside) return true;
    for (const scene::Light& light : scene.lights) {
      if (light.kind != scene::LightKind::kDirectional) continue;
      const double from = -dot(n, light.direction);
      if (sides.front ? from < 0 : from > 0) return true;
    }
  }
  return false;
}

}  // namespace lightbatch::plan
