#include "core/radiosity/elements.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/base/random.h"
#include "core/radiosity/element_lookup.h"
#include "tests/unit/accuracy/scene_kit.h"

namespace lightbatch::radiosity {
namespace {

double area_of(const scene::Scene& scene, std::uint32_t t) {
  const auto c = scene.corners(t);
  return 0.5 * length(cross(to_double(c[1] - c[0]), to_double(c[2] - c[0])));
}

struct Cut {
  hierarchy::Hierarchy tree;
  std::unique_ptr<optics::Optics> optics;
  std::unique_ptr<Elements> elements;

  Cut(const scene::Scene& scene, double edge) {
    std::vector<Aabb> boxes(scene.triangles.size());
    for (std::uint32_t i = 0; i < boxes.size(); ++i) {
      for (const Vec3f& p : scene.corners(i)) boxes[i].add(p);
    }
    tree = hierarchy::build(boxes);
    optics = std::make_unique<optics::Optics>(scene);
    elements = std::make_unique<Elements>(scene, tree, *optics, ElementOptions{edge, 1'000'000});
  }
};

scene::Scene room() {
  accuracy::SceneKit kit;
  const auto grey = kit.material({0.5f, 0.4f, 0.3f});
  const auto leaf = kit.material({0.2f, 0.6f, 0.1f}, {}, true);
  kit.quad({{{0, 0, 0}, {0, 0, 3}, {4, 0, 3}, {4, 0, 0}}}, grey);
  kit.quad({{{1, 1, 1}, {1.05f, 1, 1}, {1.05f, 1.05f, 1}, {1, 1.05f, 1}}}, leaf);
  kit.quad({{{0, 0, 0}, {4, 0, 0}, {4, 0.001f, 0}, {0, 0.001f, 0}}}, grey);
  return kit.scene();
}

TEST(Elements, AreasSumToTheSurfaceOnBothSides) {
  const scene::Scene scene = room();
  for (const double edge : {10.0, 1.0, 0.2, 0.03}) {
    const Cut cut(scene, edge);
    double want = 0, got = 0;
    for (std::uint32_t i = 0; i < scene.triangles.size(); ++i) {
      want += area_of(scene, i) * (cut.optics->double_sided(i) ? 2 : 1);
    }
    for (ElementId e = 0; e < cut.elements->count(); ++e) {
      got += static_cast<double>(cut.elements->area(e));
    }
    // Areas are stored as floats: one rounding each.
    EXPECT_NEAR(got, want, 1e-6 * want) << "edge " << edge;
  }
}

// A closed box of 8 cm in another: of either the sides that face one way would be one element.
TEST(Elements, ShellsOfASolidAreApart) {
  accuracy::SceneKit kit;
  const auto grey = kit.material({0.5f, 0.5f, 0.5f});
  kit.box({0, 0, 0}, {0.08f, 0.08f, 0.08f}, grey);
  const std::uint32_t outer =
      kit.box({-0.001f, -0.001f, -0.001f}, {0.081f, 0.081f, 0.081f}, grey, false);
  kit.finish();
  const auto cut = [&](const rays::Caster* caster) {
    return Elements(kit.scene(), kit.tree(), kit.optics(), ElementOptions{0.3, 1000}, caster);
  };
  const auto shares = [&](const Elements& elements) {
    int shared = 0;
    for (std::uint32_t inside = 0; inside < outer; ++inside) {
      for (std::uint32_t outside = outer; outside < 2 * outer; ++outside) {
        shared += elements.at(inside, 0.3f, 0.3f, false) == elements.at(outside, 0.3f, 0.3f, false);
      }
    }
    return shared;
  };
  EXPECT_GT(shares(cut(nullptr)), 0);
  EXPECT_EQ(shares(cut(&kit.caster())), 0);
}

// The end of a slot of 2 cm by 1 m, closed all around, faces the same way as a tag outside: along
// its normal nothing is near either.
TEST(Elements, TheEndOfASlotIsApartFromWhatLiesOpen) {
  accuracy::SceneKit kit;
  const auto grey = kit.material({0.5f, 0.5f, 0.5f});
  const std::uint32_t slot = kit.box({0, 0, 0}, {1, 0.02f, 0.2f}, grey);
  const std::uint32_t tag =
      kit.quad({{{0, 0.03f, 0}, {0, 0.05f, 0}, {0, 0.05f, 0.1f}, {0, 0.03f, 0.1f}}}, grey);
  kit.finish();
  const auto cut = [&](const rays::Caster* caster) {
    return Elements(kit.scene(), kit.tree(), kit.optics(), ElementOptions{0.3, 1000}, caster);
  };
  const auto shares = [&](const Elements& elements) {
    int shared = 0;
    for (std::uint32_t inside = slot; inside < tag; ++inside) {
      for (const std::uint32_t outside : {tag, tag + 1}) {
        shared += elements.at(inside, 0.3f, 0.3f, false) == elements.at(outside, 0.3f, 0.3f, false);
      }
    }
    return shared;
  };
  EXPECT_GT(shares(cut(nullptr)), 0);
  EXPECT_EQ(shares(cut(&kit.caster())), 0);
}

TEST(Elements, PointsBelongToTheirElement) {
  const scene::Scene scene = room();
  const Cut cut(scene, 0.17);
  Random random(7);
  std::uint32_t elsewhere = 0, all = 0;
  for (ElementId e = 0; e < cut.elements->count(); ++e) {
    for (int k = 0; k < 8; ++k) {
      const ElementPoint p = cut.elements->point(e, random.next_float(), random.next_float());
      EXPECT_GE(p.u, -1e-6f);
      EXPECT_GE(p.v, -1e-6f);
      EXPECT_LE(p.u + p.v, 1 + 1e-5f);
      ++all;
      if (cut.elements->at(p.triangle, p.u, p.v, cut.elements->is_back(e)) != e) ++elsewhere;
    }
  }
  // A point may round into the neighbouring cell at a shared edge.
  EXPECT_LE(elsewhere, all / 500);
}

// Wherever a wall stands on a floor: cells that the third edge of their triangle cuts, too.
TEST(Elements, CellsUnderAWallAreSplit) {
  int split = 0, cut_off = 0;
  for (const float at : {0.13f, 0.31f, 0.42f, 0.57f, 0.71f, 0.9f}) {
    accuracy::SceneKit kit;
    const auto grey = kit.material({0.5f, 0.5f, 0.5f});
    const auto sheet = kit.material({0.5f, 0.5f, 0.5f}, {}, true);
    kit.quad({{{0, 0, 0}, {0, 0, 1}, {1, 0, 1}, {1, 0, 0}}}, grey);
    kit.quad({{{at, 0, -1}, {at, 1, -1}, {at, 1, 2}, {at, 0, 2}}}, sheet);
    kit.finish();
    const Cut cut(kit.scene(), 0.25);
    const ElementLookup lookup(kit.scene(), kit.caster(), *cut.elements, 1e-5f);
    for (ElementId e = 0; e < cut.elements->count(); ++e) {
      if (!cut.elements->is_cell(e)) continue;
      const Elements::Outline outline = cut.elements->outline(e);
      float least = 1, most = 0;
      for (std::size_t k = 0; k < outline.count; ++k) {
        const ElementPoint& p = outline.corner[k];
        EXPECT_EQ(cut.elements->at(p.triangle, p.u, p.v, cut.elements->is_back(e)), e);
        if (p.triangle >= 2) continue;
        const auto c = kit.scene().corners(p.triangle);
        const float x = c[0].x * (1 - p.u - p.v) + c[1].x * p.u + c[2].x * p.v;
        least = std::min(least, x);
        most = std::max(most, x);
      }
      if (outline.corner[0].triangle >= 2) continue;
      EXPECT_EQ(lookup.is_split(e), least < at && at < most) << at << " " << least << " " << most;
      split += lookup.is_split(e) ? 1 : 0;
      cut_off += lookup.is_split(e) && outline.count != 4 ? 1 : 0;
    }
  }
  EXPECT_GE(split, 24);
  EXPECT_GE(cut_off, 6);
}

TEST(Elements, BacksOfOneSidedFacesAreNoElement) {
  const scene::Scene scene = room();
  const Cut cut(scene, 0.5);
  EXPECT_EQ(cut.elements->at(0, 0.3f, 0.3f, true), kNoElement);
  EXPECT_NE(cut.elements->at(0, 0.3f, 0.3f, false), kNoElement);
  EXPECT_NE(cut.elements->at(2, 0.3f, 0.3f, true), kNoElement);
  EXPECT_NE(cut.elements->at(2, 0.3f, 0.3f, true), cut.elements->at(2, 0.3f, 0.3f, false));
}

TEST(Elements, SliversAreCutAlongTheirLengthOnly) {
  accuracy::SceneKit kit;
  const auto grey = kit.material({0.5f, 0.5f, 0.5f});
  kit.quad({{{0, 0, 0}, {10, 0, 0}, {10, 1e-5f, 0}, {0, 1e-5f, 0}}}, grey);
  const scene::Scene scene = kit.scene();
  const Cut cut(scene, 0.1);
  EXPECT_LE(cut.elements->count(), 2u * 101u);
}

TEST(Elements, TheLimitHolds) {
  const scene::Scene scene = room();
  std::vector<Aabb> boxes(scene.triangles.size());
  for (std::uint32_t i = 0; i < boxes.size(); ++i) {
    for (const Vec3f& p : scene.corners(i)) boxes[i].add(p);
  }
  const auto tree = hierarchy::build(boxes);
  const optics::Optics optics(scene);
  const Elements elements(scene, tree, optics, {1e-3, 5000});
  EXPECT_LE(elements.count(), 5000u);
  EXPECT_GT(elements.edge(), 1e-3);
}

/// As cells and as groups: clear glass and what is wholly cut away have no covered area, half-clear
/// sheets half of theirs.
TEST(Elements, WhatIsNotThereIsNotCovered) {
  scene::Material wall, glass, gone, faint, veil;
  for (scene::Material* m : {&wall, &glass, &gone, &faint, &veil}) m->metallic = 0;
  glass.transmission = 1;
  gone.alpha_mode = scene::AlphaMode::kMask;
  gone.alpha = 0.25f;
  faint.alpha_mode = scene::AlphaMode::kBlend;
  faint.alpha = 0;
  veil.alpha_mode = scene::AlphaMode::kBlend;
  veil.alpha = 0.5f;
  for (const double edge : {0.3, 5.0}) {
    for (const auto& [material, share] :
         {std::pair{wall, 1.0}, {glass, 0.0}, {gone, 0.0}, {faint, 0.0}, {veil, 0.5}}) {
      accuracy::SceneKit kit;
      kit.quad({{{0, 0, 0}, {1, 0, 0}, {1, 0, 1}, {0, 0, 1}}}, kit.material(material));
      const scene::Scene scene = kit.scene();
      const Cut cut(scene, edge);
      double area = 0, covered = 0;
      for (ElementId e = 0; e < cut.elements->count(); ++e) {
        area += static_cast<double>(cut.elements->area(e));
        covered += static_cast<double>(cut.elements->covered_area(e));
      }
      EXPECT_NEAR(area, 1, 1e-5);
      EXPECT_NEAR(covered, share, 1e-5) << edge;
    }
  }
}

}  // namespace
}  // namespace lightbatch::radiosity
