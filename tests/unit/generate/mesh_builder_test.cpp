#include "core/generate/mesh_builder.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <map>
#include <numbers>

#include "core/generate/furniture.h"
#include "core/generate/materials.h"

namespace lightbatch::generate {
namespace {

using Key = std::array<long, 3>;

/// Positions to a hundredth of a millimetre: float noise of equal points disappears.
Key key_of(const Vec3f& p) {
  const auto rounded = [](float v) { return std::lround(static_cast<double>(v) * 1e5); };
  return {rounded(p.x), rounded(p.y), rounded(p.z)};
}

/// Directed edges that have no partner in the opposite direction: 0 for a closed surface.
int open_edges(const Surface& surface) {
  std::map<std::pair<Key, Key>, int> edges;
  for (std::size_t i = 0; i < surface.indices.size(); i += 3) {
    for (std::size_t k = 0; k < 3; ++k) {
      const Key a = key_of(surface.positions[surface.indices[i + k]]);
      const Key b = key_of(surface.positions[surface.indices[i + (k + 1) % 3]]);
      ++edges[{a, b}];
      --edges[{b, a}];
    }
  }
  int open = 0;
  for (const auto& [edge, balance] : edges) open += balance != 0 ? 1 : 0;
  return open;
}

/// Volume inside, by the divergence theorem: positive when the faces look outwards.
double volume(const Surface& surface) {
  double sum = 0;
  for (std::size_t i = 0; i < surface.indices.size(); i += 3) {
    const Vec3d a = to_double(surface.positions[surface.indices[i]]);
    const Vec3d b = to_double(surface.positions[surface.indices[i + 1]]);
    const Vec3d c = to_double(surface.positions[surface.indices[i + 2]]);
    sum += dot(a, cross(b, c)) / 6;
  }
  return sum;
}

/// Smallest cosine between a triangle's own normal and the normals at its corners.
double worst_normal(const Surface& surface) {
  double worst = 1;
  for (std::size_t i = 0; i < surface.indices.size(); i += 3) {
    const Vec3d a = to_double(surface.positions[surface.indices[i]]);
    const Vec3d b = to_double(surface.positions[surface.indices[i + 1]]);
    const Vec3d c = to_double(surface.positions[surface.indices[i + 2]]);
    const Vec3d face = normalized(cross(b - a, c - a));
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3d normal = to_double(surface.normals[surface.indices[i + k]]);
      EXPECT_NEAR(length(normal), 1, 1e-6);
      worst = std::min(worst, dot(face, normal));
    }
  }
  return worst;
}

TEST(MeshBuilder, BoxIsClosedWithTheVolumeOfItsEdges) {
  Surface surface;
  add_box(surface, {1, 2, 3}, {2, 4, 6});
  EXPECT_EQ(surface.triangles(), 12u);
  EXPECT_EQ(open_edges(surface), 0);
  EXPECT_NEAR(volume(surface), 6, 1e-5);
  EXPECT_NEAR(worst_normal(surface), 1, 1e-6);
}

TEST(MeshBuilder, RoundedBoxIsClosedAndLosesItsCorners) {
  for (const int steps : {1, 2, 5}) {
    Surface surface;
    add_rounded_box(surface, {0, 0, 0}, {2, 3, 4}, 0.25, steps);
    const auto facets = static_cast<std::uint64_t>(2 * steps + 1);
    EXPECT_EQ(surface.triangles(), 12 * facets * facets);
    EXPECT_EQ(open_edges(surface), 0) << steps;
    // Minkowski sum of the inner box 1.5 x 2.5 x 3.5 and a ball of radius 0.25; facets cut into it.
    const double r = 0.25, pi = std::numbers::pi, a = 1.5, b = 2.5, c = 3.5;
    const double exact = a * b * c + 2 * r * (a * b + b * c + c * a) + pi * r * r * (a + b + c) +
                         4.0 / 3 * pi * r * r * r;
    EXPECT_LT(volume(surface), exact);
    EXPECT_GT(volume(surface), exact * (steps == 1 ? 0.985 : 0.995));
    EXPECT_GT(worst_normal(surface), 0.5);
  }
}

TEST(MeshBuilder, CylinderTendsToItsVolume) {
  Surface surface;
  add_cylinder(surface, {5, 1, -2}, 0.5, 2, 64);
  EXPECT_EQ(surface.triangles(), 64u * 4);
  EXPECT_EQ(open_edges(surface), 0);
  const double exact = std::numbers::pi * 0.25 * 2;
  EXPECT_NEAR(volume(surface), exact, exact * 2e-3);  // 64 facets: 1 - sinc(2 pi / 64) = 0.16 %
  EXPECT_GT(worst_normal(surface), 0.99);
}

TEST(Furniture, PiecesAreClosedAndStandOnTheFloor) {
  for (int detail = 0; detail <= kMostDetail; ++detail) {
    const Model models[] = {make_desk(detail),
                            make_chair(detail),
                            make_shelf(detail),
                            make_monitor(detail),
                            make_keyboard(detail),
                            make_mug(detail),
                            make_bin(detail),
                            make_plant(detail, Random(3)),
                            make_books(kBooksInRow, Random(4))};
    for (const Model& model : models) {
      float lowest = 1;
      for (const Part& part : model.parts) {
        for (const Vec3f& p : part.surface.positions) lowest = std::min(lowest, p.y);
        EXPECT_GT(worst_normal(part.surface), 0.3) << model.name;
        // Open by design: the screen's glass, leaves and soil, the plant's pot, feet of the chair.
        const bool sheet =
            model.name == "monitor" || model.name == "plant" || model.name == "chair";
        if (!sheet) {
          EXPECT_EQ(open_edges(part.surface), 0) << model.name;
          EXPECT_GT(volume(part.surface), 0) << model.name;
        }
      }
      EXPECT_GT(lowest, 0) << model.name << ": touches what carries it";
      EXPECT_LT(lowest, 0.11f) << model.name;
    }
  }
}

TEST(Furniture, MoreDetailMeansMoreTriangles) {
  for (int detail = 0; detail < kMostDetail; ++detail) {
    EXPECT_LT(make_desk(detail).triangles(), make_desk(detail + 1).triangles());
    EXPECT_LT(make_chair(detail).triangles(), make_chair(detail + 1).triangles());
    EXPECT_LT(make_keyboard(detail).triangles(), make_keyboard(detail + 1).triangles());
  }
  for (int count = 1; count <= kBooksInRow; ++count) {
    EXPECT_EQ(make_books(count, Random(7)).triangles(), static_cast<std::uint64_t>(12 * count));
  }
}

}  // namespace
}  // namespace lightbatch::generate
