#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <memory>
#include <numbers>
#include <vector>

#include "core/base/random.h"
#include "core/optics/duplicates.h"
#include "core/radiosity/direct_light.h"
#include "core/radiosity/polygon_form_factor.h"
#include "tests/unit/accuracy/scene_kit.h"

namespace lightbatch::radiosity {
namespace {

using accuracy::SceneKit;

/// Two thousand small lamps of random facing in a slab above the receiver, nothing between.
struct ManyLamps {
  SceneKit kit;
  Receiver at;
  double exact = 0;  // lux, by the exact factor of every triangle

  ManyLamps() {
    const std::uint32_t lamp = kit.material(Rgb{}, {300, 300, 300});
    Random random(11);
    const auto point = [&](float size) {
      return Vec3f{random.next_float() - 0.5f, random.next_float() - 0.5f,
                   random.next_float() - 0.5f} *
             size;
    };
    for (int i = 0; i < 1000; ++i) {
      const Vec3f c = point(6) * 1.0f + Vec3f{0, 4.2f, 0};
      const Vec3f u = point(0.1f), v = point(0.1f);
      kit.quad({c, c + u, c + u + v, c + v}, lamp);
    }
    kit.finish();
    at.frame.position = at.frame.origin = {0.1f, 0, 0.2f};
    at.frame.normal = {0, 1, 0};
    for (std::uint32_t t = 0; t < kit.scene().triangles.size(); ++t) {
      exact += std::numbers::pi * 300 *
               point_to_triangle(to_double(at.frame.position), {0, 1, 0}, kit.scene().corners(t));
    }
  }
};

// The mean of 60,000 samples; their spread is about three times the mean, so 1.3 % is one standard
// error and 4 % three.
TEST(Emitters, OneAtRandomIsRightInTheMean) {
  ManyLamps lamps;
  const LightSources sources(lamps.kit.scene(), lamps.kit.optics(), {});
  const DirectLight direct(lamps.kit.optics(), lamps.kit.caster(), sources, false);
  for (const float worth : {0.0f, static_cast<float>(4 * lamps.exact)}) {
    Random random(5);
    double sum = 0;
    constexpr int kSamples = 60'000;
    for (int i = 0; i < kSamples; ++i) {
      RayCounts counts;
      const double pick = random.next_double();
      const Vec2f on{random.next_float(), random.next_float()};
      sum += static_cast<double>(
          direct.sampled_emitters(lamps.at, worth, pick, on, counts).irradiance.g);
    }
    EXPECT_NEAR(sum / kSamples / lamps.exact, 1, 0.04) << worth;
  }
}

// Sixteen points that share the cut's emitters out between them, against sixteen at random.
TEST(Emitters, DealtOutTheyAreLessNoisy) {
  ManyLamps lamps;
  const LightSources sources(lamps.kit.scene(), lamps.kit.optics(), {});
  const DirectLight direct(lamps.kit.optics(), lamps.kit.caster(), sources, false);
  double dealt = 0, random = 0;
  constexpr int kRuns = 60, kPoints = 16;
  for (std::uint64_t run = 0; run < kRuns; ++run) {
    double dealt_sum = 0, random_sum = 0;
    for (std::uint64_t i = 0; i < kPoints; ++i) {
      RayCounts counts;
      const auto turn = static_cast<float>(i) / kPoints;
      EmitterTerms terms;
      const auto sum_of = [&](const DirectLight::CutChoice& choice) {
        direct.emitter_terms(lamps.at, choice, terms, counts);
        return static_cast<double>(terms.total.g);
      };
      dealt_sum += sum_of({run, turn}) / kPoints;
      random_sum += sum_of({item_seed(run, i), 0}) / kPoints;
    }
    dealt += std::pow(dealt_sum / lamps.exact - 1, 2) / kRuns;
    random += std::pow(random_sum / lamps.exact - 1, 2) / kRuns;
  }
  EXPECT_LT(std::sqrt(dealt), 0.01);
  EXPECT_LT(dealt, random / 2);
}

// A flat box that glows all over, seen from its floor beside long thin walls: the irradiance is pi
// L everywhere. Chosen by the middles of their boxes, the walls make samples of 56 times that, and
// the mean square is 10.
TEST(Emitters, LongThinOnesCloseByAreChosenForWhatTheyBring) {
  SceneKit kit;
  kit.box({0, 0, 0}, {4, 0.1f, 4}, kit.material(Rgb{}, {1, 1, 1}));
  kit.finish();
  const LightSources sources(kit.scene(), kit.optics(), {});
  const DirectLight direct(kit.optics(), kit.caster(), sources, false);
  Random random(9);
  double sum = 0, squares = 0, largest = 0;
  constexpr int kSamples = 40'000;
  for (int i = 0; i < kSamples; ++i) {
    Receiver at;
    at.frame.position = at.frame.origin = {0.001f + 0.05f * random.next_float(), 0,
                                           0.2f + 3.6f * random.next_float()};
    at.frame.normal = {0, 1, 0};
    RayCounts counts;
    const double pick = random.next_double();
    const Vec2f on{random.next_float(), random.next_float()};
    const double brings =
        static_cast<double>(direct.sampled_emitters(at, 0, pick, on, counts).irradiance.g) /
        std::numbers::pi;
    sum += brings;
    squares += brings * brings;
    largest = std::max(largest, brings);
  }
  EXPECT_NEAR(sum / kSamples, 1, 0.02);  // three standard errors
  EXPECT_LT(squares / kSamples, 3);
  EXPECT_LT(largest, 12);
}

// Half of a ball faces away: a cut and picks that know it are off by 1 to 3 %, by power alone 2 to
// 7 %. One point each.
TEST(Emitters, ABallOfManyTrianglesIsKnownByItsFacing) {
  SceneKit kit;
  const std::uint32_t lamp = kit.material(Rgb{}, {300, 300, 300});
  constexpr int kRings = 24, kSectors = 48;
  const auto place = [](int ring, int sector) {
    const double theta = std::numbers::pi * ring / kRings;
    const double phi = 2 * std::numbers::pi * (sector % kSectors) / kSectors;
    return to_float(Vec3d{0.4 * std::sin(theta) * std::cos(phi), 1 + 0.4 * std::cos(theta),
                          0.4 * std::sin(theta) * std::sin(phi)});
  };
  for (int i = 0; i < kRings; ++i) {
    for (int k = 0; k < kSectors; ++k) {
      kit.quad({place(i, k), place(i, k + 1), place(i + 1, k + 1), place(i + 1, k)}, lamp);
    }
  }
  kit.finish();
  const LightSources sources(kit.scene(), kit.optics(), {});
  const DirectLight direct(kit.optics(), kit.caster(), sources, false);
  for (const Vec3f at : {Vec3f{0.2f, 0, 0.1f}, {1, 0, 0.5f}, {3, 0, 3}}) {
    Receiver receiver;
    receiver.frame.position = receiver.frame.origin = at;
    receiver.frame.normal = {0, 1, 0};
    double exact = 0;
    for (std::uint32_t t = 0; t < kit.scene().triangles.size(); ++t) {
      exact += std::numbers::pi * 300 *
               point_to_triangle(to_double(at), {0, 1, 0}, kit.scene().corners(t));
    }
    double square = 0;
    constexpr int kRuns = 100;
    for (std::uint64_t run = 0; run < kRuns; ++run) {
      EmitterTerms terms;
      RayCounts counts;
      direct.emitter_terms(receiver, {run, 0}, terms, counts);
      square += std::pow(static_cast<double>(terms.total.g) / exact - 1, 2) / kRuns;
    }
    EXPECT_LT(std::sqrt(square), 0.04) << at.x;
  }
}

// Two glowing signs of ten metres, one of them in front of the receiver at 5 mm: what counts is how
// near some part of a node comes, not how far its middle is.
TEST(Emitters, ASignRightInFrontIsNotLostInItsNode) {
  SceneKit kit;
  const std::uint32_t lamp = kit.material(Rgb{}, {10, 10, 10});
  for (const float x : {0.0f, 20.0f}) {
    for (int i = 0; i < 10; ++i) {
      const float z = 1.1f * static_cast<float>(i);
      kit.quad({Vec3f{x, 0.005f, z},
                {x + 0.1f, 0.005f, z},
                {x + 0.1f, 0.005f, z + 0.1f},
                {x, 0.005f, z + 0.1f}},
               lamp);
    }
  }
  kit.finish();
  const LightSources sources(kit.scene(), kit.optics(), {});
  const DirectLight direct(kit.optics(), kit.caster(), sources, false);
  Receiver at;
  at.frame.position = at.frame.origin = {0.05f, 0, 3.35f};
  at.frame.normal = {0, 1, 0};
  for (std::uint64_t run = 0; run < 20; ++run) {
    EmitterTerms terms;
    RayCounts counts;
    direct.emitter_terms(at, {run, 0}, terms, counts, 0.5f);
    // Nearly the whole hemisphere: pi L but for the edge, 5 mm in 50.
    EXPECT_NEAR(terms.total.g / (10 * kPi), 0.99, 0.01) << run;
  }
}

/// What a lamp brings to a surface that it touches at a point, whose rays start above it.
float light_of_touching(const std::array<Vec3f, 4>& lamp, const optics::SurfaceFrame& frame) {
  SceneKit kit;
  kit.quad(lamp, kit.material(Rgb{}, {10, 10, 10}));
  kit.finish();
  const LightSources sources(kit.scene(), kit.optics(), {});
  const DirectLight direct(kit.optics(), kit.caster(), sources, false);
  Receiver at;
  at.frame = frame;
  EmitterTerms terms;
  RayCounts counts;
  direct.emitter_terms(at, {1, 0}, terms, counts);
  return terms.total.g;
}

// A lamp that stands on a surface does not light it from below: rays start above it.
TEST(Emitters, WhatTouchesASurfaceIsBehindIt) {
  optics::SurfaceFrame frame;
  frame.position = {0.5f, -1e-7f, 0.5f};
  frame.origin = {0.5f, 1e-5f, 0.5f};
  frame.normal = {0, 1, 0};
  EXPECT_EQ(light_of_touching({Vec3f{0, 0, 0}, {1, 0, 0}, {1, 0, 1}, {0, 0, 1}}, frame), 0);
}

// The same on a slope, where the corners of the lamp's box stand high above the surface.
TEST(Emitters, WhatTouchesASlopeIsBehindIt) {
  optics::SurfaceFrame frame;
  frame.normal = normalized(Vec3f{-1, 1, 0});
  frame.position = Vec3f{0.5f, 0.5f, 0.5f} - frame.normal * 1e-6f;
  frame.origin = Vec3f{0.5f, 0.5f, 0.5f} + frame.normal * 1e-5f;
  EXPECT_EQ(light_of_touching({Vec3f{0, 0, 0}, {1, 1, 0}, {1, 1, 1}, {0, 0, 1}}, frame), 0);
}

TEST(Emitters, ALampAtTheSamePlaceTwiceShinesOnce) {
  SceneKit kit;
  const std::uint32_t lamp = kit.material(Rgb{}, {300, 300, 300});
  const std::array<Vec3f, 4> up{Vec3f{0, 0, 0}, {0, 0, 1}, {1, 0, 1}, {1, 0, 0}};
  const std::array<Vec3f, 4> down{up[3], up[2], up[1], up[0]};
  for (const auto& corners : {up, up, down}) kit.quad(corners, lamp);
  kit.finish();
  const std::vector<std::uint32_t> all{0, 1, 2, 3, 4, 5};
  EXPECT_EQ(optics::hidden_duplicates(kit.scene(), all), (std::vector<std::uint32_t>{2, 3}));
  for (const std::uint32_t t : {0u, 1u, 4u, 5u}) EXPECT_TRUE(kit.optics().emits(t)) << t;
  for (const std::uint32_t t : {2u, 3u}) EXPECT_FALSE(kit.optics().emits(t)) << t;
}

// Every node's cone holds the directions that its emitters shine in, so that nothing is passed
// over.
TEST(Emitters, ConesOfNodesHoldAllThatIsBelow) {
  ManyLamps lamps;
  const LightSources sources(lamps.kit.scene(), lamps.kit.optics(), {});
  const auto& tree = sources.emitter_tree();
  for (hierarchy::Hierarchy::NodeId node = 0; node < tree.node_count(); ++node) {
    const FacingCone& cone = sources.facing(node);
    ASSERT_NEAR(length(cone.axis), 1, 1e-5);
    for (const std::uint32_t i : tree.primitives(node)) {
      const Emitter& e = sources.emitters()[i];
      const Vec3f normal = normalized(cross(e.b - e.a, e.c - e.a));
      ASSERT_GE(dot(normal, cone.axis), cone.cos_angle - 1e-4f) << node;
    }
  }
}

TEST(Emitters, ConesAreAsNarrowAsTheyCanBe) {
  const FacingCone up{{0, 1, 0}, 1}, aside{{1, 0, 0}, 1};
  const FacingCone both = FacingCone::around(up, aside);
  EXPECT_NEAR(both.cos_angle, std::cos(std::numbers::pi / 4), 1e-6);
  EXPECT_NEAR(dot(both.axis, up.axis), std::cos(std::numbers::pi / 4), 1e-6);
  // What is inside already changes nothing; opposite directions leave none out.
  EXPECT_EQ(FacingCone::around(both, up).cos_angle, both.cos_angle);
  EXPECT_EQ(FacingCone::around(up, {{0, -1, 0}, 1}).cos_angle, -1);
  Emitter two_sided;
  two_sided.a = {0, 0, 0};
  two_sided.b = {1, 0, 0};
  two_sided.c = {0, 1, 0};
  EXPECT_EQ(FacingCone::of(two_sided).axis, (Vec3f{0, 0, 1}));
  EXPECT_EQ(FacingCone::of(two_sided).cos_angle, 1);
  two_sided.double_sided = true;
  EXPECT_EQ(FacingCone::of(two_sided).cos_angle, -1);
}

/// A square of 1 m that emits 100 nits times an 8-bit picture, nearest texels.
struct Picture {
  SceneKit kit;
  double flux = 0;     // of all its emitters, red
  double largest = 0;  // area of an emitter that is not black

  /// along_a_line: its coordinates run along the picture's middle row.
  Picture(int width, int height, const std::vector<std::uint8_t>& grey, bool along_a_line = false) {
    image::Image8 image;
    image.width = width;
    image.height = height;
    for (const std::uint8_t v : grey) image.rgba.insert(image.rgba.end(), {v, v, v, 255});
    kit.scene().images.push_back(std::make_shared<image::Image8>(image));
    scene::Material m;
    m.emission = Rgb::grey(100);
    m.emission_texture.image = 0;
    m.emission_texture.filter = scene::Filter::kNearest;
    kit.quad({Vec3f{0, 0, 0}, {1, 0, 0}, {1, 0, -1}, {0, 0, -1}}, kit.material(m));
    for (Vec2f& uv : kit.scene().uv0) uv.y = along_a_line ? 0.5f : uv.y;
    kit.finish();
    const LightSources sources(kit.scene(), kit.optics(), {});
    for (const Emitter& e : sources.emitters()) {
      flux += static_cast<double>(e.area * e.luminance.r);
      largest = std::max(largest, static_cast<double>(e.area));
    }
  }
};

// The means of its quarters are the same.
TEST(Emitters, AChequeredLampIsNotEven) {
  std::vector<std::uint8_t> grey(64);
  for (std::size_t i = 0; i < grey.size(); ++i) grey[i] = (i + i / 8) % 2 == 0 ? 255 : 0;
  const Picture picture(8, 8, grey);
  EXPECT_NEAR(picture.flux, 50, 0.2);
  EXPECT_LE(picture.largest, 1.0 / 64);
}

TEST(Emitters, OneBrightTexelOfManyIsFound) {
  std::vector<std::uint8_t> grey(64 * 64);
  grey[64 * 20 + 41] = 255;
  const Picture picture(64, 64, grey);
  EXPECT_NEAR(picture.flux, 100.0 / 4096, 0.02 * 100.0 / 4096);
  EXPECT_LE(picture.largest, 1.0 / 256);
}

TEST(Emitters, CoordinatesAlongALineTellAsMuch) {
  std::vector<std::uint8_t> grey(512);
  std::fill(grey.begin() + 128, grey.begin() + 256, 255);
  const Picture picture(512, 1, grey, true);
  EXPECT_NEAR(picture.flux, 25, 0.1);
  EXPECT_LE(picture.largest, 1.0 / 8);
}

}  // namespace
}  // namespace lightbatch::radiosity
