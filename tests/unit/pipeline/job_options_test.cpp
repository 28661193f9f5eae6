#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "core/optics/environment.h"
#include "core/pipeline/job.h"

namespace lightbatch::pipeline {
namespace {

TEST(JobOptions, NumbersAreBounded) {
  const auto reason = [](auto set) {
    JobOptions options;
    set(options);
    return validate(options).reason();
  };
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  for (const double bad : {-1.0, 3e37, 1e300, kInfinity, std::nan("")}) {
    EXPECT_EQ(reason([&](JobOptions& o) { o.sky_nits = bad; }), "BAD_OPTION") << bad;
    EXPECT_EQ(reason([&](JobOptions& o) { o.texels_per_metre = bad; }), "BAD_OPTION") << bad;
    EXPECT_EQ(reason([&](JobOptions& o) { o.max_growth = bad; }), "BAD_OPTION") << bad;
    EXPECT_EQ(reason([&](JobOptions& o) { o.target_error = bad; }), "BAD_OPTION") << bad;
  }
  EXPECT_EQ(reason([](JobOptions& o) { o.sky_nits = 1e30; }), "");
  EXPECT_EQ(reason([](JobOptions& o) { o.time_budget = 3600; }), "");
}

TEST(JobOptions, PixelsOfASkyAreBoundedAlike) {
  image::ImageRgb map(2, 1);
  map.pixels = {Rgb{3e38f, 1e30f, 1}, Rgb{}};
  const optics::Environment sky(map);
  EXPECT_LE(sky.mean().max(), optics::kMostRadiance);
  EXPECT_GT(sky.mean().r, 0.4 * optics::kMostRadiance);
}

}  // namespace
}  // namespace lightbatch::pipeline
