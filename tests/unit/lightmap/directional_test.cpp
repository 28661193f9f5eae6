#include "core/lightmap/directional.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "core/base/parallel.h"
#include "tests/unit/lightmap/lit_scene.h"

namespace lightbatch::lightmap {
namespace {

/// A floor of 4 x 4 metres with a normal map, front up.
struct Floor {
  LitScene lit;
  std::uint32_t mapped = 0;

  explicit Floor(const Rgb& reflectance = {}) {
    scene::Material material;
    material.base_color = reflectance;
    material.metallic = 0;
    material.has_normal_map = true;
    mapped = lit.kit.material(material);
    lit.kit.quad({Vec3f{-2, 0, 2}, {2, 0, 2}, {2, 0, -2}, {-2, 0, -2}}, mapped);
  }

  DirectionalMap bake(int rays = 1024, std::uint64_t seed = 1) {
    lit.chart(4);
    lit.solve();
    return again(rays, seed);
  }
  DirectionalMap again(int rays, std::uint64_t seed = 1) const {
    GatherSettings settings;
    settings.rays = rays;
    BakeInput input = lit.input();
    input.seed = seed;
    auto map = bake_directional(input, settings, charts_with_normal_maps(input.scene, lit.layout),
                                Progress{});
    EXPECT_TRUE(map.ok());
    return std::move(map).value();
  }
};

// d = n / 2; tilted by an angle, the sky's light is (1 + cos) / 2 of what arrives flat.
TEST(Directional, ConstantSky) {
  Floor floor;
  floor.lit.sky = optics::Environment(Rgb{100, 50, 20});
  const DirectionalMap map = floor.bake(4096);
  ASSERT_GT(map.texels, 200u);
  EXPECT_EQ(map.texels, map.direction.size());
  for (const Vec3f& d : map.direction) {
    EXPECT_NEAR(d.x, 0, 0.002);
    EXPECT_NEAR(d.y, 0.5, 0.002);
    EXPECT_NEAR(d.z, 0, 0.002);
    const Vec3f tilted = normalized(Vec3f{1, 2, 0});
    const float share = (1 + 2 * dot(d, tilted)) / (1 + 2 * d.y);
    EXPECT_NEAR(share, (1 + tilted.y) / 2, 0.004);
  }
}

TEST(Directional, OneDirectionalLight) {
  Floor floor;
  const Vec3f towards = normalized(Vec3f{0.6f, 0.5f, -0.3f});
  scene::Light sun;
  sun.kind = scene::LightKind::kDirectional;
  sun.direction = to_double(-towards);
  sun.intensity = {1000, 800, 100};
  floor.lit.kit.scene().lights.push_back(sun);
  for (const Vec3f& d : floor.bake().direction) EXPECT_LT(length(d - towards), 1e-5f);
}

// A lamp straight above the middle and a sun from the side: moments add by luminance.
TEST(Directional, LightsAddByLuminance) {
  Floor floor;
  scene::Light lamp;
  lamp.position = {0, 3, 0};
  lamp.intensity = {900, 900, 900};
  scene::Light sun;
  sun.kind = scene::LightKind::kDirectional;
  sun.direction = normalized(Vec3d{-1, -1, 0});
  sun.intensity = {100, 0, 0};
  floor.lit.kit.scene().lights = {lamp, sun};
  const DirectionalMap map = floor.bake();
  for (std::size_t t = 0; t < map.direction.size(); ++t) {
    const atlas::Texel& texel = floor.lit.texels.texels[t];
    const TexelPoints points = texel_points(floor.lit.texels, texel);
    const double weak = 0.2126 * 100;
    Vec3d sum{};
    double light = 0;
    for (std::uint32_t i = 0; i < points.count; ++i) {
      const Vec3f p =
          receiver_at(floor.lit.kit.scene(), floor.lit.layout, points.point[i], 0).frame.position;
      const Vec3d to = Vec3d{0, 3, 0} - to_double(p);
      const double strong = 900 / dot(to, to);
      sum = sum + normalized(to) * strong + normalized(Vec3d{1, 1, 0}) * weak;
      light += strong + weak;
    }
    const Vec3d expected = sum / light;
    EXPECT_LT(length(to_double(map.direction[t]) - expected), 0.005) << t;
  }
}

// Constant luminance over every hemisphere, from emitters and from surfaces.
TEST(Directional, AFurnace) {
  Floor box;
  scene::Material wall = box.lit.kit.scene().materials[box.mapped];
  wall.base_color = Rgb::grey(0.8f);
  wall.emission = Rgb::grey(10);
  box.lit.kit.box({10, 0, 0}, {11, 1, 1}, box.lit.kit.material(wall));
  const DirectionalMap map = box.bake(4096);
  double squares = 0;
  std::size_t count = 0;
  for (std::size_t t = 0; t < map.direction.size(); ++t) {
    const TexelPoints::Point middle = central_point(box.lit.texels, box.lit.texels.texels[t]);
    const auto at = receiver_at(box.lit.kit.scene(), box.lit.layout, middle, 0).frame;
    if (at.position.x < 5) continue;
    const Vec3f off = map.direction[t] - at.normal * 0.5f;
    squares += static_cast<double>(dot(off, off));
    ++count;
  }
  ASSERT_GT(count, 50u);
  EXPECT_LT(std::sqrt(squares / static_cast<double>(count)), 0.01);
}

TEST(Directional, ChartsWithoutNormalMapsCostNothing) {
  Floor floor;
  floor.lit.kit.quad({Vec3f{-2, 9, 2}, {2, 9, 2}, {2, 9, -2}, {-2, 9, -2}},
                     floor.lit.kit.material(Rgb{}));
  floor.lit.sky = optics::Environment(Rgb::grey(1));
  const DirectionalMap map = floor.bake(64);
  EXPECT_EQ(2 * map.texels, map.direction.size());
  EXPECT_EQ(map.counts.rays.cast(), 4 * map.texels);
  std::uint64_t dark = 0;
  for (const Vec3f& d : map.direction) dark += dot(d, d) == 0 ? 1u : 0u;
  EXPECT_EQ(dark, map.texels);
}

/// A room with a lamp, a mapped floor.
void furnish(Floor& floor) {
  auto& kit = floor.lit.kit;
  const auto white = kit.material(Rgb::grey(0.7f));
  kit.box({-2, -0.01f, -2}, {2, 3, 2}, white);
  kit.quad({Vec3f{0.5f, 2.9f, 0.5f}, {1.5f, 2.9f, 0.5f}, {1.5f, 2.9f, 1.5f}, {0.5f, 2.9f, 1.5f}},
           kit.material(Rgb{}, Rgb::grey(100)));
}

// Irradiance on a normal bent by 20 degrees, from as few rays as a bake at 2 % takes: noise well
// below that.
TEST(Directional, FewRaysAreEnoughForBentNormals) {
  Floor floor{Rgb::grey(0.3f)};
  furnish(floor);
  const DirectionalMap few = floor.bake(176);
  const DirectionalMap many = floor.again(16384, 2);
  double squares = 0, count = 0;
  for (std::size_t t = 0; t < few.direction.size(); ++t) {
    if (dot(many.direction[t], many.direction[t]) == 0) continue;
    for (const Vec3f& bent : {Vec3f{0.342f, 0.940f, 0}, Vec3f{0, 0.940f, -0.342f}}) {
      const auto share = [&](const Vec3f& d) {
        return static_cast<double>((1 + 2 * dot(d, bent)) / (1 + 2 * d.y));
      };
      squares += std::pow(share(few.direction[t]) - share(many.direction[t]), 2);
      ++count;
    }
  }
  ASSERT_GT(count, 100);
  const double error = std::sqrt(squares / count);
  std::printf("rms error of irradiance on bent normals: %.2f %%\n", 100 * error);
  EXPECT_LT(error, 0.02);
}

TEST(Directional, SameBytesOnAnyNumberOfThreads) {
  Floor floor{Rgb::grey(0.3f)};
  furnish(floor);
  const DirectionalMap many = floor.bake(64);
  const int threads = thread_count();
  set_thread_count(1);
  const DirectionalMap one = floor.again(64);
  set_thread_count(threads);
  ASSERT_EQ(many.direction.size(), one.direction.size());
  EXPECT_EQ(std::memcmp(many.direction.data(), one.direction.data(),
                        one.direction.size() * sizeof(Vec3f)),
            0);
}

}  // namespace
}  // namespace lightbatch::lightmap
