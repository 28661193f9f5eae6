#include "core/rays/shaft.h"

#include <algorithm>
#include <cmath>

namespace lightbatch::rays {

Shaft::Shaft(const Aabb& a, const Aabb& b, float slack) : bounds(a) {
  bounds.add(b);
  bounds.lower = bounds.lower - Vec3f{slack, slack, slack};
  bounds.upper = bounds.upper + Vec3f{slack, slack, slack};
  for (std::size_t third = 0; third < 3; ++third) {
    const std::size_t i = (third + 1) % 3, j = (third + 2) % 3;
    for (int corner = 0; corner < 4; ++corner) {
      const bool up_i = (corner & 1) != 0, up_j = (corner & 2) != 0;
      const auto pick = [](const Aabb& box, std::size_t axis, bool up) {
        return static_cast<double>(up ? box.upper[axis] : box.lower[axis]);
      };
      // Perpendicular to the line between the boxes' corners, pointing out of that corner.
      double x = pick(b, j, up_j) - pick(a, j, up_j);
      double y = pick(a, i, up_i) - pick(b, i, up_i);
      if ((x > 0) != up_i) {
        x = -x;
        y = -y;
      }
      const double size = std::hypot(x, y);
      if (x == 0 || y == 0 || !std::isfinite(size) || (y > 0) != up_j) continue;
      Plane& plane = planes[plane_count];
      plane.axis[0] = i;
      plane.axis[1] = j;
      plane.normal[0] = static_cast<float>(x / size);
      plane.normal[1] = static_cast<float>(y / size);
      if (plane.normal[0] == 0 || plane.normal[1] == 0) continue;
      // The furthest point of either box with the rounded normal: right whatever was rounded.
      const auto reach = [&](const Aabb& box) {
        return static_cast<double>(plane.normal[0]) * pick(box, i, up_i) +
               static_cast<double>(plane.normal[1]) * pick(box, j, up_j);
      };
      plane.limit = static_cast<float>(std::max(reach(a), reach(b))) + 2 * slack;
      ++plane_count;
    }
  }
}

}  // namespace lightbatch::rays
