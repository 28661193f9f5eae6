#pragma once

#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "core/scene/scene.h"

namespace lightbatch::atlas {

/// Scenes made in code: each add_ call makes one object with its own node.
class SceneBuilder {
 public:
  scene::Scene scene;

  /// Starts an object; the add_ functions below append to it.
  void begin_object(const Affine& to_world = {}, std::uint32_t mesh = scene::kNone) {
    scene::Object object;
    object.node = static_cast<std::uint32_t>(scene.objects.size());
    object.mesh = mesh;
    object.first_triangle = static_cast<std::uint32_t>(scene.triangles.size());
    object.to_world = to_world;
    object.mirrored = to_world.determinant() < 0;
    scene.objects.push_back(object);
  }

  std::uint32_t add_point(const Vec3d& p) {
    const Vec3f q = to_float(scene.objects.back().to_world.point(p));
    scene.positions.push_back(q);
    scene.box.add(q);
    return static_cast<std::uint32_t>(scene.positions.size() - 1);
  }

  void add_triangle(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    scene::Object& object = scene.objects.back();
    scene::Triangle t;
    t.vertex = {a, b, c};
    if (object.mirrored) std::swap(t.vertex[1], t.vertex[2]);
    t.object = static_cast<std::uint32_t>(scene.objects.size() - 1);
    t.source = object.triangle_count++;
    scene.triangles.push_back(t);
  }

  /// Parallelogram with corner o and sides u, v; front towards cross(u, v).
  void add_quad(const Vec3d& o, const Vec3d& u, const Vec3d& v) {
    const std::uint32_t a = add_point(o), b = add_point(o + u), c = add_point(o + u + v),
                        d = add_point(o + v);
    add_triangle(a, b, c);
    add_triangle(a, c, d);
  }

  void add_box(const Vec3d& o, const Vec3d& size) {
    const Vec3d x{size.x, 0, 0}, y{0, size.y, 0}, z{0, 0, size.z};
    add_quad(o, y, x);
    add_quad(o + z, x, y);
    add_quad(o, x, z);
    add_quad(o + y, z, x);
    add_quad(o, z, y);
    add_quad(o + x, y, z);
  }

  /// A grid of (nu + 1) x (nv + 1) shared points at surface(u, v), u and v in [0, 1].
  template <typename Surface>
  void add_patch(int nu, int nv, Surface surface) {
    const auto base = static_cast<std::uint32_t>(scene.positions.size());
    for (int j = 0; j <= nv; ++j) {
      for (int i = 0; i <= nu; ++i) {
        add_point(surface(static_cast<double>(i) / nu, static_cast<double>(j) / nv));
      }
    }
    const auto at = [&](int i, int j) {
      return base + static_cast<std::uint32_t>(j * (nu + 1) + i);
    };
    for (int j = 0; j < nv; ++j) {
      for (int i = 0; i < nu; ++i) {
        add_triangle(at(i, j), at(i + 1, j), at(i + 1, j + 1));
        add_triangle(at(i, j), at(i + 1, j + 1), at(i, j + 1));
      }
    }
  }

  void add_sphere(const Vec3d& centre, double radius, int nu, int nv) {
    add_patch(nu, nv, [&](double u, double v) {
      const double a = 2 * std::numbers::pi * u, b = std::numbers::pi * (v - 0.5);
      return centre +
             Vec3d{std::cos(a) * std::cos(b), std::sin(a) * std::cos(b), std::sin(b)} * radius;
    });
  }

  void add_torus(double major, double minor, int nu, int nv) {
    add_patch(nu, nv, [&](double u, double v) {
      const double a = 2 * std::numbers::pi * u, b = 2 * std::numbers::pi * v;
      const double r = major + minor * std::cos(b);
      return Vec3d{r * std::cos(a), r * std::sin(a), minor * std::sin(b)};
    });
  }

  std::vector<std::uint8_t> all_lit() const {
    return std::vector<std::uint8_t>(scene.triangles.size(), 1);
  }
};

}  // namespace lightbatch::atlas
