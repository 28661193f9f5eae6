#include "core/accuracy/path_tracer.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "core/base/random.h"
#include "core/math/sampling.h"
#include "core/radiosity/polygon_form_factor.h"
#include "tests/unit/accuracy/scene_kit.h"

namespace lightbatch::accuracy {
namespace {

const optics::Environment kBlackSky;

/// Within four standard errors (paths taken as independent, which Sobol points only better).
void expect_irradiance(const PathSum& sum, const Rgbd& exact, const char* what) {
  for (const auto channel : {&Rgbd::r, &Rgbd::g, &Rgbd::b}) {
    const double error =
        4 * std::sqrt(sum.variance.*channel / static_cast<double>(sum.paths)) + 1e-5 * exact.max();
    EXPECT_NEAR(sum.irradiance.*channel, exact.*channel, error) << what;
  }
}

/// A floor of 20 m at y = 0 (fronts up), and what hangs above it.
struct Floor {
  SceneKit kit;
  std::uint32_t triangle = 0;
  explicit Floor(const Rgb& reflectance = {}) {
    triangle = kit.quad({Vec3f{-10, 0, 10}, {10, 0, 10}, {10, 0, -10}, {-10, 0, -10}},
                        kit.material(reflectance));
  }
  /// The point (x, 0, z).
  SurfacePoint at(float x, float z) const {
    const float s = (x + 10) / 20, t = (10 - z) / 20;
    // First triangle (0, 1, 2): s >= t; second (0, 2, 3).
    if (s >= t) return {triangle, s - t, t, false};
    return {triangle + 1, s, t - s, false};
  }
};

TEST(PathTracer, FurnaceOfEveryReflectance) {
  struct Case {
    float rho;
    std::uint32_t samples;
  };
  for (const Case& c :
       {Case{0, 100}, {0.5f, 20000}, {0.9f, 10000}, {0.99f, 3000}, {0.999f, 1000}}) {
    SceneKit kit;
    kit.box({0, 0, 0}, {2, 1, 3}, kit.material(Rgb::grey(c.rho), {1, 2, 0}));
    kit.finish();
    const PathTracer tracer(kit.caster(), kit.optics(), kBlackSky);
    const std::vector<SurfacePoint> points = {{0, 0.3f, 0.3f}, {5, 0.999f, 0.0005f}};
    const double e = kPiDouble / (1 - static_cast<double>(c.rho));
    expect_irradiance(tracer.irradiance(points, c.samples, 7), {e, 2 * e, 0}, "furnace");
  }
}

TEST(PathTracer, RectangleOverFloor) {
  Floor floor;
  const std::array<Vec3f, 4> lamp = {
      Vec3f{-0.5f, 2, -0.5f}, {0.5f, 2, -0.5f}, {0.5f, 2, 0.5f}, {-0.5f, 2, 0.5f}};
  floor.kit.quad(lamp, floor.kit.material(Rgb{}, {100, 50, 10}));
  floor.kit.finish();
  const PathTracer tracer(floor.kit.caster(), floor.kit.optics(), kBlackSky);
  std::vector<Vec3d> polygon;
  for (const Vec3f& p : lamp) polygon.push_back(to_double(p));
  for (const auto& [x, z] : {std::pair{0.0f, 0.0f}, {1.5f, -0.25f}, {-6.0f, 4.0f}}) {
    const Vec3d at{static_cast<double>(x), 0, static_cast<double>(z)};
    const double e = kPiDouble * radiosity::point_to_polygon(at, {0, 1, 0}, polygon);
    ASSERT_GT(e, 0);
    const std::vector<SurfacePoint> point = {floor.at(x, z)};
    expect_irradiance(tracer.irradiance(point, 20000, 3), {100 * e, 50 * e, 10 * e}, "lamp");
  }
  // From behind and from below: nothing.
  SurfacePoint back = floor.at(0, 0);
  back.back = true;
  EXPECT_TRUE(tracer.irradiance(std::vector{back}, 200, 3).irradiance.is_black());
}

// A lamp 1 mm above the floor: without the weights one path could bring 1 / d^2 = 1e6; with them
// its spread stays below half of what the lamp brings underneath.
TEST(PathTracer, LampOneMillimetreAboveTheFloor) {
  Floor floor;
  const std::array<Vec3f, 4> lamp = {Vec3f{-0.5f, 0.001f, -0.5f},
                                     {0.5f, 0.001f, -0.5f},
                                     {0.5f, 0.001f, 0.5f},
                                     {-0.5f, 0.001f, 0.5f}};
  floor.kit.quad(lamp, floor.kit.material(Rgb{}, {1, 1, 1}));
  floor.kit.finish();
  const PathTracer tracer(floor.kit.caster(), floor.kit.optics(), kBlackSky);
  std::vector<Vec3d> polygon;
  for (const Vec3f& p : lamp) polygon.push_back(to_double(p));
  for (const float x : {0.0f, 0.45f, 0.5f, 0.502f, 0.6f}) {
    const double e = kPiDouble * radiosity::point_to_polygon({static_cast<double>(x), 0, 0.1},
                                                             {0, 1, 0}, polygon);
    const PathSum sum = tracer.irradiance(std::vector{floor.at(x, 0.1f)}, 40000, 5);
    expect_irradiance(sum, Rgbd::grey(e), "near lamp");
    EXPECT_LT(std::sqrt(sum.variance.r), 0.5 * kPiDouble);
  }
}

TEST(PathTracer, PunctualLightsAsTheExtensionSays) {
  Floor floor;
  scene::Light point;
  point.position = {0, 2, 0};
  point.intensity = {100, 200, 300};
  scene::Light ranged = point;
  ranged.range = 3;
  scene::Light spot = point;
  spot.kind = scene::LightKind::kSpot;
  spot.direction = {0, -1, 0};
  spot.cos_inner = std::cos(0.2);
  spot.cos_outer = std::cos(0.7);
  scene::Light sun;
  sun.kind = scene::LightKind::kDirectional;
  sun.direction = normalized(Vec3d{1, -2, 0});
  sun.intensity = {1e5f, 1e5f, 9e4f};
  const double d2 = 5, d = std::sqrt(d2), cosine = 2 / d;  // at (1, 0, 0)
  const double plain = cosine / d2;
  const double window = 1 - std::pow(d / 3, 4);
  const double ramp = (cosine - std::cos(0.7)) / (std::cos(0.2) - std::cos(0.7));
  struct Case {
    scene::Light light;
    double factor;
  };
  for (const Case& c :
       {Case{point, plain}, {ranged, plain * window}, {spot, plain * ramp * ramp}, {sun, 2 / d}}) {
    Floor scene;
    scene.kit.scene().lights = {c.light};
    scene.kit.finish();
    const PathTracer tracer(scene.kit.caster(), scene.kit.optics(), kBlackSky);
    const PathSum sum = tracer.irradiance(std::vector{scene.at(1, 0)}, 4, 1);
    const Rgbd exact = to_double(c.light.intensity) * c.factor;
    EXPECT_NEAR(sum.irradiance.r / exact.r, 1, 2e-5);
    EXPECT_NEAR(sum.irradiance.g / exact.g, 1, 2e-5);
    EXPECT_NEAR(sum.irradiance.b / exact.b, 1, 2e-5);
    // Out of range, outside the cone: black.
    if (c.light.range > 0 || c.light.kind == scene::LightKind::kSpot) {
      EXPECT_TRUE(tracer.irradiance(std::vector{scene.at(4, 0)}, 4, 1).irradiance.is_black());
    }
  }
}

// A lamp in the very plane of a ceiling is not shadowed by it, wherever on the floor.
TEST(PathTracer, WhatIsSwitchedOffIsNotTraced) {
  SceneKit kit;
  const std::uint32_t white = kit.material(Rgb::grey(0.5f));
  const std::uint32_t glowing = kit.material(Rgb{}, Rgb::grey(100));
  kit.box({0, 0, 0}, {4, 4, 4}, white);
  kit.quad({Vec3f{1, 3.5f, 1}, {2, 3.5f, 1}, {2, 3.5f, 2}, {1, 3.5f, 2}}, glowing);
  scene::Light point, spot, sun;
  point.position = spot.position = {3, 3, 3};
  point.intensity = spot.intensity = sun.intensity = {50, 50, 50};
  spot.kind = scene::LightKind::kSpot;
  spot.direction = sun.direction = {0, -1, 0};
  spot.cos_inner = spot.cos_outer = std::cos(0.7);
  sun.kind = scene::LightKind::kDirectional;
  kit.scene().lights = {point, spot, sun};
  kit.finish();
  std::vector<SurfacePoint> walls;
  for (std::uint32_t t = 0; t < 12; ++t) walls.push_back({t, 0.4f, 0.3f, false});
  const auto light = [&](const TracedLight& traced) {
    return PathTracer(kit.caster(), kit.optics(), kBlackSky, traced)
        .irradiance(walls, 1 << 16, 5)
        .irradiance.g;
  };
  const double all = light({});
  double parts = 0;
  for (int kind = 0; kind < 4; ++kind) {
    TracedLight one;
    one.lights.points = kind == 0;
    one.lights.spots = kind == 1;
    one.lights.suns = kind == 2;
    one.lights.emitters = kind == 3;
    parts += light(one);
  }
  EXPECT_NEAR(parts / all, 1, 0.02);  // the noise of 65,536 paths
  TracedLight direct;
  direct.interreflection = false;
  EXPECT_LT(light(direct), 0.8 * all);
  TracedLight unshadowed = direct;
  unshadowed.shadows = false;
  // The ceiling shades the room from the sun.
  EXPECT_GT(light(unshadowed), light(direct) + 1);
  TracedLight none = direct;
  none.lights = {false, false, false, false};
  EXPECT_EQ(light(none), 0);
}

TEST(PathTracer, LampInAPlaneOfTheScene) {
  Floor scene;
  const float height = 2.9f;
  scene.kit.quad({Vec3f{-10, height, -10}, {10, height, -10}, {10, height, 10}, {-10, height, 10}},
                 scene.kit.material(Rgb{}));
  scene::Light lamp;
  lamp.position = {0.3f, height, 0.1f};
  lamp.intensity = {100, 100, 100};
  scene.kit.scene().lights = {lamp};
  scene.kit.finish();
  const PathTracer tracer(scene.kit.caster(), scene.kit.optics(), kBlackSky);
  for (int i = 0; i < 200; ++i) {
    const float x = -9.7f + 0.097f * static_cast<float>(i), z = 0.37f * static_cast<float>(i % 20);
    const PathSum sum = tracer.irradiance(std::vector{scene.at(x, z)}, 1, 1);
    const Vec3d to = lamp.position - Vec3d{x, 0, z};
    const double d2 = dot(to, to);
    EXPECT_NEAR(sum.irradiance.r * d2 * std::sqrt(d2) / (100 * to.y), 1, 2e-5) << x << " " << z;
  }
}

// 2,000 lamps of both kinds: the picked one times 1 / probability is the sum of all.
TEST(PathTracer, ManyLampsAreUnbiased) {
  Floor floor;
  Random random(6);
  Rgbd exact;
  const Vec3d at{1, 0, 1};
  const std::uint32_t glow = floor.kit.material(Rgb{}, {500, 500, 100}, true);
  for (int i = 0; i < 1000; ++i) {
    const float x = 20 * random.next_float() - 10, z = 20 * random.next_float() - 10;
    const float y = 1 + 2 * random.next_float();
    scene::Light light;
    light.position = {static_cast<double>(x), static_cast<double>(y) + 1.5, static_cast<double>(z)};
    light.intensity = {1, 2, 3};
    // Above everything, but small and scattered squares can hide it: none here by construction.
    const std::array<Vec3f, 4> square = {
        Vec3f{x, y, z}, {x + 0.02f, y, z}, {x + 0.02f, y, z + 0.02f}, {x, y, z + 0.02f}};
    floor.kit.quad(square, glow);
    std::vector<Vec3d> polygon;
    for (const Vec3f& p : square) polygon.push_back(to_double(p));
    exact +=
        Rgbd{500, 500, 100} * (kPiDouble * radiosity::point_to_polygon(at, {0, 1, 0}, polygon));
    floor.kit.scene().lights.push_back(light);
    const Vec3d v = light.position - at;
    exact += Rgbd{1, 2, 3} * (v.y / std::pow(dot(v, v), 1.5));
  }
  floor.kit.finish();
  const PathTracer tracer(floor.kit.caster(), floor.kit.optics(), kBlackSky);
  const PathSum sum = tracer.irradiance(std::vector{floor.at(1, 1)}, 100000, 9);
  expect_irradiance(sum, exact, "lamps");
  // Picking by what arrives: the spread of one path stays below the mean.
  EXPECT_LT(std::sqrt(sum.variance.g), sum.irradiance.g);
}

TEST(PathTracer, SkyUniformAndMapped) {
  Floor floor;
  floor.kit.finish();
  const std::vector<SurfacePoint> point = {floor.at(0, 0)};
  const optics::Environment uniform(Rgb{1000, 500, 250});
  const PathTracer open(floor.kit.caster(), floor.kit.optics(), uniform);
  expect_irradiance(open.irradiance(point, 64, 1),
                    {1000 * kPiDouble, 500 * kPiDouble, 250 * kPiDouble}, "open sky");

  // A map: dim, with one hot pixel; exact by summing pixels.
  image::ImageRgb map(64, 32);
  for (Rgb& p : map.pixels) p = {1, 1, 1};
  map.at(10, 5) = {20000, 10000, 0};
  map.at(40, 20) = {1e6f, 0, 0};  // below the horizon
  Rgbd exact;
  for (int y = 0; y < 16; ++y) {
    const double top = kPiDouble * y / 32, bottom = kPiDouble * (y + 1) / 32;
    const double flux = (std::sin(bottom) * std::sin(bottom) - std::sin(top) * std::sin(top)) / 2 *
                        2 * kPiDouble / 64;
    for (int x = 0; x < 64; ++x) exact += to_double(map.at(x, y)) * flux;
  }
  const optics::Environment mapped(map);
  const PathTracer lit(floor.kit.caster(), floor.kit.optics(), mapped);
  const PathSum sum = lit.irradiance(point, 40000, 2);
  expect_irradiance(sum, exact, "map");
}

TEST(PathTracer, SkyBesideWall) {
  Floor floor;
  floor.kit.quad({Vec3f{0, 0, -10}, {0, 0, 10}, {0, 10, 10}, {0, 10, -10}},
                 floor.kit.material(Rgb{}));
  floor.kit.finish();
  const optics::Environment sky(Rgb{1, 1, 1});
  const PathTracer tracer(floor.kit.caster(), floor.kit.optics(), sky);
  const std::vector<Vec3d> wall = {{0, 0, -10}, {0, 0, 10}, {0, 10, 10}, {0, 10, -10}};
  for (const float x : {0.01f, 1.0f, 5.0f}) {
    const double f =
        radiosity::point_to_polygon({static_cast<double>(x), 0, 0}, {0, 1, 0},
                                    std::vector<Vec3d>{wall[0], wall[3], wall[2], wall[1]}) +
        radiosity::point_to_polygon({static_cast<double>(x), 0, 0}, {0, 1, 0}, wall);
    expect_irradiance(tracer.irradiance(std::vector{floor.at(x, 0)}, 20000, 4),
                      Rgbd::grey(kPiDouble * (1 - f)), "wall");
  }
}

// A sheet of transmittance T and reflectance rho over a black floor under a sky: T pi L where the
// sheet covers everything; between sheet and a white floor the light bounces:
// T / (1 - rho_floor rho_sheet).
TEST(PathTracer, SheetsLetLightThrough) {
  for (const bool one_sided : {true, false}) {
    SceneKit kit;
    scene::Material glass;
    glass.metallic = 0;
    glass.base_color = {0.8f, 0.4f, 0.2f};
    glass.transmission = 0.75f;
    glass.double_sided = !one_sided;
    const std::uint32_t pane = kit.material(glass);
    const std::uint32_t white = kit.material(Rgb::grey(0.5f));
    const std::uint32_t black = kit.material(Rgb{});
    // A closed black box without lid; the floor white, the pane just above it.
    const std::uint32_t floor =
        kit.quad({Vec3f{-100, 0, 100}, {100, 0, 100}, {100, 0, -100}, {-100, 0, -100}}, white);
    kit.quad({Vec3f{-100, 0.01f, 100}, {100, 0.01f, 100}, {100, 0.01f, -100}, {-100, 0.01f, -100}},
             pane);
    kit.quad({Vec3f{-100, -1, 100}, {100, -1, 100}, {100, -1, -100}, {-100, -1, -100}}, black);
    kit.finish();
    const optics::Environment sky(Rgb{1, 1, 1});
    const PathTracer tracer(kit.caster(), kit.optics(), sky);
    const PathSum sum = tracer.irradiance(std::vector{SurfacePoint{floor, 0.5f, 0.25f}}, 100000, 3);
    Rgbd exact;
    for (const auto c : {&Rgb::r, &Rgb::g, &Rgb::b}) {
      const double t = 0.75 * static_cast<double>(glass.base_color.*c);
      const double rho = one_sided ? 0 : 0.25 * static_cast<double>(glass.base_color.*c);
      const double e = kPiDouble * t / (1 - 0.5 * rho);
      (c == &Rgb::r ? exact.r : c == &Rgb::g ? exact.g : exact.b) = e;
    }
    expect_irradiance(sum, exact, one_sided ? "one-sided pane" : "two-sided pane");
  }
}

// Coplanar twins, one facing up and one down, with a lamp above: no acne, no leak.
TEST(PathTracer, CoincidentFacesNeitherShadowNorLeak) {
  Floor floor;
  const std::uint32_t grey = floor.kit.material(Rgb::grey(0.5f));
  floor.kit.quad({Vec3f{-10, 0, -10}, {10, 0, -10}, {10, 0, 10}, {-10, 0, 10}}, grey);
  scene::Light light;
  light.position = {0, 3, 0};
  light.intensity = {9, 9, 9};
  floor.kit.scene().lights = {light};
  floor.kit.finish();
  const PathTracer tracer(floor.kit.caster(), floor.kit.optics(), kBlackSky);
  EXPECT_NEAR(tracer.irradiance(std::vector{floor.at(0, 0)}, 16, 1).irradiance.r, 1, 1e-5);
  EXPECT_EQ(tracer.irradiance(std::vector{SurfacePoint{floor.triangle + 2, 0.3f, 0.3f}}, 16, 1)
                .irradiance.r,
            0);
}

TEST(PathTracer, SeedsAreIndependentAndRepeatable) {
  SceneKit kit;
  kit.box({0, 0, 0}, {1, 1, 1}, kit.material(Rgb::grey(0.5f), {1, 1, 1}));
  kit.finish();
  const PathTracer tracer(kit.caster(), kit.optics(), kBlackSky);
  const std::vector<SurfacePoint> points = {{0, 0.3f, 0.3f}};
  const double a = tracer.irradiance(points, 64, 1).irradiance.r;
  EXPECT_EQ(a, tracer.irradiance(points, 64, 1).irradiance.r);
  EXPECT_NE(a, tracer.irradiance(points, 64, 2).irradiance.r);
  double product = 0, square = 0;
  for (std::uint64_t s = 0; s < 400; ++s) {
    const double x = tracer.irradiance(points, 16, 2 * s).irradiance.r - 2 * kPiDouble;
    const double y = tracer.irradiance(points, 16, 2 * s + 1).irradiance.r - 2 * kPiDouble;
    product += x * y;
    square += x * x;
  }
  EXPECT_LT(std::abs(product / square), 4 / std::sqrt(400));
  EXPECT_EQ(tracer.irradiance(std::vector<SurfacePoint>{}, 10, 1).paths, 0u);
  EXPECT_EQ(tracer.irradiance(points, 0, 1).paths, 0u);
}

}  // namespace
}  // namespace lightbatch::accuracy
