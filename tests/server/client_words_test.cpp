#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "client/cli/exit_code.h"
#include "client/cli/job_request.h"
#include "client/cli/units.h"

namespace lightbatch::cli {
namespace {

TEST(Units, ErrorBounds) {
  EXPECT_DOUBLE_EQ(*parse_error_bound("2%"), 0.02);
  EXPECT_DOUBLE_EQ(*parse_error_bound("0.02"), 0.02);
  EXPECT_DOUBLE_EQ(*parse_error_bound("0.5%"), 0.005);
  EXPECT_DOUBLE_EQ(*parse_error_bound("100%"), 1);
  for (const char* word : {"", "%", "0", "0%", "-1%", "101%", "2 %", "two", "nan", "inf", "2%%"}) {
    EXPECT_FALSE(parse_error_bound(word)) << word;
  }
}

TEST(Units, Durations) {
  EXPECT_DOUBLE_EQ(*parse_duration("30s"), 30);
  EXPECT_DOUBLE_EQ(*parse_duration("2m"), 120);
  EXPECT_DOUBLE_EQ(*parse_duration("1.5h"), 5400);
  EXPECT_DOUBLE_EQ(*parse_duration("500ms"), 0.5);
  EXPECT_DOUBLE_EQ(*parse_duration("12"), 12);
  for (const char* word : {"", "s", "0s", "-1s", "2d", "1m30s"}) {
    EXPECT_FALSE(parse_duration(word)) << word;
  }
}

TEST(Units, WholeNumbers) {
  for (const char* word : {"0", "7", "18446744073709551615"}) EXPECT_TRUE(is_whole_number(word));
  for (const char* word : {"", "-1", "+1", "1.0", "1e3", "0x10", " 1", "18446744073709551616"}) {
    EXPECT_FALSE(is_whole_number(word)) << word;
  }
}

TEST(Units, ServerAddresses) {
  for (const char* word : {"localhost:7411", "[::1]:1", "10.0.0.1:65535", "unix:/run/lightbatch",
                           "dns:///host:7411", "dns:///host"}) {
    EXPECT_TRUE(is_server_address(word)) << word;
  }
  // gRPC takes a port modulo 65536.
  for (const char* word : {"", "localhost", ":7411", "localhost:", "localhost:0", "localhost:65536",
                           "localhost:-1", "localhost:74x"}) {
    EXPECT_FALSE(is_server_address(word)) << word;
  }
}

TEST(Units, TextForPeople) {
  EXPECT_EQ(format_seconds(3.21), "3.2 s");
  EXPECT_EQ(format_seconds(42), "42 s");
  EXPECT_EQ(format_seconds(200), "3 min 20 s");
  EXPECT_EQ(format_seconds(7500), "2 h 05 min");
  EXPECT_EQ(format_bytes(999), "999 B");
  EXPECT_EQ(format_bytes(1536 * 1024), "1.5 MiB");
}

TEST(Words, BecomeOptions) {
  JobWords words;
  words.target_error = "2%";
  words.sky = "5000";
  words.effects = "+sky,-shadows";
  words.carrier = "both";
  const auto made = make_request(v1::JOB_KIND_BAKE, words);
  ASSERT_TRUE(std::holds_alternative<JobRequest>(made));
  const v1::JobOptions& options = std::get<JobRequest>(made).options;
  EXPECT_DOUBLE_EQ(options.target_error(), 0.02);
  EXPECT_DOUBLE_EQ(options.sky_nits(), 5000);
  EXPECT_EQ(options.effects_size(), 2);
  EXPECT_EQ(options.carrier(), v1::CARRIER_BOTH);
  EXPECT_EQ(options.profile(), "desktop");
}

TEST(Words, ComplaintsNameTheOption) {
  const auto complaint = [](void (*change)(JobWords&)) {
    JobWords words;
    change(words);
    const auto made = make_request(v1::JOB_KIND_BAKE, words);
    const auto* text = std::get_if<std::string>(&made);
    return text == nullptr ? std::string() : *text;
  };
  EXPECT_NE(complaint([](JobWords& w) { w.target_error = "a lot"; }).find("--target-error"),
            std::string::npos);
  EXPECT_NE(complaint([](JobWords& w) { w.sky = "no_such.hdr"; }).find("no_such.hdr"),
            std::string::npos);
  EXPECT_NE(complaint([](JobWords& w) { w.effects = "sky"; }).find("--effects"), std::string::npos);
  EXPECT_NE(complaint([](JobWords& w) {
              w.target_error = "1%";
              w.time_budget = "3s";
            }).find("exclude"),
            std::string::npos);
  EXPECT_NE(complaint([](JobWords& w) { w.errors = "10%,,1%"; }).find("--errors"),
            std::string::npos);
}

TEST(ExitCodes, AreThePromisedOnes) {
  v1::Job job;
  job.set_state(v1::JOB_STATE_SUCCEEDED);
  job.set_verdict(v1::VERDICT_DONE);
  EXPECT_EQ(exit_code(job), 0);
  job.set_verdict(v1::VERDICT_MISSED_TARGET);
  EXPECT_EQ(exit_code(job), 4);
  job.set_state(v1::JOB_STATE_CANCELLED);
  EXPECT_EQ(exit_code(job), 6);
  job.set_state(v1::JOB_STATE_FAILED);
  const auto with = [&](const char* reason) {
    job.mutable_error()->mutable_detail()->set_reason(reason);
    return exit_code(job);
  };
  EXPECT_EQ(with("INPUT_MALFORMED"), 3);
  EXPECT_EQ(with("INPUT_UNSUPPORTED"), 3);
  EXPECT_EQ(with("INPUT_OVER_BUDGET"), 3);
  EXPECT_EQ(with("SCENE_URI_FORBIDDEN"), 3);
  EXPECT_EQ(with("BAD_OPTION"), 2);
  EXPECT_EQ(with("WORKER_CRASHED"), 70);
  client::Error error;
  error.unreachable = true;
  EXPECT_EQ(exit_code(error), 5);
}

class SceneFilesTest : public testing::Test {
 protected:
  SceneFilesTest() {
    std::string pattern = (std::filesystem::temp_directory_path() / "lightbatch-XXXXXX").string();
    folder_ = mkdtemp(pattern.data());
    std::filesystem::create_directories(folder_ / "scene" / "tex");
    std::ofstream(folder_ / "scene" / "a b.bin") << "x";
    std::ofstream(folder_ / "scene" / "tex" / "c.png") << "x";
    std::ofstream(folder_ / "secret") << "x";
  }
  ~SceneFilesTest() override { std::filesystem::remove_all(folder_); }
  std::vector<std::string> paths(const std::string& text) {
    const auto main = folder_ / "scene" / "main.gltf";
    std::ofstream(main) << text;
    const auto files = client::scene_files(main);
    std::vector<std::string> out;
    if (files.ok()) {
      for (const auto& [path, file] : *files) out.push_back(path);
    }
    return out;
  }
  std::filesystem::path folder_;
};

TEST_F(SceneFilesTest, TakesWhatLiesInTheFolder) {
  using Paths = std::vector<std::string>;
  EXPECT_EQ(paths(R"({"buffers":[{"uri":"a%20b.bin"}],"images":[{"uri":"./tex/c.png"}]})"),
            (Paths{"a b.bin", "main.gltf", "tex/c.png"}));
  EXPECT_EQ(paths(R"({"buffers":[{"uri":"../secret"},{"uri":"%2e%2e/secret"},{"uri":"/etc/passwd"},
                     {"uri":"data:,x"},{"uri":"http://h/x"},{"uri":"missing.bin"},{"uri":7}]})"),
            Paths{"main.gltf"});
  EXPECT_EQ(paths("not json"), Paths{"main.gltf"});
  EXPECT_EQ(paths(std::string(100'000, '[')), Paths{"main.gltf"});
}

TEST_F(SceneFilesTest, AnyFileNameCanBeTheMainFile) {
  EXPECT_EQ(client::manifest_name("a/\xc3\xbc \"<%41>.glb"), "\xc3\xbc \"<%41>.glb");
  EXPECT_EQ(client::manifest_name("a/\xfc.gltf"), "scene.gltf");
  EXPECT_EQ(client::manifest_name("back\\slash.glb"), "scene.glb");
  EXPECT_EQ(client::manifest_name("new\nline.glb"), "scene.glb");
  EXPECT_EQ(client::manifest_name("x.\xfc"), "scene");
  const auto main = folder_ / "\xfc.glb";
  std::ofstream(main) << "x";
  ASSERT_TRUE(client::scene_files(main).ok());
  EXPECT_EQ(client::scene_files(main)->begin()->first, "scene.glb");
  std::ofstream(folder_ / "scene" / "\xfc.bin") << "x";
  EXPECT_EQ(paths(R"({"buffers":[{"uri":"%FC.bin"}]})"), std::vector<std::string>{"main.gltf"});
  // Cut within a character.
  EXPECT_EQ(client::utf8_of(std::string("\xe6\x97\xa5\xe6\x9c")), "\xe6\x97\xa5");
}

TEST_F(SceneFilesTest, MissingMainIsAnError) {
  const auto files = client::scene_files(folder_ / "nothing.glb");
  ASSERT_FALSE(files.ok());
  EXPECT_EQ(files.error().reason, "IO_ERROR");
}

}  // namespace
}  // namespace lightbatch::cli
