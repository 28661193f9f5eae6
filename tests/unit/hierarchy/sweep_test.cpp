#include "core/hierarchy/sweep.h"

#include <gtest/gtest.h>

#include <cstring>
#include <string>
#include <vector>

#include "core/base/parallel.h"
#include "tests/unit/hierarchy/box_sets.h"
#include "tests/unit/hierarchy/sweep_reference.h"

namespace lightbatch::hierarchy {
namespace {

/// -1: equal; otherwise the first place that differs.
std::ptrdiff_t first_difference(const TreeArrays& a, const TreeArrays& b) {
  for (std::size_t i = 0; i < a.nodes.size(); ++i) {
    if (std::memcmp(&a.nodes[i], &b.nodes[i], sizeof(TreeNode)) != 0) {
      return static_cast<std::ptrdiff_t>(i);
    }
  }
  return a.primitives == b.primitives ? -1 : static_cast<std::ptrdiff_t>(a.nodes.size());
}

std::vector<SweepFunction> functions() {
  std::vector<SweepFunction> list{sweep_baseline};
#if defined(__x86_64__)
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("bmi")) list.push_back(sweep_avx2);
  if (sweep_avx512_runs()) list.push_back(sweep_avx512);
#endif
  return list;
}

void expect_reference(std::span<const Aabb> boxes, const std::string& name) {
  const TreeArrays expected = sweep_reference(boxes);
  for (std::size_t f = 0; f < functions().size(); ++f) {
    EXPECT_EQ(first_difference(sweep(boxes, functions()[f]), expected), -1)
        << name << ", function " << f;
  }
}

TEST(Sweep, EqualsTheReferenceOnSmallSets) {
  for (std::size_t n = 1; n <= 200; ++n) {
    expect_reference(testing::random_boxes(n, 0.2f, n), "random " + std::to_string(n));
    for (const testing::BoxSet& set : testing::hostile_sets(n)) {
      expect_reference(set.boxes, set.name + " " + std::to_string(n));
    }
  }
}

TEST(Sweep, EqualsTheReferenceOnLargeSets) {
  const int before = thread_count();
  for (const int threads : {1, 2}) {
    set_thread_count(threads);
    for (const testing::BoxSet& set : testing::hostile_sets(40000)) {
      expect_reference(set.boxes, set.name);
    }
    expect_reference(testing::random_boxes(60000, 0.02f, 3), "random");
    expect_reference(testing::random_boxes(50000, 1.0f, 4), "overlapping");
    expect_reference(testing::grid_boxes(36), "grid");
    std::vector<Aabb> sheet = testing::random_boxes(50000, 0.02f, 5);
    for (Aabb& box : sheet) box.lower.y = box.upper.y = 0.5f;
    expect_reference(sheet, "flat sheet");
    // Thousands to a bin.
    std::vector<Aabb> crowd = testing::random_boxes(60000, 0.3f, 6);
    for (std::size_t i = 2; i < crowd.size(); ++i) {
      crowd[i] = {crowd[i].lower * 0.02f, crowd[i].upper * 0.02f};
    }
    expect_reference(crowd, "crowd and outliers");
  }
  set_thread_count(before);
}

}  // namespace
}  // namespace lightbatch::hierarchy
