#include "core/probes/bake.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "core/accuracy/path_tracer.h"
#include "core/base/parallel.h"
#include "tests/unit/lightmap/lit_scene.h"

namespace lightbatch::probes {
namespace {

using lightmap::LitScene;

const double kRoot4Pi = std::sqrt(4 * kPiDouble);

LightProbes bake(const LitScene& lit, const std::vector<Vec3d>& positions, double error = 0.01) {
  const lightmap::BakeInput input = lit.input();
  const lightmap::GatherSettings settings;
  const lightmap::Gather gather(input, settings);
  ProbeGrid grid;
  grid.positions = positions;
  ProbeSettings probe_settings;
  probe_settings.error = error;
  auto probes = bake_probes(input, gather, std::move(grid), probe_settings, Progress{});
  EXPECT_TRUE(probes.ok());
  return std::move(probes).value();
}

/// Root mean square over all normals of the difference.
double difference(const ShIrradiance& a, const std::array<Rgbd, 9>& b) {
  double squares = 0;
  for (std::size_t k = 0; k < 9; ++k) {
    const Rgbd d = to_double(a.coefficient[k]) - b[k];
    squares += (d * d).sum() / 3;
  }
  return std::sqrt(squares) / kRoot4Pi;
}

TEST(Probes, ConstantSkyIsTheFirstCoefficientAlone) {
  LitScene lit;
  lit.sky = optics::Environment(Rgb{100, 50, 20});
  lit.solve();
  const LightProbes probes = bake(lit, {{0, 0, 0}, {3, -2, 8}});
  for (const ShIrradiance& sh : probes.irradiance) {
    EXPECT_NEAR(sh.coefficient[0].r, kPiDouble * 100 * kRoot4Pi, 0.01);
    EXPECT_NEAR(sh.coefficient[0].b, kPiDouble * 20 * kRoot4Pi, 0.01);
    for (std::size_t k = 1; k < 9; ++k) EXPECT_NEAR(sh.coefficient[k].r, 0, 0.01) << k;
    EXPECT_NEAR(sh.at({0, 0.6f, -0.8f}).g, kPiDouble * 50, 0.01);
  }
  EXPECT_EQ(probes.counts.rays.cast(), 2u * 64u);
  EXPECT_NEAR(probes.noise, 0, 1e-6);
}

TEST(Probes, ADirectionalLightIsTheCosineLobeAboutItsDirection) {
  LitScene lit;
  const Vec3f towards = normalized(Vec3f{0.3f, 0.8f, -0.5f});
  scene::Light sun;
  sun.kind = scene::LightKind::kDirectional;
  sun.direction = to_double(-towards);
  sun.intensity = {1000, 900, 800};
  lit.kit.scene().lights.push_back(sun);
  // A roof over the second probe.
  lit.kit.quad({Vec3f{10, 5, 12}, {14, 5, 12}, {14, 5, 8}, {10, 5, 8}},
               lit.kit.material(Rgb::grey(0), Rgb{}, true));
  lit.solve();
  const Vec3d under = Vec3d{12, 5, 10} - to_double(towards);
  const LightProbes probes = bake(lit, {{0, 0, 0}, under});
  const Sh9 basis = sh_basis(towards);
  for (std::size_t k = 0; k < 9; ++k) {
    EXPECT_NEAR(probes.irradiance[0].coefficient[k].r, 1000 * kShCosine[k] * basis[k], 0.01) << k;
    EXPECT_NEAR(probes.irradiance[0].coefficient[k].b, 800 * kShCosine[k] * basis[k], 0.01) << k;
    EXPECT_EQ(probes.irradiance[1].coefficient[k].r, 0) << k;
  }
  // Order 2 of the clamped cosine at its peak: 1/4 + 1/2 + 5/16.
  EXPECT_NEAR(probes.irradiance[0].at(towards).r, 1062.5, 0.1);
}

TEST(Probes, AFurnaceIsConstant) {
  LitScene lit;
  lit.kit.box({0, 0, 0}, {1, 1, 1}, lit.kit.material(Rgb::grey(0.8f), Rgb::grey(10)));
  lit.solve();
  const LightProbes probes = bake(lit, {{0.5, 0.5, 0.5}, {0.05, 0.9, 0.3}}, 0.002);
  const double exact = kPiDouble * 10 / (1 - 0.8);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(probes.valid[i], 1);
    EXPECT_NEAR(probes.irradiance[i].coefficient[0].g, exact * kRoot4Pi, 0.01 * exact * kRoot4Pi);
    EXPECT_LT(difference(probes.irradiance[i], {Rgbd::grey(exact * kRoot4Pi)}), 0.01 * exact) << i;
  }
}

TEST(Probes, InsideASolidIsInvalidAndTakesFromItsNeighbours) {
  LitScene lit;
  lit.sky = optics::Environment(Rgb::grey(100));
  lit.kit.box({-1, -1, -1}, {1, 1, 1}, lit.kit.material(Rgb::grey(0)), false);
  lit.solve();
  const lightmap::BakeInput input = lit.input();
  const lightmap::GatherSettings settings;
  const lightmap::Gather gather(input, settings);
  ProbeGrid grid;
  for (std::uint32_t k = 0; k < 8; ++k) {  // the first corner is the middle of the solid
    grid.positions.push_back({(k & 1) * 20.0, (k >> 1 & 1) * 20.0, (k >> 2 & 1) * 20.0});
  }
  grid.volumes.push_back(
      {{0, 0, 0}, 20, {1, 1, 1}, 1, {{{0, 0, 0}, 1, {0, 1, 2, 3, 4, 5, 6, 7}}}, {}});
  const auto probes = bake_probes(input, gather, std::move(grid), {}, Progress{});
  ASSERT_TRUE(probes.ok());
  EXPECT_EQ(probes->valid, (std::vector<std::uint8_t>{0, 1, 1, 1, 1, 1, 1, 1}));
  EXPECT_NEAR(probes->irradiance[0].at({0, 1, 0}).g, kPiDouble * 100, 3);
}

/// A room of 4 x 3 x 5 metres with coloured walls, a lamp and a block.
class Room {
 public:
  LitScene lit;
  Room() {
    auto& kit = lit.kit;
    const auto white = kit.material(Rgb{0.7f, 0.7f, 0.7f});
    const auto red = kit.material(Rgb{0.6f, 0.1f, 0.1f});
    kit.box({0, 0, 0}, {4, 3, 5}, white);
    kit.quad({Vec3f{0.001f, 0, 0}, {0.001f, 3, 0}, {0.001f, 3, 5}, {0.001f, 0, 5}}, red);
    kit.box({1, 0, 2}, {2, 1.2f, 3.5f}, white, false);
    kit.quad(
        {Vec3f{1.5f, 2.99f, 1.5f}, {2.5f, 2.99f, 1.5f}, {2.5f, 2.99f, 2.5f}, {1.5f, 2.99f, 2.5f}},
        kit.material(Rgb::grey(0), Rgb{100, 100, 80}));
  }
};

/// Normals spread evenly (a spiral), for the quadrature of the reference.
std::vector<Vec3f> spread_normals(int count) {
  std::vector<Vec3f> normals;
  for (int i = 0; i < count; ++i) {
    const double z = 1 - (2 * i + 1.0) / count, r = std::sqrt(1 - z * z);
    const double angle = i * kPiDouble * (3 - std::sqrt(5.0));
    normals.push_back(to_float(Vec3d{r * std::cos(angle), r * std::sin(angle), z}));
  }
  return normals;
}

// The reference starts its paths on triangles that light does not see, one for each normal.
TEST(Probes, AgreeWithThePathTracer) {
  Room room;
  const std::vector<Vec3d> positions{
      {2, 1.5, 2.5}, {3.5, 0.4, 0.6}, {0.4, 0.3, 2.7}, {1.5, 1.35, 2.2}};
  const std::vector<Vec3f> normals = spread_normals(96);
  scene::Material clear;
  clear.metallic = 0;
  clear.alpha_mode = scene::AlphaMode::kBlend;
  clear.alpha = 0;
  const auto unseen = room.lit.kit.material(clear);
  std::vector<std::uint32_t> starts;
  for (const Vec3d& position : positions) {
    for (const Vec3f& n : normals) {
      const Frame frame = Frame::about(n);
      const Vec3f at = to_float(position);
      const Vec3f u = frame.x * 1e-3f, v = frame.y * 1e-3f;
      starts.push_back(room.lit.kit.quad({at - u - v, at + u - v, at + u + v, at - u + v}, unseen));
    }
  }
  room.lit.edge = 0.12;
  room.lit.solve();
  const double target = 0.02;
  const LightProbes probes = bake(room.lit, positions, target);
  const accuracy::PathTracer tracer(room.lit.kit.caster(), room.lit.kit.optics(), room.lit.sky);
  double squares = 0, mean = 0;
  for (std::size_t i = 0; i < positions.size(); ++i) {
    EXPECT_EQ(probes.valid[i], 1) << i;
    std::array<Rgbd, 9> reference{};
    for (std::size_t j = 0; j < normals.size(); ++j) {
      // Where the diagonal is cut: the middle of the quad.
      const accuracy::SurfacePoint start{starts[i * normals.size() + j], 0, 0.5f, false};
      const Rgbd e = tracer.irradiance(std::array{start}, 4096, 7 * i + j).irradiance;
      const Sh9 basis = sh_basis(normals[j]);
      for (std::size_t k = 0; k < 9; ++k) {
        reference[k] += e * (4 * kPiDouble / static_cast<double>(normals.size()) *
                             static_cast<double>(basis[k]));
      }
    }
    const double off = difference(probes.irradiance[i], reference);
    squares += off * off / static_cast<double>(positions.size());
    mean += reference[0].sum() / 3 / kRoot4Pi / static_cast<double>(positions.size());
  }
  const double error = std::sqrt(squares) / mean;
  RecordProperty("relrmse_percent", std::to_string(100 * error));
  std::printf("relRMSE of %zu probes against the path tracer: %.2f %% (noise said: %.2f %%)\n",
              positions.size(), 100 * error, 100 * probes.noise);
  EXPECT_LT(error, 1.25 * target);
  EXPECT_LE(probes.noise, target);
}

TEST(Probes, NoiseIsWhatIsAskedFor) {
  Room room;
  room.lit.solve();
  const std::vector<Vec3d> positions{{2, 1.5, 2.5}, {3.5, 0.4, 0.6}, {0.4, 0.3, 2.7}};
  const LightProbes exact = bake(room.lit, positions, 0.0005);
  std::uint64_t before = 0;
  for (const double error : {0.1, 0.02, 0.005}) {
    const LightProbes probes = bake(room.lit, positions, error);
    double squares = 0, mean = 0;
    for (std::size_t i = 0; i < positions.size(); ++i) {
      std::array<Rgbd, 9> reference;
      for (std::size_t k = 0; k < 9; ++k) {
        reference[k] = to_double(exact.irradiance[i].coefficient[k]);
      }
      squares += std::pow(difference(probes.irradiance[i], reference), 2) / 3;
      mean += reference[0].sum() / 3 / kRoot4Pi / 3;
    }
    EXPECT_LT(std::sqrt(squares) / mean, 1.5 * error);
    EXPECT_LE(probes.noise, error);
    EXPECT_GE(probes.counts.rays.cast(), before);
    before = probes.counts.rays.cast();
  }
}

TEST(Probes, SameBytesOnAnyNumberOfThreads) {
  Room room;
  room.lit.solve();
  std::vector<Vec3d> positions;
  for (int i = 0; i < 40; ++i) positions.push_back({0.1 * i, 1.3, 4.7 - 0.1 * i});
  const LightProbes many = bake(room.lit, positions);
  const int threads = thread_count();
  set_thread_count(1);
  const LightProbes one = bake(room.lit, positions);
  set_thread_count(threads);
  ASSERT_EQ(many.irradiance.size(), one.irradiance.size());
  EXPECT_EQ(std::memcmp(many.irradiance.data(), one.irradiance.data(),
                        one.irradiance.size() * sizeof(ShIrradiance)),
            0);
  EXPECT_EQ(many.counts.rays.cast(), one.counts.rays.cast());
}

}  // namespace
}  // namespace lightbatch::probes
