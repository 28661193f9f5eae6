#include "core/atlas/clip.h"

#include <cmath>

namespace lightbatch::atlas {

Polygon clipped(const Polygon& polygon, bool vertical, double bound, double sign) {
  Polygon out;
  const auto distance = [&](const Vec2d& p) { return sign * ((vertical ? p.y : p.x) - bound); };
  for (std::size_t i = 0; i < polygon.count; ++i) {
    const Vec2d& a = polygon.corners[i];
    const Vec2d& b = polygon.corners[(i + 1) % polygon.count];
    const double da = distance(a), db = distance(b);
    if (da >= 0 && out.count < out.corners.size()) out.add(a);
    if ((da > 0 && db < 0) || (da < 0 && db > 0)) {
      Vec2d cut = a + (b - a) * (da / (da - db));
      (vertical ? cut.y : cut.x) = bound;
      if (out.count < out.corners.size()) out.add(cut);
    }
  }
  return out;
}

AreaCentroid area_centroid(const Polygon& polygon) {
  AreaCentroid result;
  if (polygon.count == 0) return result;
  const Vec2d base = polygon.corners[0];
  double twice = 0;
  Vec2d moment, mean;
  for (std::size_t i = 0; i < polygon.count; ++i) {
    const Vec2d a = polygon.corners[i] - base;
    const Vec2d b = polygon.corners[(i + 1) % polygon.count] - base;
    const double part = cross(a, b);
    twice += part;
    moment = moment + (a + b) * part;
    mean = mean + a * (1.0 / static_cast<double>(polygon.count));
  }
  result.area = std::abs(twice) / 2;
  result.centroid = base + (result.area > 1e-15 ? moment * (1 / (3 * twice)) : mean);
  return result;
}

}  // namespace lightbatch::atlas
