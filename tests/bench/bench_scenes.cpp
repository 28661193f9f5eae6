#include "tests/bench/bench_scenes.h"

#include <cmath>
#include <cstdio>
#include <memory>
#include <numbers>

#include "core/base/random.h"

namespace lightbatch::bench {
namespace {

constexpr double kTau = 2 * std::numbers::pi;

void add_quad(Scene& scene, const Vec3f& at, const Vec3f& s, const Vec3f& t, int cells) {
  const float step = 1.0f / static_cast<float>(cells);
  for (int i = 0; i < cells; ++i) {
    for (int j = 0; j < cells; ++j) {
      const auto p = [&](int di, int dj) {
        return at + s * (static_cast<float>(i + di) * step) +
               t * (static_cast<float>(j + dj) * step);
      };
      scene.add(p(0, 0), p(1, 0), p(1, 1));
      scene.add(p(0, 0), p(1, 1), p(0, 1));
    }
  }
}

void add_box(Scene& scene, const Vec3f& low, const Vec3f& size, int cells) {
  const Vec3f x{size.x, 0, 0}, y{0, size.y, 0}, z{0, 0, size.z};
  add_quad(scene, low, x, y, cells);
  add_quad(scene, low + z, x, y, cells);
  add_quad(scene, low, x, z, cells);
  add_quad(scene, low + y, x, z, cells);
  add_quad(scene, low, y, z, cells);
  add_quad(scene, low + x, y, z, cells);
}

void add_sphere(Scene& scene, const Vec3f& centre, float radius, int sides) {
  const auto p = [&](int i, int j) {
    const double a = kTau * i / sides, b = std::numbers::pi * j / sides;
    return centre +
           to_float(Vec3d{std::sin(b) * std::cos(a), std::cos(b), std::sin(b) * std::sin(a)}) *
               radius;
  };
  for (int i = 0; i < sides; ++i) {
    for (int j = 0; j < sides; ++j) {
      if (j > 0) scene.add(p(i, j), p(i + 1, j), p(i + 1, j + 1));
      if (j + 1 < sides) scene.add(p(i, j), p(i + 1, j + 1), p(i, j + 1));
    }
  }
}

void add_room(Scene& scene, const Vec3f& at, std::uint64_t seed) {
  Random random(seed);
  add_quad(scene, at, {5, 0, 0}, {0, 0, 4}, 12);
  add_quad(scene, at + Vec3f{0, 2.8f, 0}, {5, 0, 0}, {0, 0, 4}, 12);
  add_quad(scene, at, {5, 0, 0}, {0, 2.8f, 0}, 10);
  add_quad(scene, at, {0, 0, 4}, {0, 2.8f, 0}, 10);
  for (int desk = 0; desk < 4; ++desk) {
    const Vec3f corner = at + Vec3f{0.4f + 2.3f * static_cast<float>(desk % 2), 0,
                                    0.4f + 1.9f * static_cast<float>(desk / 2)};
    add_box(scene, corner + Vec3f{0, 0.7f, 0}, {1.6f, 0.04f, 0.8f}, 4);
    for (int leg = 0; leg < 4; ++leg) {
      add_box(
          scene,
          corner + Vec3f{1.5f * static_cast<float>(leg % 2), 0, 0.7f * static_cast<float>(leg / 2)},
          {0.06f, 0.7f, 0.06f}, 3);
    }
    add_sphere(scene, corner + Vec3f{0.4f + 0.8f * random.next_float(), 0.9f, 0.4f}, 0.15f, 16);
    add_box(scene, corner + Vec3f{0.6f, 0.74f, 0.2f + 0.2f * random.next_float()},
            {0.5f, 0.35f, 0.03f}, 3);
  }
}

}  // namespace

void Scene::add(const Vec3f& a, const Vec3f& b, const Vec3f& c) {
  const auto first = static_cast<std::uint32_t>(positions.size());
  positions.insert(positions.end(), {a, b, c});
  triangles.push_back({first, first + 1, first + 2});
  Aabb box;
  for (const Vec3f& p : {a, b, c}) box.add(p);
  boxes.push_back(box);
}

Aabb Scene::bounds() const {
  Aabb box;
  for (const Aabb& b : boxes) box.add(b);
  return box;
}

Scene load_soup(const std::string& path, const std::string& name) {
  Scene scene{name, {}, {}, {}, true};
  const std::unique_ptr<FILE, int (*)(FILE*)> file(std::fopen(path.c_str(), "rb"), std::fclose);
  std::uint32_t n = 0;
  if (!file || std::fread(&n, 4, 1, file.get()) != 1) return scene;
  std::array<Vec3f, 3> corner;
  for (std::uint32_t i = 0; i < n && std::fread(corner.data(), 36, 1, file.get()) == 1; ++i) {
    scene.add(corner[0], corner[1], corner[2]);
  }
  return scene;
}

Scene make_office(std::size_t n) {
  Scene scene{"office", {}, {}, {}, true};
  for (std::uint64_t room = 0; scene.triangles.size() < n; ++room) {
    const auto column = static_cast<float>(room % 8), row = static_cast<float>(room / 8 % 6),
               floor = static_cast<float>(room / 48);
    add_room(scene, {column * 5, floor * 3, row * 4}, room);
  }
  return scene;
}

Scene make_torus(std::size_t n) {
  Scene scene{"torus", {}, {}, {}, true};
  const int sides = static_cast<int>(std::sqrt(static_cast<double>(n) / 6));
  const int rings = 3 * sides;
  const auto p = [&](int i, int j) {
    const double a = kTau * (i % rings) / rings, b = kTau * (j % sides) / sides;
    const double r = 0.4 + 0.03 * std::sin(23 * a + 5 * std::sin(7 * b)) * std::cos(17 * b) +
                     0.004 * std::sin(131 * a + 97 * b);
    return to_float(Vec3d{(1 + r * std::cos(b)) * std::cos(a), r * std::sin(b),
                          (1 + r * std::cos(b)) * std::sin(a)});
  };
  for (int i = 0; i < rings; ++i) {
    for (int j = 0; j < sides; ++j) {
      scene.add(p(i, j), p(i, j + 1), p(i + 1, j));
      scene.add(p(i + 1, j), p(i, j + 1), p(i + 1, j + 1));
    }
  }
  return scene;
}

Scene make_needles(std::size_t n) {
  Scene scene{"needles", {}, {}, {}, false};
  Random random(3);
  const auto point = [&] {
    return Vec3f{random.next_float(), random.next_float(), random.next_float()};
  };
  for (std::size_t i = 0; i < n; ++i) {
    const Vec3f at = point();
    const Vec3f along = (point() - Vec3f{.5f, .5f, .5f}) * 0.2f;
    const Vec3f across = (point() - Vec3f{.5f, .5f, .5f}) * 0.0006f;
    scene.add(at, at + along, at + along * 0.5f + across);
  }
  return scene;
}

Scene make_swarm(std::size_t n) {
  Scene scene{"swarm", {}, {}, {}, false};
  Random random(5);
  const auto point = [&] {
    return Vec3f{random.next_float(), random.next_float(), random.next_float()};
  };
  for (std::size_t i = 0; i < n; ++i) {
    const Vec3f at = point();
    scene.add(at, at + point() * 0.01f, at + point() * 0.01f);
  }
  return scene;
}

}  // namespace lightbatch::bench
