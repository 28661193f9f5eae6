#include "core/lightmap/lamp_cells.h"

#include <array>
#include <cmath>

#include "core/math/sampling.h"

namespace lightbatch::lightmap {
namespace {

using radiosity::PunctualLight;

constexpr double kSixteenth = 0.25;  // edge, texels
/// Radius over distance from which on light from a point is uneven.
constexpr double kClose = 0.3;
/// Radius over width of the cone's ramp from which on it is, and over the range.
constexpr double kNarrow = 0.25, kOfRange = 0.05;
/// Radius of the cells that are cut no further, over the ramp.
constexpr double kOfRamp = 0.08;
/// Error that a sharp edge through a square of cells of edge s leaves, over its light and s^1.5:
/// about 1 / s cells are met, each off by 0.3 of its area.
constexpr double kEdgeOfCells = 0.3;
constexpr int kMostCuts = 10;

double angle_of(float dip) { return 2 * std::asin(std::sqrt(static_cast<double>(dip) / 2)); }

/// How a sphere lies to the ramp between a cone's angles.
struct Ramp {
  bool met = false;
  double radius = 0, ramp = 0;  // angles

  Ramp(const PunctualLight& light, const Vec3d& centre, double size) {
    if (light.kind != scene::LightKind::kSpot) return;
    const Vec3d from = centre - to_double(light.position), axis = to_double(light.direction);
    const double distance = length(from);
    const double angle = std::atan2(length(cross(from, axis)), dot(from, axis));
    radius = size < distance ? std::asin(size / distance) : kPiDouble;
    const double outer = angle_of(light.dip_outer);
    ramp = outer - angle_of(light.dip_inner);
    met = angle - radius < outer && angle + radius > outer - ramp;
  }
};

/// One sixteenth on the plane of its triangle.
class Cutter {
 public:
  Cutter(const PunctualLight& light, const scene::Scene& scene, const atlas::Layout& layout,
         const TexelPoints::Point& about, double allowed, std::vector<LampCell>& cells)
      : light_(light), about_(about), cells_(cells) {
    const auto& uv = layout.uv[about.triangle];
    const auto corner = scene.corners(about.triangle);
    const Vec2<double> ab = to_double2(uv[1] - uv[0]), ac = to_double2(uv[2] - uv[0]);
    const double whole = cross(ab, ac);
    if (whole == 0) return;
    const Vec3d a = to_double(corner[0]);
    const Vec3d on_ab = to_double(corner[1]) - a, on_ac = to_double(corner[2]) - a;
    along_x_ = (on_ab * ac.y - on_ac * ab.y) / whole;
    along_y_ = (on_ac * ab.x - on_ab * ac.x) / whole;
    const Vec2<double> at = to_double2(about.at - uv[0]);
    middle_ = a + along_x_ * at.x + along_y_ * at.y;
    const Vec3d normal = cross(along_x_, along_y_);
    area_ = length(normal) * kSixteenth * kSixteenth;
    const Vec3d front = cross(on_ab, on_ac) * (about.back ? -1.0 : 1.0);
    const Vec3d to_lamp = to_double(light.position) - middle_;
    lit_ = area_ > 0 && dot(front, to_lamp) > 0;
    if (lit_) finest_ = finest(allowed, to_lamp, normal);
  }

  void run() {
    if (lit_) cut(0, 0, kSixteenth, 0);
  }

 private:
  static Vec2<double> to_double2(const Vec2f& v) {
    return {static_cast<double>(v.x), static_cast<double>(v.y)};
  }

  Vec3d place(double x, double y) const { return middle_ + along_x_ * x + along_y_ * y; }

  /// x, y: the cell's middle from the sixteenth's.
  void cut(double x, double y, double edge, int cuts) {
    const Vec3d centre = place(x, y);
    const double radius = 0.5 * edge * (length(along_x_) + length(along_y_));
    if (cuts < kMostCuts && is_uneven(centre, radius, edge)) {
      const double step = edge / 4;
      for (const double v : {y - step, y + step}) {
        for (const double u : {x - step, x + step}) cut(u, v, edge / 2, cuts + 1);
      }
      return;
    }
    const double angle = solid_angle(x, y, edge / 2);
    const Rgb light =
        light_.intensity * (light_.window(to_float(centre)) * static_cast<float>(angle / area_));
    if (light.is_black()) return;
    cells_.push_back({{about_.at.x + static_cast<float>(x), about_.at.y + static_cast<float>(y)},
                      static_cast<float>(edge),
                      light});
  }

  bool is_uneven(const Vec3d& centre, double radius, double edge) const {
    if (light_.range > 0 && radius > kOfRange * static_cast<double>(light_.range)) return true;
    const Ramp ramp(light_, centre, radius);
    return ramp.met && edge > finest_ && ramp.radius > kOfRamp * ramp.ramp;
  }

  /// Edge of a cell, texels, from which on the cone's edge is told well enough.
  double finest(double allowed, const Vec3d& to_lamp, const Vec3d& normal) const {
    const double distance = length(to_lamp);
    const double cosine = std::fabs(dot(to_lamp, normal)) / (distance * length(normal));
    const double lux = static_cast<double>(light_.intensity.max()) * cosine / (distance * distance);
    return lux > 0 ? std::pow(allowed / (kEdgeOfCells * lux), 2.0 / 3.0) : 1.0;
  }

  double solid_angle(double x, double y, double half) const {
    const Vec3d from = to_double(light_.position);
    const std::array<Vec3d, 4> corner{
        place(x - half, y - half) - from, place(x + half, y - half) - from,
        place(x + half, y + half) - from, place(x - half, y + half) - from};
    return triangle_angle(corner[0], corner[1], corner[2]) +
           triangle_angle(corner[0], corner[2], corner[3]);
  }

  /// Van Oosterom and Strackee 1983.
  static double triangle_angle(const Vec3d& a, const Vec3d& b, const Vec3d& c) {
    const double la = length(a), lb = length(b), lc = length(c);
    return 2 * std::atan2(std::fabs(dot(a, cross(b, c))),
                          la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb);
  }

  const PunctualLight& light_;
  const TexelPoints::Point& about_;
  std::vector<LampCell>& cells_;
  Vec3d along_x_, along_y_;  // metres a texel
  Vec3d middle_;
  double area_ = 0;
  double finest_ = 0;  // texels
  bool lit_ = false;
};

}  // namespace

bool varies_within(const PunctualLight& light, const Vec3f& centre, float radius) {
  if (light.is_directional()) return false;
  const Vec3d at = to_double(centre);
  const double r = static_cast<double>(radius);
  if (r > kClose * length(at - to_double(light.position))) return true;
  const Ramp ramp(light, at, r);
  return ramp.met && ramp.radius > kNarrow * ramp.ramp;
}

void cut_for_lamp(const PunctualLight& light, const scene::Scene& scene,
                  const atlas::Layout& layout, const TexelPoints::Point& about, double allowed,
                  std::vector<LampCell>& cells) {
  cells.clear();
  Cutter(light, scene, layout, about, allowed, cells).run();
}

}  // namespace lightbatch::lightmap
