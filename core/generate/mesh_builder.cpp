#include "core/generate/mesh_builder.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace lightbatch::generate {
namespace {

std::uint32_t add_vertex(Surface& surface, const Vec3d& position, const Vec3d& normal) {
  surface.positions.push_back(to_float(position));
  surface.normals.push_back(to_float(normalized(normal)));
  return static_cast<std::uint32_t>(surface.positions.size() - 1);
}

void add_triangle(Surface& surface, std::uint32_t a, std::uint32_t b, std::uint32_t c) {
  surface.indices.insert(surface.indices.end(), {a, b, c});
}

/// One side of a rounded box: a grid over the cube's face, pushed out from the inner box along the
/// direction of the cube point (so that neighbouring sides meet in the same positions).
class RoundedSide {
 public:
  RoundedSide(const Vec3d& lower, const Vec3d& upper, double radius, int steps)
      : inner_lower_(lower + Vec3d{radius, radius, radius}),
        inner_upper_(upper - Vec3d{radius, radius, radius}),
        radius_(radius),
        steps_(steps) {}

  /// axis: of the side's normal; sign: its direction.
  void add_to(Surface& surface, std::size_t axis, double sign) const {
    const int lines = 2 * steps_ + 2;
    const std::size_t u_axis = (axis + 1) % 3, v_axis = (axis + 2) % 3;
    const auto first = static_cast<std::uint32_t>(surface.positions.size());
    for (int j = 0; j < lines; ++j) {
      for (int i = 0; i < lines; ++i) {
        Vec3d direction;
        direction[axis] = sign;
        direction[u_axis] = slope(i);
        direction[v_axis] = slope(j);
        direction = normalized(direction);
        Vec3d corner;
        corner[axis] = sign > 0 ? inner_upper_[axis] : inner_lower_[axis];
        corner[u_axis] = i <= steps_ ? inner_lower_[u_axis] : inner_upper_[u_axis];
        corner[v_axis] = j <= steps_ ? inner_lower_[v_axis] : inner_upper_[v_axis];
        add_vertex(surface, corner + direction * radius_, direction);
      }
    }
    const auto stride = static_cast<std::uint32_t>(lines);
    for (std::uint32_t j = 0; j + 1 < stride; ++j) {
      for (std::uint32_t i = 0; i + 1 < stride; ++i) {
        const std::uint32_t a = first + j * stride + i, b = a + 1, c = a + stride, d = c + 1;
        if (sign > 0) {
          add_triangle(surface, a, b, d);
          add_triangle(surface, a, d, c);
        } else {
          add_triangle(surface, a, d, b);
          add_triangle(surface, a, c, d);
        }
      }
    }
  }

 private:
  /// Tangent of the angle from the side's normal at grid line i: -45 degrees to 0 on the first half
  /// of the lines, 0 to 45 degrees on the second.
  double slope(int i) const {
    const double quarter = std::numbers::pi / 4;
    const int distance = i <= steps_ ? steps_ - i : i - steps_ - 1;
    const double angle = quarter * distance / steps_;
    return i <= steps_ ? -std::tan(angle) : std::tan(angle);
  }

  Vec3d inner_lower_, inner_upper_;
  double radius_;
  int steps_;
};

}  // namespace

void add_quad(Surface& surface, const Vec3d& a, const Vec3d& b, const Vec3d& c, const Vec3d& d) {
  const Vec3d normal = cross(b - a, d - a);
  const std::uint32_t i = add_vertex(surface, a, normal);
  add_vertex(surface, b, normal);
  add_vertex(surface, c, normal);
  add_vertex(surface, d, normal);
  add_triangle(surface, i, i + 1, i + 2);
  add_triangle(surface, i, i + 2, i + 3);
}

void add_box(Surface& surface, const Vec3d& lower, const Vec3d& upper) {
  const auto corner = [&](int x, int y, int z) {
    return Vec3d{x ? upper.x : lower.x, y ? upper.y : lower.y, z ? upper.z : lower.z};
  };
  add_quad(surface, corner(0, 0, 0), corner(0, 0, 1), corner(0, 1, 1), corner(0, 1, 0));
  add_quad(surface, corner(1, 0, 0), corner(1, 1, 0), corner(1, 1, 1), corner(1, 0, 1));
  add_quad(surface, corner(0, 0, 0), corner(1, 0, 0), corner(1, 0, 1), corner(0, 0, 1));
  add_quad(surface, corner(0, 1, 0), corner(0, 1, 1), corner(1, 1, 1), corner(1, 1, 0));
  add_quad(surface, corner(0, 0, 0), corner(0, 1, 0), corner(1, 1, 0), corner(1, 0, 0));
  add_quad(surface, corner(0, 0, 1), corner(1, 0, 1), corner(1, 1, 1), corner(0, 1, 1));
}

void add_rounded_box(Surface& surface, const Vec3d& lower, const Vec3d& upper, double radius,
                     int steps) {
  if (steps <= 0) {
    add_box(surface, lower, upper);
    return;
  }
  const Vec3d size = upper - lower;
  const double largest = 0.49 * std::min(size.x, std::min(size.y, size.z));
  const RoundedSide side(lower, upper, std::min(radius, largest), steps);
  for (const std::size_t axis : {0u, 1u, 2u}) {
    side.add_to(surface, axis, 1.0);
    side.add_to(surface, axis, -1.0);
  }
}

void add_lathe(Surface& surface, const Vec3d& centre, const std::vector<ProfilePoint>& profile,
               int segments) {
  const auto on_circle = [&](const ProfilePoint& p, int i) {
    const double angle = 2 * std::numbers::pi * (i % segments) / segments;
    return centre + Vec3d{p.radius * std::cos(angle), p.height, -p.radius * std::sin(angle)};
  };
  for (std::size_t k = 0; k + 1 < profile.size(); ++k) {
    const ProfilePoint& low = profile[k];
    const ProfilePoint& high = profile[k + 1];
    const double rise = high.height - low.height, out = low.radius - high.radius;
    for (int i = 0; i < segments; ++i) {
      const auto normal = [&](double step) {
        const double angle = 2 * std::numbers::pi * (i + step) / segments;
        return Vec3d{rise * std::cos(angle), out, -rise * std::sin(angle)};
      };
      const std::uint32_t first = static_cast<std::uint32_t>(surface.positions.size());
      if (low.radius > 0 && high.radius > 0) {
        add_vertex(surface, on_circle(low, i), normal(0));
        add_vertex(surface, on_circle(low, i + 1), normal(1));
        add_vertex(surface, on_circle(high, i + 1), normal(1));
        add_vertex(surface, on_circle(high, i), normal(0));
        add_triangle(surface, first, first + 1, first + 2);
        add_triangle(surface, first, first + 2, first + 3);
      } else if (low.radius > 0) {
        add_vertex(surface, on_circle(low, i), normal(0));
        add_vertex(surface, on_circle(low, i + 1), normal(1));
        add_vertex(surface, on_circle(high, i), normal(0.5));
        add_triangle(surface, first, first + 1, first + 2);
      } else if (high.radius > 0) {
        add_vertex(surface, on_circle(low, i), normal(0.5));
        add_vertex(surface, on_circle(high, i + 1), normal(1));
        add_vertex(surface, on_circle(high, i), normal(0));
        add_triangle(surface, first, first + 1, first + 2);
      }
    }
  }
}

void add_cylinder(Surface& surface, const Vec3d& foot, double radius, double height, int segments) {
  add_lathe(surface, foot, {{0, 0}, {radius, 0}, {radius, height}, {0, height}}, segments);
}

}  // namespace lightbatch::generate
