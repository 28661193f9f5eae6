#include "core/batches/profile.h"

#include <gtest/gtest.h>

namespace lightbatch::batches {
namespace {

TEST(Profile, Presets) {
  for (const char* name : {"desktop", "webgl", "mobile"}) {
    const auto profile = preset_profile(name);
    ASSERT_TRUE(profile.ok());
    EXPECT_EQ(profile->name, name);
    EXPECT_GT(profile->draw, 100 * profile->triangle);
  }
  EXPECT_EQ(preset_profile("toaster").status().reason(), "BAD_OPTION");
}

TEST(Profile, JsonStartsFromItsBase) {
  const auto profile =
      read_profile(R"({"base": "mobile", "name": "mine", "draw": 3.5, "max_vertices": 1000})", "p");
  ASSERT_TRUE(profile.ok());
  EXPECT_EQ(profile->name, "mine");
  EXPECT_EQ(profile->draw, 3.5);
  EXPECT_EQ(profile->max_vertices, 1000u);
  EXPECT_EQ(profile->triangle, preset_profile("mobile")->triangle);
}

TEST(Profile, BadJsonSaysWhere) {
  for (const auto& [text, place] : {std::pair{"[]", "p"},
                                    {"{", "p"},
                                    {R"({"draw": "x"})", "p#/draw"},
                                    {R"({"draw": -1})", "p#/draw"},
                                    {R"({"drow": 1})", "p#/drow"},
                                    {R"({"max_vertices": 2})", "p#/max_vertices"},
                                    {R"({"max_vertices": 10.5})", "p#/max_vertices"},
                                    {R"({"triangle": 1e999})", "p"},
                                    {R"({"base": 3})", "p#/base"},
                                    {R"({"inside": 1.5})", "p#/inside"}}) {
    const auto profile = read_profile(text, "p");
    ASSERT_FALSE(profile.ok()) << text;
    EXPECT_EQ(profile.status().place(), place) << text;
  }
}

}  // namespace
}  // namespace lightbatch::batches
