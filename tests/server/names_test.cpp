#include "server/names.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <limits>

namespace lightbatch::server {
namespace {

TEST(Names, PathsInsideTheSceneAreTaken) {
  for (const char* path :
       {"a.glb", "textures/wall 1.png", "a/b/c.bin", "\xc3\xa4.png", "...", "a..b"}) {
    EXPECT_TRUE(check_path(path).ok()) << path;
  }
}

TEST(Names, PathsThatCouldEscapeAreRefused) {
  for (const std::string& path :
       {std::string(), std::string("/etc/passwd"), std::string("../a"), std::string("a/../b"),
        std::string("a//b"), std::string("./a"), std::string("a/"), std::string("a\\b"),
        std::string("a\nb"), std::string("a\0b", 3), std::string("\xc0\xaf"),
        std::string("\xed\xa0\x80"), std::string("\xff"), std::string(1025, 'a')}) {
    EXPECT_EQ(check_path(path).reason(), "BAD_PATH") << path;
  }
}

TEST(Names, DigestsAreLowerCaseHex) {
  v1::Digest digest;
  digest.set_sha256(std::string(64, 'a'));
  EXPECT_TRUE(check_digest(digest, "digest").ok());
  digest.set_size_bytes(-1);
  EXPECT_EQ(check_digest(digest, "digest").reason(), "BAD_DIGEST");
  digest.set_size_bytes(0);
  for (const std::string& hex : {std::string(63, 'a'), std::string(65, 'a'), std::string(64, 'A'),
                                 std::string(64, '/'), std::string()}) {
    digest.set_sha256(hex);
    EXPECT_EQ(check_digest(digest, "digest").reason(), "BAD_DIGEST") << hex;
  }
}

TEST(Names, PageTokensAreBoundToTheirFilter) {
  const std::string token = make_page_token(42, 3);
  EXPECT_EQ(*parse_page_token(token, 3), 42);
  EXPECT_EQ(*parse_page_token("", 3), std::numeric_limits<std::int64_t>::max());
  EXPECT_EQ(parse_page_token(token, 4).status().reason(), "BAD_PAGE_TOKEN");
  EXPECT_EQ(parse_page_token("43" + token.substr(2), 3).status().reason(), "BAD_PAGE_TOKEN");
  for (std::size_t cut = 1; cut < token.size(); ++cut) {
    EXPECT_FALSE(parse_page_token(token.substr(0, cut), 3).ok());
  }
}

TEST(Names, NamesHaveTheirPrefix) {
  EXPECT_EQ(*parse_name("jobs/0a-1", "jobs/"), "0a-1");
  for (const char* name : {"", "jobs/", "scenes/a", "jobs/A", "jobs/a/b", "jobs/../a"}) {
    EXPECT_FALSE(parse_name(name, "jobs/").ok()) << name;
  }
}

}  // namespace
}  // namespace lightbatch::server
