#include <gtest/gtest.h>

#include <memory>

#include "core/pipeline/certify_stage.h"

namespace lightbatch::pipeline {
namespace {

/// One triangle of the given reflectance.
Prepared surface_of(float reflectance) {
  Prepared p;
  p.scene = std::make_unique<scene::Scene>();
  p.scene->positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  scene::Material material;
  material.base_color = Rgb::grey(reflectance);
  material.metallic = 0;
  p.scene->materials.push_back(material);
  scene::Object object;
  object.triangle_count = 1;
  p.scene->objects.push_back(object);
  p.scene->triangles.push_back({{0, 1, 2}, 0, 0});
  p.optics = std::make_unique<optics::Optics>(*p.scene);
  return p;
}

TEST(CertificateBudget, TellsATargetFromNoiseAfterASmallBake) {
  const Prepared black = surface_of(0);
  // Noise falls with the root of the paths: half the target takes four times as many.
  const auto at = [&](double target) { return certificate_budget(black, 1000, target); };
  EXPECT_NEAR(static_cast<double>(at(0.01)) / static_cast<double>(at(0.02)), 4, 0.01);
  EXPECT_GE(at(0.005), at(0.01));
  // Within limits, however coarse or fine the target.
  EXPECT_EQ(at(1.0), at(0.5));
  EXPECT_EQ(at(1e-5), at(1e-4));
  EXPECT_GT(at(1.0), 0u);
}

TEST(CertificateBudget, IsAQuarterOfALargeBake) {
  const Prepared black = surface_of(0);
  const std::uint64_t large = certificate_budget(black, 2e7, 0.02);
  // A path in a black scene is two rays: to a surface, and to a light.
  EXPECT_EQ(large, path_budget(black, 2e7));
  EXPECT_NEAR(static_cast<double>(large), 0.25 * 2e7 / 2, 1);
  EXPECT_GE(certificate_budget(black, 1e3, 0.02), path_budget(black, 1e3));
}

TEST(CertificateBudget, FewerPathsWhereTheyAreLong) {
  const Prepared black = surface_of(0), white = surface_of(0.9f);
  EXPECT_LT(certificate_budget(white, 1e8, 0.02), certificate_budget(black, 1e8, 0.02));
  EXPECT_LT(certificate_budget(white, 1000, 0.01), certificate_budget(black, 1000, 0.01));
}

}  // namespace
}  // namespace lightbatch::pipeline
