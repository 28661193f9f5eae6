#include "core/gltf/json_text.h"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <limits>
#include <string>

#include "core/base/random.h"

namespace lightbatch::gltf {
namespace {

constexpr std::uint64_t kMemory = 1 << 20;

Result<Json> parse(std::string_view text, int depth = 64, std::uint64_t memory = kMemory) {
  return parse_json(text, "t.gltf", depth, memory);
}

TEST(JsonParse, KeepsValues) {
  const auto json = parse(R"( {"a": [1, -2, 3.5, true, null, "x\u00e9"], "b": {"c": {}}} )");
  ASSERT_TRUE(json.ok()) << json.status().to_string();
  EXPECT_EQ(json->dump(), R"({"a":[1,-2,3.5,true,null,"xé"],"b":{"c":{}}})");
}

TEST(JsonParse, RefusesWhatIsNotStrictJson) {
  for (const char* text :
       {"", " ", "{", "{}{}", "{} x", "{'a':1}", "{\"a\":1,}", "[1,]", "{\"a\":NaN}",
        "{\"a\":Infinity}", "{\"a\":1e999}", "{\"a\":01}", "{\"a\":\"\x01\"}", "{\"a\":\"\xff\"}",
        "{\"a\":1,\"a\":2}", "\xef\xbb\xbf{}", "// c\n{}", "{\"a\":\"\\u12\"}", "{\"a\" 1}"}) {
    const auto json = parse(text);
    ASSERT_FALSE(json.ok()) << text;
    EXPECT_EQ(json.status().reason(), "INPUT_MALFORMED") << text;
    EXPECT_TRUE(json.status().place().starts_with("t.gltf")) << json.status().place();
  }
}

TEST(JsonParse, NamesTheByteOfTheFault) {
  const auto json = parse_json("{\"a\": ?}", "s.glb", 64, kMemory, 20);
  ASSERT_FALSE(json.ok());
  EXPECT_EQ(json.status().place(), "s.glb@27");
  // What the builder refuses rather than the parser.
  EXPECT_EQ(parse(R"({"a": 1, "a": 2})").status().place(), "t.gltf@12");
  EXPECT_EQ(parse("[[[[]]]]", 3).status().place(), "t.gltf@4");
}

TEST(JsonParse, DepthIsLimited) {
  const auto nested = [](int depth) {
    return std::string(static_cast<std::size_t>(depth), '[') +
           std::string(static_cast<std::size_t>(depth), ']');
  };
  EXPECT_TRUE(parse(nested(64)).ok());
  EXPECT_EQ(parse(nested(65)).status().reason(), "INPUT_OVER_BUDGET");
  EXPECT_EQ(parse(std::string(2'000'000, '[')).status().reason(), "INPUT_OVER_BUDGET");
}

TEST(JsonParse, MemoryIsLimited) {
  std::string text = "[0";
  for (int i = 0; i < 100'000; ++i) text += ",0";
  text += "]";
  EXPECT_EQ(parse(text).status().reason(), "INPUT_OVER_BUDGET");
  EXPECT_TRUE(parse(text, 64, 1 << 24).ok());
}

TEST(JsonWrite, NumbersReadBackEqual) {
  Random random(7);
  Json json = Json::array();
  for (int i = 0; i < 20'000; ++i) {
    const double value = std::bit_cast<double>(random.next_u64());
    if (std::isfinite(value)) json.push_back(value);
    const float narrow = std::bit_cast<float>(random.next_u32());
    if (std::isfinite(narrow)) json.push_back(static_cast<double>(narrow));
  }
  for (const double value : {0.0, -0.0, 0.1, 1e22, 5e-324, 1.7976931348623157e308}) {
    json.push_back(value);
  }
  json.push_back(std::numeric_limits<std::int64_t>::min());
  json.push_back(std::numeric_limits<std::uint64_t>::max());
  const auto text = write_json(json);
  ASSERT_TRUE(text.ok());
  const auto back = parse(*text, 64, 1 << 26);
  ASSERT_TRUE(back.ok()) << back.status().to_string();
  ASSERT_EQ(back->size(), json.size());
  for (std::size_t i = 0; i < json.size(); ++i) {
    EXPECT_EQ((*back)[i].get<double>(), json[i].get<double>()) << i;
  }
}

TEST(JsonWrite, IsCompactSortedAndShort) {
  const auto text = write_json(Json{{"b", 0.1}, {"a", {1.0, "\"\n"}}, {"c", Json::object()}});
  ASSERT_TRUE(text.ok());
  EXPECT_EQ(*text, R"({"a":[1,"\"\n"],"b":0.1,"c":{}})");
}

TEST(JsonWrite, RefusesWhatHasNoJsonForm) {
  EXPECT_FALSE(write_json(Json(std::nan(""))).ok());
  EXPECT_FALSE(write_json(Json(std::string("\xff\xfe"))).ok());
}

}  // namespace
}  // namespace lightbatch::gltf
