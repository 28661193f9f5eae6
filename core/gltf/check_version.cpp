#include "core/gltf/check_version.h"

#include <optional>
#include <string_view>

namespace lightbatch::gltf {
namespace {

struct Version {
  int major = 0;
  int minor = 0;
};

std::optional<int> parse_number(std::string_view digits) {
  if (digits.empty() || digits.size() > 4) return std::nullopt;
  int value = 0;
  for (const char c : digits) {
    if (c < '0' || c > '9') return std::nullopt;
    value = value * 10 + (c - '0');
  }
  return value;
}

std::optional<Version> parse_version(std::string_view text) {
  const std::size_t dot = text.find('.');
  if (dot == std::string_view::npos) return std::nullopt;
  const std::optional<int> major = parse_number(text.substr(0, dot));
  const std::optional<int> minor = parse_number(text.substr(dot + 1));
  if (!major || !minor) return std::nullopt;
  return Version{*major, *minor};
}

/// The version named by a property of "asset"; a default when it is absent.
Result<Version> read_version(const Json& asset, const char* name, const JsonPath& path) {
  const auto found = asset.find(name);
  if (found == asset.end()) return Version{};
  const std::string place = JsonPath(path, name).text();
  if (!found->is_string()) return malformed(place, "must be a string");
  const std::optional<Version> version = parse_version(found->get_ref<const std::string&>());
  if (!version) return malformed(place, "the version must look like \"2.0\"");
  return *version;
}

}  // namespace

Status check_version(const Json& json, const JsonPath& root, std::vector<std::string>& warnings) {
  if (!json.is_object()) return malformed(root.text(), "a glTF file is a JSON object");
  const auto asset = json.find("asset");
  const JsonPath path(root, "asset");
  if (asset == json.end() || !asset->is_object() || !asset->contains("version")) {
    return malformed(path.text(), "a glTF file needs asset.version");
  }
  LB_ASSIGN_OR_RETURN(const Version version, read_version(*asset, "version", path));
  LB_ASSIGN_OR_RETURN(const Version least, read_version(*asset, "minVersion", path));
  if (version.major != 2) {
    return unsupported(path.text() + "/version", "glTF " + std::to_string(version.major) + "." +
                                                     std::to_string(version.minor) +
                                                     "; only glTF 2 can be read");
  }
  if (least.major > 2) {
    return unsupported(path.text() + "/minVersion", "the scene needs a later glTF version");
  }
  if (least.major == 2 && least.minor > version.minor) {
    warnings.push_back(path.text() + "/minVersion: is greater than version");
  }
  return {};
}

}  // namespace lightbatch::gltf
