#include "core/report/text.h"

#include <gtest/gtest.h>

#include <limits>

#include "core/base/bytes.h"

namespace lightbatch::report {
namespace {

TEST(Escape, MarkupBecomesText) {
  EXPECT_EQ(escape("<script src=\"x\">'&'"), "&lt;script src=&quot;x&quot;&gt;&#39;&amp;&#39;");
  EXPECT_EQ(escape("Küche, 部屋 🛋"), "Küche, 部屋 🛋");
}

TEST(Escape, WhatIsNotUtf8IsReplaced) {
  const std::string mark = "\xEF\xBF\xBD";
  EXPECT_EQ(escape("a\xFFz"), "a" + mark + "z");
  EXPECT_EQ(escape("\xC3"), mark);             // cut short
  EXPECT_EQ(escape("\xC0\xAF"), mark + mark);  // overlong '/'
  EXPECT_EQ(escape("\xE0\x80\xAF"), mark + mark + mark);
  EXPECT_EQ(escape("\xED\xA0\x80"), mark + mark + mark);  // half of a surrogate pair
  EXPECT_EQ(escape("\xF5\x80\x80\x80"), mark + mark + mark + mark);
  EXPECT_EQ(escape(std::string("\x01\x00\x1b", 3)), mark + mark + mark);
  EXPECT_EQ(escape("a\nb"), "a\nb");
}

// RFC 4648 section 10.
TEST(Base64, PublishedExamples) {
  EXPECT_EQ(base64(as_bytes("")), "");
  EXPECT_EQ(base64(as_bytes("f")), "Zg==");
  EXPECT_EQ(base64(as_bytes("fo")), "Zm8=");
  EXPECT_EQ(base64(as_bytes("foo")), "Zm9v");
  EXPECT_EQ(base64(as_bytes("foobar")), "Zm9vYmFy");
}

TEST(Numbers, ReadAsPeopleWriteThem) {
  EXPECT_EQ(significant(0.0173451), "0.01735");
  EXPECT_EQ(significant(12345.6), "12346");
  EXPECT_EQ(significant(2.50), "2.5");
  EXPECT_EQ(significant(-0.25), "-0.25");
  EXPECT_EQ(significant(0), "0");
  EXPECT_EQ(significant(1e-9), "1.000e-09");
  EXPECT_EQ(significant(std::numeric_limits<double>::quiet_NaN()), "-");
  EXPECT_EQ(count_text(1188348), "1,188,348");
  EXPECT_EQ(count_text(-1000), "-1,000");
  EXPECT_EQ(count_text(999), "999");
  EXPECT_EQ(count_text(0.5), "0.5");
  EXPECT_EQ(percent_text(0.0173), "1.73 %");
  EXPECT_EQ(seconds_text(0.42), "420 ms");
  EXPECT_EQ(seconds_text(8.69e-6), "8.69 µs");
  EXPECT_EQ(seconds_text(12.34), "12.3 s");
  EXPECT_EQ(seconds_text(192), "3 min 12 s");
  EXPECT_EQ(seconds_text(121.4), "2 min 01 s");
  EXPECT_EQ(seconds_text(7500), "2 h 05 min");
  EXPECT_EQ(bytes_text(1300000000), "1.21 GiB");
  EXPECT_EQ(bytes_text(12), "12 B");
}

TEST(Numbers, CoordinatesAreShortAndFinite) {
  EXPECT_EQ(coordinate(1.23456), "1.23");
  EXPECT_EQ(coordinate(-0.001), "0");
  EXPECT_EQ(coordinate(100), "100");
  EXPECT_EQ(coordinate(std::numeric_limits<double>::infinity()), "0");
  EXPECT_EQ(coordinate(1e300), "1000000000");
}

}  // namespace
}  // namespace lightbatch::report
