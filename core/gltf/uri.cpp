#include "core/gltf/uri.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

namespace lightbatch::gltf {
namespace {

bool is_letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); }
bool is_digit(char c) { return c >= '0' && c <= '9'; }
char to_lower(char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; }

int hex_value(char c) {
  if (is_digit(c)) return c - '0';
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  if (c >= 'A' && c <= 'F') return c - 'A' + 10;
  return -1;
}

/// The part before the first colon when it may be a scheme (RFC 3986, 3.1).
bool has_scheme(std::string_view uri) {
  const std::size_t colon = uri.find(':');
  if (colon == std::string_view::npos || colon == 0 || !is_letter(uri[0])) return false;
  for (const char c : uri.substr(0, colon)) {
    if (!is_letter(c) && !is_digit(c) && c != '+' && c != '-' && c != '.') return false;
  }
  return true;
}

bool starts_with_data(std::string_view uri) {
  constexpr std::string_view kData = "data:";
  if (uri.size() < kData.size()) return false;
  for (std::size_t i = 0; i < kData.size(); ++i) {
    if (to_lower(uri[i]) != kData[i]) return false;
  }
  return true;
}

bool percent_decode(std::string_view text, std::string* out) {
  out->clear();
  out->reserve(text.size());
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] != '%') {
      *out += text[i];
      continue;
    }
    if (text.size() - i < 3) return false;
    const int high = hex_value(text[i + 1]);
    const int low = hex_value(text[i + 2]);
    if (high < 0 || low < 0) return false;
    *out += static_cast<char>(high * 16 + low);
    i += 2;
  }
  return true;
}

constexpr std::array<std::int8_t, 256> make_base64_table() {
  std::array<std::int8_t, 256> table{};
  for (auto& value : table) value = -1;
  constexpr std::string_view kDigits =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  for (std::size_t i = 0; i < kDigits.size(); ++i) {
    table[static_cast<unsigned char>(kDigits[i])] = static_cast<std::int8_t>(i);
  }
  return table;
}
constexpr std::array<std::int8_t, 256> kBase64 = make_base64_table();

bool decode_base64(std::string_view text, Bytes* out) {
  if (text.size() % 4 != 0) return false;
  std::size_t padding = 0;
  while (padding < 2 && padding < text.size() && text[text.size() - 1 - padding] == '=') ++padding;
  const std::size_t digits = text.size() - padding;
  out->resize(text.size() / 4 * 3 - padding);
  std::uint32_t group = 0;
  std::size_t written = 0;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const int value = i < digits ? kBase64[static_cast<unsigned char>(text[i])] : 0;
    if (value < 0) return false;
    group = group << 6 | static_cast<std::uint32_t>(value);
    if (i % 4 != 3) continue;
    for (int shift = 16; shift >= 0 && written < out->size(); shift -= 8) {
      (*out)[written++] = static_cast<std::byte>(group >> shift & 0xff);
    }
    group = 0;
  }
  return true;
}

}  // namespace

Status uri_forbidden(const std::string& place, const std::string& message) {
  return {StatusCode::kPermissionDenied, "SCENE_URI_FORBIDDEN", message, place};
}

Result<UriKind> classify_uri(std::string_view uri, const std::string& place) {
  if (uri.empty()) return malformed(place, "the uri is empty");
  if (uri[0] == ':') return malformed(place, "the uri has no scheme before its colon");
  if (starts_with_data(uri)) return UriKind::kData;
  if (has_scheme(uri) || uri[0] == '/' || uri[0] == '\\') return UriKind::kAbsolute;
  return UriKind::kRelative;
}

Result<std::string> resolve_uri(std::string_view uri, std::string_view folder,
                                const std::string& place) {
  std::string decoded;
  if (!percent_decode(uri, &decoded)) return malformed(place, "the uri has a broken % escape");
  for (const char c : decoded) {
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) {
      return malformed(place, "the uri holds a control character");
    }
  }
  const std::string joined = folder.empty() ? decoded : std::string(folder) + "/" + decoded;
  std::vector<std::string_view> parts;
  std::string_view rest = joined;
  while (true) {
    const std::size_t slash = rest.find('/');
    const std::string_view part = rest.substr(0, slash);
    if (part == "..") {
      if (parts.empty()) {
        return uri_forbidden(place,
                             "the uri \"" + std::string(uri) + "\" leaves the scene's folder");
      }
      parts.pop_back();
    } else if (!part.empty() && part != ".") {
      parts.push_back(part);
    }
    if (slash == std::string_view::npos) break;
    rest.remove_prefix(slash + 1);
  }
  std::string name;
  for (const std::string_view part : parts) {
    if (!name.empty()) name += '/';
    name += part;
  }
  if (name.empty()) return malformed(place, "the uri names no file");
  return name;
}

Result<DataUri> decode_data_uri(std::string_view uri, const std::string& place) {
  uri.remove_prefix(std::string_view("data:").size());
  const std::size_t comma = uri.find(',');
  if (comma == std::string_view::npos) return malformed(place, "the data uri has no comma");
  std::string_view head = uri.substr(0, comma);
  const std::string_view body = uri.substr(comma + 1);
  constexpr std::string_view kBase64Mark = ";base64";
  const bool base64 = head.ends_with(kBase64Mark);
  if (base64) head.remove_suffix(kBase64Mark.size());

  DataUri data;
  for (std::size_t i = 0; i <= head.size();) {
    const std::size_t end = std::min(head.find(';', i), head.size());
    const std::string_view part = head.substr(i, end - i);
    if (i == 0) {
      if (!part.empty() && part.find('/') == std::string_view::npos) {
        return malformed(place, "the data uri has no valid media type");
      }
      for (const char c : part) data.media_type += to_lower(c);
    } else if (part.find('=') == std::string_view::npos) {
      return malformed(place, "the data uri has a broken parameter");
    }
    i = end + 1;
  }
  if (base64) {
    if (!decode_base64(body, &data.bytes)) {
      return malformed(place, "the data uri is not valid base64 (padding included, no spaces)");
    }
    return data;
  }
  std::string text;
  if (!percent_decode(body, &text)) return malformed(place, "the data uri has a broken % escape");
  const auto bytes = as_bytes(text);
  data.bytes.assign(bytes.begin(), bytes.end());
  return data;
}

}  // namespace lightbatch::gltf
