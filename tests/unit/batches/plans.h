#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <tuple>
#include <vector>

#include "core/batches/plan.h"
#include "tests/unit/batches/scenes.h"

namespace lightbatch::batches::testing {

inline BatchPlan plan_of(const scene::Scene& scene, const BatchOptions& options = {},
                         const Profile& profile = {}) {
  auto result = plan(scene, hierarchy_of(scene), Viewpoints(scene, profile), options);
  EXPECT_TRUE(result.ok()) << result.status().to_string();
  return std::move(result).value();
}

/// Every triangle of an object is in one batch, a cell or left alone, and boxes are tight.
inline void expect_complete(const scene::Scene& scene, const BatchPlan& plan) {
  std::vector<int> times(scene.triangles.size(), 0);
  for (const Batch& batch : plan.batches) {
    Aabb all;
    std::set<std::tuple<std::uint32_t, std::uint32_t, std::uint32_t, std::uint32_t>> keys;
    for (const Group& group : batch.groups) {
      const bool blended = scene.materials[group.material].alpha_mode == scene::AlphaMode::kBlend;
      EXPECT_TRUE(!blended || group.pieces.size() == 1);
      const std::uint32_t object = blended ? group.pieces.front().object : scene::kNone;
      EXPECT_TRUE(keys.insert({group.material, group.layout, group.page, object}).second);
      Aabb box;
      std::uint64_t triangles = 0;
      for (const Piece& piece : group.pieces)
        for (const Range& range : piece.ranges)
          for (std::uint32_t t = range.first; t < range.first + range.count; ++t) {
            ++times[t];
            ++triangles;
            EXPECT_EQ(scene.triangles[t].object, piece.object);
            EXPECT_TRUE(group.coloured || scene.objects[piece.object].material == group.material);
            for (const Vec3f& p : scene.corners(t)) box.add(p);
          }
      EXPECT_EQ(triangles, group.triangles);
      EXPECT_EQ(box, group.box);
      all.add(box);
    }
    EXPECT_EQ(all, batch.box);
  }
  for (const InstanceCell& cell : plan.cells) {
    std::uint64_t triangles = 0;
    for (const std::uint32_t placed : cell.objects)
      for (const Piece& piece : plan.parts[cell.part].pieces)
        for (std::uint32_t o = 0; o < scene.objects.size(); ++o) {
          // The object of this placement that corresponds to the piece's.
          const scene::Object& object = scene.objects[o];
          const scene::Object& model = scene.objects[piece.object];
          if (object.node != scene.objects[placed].node || object.mesh != model.mesh ||
              object.instance != scene.objects[placed].instance ||
              object.primitive != model.primitive)
            continue;
          for (const Range& range : piece.ranges)
            for (std::uint32_t k = 0; k < range.count; ++k) {
              const std::uint32_t t =
                  object.first_triangle + range.first + k - model.first_triangle;
              ++times[t];
              ++triangles;
              for (const Vec3f& p : scene.corners(t)) {
                const Aabb corner{p, p};
                Aabb box = cell.box;
                box.add(corner);
                EXPECT_EQ(box, cell.box);
              }
            }
        }
    EXPECT_EQ(triangles, cell.triangles);
  }
  for (const LeftAlone& left : plan.left_alone) {
    EXPECT_FALSE(left.reason.empty());
    for (std::uint32_t k = 0; k < scene.objects[left.object].triangle_count; ++k)
      ++times[scene.objects[left.object].first_triangle + k];
  }
  EXPECT_EQ(std::count(times.begin(), times.end(), 1), static_cast<std::ptrdiff_t>(times.size()));
  std::set<std::uint32_t> in_tree;
  for (std::size_t i = 0; i < plan.tree.size(); ++i) {
    const TreeNode& node = plan.tree[i];
    if (node.batch != scene::kNone) {
      EXPECT_TRUE(in_tree.insert(node.batch).second);
    } else {
      EXPECT_GE(node.children.size(), 2u);
      for (const std::uint32_t child : node.children) EXPECT_GT(child, i);
    }
  }
  EXPECT_EQ(in_tree.size(), plan.batches.size());
}

}  // namespace lightbatch::batches::testing
