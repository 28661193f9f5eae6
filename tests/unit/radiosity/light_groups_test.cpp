#include "core/radiosity/light_groups.h"

#include <gtest/gtest.h>

namespace lightbatch::radiosity {
namespace {

LightGroup lamp(std::uint32_t index) {
  return {LightGroup::Kind::kPunctual, index, "lamp " + std::to_string(index), {1, 1, 1}};
}

TEST(Grouping, SourcesOfOneDefinitionAreOneGroup) {
  Grouping grouping;
  EXPECT_EQ(grouping.add(lamp(4), 1), 0u);
  EXPECT_EQ(grouping.add({LightGroup::Kind::kEmitter, 4, "glow", {2, 2, 2}}, 1), 1u);
  EXPECT_EQ(grouping.add(lamp(4), 1), 0u);
  const auto [groups, renumber] = grouping.finish();
  ASSERT_EQ(groups.size(), 2u);
  EXPECT_EQ(groups[1].name, "glow");
  EXPECT_EQ(renumber, (std::vector<std::uint32_t>{0, 1}));
}

TEST(Grouping, BeyondTheLimitTheWeakestShareOne) {
  Grouping grouping;
  constexpr std::uint32_t kLamps = 100;
  // The strongest come last, and one lamp is strong by number.
  for (std::uint32_t i = 0; i < kLamps; ++i) grouping.add(lamp(i), 1 + i);
  for (int i = 0; i < 1000; ++i) grouping.add(lamp(0), 1);
  const auto [groups, renumber] = grouping.finish();
  ASSERT_EQ(groups.size(), kMostGroups - 1);
  EXPECT_EQ(groups[0].index, 0u);
  EXPECT_EQ(groups[1].index, kLamps - 1);
  EXPECT_EQ(groups.back().kind, LightGroup::Kind::kOthers);
  EXPECT_EQ(renumber[0], 0u);
  EXPECT_EQ(renumber[1], kMostGroups - 2);
  EXPECT_EQ(renumber[kLamps - 1], 1u);
}

}  // namespace
}  // namespace lightbatch::radiosity
