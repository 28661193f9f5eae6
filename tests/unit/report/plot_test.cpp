#include "core/report/plot.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "core/report/ticks.h"
#include "tests/unit/report/sample_report.h"

namespace lightbatch::report {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInf = std::numeric_limits<double>::infinity();

std::vector<std::string> names(const Scale& scale) {
  std::vector<std::string> out;
  for (const double tick : scale.ticks()) out.push_back(scale.name(tick));
  return out;
}

TEST(Scale, LinearTicksAreRoundAndCoverTheValues) {
  const Scale scale({"", Unit::kNumber, false, true}, {3, 17.2}, 5);
  EXPECT_EQ(names(scale), (std::vector<std::string>{"0", "5", "10", "15", "20"}));
  EXPECT_EQ(scale.place(0), 0);
  EXPECT_EQ(scale.place(20), 1);
  EXPECT_DOUBLE_EQ(scale.place(5), 0.25);
}

TEST(Scale, LogarithmicTicksAreOneTwoFive) {
  const Scale scale({"", Unit::kPercent, true, false}, {0.005, 0.1}, 6);
  EXPECT_EQ(names(scale), (std::vector<std::string>{"0.5 %", "1 %", "2 %", "5 %", "10 %"}));
  EXPECT_NEAR(scale.place(0.005), 0, 1e-12);
  EXPECT_NEAR(scale.place(0.1), 1, 1e-12);
  EXPECT_NEAR(scale.place(std::sqrt(0.005 * 0.1)), 0.5, 1e-12);
}

TEST(Scale, ManyDecadesShowSomePowersOfTen) {
  for (const double most : {1e3, 1e6, 1e12, 1e60}) {
    const Scale scale({"", Unit::kNumber, true, false}, {1e-3, most}, 6);
    EXPECT_GE(scale.ticks().size(), 3u) << most;
    EXPECT_LE(scale.ticks().size(), 20u) << most;
  }
}

TEST(Scale, AnyValuesGiveAUsableScale) {
  const std::vector<std::vector<double>> sets = {
      {}, {0}, {5}, {-3}, {7, 7, 7}, {kNan, kInf}, {1e-300, 1e300}, {1, 1 + 1e-15}, {-1e50, 1e50}};
  for (const bool logarithmic : {false, true}) {
    for (const bool from_zero : {false, true}) {
      for (const auto& values : sets) {
        const Scale scale({"", Unit::kNumber, logarithmic, from_zero}, values, 5);
        EXPECT_GE(scale.ticks().size(), 2u);
        EXPECT_LE(scale.ticks().size(), 100u);
        for (const double value : values) {
          if (!scale.shows(value)) continue;
          EXPECT_GE(scale.place(value), -1e-9);
          EXPECT_LE(scale.place(value), 1 + 1e-9);
        }
      }
    }
  }
}

TEST(Plot, DrawsWellFormedSvgWithoutNumbersThatAreNone) {
  Plot plot;
  plot.title = "<title> & \"quotes\"";
  plot.x = {"x <", Unit::kSeconds, true, false};
  plot.y = {"y", Unit::kPercent, true, false};
  plot.series = {{"a & b", {{1, 0.1, 0.05, 0.2}, {10, 0.01}, {kNan, 1}, {1, kInf}, {-1, 1}}},
                 {"none", {}},
                 {"dashed", {{2, 0.2}}, true, true}};
  plot.marks = {{"target <2>", 0.02, false}, {"", 3, true}, {"", -1, false}};
  const std::string svg = plot_svg(plot);
  EXPECT_EQ(tag_fault(svg), "");
  EXPECT_EQ(tag_fault(standalone_svg(svg)), "");
  EXPECT_EQ(svg.find("nan"), std::string::npos);
  EXPECT_EQ(svg.find("inf"), std::string::npos);
  EXPECT_NE(svg.find("a &amp; b"), std::string::npos);
  // Three points can be shown.
  std::size_t dots = 0;
  for (std::size_t at = svg.find("<circle"); at != std::string::npos;
       at = svg.find("<circle", at + 1)) {
    ++dots;
  }
  EXPECT_EQ(dots, 3u);
}

TEST(Plot, SaysWhenThereIsNothing) {
  EXPECT_NE(plot_svg(Plot()).find("no data"), std::string::npos);
}

TEST(Bars, LengthsAreInProportion) {
  const std::string svg = bars_svg("t", {{"a", 1, "1"}, {"b", 4, "4"}, {"c", kNan, "-"}});
  EXPECT_EQ(tag_fault(svg), "");
  std::vector<double> widths;
  for (std::size_t at = svg.find("class=\"fill c0\""); at != std::string::npos;
       at = svg.find("class=\"fill c0\"", at + 1)) {
    const std::size_t width = svg.find("width=\"", at) + 7;
    widths.push_back(std::stod(svg.substr(width)));
  }
  ASSERT_EQ(widths.size(), 3u);
  EXPECT_NEAR(widths[1], 4 * widths[0], 0.05);
  EXPECT_EQ(tag_fault(bars_svg("none", {})), "");
}

TEST(Gauge, StaysInsideItsPicture) {
  for (const double value : {0.0, 0.02, 5.0}) {
    for (const double target : {0.0, 0.01, 1.0}) {
      EXPECT_EQ(tag_fault(gauge_svg({value, 0.9 * value, 1.1 * value, target})), "");
    }
  }
}

}  // namespace
}  // namespace lightbatch::report
