#include "core/report/fields.h"

#include <gtest/gtest.h>

#include <limits>

namespace lightbatch::report {
namespace {

TEST(Fields, WalkObjectsAndNeverThrow) {
  const Json report = {{"a", {{"b", 2.5}, {"text", "x"}, {"none", nullptr}, {"list", {1, 2}}}},
                       {"number", 1}};
  EXPECT_EQ(number(report, "a/b"), 2.5);
  EXPECT_EQ(text(report, "a/text"), "x");
  EXPECT_EQ(list(report, "a/list").size(), 2u);
  EXPECT_EQ(object(report, "a").size(), 4u);
  for (const char* path :
       {"", "a", "a/none", "a/b/c", "number/x", "a/list/0", "missing", "/", "//"}) {
    EXPECT_FALSE(number(report, path)) << path;
    EXPECT_EQ(text(report, path), "") << path;
    EXPECT_FALSE(flag(report, path)) << path;
    EXPECT_TRUE(list(report, path).empty()) << path;
  }
  EXPECT_TRUE(object(report, "a/list").empty());
  EXPECT_FALSE(number(Json(), "a"));
  EXPECT_FALSE(number({{"x", std::numeric_limits<double>::quiet_NaN()}}, "x"));
}

TEST(Fields, ValuesReadByTheirKeys) {
  EXPECT_EQ(value_text("peak_bytes", 2048), "2 KiB");
  EXPECT_EQ(value_text("build_seconds", 0.5), "500 ms");
  EXPECT_EQ(value_text("cost_share", 0.25), "25 %");
  EXPECT_EQ(value_text("triangles", 12345), "12,345");
  EXPECT_EQ(value_text("on", true), "yes");
  EXPECT_EQ(value_text("levels", {13, 14}), "13, 14");
  EXPECT_EQ(value_text("levels", Json::array()), "none");
  EXPECT_EQ(value_text("dropped", {{"zero_area", 12}}), "zero area 12");
  EXPECT_EQ(value_text("sweep_errors", {0.1, 0.05}), "10 %, 5 %");
  EXPECT_NE(value_text("many", Json(std::vector<int>(1000, 1))).find("(1000)"), std::string::npos);
  EXPECT_EQ(value_text("x", nullptr), "-");
}

}  // namespace
}  // namespace lightbatch::report
