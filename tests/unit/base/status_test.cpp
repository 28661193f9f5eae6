#include "core/base/status.h"

#include <gtest/gtest.h>

#include <memory>
#include <string>

namespace lightbatch {
namespace {

TEST(Status, DefaultIsOk) {
  const Status status;
  EXPECT_TRUE(status.ok());
  EXPECT_EQ(status.to_string(), "OK");
}

TEST(Status, SaysWhatWhereAndWhy) {
  const Status status = malformed("scene.gltf#/accessors/3/count", "count is negative");
  EXPECT_FALSE(status.ok());
  EXPECT_EQ(status.code(), StatusCode::kInvalidArgument);
  EXPECT_EQ(status.reason(), "INPUT_MALFORMED");
  EXPECT_EQ(status.place(), "scene.gltf#/accessors/3/count");
  EXPECT_EQ(status.to_string(),
            "count is negative (at scene.gltf#/accessors/3/count) [INPUT_MALFORMED]");
}

TEST(Status, MakersGiveStableReasons) {
  EXPECT_EQ(over_budget("p", "m").reason(), "INPUT_OVER_BUDGET");
  EXPECT_EQ(over_budget("p", "m").code(), StatusCode::kResourceExhausted);
  EXPECT_EQ(unsupported("p", "m").reason(), "INPUT_UNSUPPORTED");
  EXPECT_EQ(bad_option("m").reason(), "BAD_OPTION");
  EXPECT_EQ(cancelled().code(), StatusCode::kCancelled);
  EXPECT_EQ(io_error("p", "m").reason(), "IO_ERROR");
  EXPECT_EQ(bad_option("m").to_string(), "m [BAD_OPTION]");
}

Result<int> half_of(int value) {
  if (value % 2 != 0) return bad_option("odd");
  return value / 2;
}

Result<int> quarter_of(int value) {
  LB_ASSIGN_OR_RETURN(const int half, half_of(value));
  LB_ASSIGN_OR_RETURN(const int quarter, half_of(half));
  return quarter;
}

Status check_quarter(int value) {
  LB_RETURN_IF_ERROR(quarter_of(value).status());
  return {};
}

TEST(Result, HoldsAValueOrTheReasonForNone) {
  ASSERT_TRUE(half_of(4).ok());
  EXPECT_EQ(*half_of(4), 2);
  EXPECT_TRUE(half_of(4).status().ok());
  EXPECT_FALSE(half_of(3).ok());
  EXPECT_EQ(half_of(3).status().message(), "odd");
}

TEST(Result, MacrosReturnTheFirstError) {
  EXPECT_EQ(*quarter_of(12), 3);
  EXPECT_FALSE(quarter_of(6).ok());
  EXPECT_TRUE(check_quarter(8).ok());
  EXPECT_EQ(check_quarter(5).reason(), "BAD_OPTION");
}

TEST(Result, CarriesTypesThatOnlyMove) {
  Result<std::unique_ptr<int>> made = std::make_unique<int>(7);
  ASSERT_TRUE(made.ok());
  const std::unique_ptr<int> taken = std::move(made).value();
  EXPECT_EQ(*taken, 7);
}

TEST(ResultDeathTest, ValueOfAnErrorAborts) {
  EXPECT_DEATH(static_cast<void>(*half_of(3)), "odd");
  EXPECT_DEATH(Result<int>{Status()}, "a value or an error");
}

}  // namespace
}  // namespace lightbatch
