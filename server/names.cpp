#include "server/names.h"

#include <sys/random.h>

#include <algorithm>
#include <charconv>
#include <chrono>
#include <limits>

#include "core/base/bytes.h"
#include "core/base/hash.h"

namespace lightbatch::server {
namespace {

constexpr std::size_t kMaxPathBytes = 1024;
constexpr std::int64_t kDefaultPage = 50;
constexpr std::int64_t kMaxPage = 500;
constexpr std::size_t kTokenCheckDigits = 8;

Status bad_path(std::string_view path, const char* why) {
  return Status(StatusCode::kInvalidArgument, "BAD_PATH",
                std::string("a manifest path ") + why +
                    "; give relative paths with '/' between parts, inside the scene's folder",
                std::string(path.substr(0, 200)));
}

bool is_id(std::string_view id) {
  return !id.empty() && id.size() <= 64 && std::all_of(id.begin(), id.end(), [](char c) {
    return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || c == '-';
  });
}

/// Well-formed UTF-8 (RFC 3629): no overlong forms, no surrogates.
bool is_utf8(std::string_view text) {
  for (std::size_t i = 0; i < text.size();) {
    const auto lead = static_cast<unsigned char>(text[i]);
    std::size_t length = 1;
    if (lead >= 0xf0 && lead <= 0xf4)
      length = 4;
    else if (lead >= 0xe0 && lead < 0xf0)
      length = 3;
    else if (lead >= 0xc2 && lead < 0xe0)
      length = 2;
    else if (lead >= 0x80)
      return false;
    if (i + length > text.size()) return false;
    for (std::size_t k = 1; k < length; ++k) {
      if ((static_cast<unsigned char>(text[i + k]) & 0xc0) != 0x80) return false;
    }
    if (length > 1) {
      const auto second = static_cast<unsigned char>(text[i + 1]);
      if ((lead == 0xe0 && second < 0xa0) || (lead == 0xed && second >= 0xa0) ||
          (lead == 0xf0 && second < 0x90) || (lead == 0xf4 && second >= 0x90)) {
        return false;
      }
    }
    i += length;
  }
  return true;
}

std::string token_check(std::string_view body) {
  return sha256_hex(as_bytes("page:" + std::string(body))).substr(0, kTokenCheckDigits);
}

}  // namespace

Status check_digest(const v1::Digest& digest, std::string_view place) {
  const std::string& hex = digest.sha256();
  const bool good = hex.size() == 64 && std::all_of(hex.begin(), hex.end(), [](char c) {
                      return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'f');
                    });
  if (!good || digest.size_bytes() < 0) {
    return Status(StatusCode::kInvalidArgument, "BAD_DIGEST",
                  "a digest is 64 lower-case hexadecimal digits of SHA-256 and a size >= 0",
                  std::string(place));
  }
  return {};
}

Status check_path(std::string_view path) {
  if (path.empty()) return bad_path(path, "is empty");
  if (path.size() > kMaxPathBytes) return bad_path(path, "is longer than 1,024 bytes");
  if (!is_utf8(path)) return bad_path("", "is not UTF-8");
  if (std::any_of(path.begin(), path.end(), [](char c) {
        return static_cast<unsigned char>(c) < 0x20 || c == 0x7f || c == '\\';
      })) {
    return bad_path("", "holds a control character or a backslash");
  }
  for (std::size_t begin = 0; begin <= path.size();) {
    const std::size_t end = std::min(path.find('/', begin), path.size());
    const std::string_view part = path.substr(begin, end - begin);
    if (part.empty() || part == "." || part == "..") {
      return bad_path(path, "has an empty, '.' or '..' part");
    }
    begin = end + 1;
  }
  return {};
}

Result<std::string> parse_name(std::string_view name, std::string_view prefix) {
  if (!name.starts_with(prefix) || !is_id(name.substr(prefix.size()))) {
    return Status(StatusCode::kInvalidArgument, "BAD_REQUEST",
                  "a name looks like \"" + std::string(prefix) + "{id}\"", "name");
  }
  return std::string(name.substr(prefix.size()));
}

std::string random_id() {
  unsigned char bytes[8];
  LB_CHECK(getrandom(bytes, sizeof bytes, 0) == sizeof bytes, "the kernel gives random bytes");
  std::string id;
  for (const unsigned char byte : bytes) {
    id += "0123456789abcdef"[byte >> 4];
    id += "0123456789abcdef"[byte & 15];
  }
  return id;
}

std::int64_t now_us() {
  return std::chrono::duration_cast<std::chrono::microseconds>(
             std::chrono::system_clock::now().time_since_epoch())
      .count();
}

std::string make_page_token(std::int64_t before, std::int64_t filter) {
  const std::string body = std::to_string(before) + "-" + std::to_string(filter);
  return body + "-" + token_check(body);
}

Result<std::int64_t> parse_page_token(std::string_view token, std::int64_t filter) {
  if (token.empty()) return std::numeric_limits<std::int64_t>::max();
  const Status bad(StatusCode::kInvalidArgument, "BAD_PAGE_TOKEN",
                   "page_token must be a next_page_token of the same listing with the same filter",
                   "page_token");
  std::int64_t before = 0;
  const auto parsed = std::from_chars(token.data(), token.data() + token.size(), before);
  if (parsed.ec != std::errc() || token != make_page_token(before, filter)) return bad;
  return before;
}

Result<std::int64_t> page_rows(std::int32_t page_size) {
  if (page_size < 0) {
    return Status(StatusCode::kInvalidArgument, "BAD_REQUEST", "page_size must not be negative",
                  "page_size");
  }
  return page_size == 0 ? kDefaultPage : std::min<std::int64_t>(page_size, kMaxPage);
}

}  // namespace lightbatch::server
