#include "core/gltf/uri.h"

#include <gtest/gtest.h>

#include <string>

namespace lightbatch::gltf {
namespace {

TEST(Uri, KindsAreToldApart) {
  EXPECT_EQ(*classify_uri("a/b.bin", "p"), UriKind::kRelative);
  EXPECT_EQ(*classify_uri("DATA:,x", "p"), UriKind::kData);
  for (const char* uri : {"http://h/x", "file:///etc/passwd", "C:\\x.bin", "/etc/passwd",
                          "//host/x", "\\\\host\\x", "x-y+z.1:rest"}) {
    EXPECT_EQ(*classify_uri(uri, "p"), UriKind::kAbsolute) << uri;
  }
  EXPECT_FALSE(classify_uri("", "p").ok());
  EXPECT_FALSE(classify_uri(":", "p").ok());
}

TEST(Uri, RelativeNamesAreNormalised) {
  EXPECT_EQ(*resolve_uri("a.bin", "", "p"), "a.bin");
  EXPECT_EQ(*resolve_uri("./x//y/../a%20b.bin", "", "p"), "x/a b.bin");
  EXPECT_EQ(*resolve_uri("../t/a.bin", "models", "p"), "t/a.bin");
  EXPECT_EQ(*resolve_uri("%C3%A9.bin", "", "p"), "\xc3\xa9.bin");
}

TEST(Uri, EscapesAreRefused) {
  for (const char* uri :
       {"../a.bin", "x/../../a.bin", "%2e%2e/a.bin", "..%2fa.bin", "../../../../etc/passwd"}) {
    EXPECT_EQ(resolve_uri(uri, "", "p").status().reason(), "SCENE_URI_FORBIDDEN") << uri;
  }
  EXPECT_EQ(resolve_uri("../../a.bin", "models", "p").status().reason(), "SCENE_URI_FORBIDDEN");
}

TEST(Uri, BrokenNamesAreRefused) {
  for (const char* uri : {"a%", "a%2", "a%zz", "a%00b", "a%0ab", "a\x01", ".", "./", "x/.."}) {
    EXPECT_EQ(resolve_uri(uri, "", "p").status().reason(), "INPUT_MALFORMED") << uri;
  }
}

std::string decoded(std::string_view uri) {
  const auto data = decode_data_uri(uri, "p");
  return data.ok() ? std::string(as_text(data->bytes)) : "refused";
}

TEST(DataUri, Base64VectorsOfRfc4648) {
  EXPECT_EQ(decoded("data:;base64,"), "");
  EXPECT_EQ(decoded("data:;base64,Zg=="), "f");
  EXPECT_EQ(decoded("data:;base64,Zm8="), "fo");
  EXPECT_EQ(decoded("data:;base64,Zm9v"), "foo");
  EXPECT_EQ(decoded("data:a/b;base64,Zm9vYg=="), "foob");
  EXPECT_EQ(decoded("data:a/b;x=y;base64,Zm9vYmE="), "fooba");
  EXPECT_EQ(decoded("data:A/B;base64,Zm9vYmFy"), "foobar");
  EXPECT_EQ(decode_data_uri("data:A/B;base64,Zm9v", "p")->media_type, "a/b");
}

TEST(DataUri, PlainText) { EXPECT_EQ(decoded("data:a/b,x%20y"), "x y"); }

TEST(DataUri, AnythingElseIsRefused) {
  for (const char* uri : {"data:", "data:x", "data:;base64,Zg=", "data:;base64,Zg",
                          "data:;base64,Z===", "data:;base64,Zm9v\n", "data:;base64,Zm 9v",
                          "data:;base64,Zm9-", "data:;base64,====", "data:;base64,Zg==Zg==",
                          "data:a/b;;base64,Zg==", "data:ab;base64,Zg==", "data:a/b,%4"}) {
    EXPECT_EQ(decoded(uri), "refused") << uri;
  }
}

}  // namespace
}  // namespace lightbatch::gltf
