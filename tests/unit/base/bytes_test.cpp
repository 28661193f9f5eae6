#include "core/base/bytes.h"

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <string>

namespace lightbatch {
namespace {

namespace fs = std::filesystem;

class BytesTest : public testing::Test {
 protected:
  void SetUp() override {
    std::string pattern = (fs::temp_directory_path() / "lightbatch-bytes-XXXXXX").string();
    ASSERT_NE(::mkdtemp(pattern.data()), nullptr);
    folder_ = pattern;
  }
  void TearDown() override { fs::remove_all(folder_); }
  std::size_t files() const {
    return static_cast<std::size_t>(
        std::distance(fs::directory_iterator(folder_), fs::directory_iterator()));
  }

  fs::path folder_;
};

TEST_F(BytesTest, WritesAndReadsBack) {
  for (const std::size_t size : {0u, 1u, 4096u, 1'000'003u}) {
    Bytes bytes(size);
    for (std::size_t i = 0; i < size; ++i) bytes[i] = static_cast<std::byte>(i * 31 % 251);
    ASSERT_TRUE(write_file(folder_ / "file", bytes).ok());
    const Result<Bytes> back = read_file(folder_ / "file");
    ASSERT_TRUE(back.ok()) << back.status().to_string();
    EXPECT_EQ(*back, bytes);
  }
  EXPECT_EQ(files(), 1u) << "a temporary file was left";
}

TEST_F(BytesTest, ReplacesTheFileAndLeavesOpenReadersTheOldOne) {
  ASSERT_TRUE(write_file(folder_ / "file", as_bytes("old")).ok());
  struct stat before {};
  ASSERT_EQ(::stat((folder_ / "file").c_str(), &before), 0);
  ASSERT_TRUE(write_file(folder_ / "file", as_bytes("new")).ok());
  struct stat after {};
  ASSERT_EQ(::stat((folder_ / "file").c_str(), &after), 0);
  EXPECT_NE(before.st_ino, after.st_ino) << "written in place: a reader could see a part";
  EXPECT_EQ(as_text(*read_file(folder_ / "file")), "new");
}

TEST_F(BytesTest, FailureNamesThePathAndLeavesNothing) {
  const Status missing_folder = write_file(folder_ / "none" / "file", as_bytes("x"));
  EXPECT_EQ(missing_folder.reason(), "IO_ERROR");
  EXPECT_NE(missing_folder.place().find("none"), std::string::npos);

  fs::create_directory(folder_ / "taken");
  ASSERT_TRUE(write_file(folder_ / "taken" / "inside", as_bytes("x")).ok());
  EXPECT_EQ(write_file(folder_ / "taken", as_bytes("x")).reason(), "IO_ERROR");
  EXPECT_EQ(files(), 1u) << "a temporary file was left";
}

TEST_F(BytesTest, ReadsOnlyRegularFiles) {
  const Result<Bytes> missing = read_file(folder_ / "missing");
  ASSERT_FALSE(missing.ok());
  EXPECT_EQ(missing.status().reason(), "IO_ERROR");
  EXPECT_NE(missing.status().place().find("missing"), std::string::npos);
  EXPECT_FALSE(read_file(folder_).ok());
  EXPECT_FALSE(read_file("/dev/zero").ok());
}

}  // namespace
}  // namespace lightbatch
