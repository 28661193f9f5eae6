#include <gtest/gtest.h>

#include <map>
#include <set>
#include <vector>

#include "tests/unit/rays/oracle.h"

namespace lightbatch::rays {
namespace {

using testing::Mesh;

class Recorder : public HitFilter {
 public:
  explicit Recorder(std::set<std::uint32_t> stopping) : stopping_(std::move(stopping)) {}
  bool stops(const Hit& hit) override {
    ++asked[hit.triangle];
    return stopping_.contains(hit.triangle);
  }
  std::map<std::uint32_t, int> asked;

 private:
  std::set<std::uint32_t> stopping_;
};

/// Screens one behind the other: screen i at z = i + 1.
Mesh screens(int n) {
  Mesh mesh;
  for (int i = 0; i < n; ++i) {
    const float z = static_cast<float>(i + 1);
    mesh.add({-9, -9, z}, {9, -9, z}, {0, 9, z});
  }
  return mesh;
}

TEST(Filter, ClearTrianglesAreNotThere) {
  std::vector<Surface> surfaces(10, Surface::kClear);
  surfaces[7] = Surface::kOpaque;
  const Caster caster = screens(10).caster(surfaces);
  EXPECT_EQ(caster.closest({{0, 0, 0}, {0, 0, 1}}).triangle, 7u);
  EXPECT_FALSE(caster.occluded({{0, 0, 0}, {0, 0, 1}, 0, 7.5f}));
  surfaces[7] = Surface::kClear;
  EXPECT_FALSE(screens(10).caster(surfaces).closest({{0, 0, 0}, {0, 0, 1}}).found());
}

TEST(Filter, FilteredTrianglesAskOnceAndStopWithoutAFilter) {
  std::vector<Surface> surfaces(30, Surface::kFiltered);
  surfaces[20] = Surface::kOpaque;
  const Caster caster = screens(30).caster(surfaces);
  const Ray ray{{0, 0, 0}, {0, 0, 1}};
  EXPECT_EQ(caster.closest(ray).triangle, 0u);
  EXPECT_TRUE(caster.occluded({{0, 0, 0}, {0, 0, 1}, 0, 5}));

  Recorder none({});
  EXPECT_EQ(caster.closest(ray, kNoTriangle, &none).triangle, 20u);
  for (const auto& [triangle, times] : none.asked) {
    EXPECT_EQ(times, 1) << triangle;
    EXPECT_NE(triangle, 20u);
  }
  Recorder some({12});
  EXPECT_EQ(caster.closest(ray, kNoTriangle, &some).triangle, 12u);
  EXPECT_EQ(caster.closest(ray, 12, &some).triangle, 20u);

  Recorder shadow({});
  EXPECT_FALSE(
      caster.occluded({{0, 0, 0}, {0, 0, 1}, 0, 20.5f}, kNoTriangle, kNoTriangle, &shadow));
  EXPECT_EQ(shadow.asked.size(), 20u);
  for (const auto& [triangle, times] : shadow.asked) EXPECT_EQ(times, 1) << triangle;
  EXPECT_TRUE(caster.occluded(ray, kNoTriangle, kNoTriangle, &shadow));
}

}  // namespace
}  // namespace lightbatch::rays
