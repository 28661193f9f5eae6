#include <algorithm>
#include <cstdint>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string_view>

#include "lightbatch/client.h"

namespace lightbatch::client {
namespace {

using Json = nlohmann::json;

constexpr std::uint64_t kMaxJsonBytes = std::uint64_t{64} << 20;
constexpr std::uint32_t kGlbMagic = 0x46546c67;   // "glTF"
constexpr std::uint32_t kJsonChunk = 0x4e4f534a;  // "JSON"
constexpr int kCodeNotFound = 5;                  // gRPC's

/// Collects the strings under "uri" in the top-level arrays that may hold one. Sees every value
/// once and keeps nothing else, so that a hostile file costs no more than its size.
class UriScan : public nlohmann::json_sax<Json> {
 public:
  std::vector<std::string> uris;

  bool null() override { return true; }
  bool boolean(bool) override { return true; }
  bool number_integer(number_integer_t) override { return true; }
  bool number_unsigned(number_unsigned_t) override { return true; }
  bool number_float(number_float_t, const string_t&) override { return true; }
  bool string(string_t& value) override {
    if (is_uri_ && !value.starts_with("data:")) uris.push_back(value);
    is_uri_ = false;
    return true;
  }
  bool binary(binary_t&) override { return true; }
  bool start_object(std::size_t) override { return ++depth_ < kMaxDepth; }
  bool key(string_t& name) override {
    is_uri_ = name == "uri";
    return true;
  }
  bool end_object() override { return --depth_ >= 0; }
  bool start_array(std::size_t) override { return ++depth_ < kMaxDepth; }
  bool end_array() override { return --depth_ >= 0; }
  bool parse_error(std::size_t, const std::string&, const nlohmann::detail::exception&) override {
    return false;
  }

 private:
  static constexpr int kMaxDepth = 512;
  int depth_ = 0;
  bool is_uri_ = false;
};

std::uint32_t word(std::string_view bytes, std::size_t at) {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    value |= static_cast<std::uint32_t>(static_cast<unsigned char>(bytes[at + i])) << (8 * i);
  }
  return value;
}

/// The JSON text of a .gltf, or of a .glb's first chunk; empty when there is none.
std::string json_text(std::ifstream& file, std::uint64_t file_bytes) {
  std::string head(20, '\0');
  file.read(head.data(), 20);
  std::uint64_t begin = 0;
  std::uint64_t size = file_bytes;
  if (file.gcount() == 20 && word(head, 0) == kGlbMagic) {
    if (word(head, 16) != kJsonChunk) return {};
    begin = 20;
    size = std::min<std::uint64_t>(word(head, 12), file_bytes - begin);
  }
  if (size > kMaxJsonBytes) return {};
  std::string text(size, '\0');
  file.clear();
  file.seekg(static_cast<std::streamoff>(begin));
  file.read(text.data(), static_cast<std::streamsize>(size));
  text.resize(static_cast<std::size_t>(file.gcount()));
  return text;
}

int hex_digit(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  if (c >= 'A' && c <= 'F') return c - 'A' + 10;
  return -1;
}

bool is_manifest_text(const std::string& text) {
  if (text.size() > 1024 || utf8_of(text) != text) return false;
  return std::none_of(text.begin(), text.end(), [](char c) {
    return static_cast<unsigned char>(c) < 0x20 || c == '\\' || c == 0x7f;
  });
}

/// uri -> manifest path: percent-decoded, "./" taken out. Empty for what cannot lie in the
/// scene's folder.
std::string manifest_path(std::string_view uri) {
  std::string decoded;
  for (std::size_t i = 0; i < uri.size(); ++i) {
    if (uri[i] == '%' && i + 2 < uri.size() && hex_digit(uri[i + 1]) >= 0 &&
        hex_digit(uri[i + 2]) >= 0) {
      decoded += static_cast<char>(hex_digit(uri[i + 1]) * 16 + hex_digit(uri[i + 2]));
      i += 2;
    } else {
      decoded += uri[i];
    }
  }
  if (decoded.empty() || decoded[0] == '/' || !is_manifest_text(decoded)) return {};
  std::string path;
  for (std::size_t begin = 0; begin <= decoded.size();) {
    const std::size_t end = std::min(decoded.find('/', begin), decoded.size());
    const std::string part = decoded.substr(begin, end - begin);
    if (part.empty() || part == "..") return {};
    if (part != ".") path += (path.empty() ? "" : "/") + part;
    begin = end + 1;
  }
  return path;
}

}  // namespace

std::string utf8_of(const std::string& text) {
  return Json::parse(Json(text).dump(-1, ' ', false, Json::error_handler_t::ignore))
      .get<std::string>();
}

std::string manifest_name(const std::filesystem::path& main) {
  const std::string name = main.filename().string(), kind = main.extension().string();
  if (is_manifest_text(name)) return name;
  return "scene" + (is_manifest_text(kind) ? kind : std::string());
}

Outcome<std::map<std::string, std::filesystem::path>> scene_files(
    const std::filesystem::path& main) {
  std::error_code error;
  const auto bytes = std::filesystem::file_size(main, error);
  std::ifstream file(main, std::ios::binary);
  if (error || !file) {
    Error missing;
    missing.code = kCodeNotFound;
    missing.reason = "IO_ERROR";
    missing.message = "cannot read the scene" + (error ? ": " + error.message() : std::string());
    missing.place = main.string();
    return missing;
  }
  std::map<std::string, std::filesystem::path> files = {{manifest_name(main), main}};
  UriScan scan;
  const std::string text = json_text(file, bytes);
  // What does not parse is uploaded as it is: the service says what is wrong and where.
  static_cast<void>(Json::sax_parse(text, &scan, Json::input_format_t::json, false));
  for (const std::string& uri : scan.uris) {
    const std::string path = manifest_path(uri);
    if (path.empty()) continue;
    const std::filesystem::path beside = main.parent_path() / path;
    if (std::filesystem::is_regular_file(beside, error)) files.emplace(path, beside);
  }
  return files;
}

}  // namespace lightbatch::client
