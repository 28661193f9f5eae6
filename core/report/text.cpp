#include "core/report/text.h"

#include <array>
#include <charconv>
#include <cmath>
#include <cstdint>

namespace lightbatch::report {
namespace {

constexpr std::string_view kReplacement = "\xEF\xBF\xBD";

/// Length of the UTF-8 sequence that starts at text[i], or 0 when none does (RFC 3629).
std::size_t sequence_length(std::string_view text, std::size_t i) {
  const auto byte = [&](std::size_t at) {
    return at < text.size() ? static_cast<unsigned char>(text[at]) : 0u;
  };
  const unsigned first = byte(i);
  if (first < 0x80) return 1;
  const std::size_t length = first >= 0xC2 && first < 0xE0   ? 2
                             : first >= 0xE0 && first < 0xF0 ? 3
                             : first >= 0xF0 && first < 0xF5 ? 4
                                                             : 0;
  for (std::size_t k = 1; k < length; ++k) {
    if ((byte(i + k) & 0xC0u) != 0x80u) return 0;
  }
  const unsigned second = byte(i + 1);
  const bool overlong = (first == 0xE0 && second < 0xA0) || (first == 0xF0 && second < 0x90);
  const bool outside = (first == 0xED && second > 0x9F) || (first == 0xF4 && second > 0x8F);
  return overlong || outside ? 0 : length;
}

}  // namespace

std::string escape(std::string_view text) {
  std::string out;
  out.reserve(text.size() + text.size() / 8);
  for (std::size_t i = 0; i < text.size();) {
    const std::size_t length = sequence_length(text, i);
    const char c = text[i];
    if (length == 0) {
      out += kReplacement;
      ++i;
      continue;
    }
    if (length == 1) {
      switch (c) {
        case '&':
          out += "&amp;";
          break;
        case '<':
          out += "&lt;";
          break;
        case '>':
          out += "&gt;";
          break;
        case '"':
          out += "&quot;";
          break;
        case '\'':
          out += "&#39;";
          break;
        default:
          if (static_cast<unsigned char>(c) >= 0x20 && c != 0x7F) {
            out += c;
          } else if (c == '\n' || c == '\t') {
            out += c;
          } else {
            out += kReplacement;
          }
      }
    } else {
      out += text.substr(i, length);
    }
    i += length;
  }
  return out;
}

std::string base64(std::span<const std::byte> bytes) {
  static constexpr char kDigits[] =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  out.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t group = 0;
    const std::size_t held = std::min<std::size_t>(3, bytes.size() - i);
    for (std::size_t k = 0; k < 3; ++k) {
      group = (group << 8) | (k < held ? std::to_integer<std::uint32_t>(bytes[i + k]) : 0u);
    }
    for (std::size_t k = 0; k < 4; ++k) {
      out += k <= held ? kDigits[(group >> (18 - 6 * k)) & 63u] : '=';
    }
  }
  return out;
}

std::string significant(double value, int digits) {
  if (!std::isfinite(value)) return std::isnan(value) ? "-" : value > 0 ? "∞" : "-∞";
  if (value == 0) return "0";
  const double magnitude = std::floor(std::log10(std::abs(value)));
  std::array<char, 64> buffer;
  std::to_chars_result result;
  if (magnitude < -4 || magnitude >= 15) {
    result = std::to_chars(buffer.data(), buffer.data() + buffer.size(), value,
                           std::chars_format::scientific, digits - 1);
    return {buffer.data(), result.ptr};
  }
  const int decimals = std::max(0, digits - 1 - static_cast<int>(magnitude));
  result = std::to_chars(buffer.data(), buffer.data() + buffer.size(), value,
                         std::chars_format::fixed, decimals);
  std::string text(buffer.data(), result.ptr);
  if (text.find('.') != std::string::npos) {
    text.erase(text.find_last_not_of('0') + 1);
    if (text.back() == '.') text.pop_back();
  }
  return text;
}

std::string coordinate(double value) {
  if (!std::isfinite(value)) return "0";
  std::array<char, 64> buffer;
  const double rounded = std::round(value * 100) / 100;
  if (rounded == 0) return "0";
  if (std::abs(rounded) > 1e9) return rounded > 0 ? "1000000000" : "-1000000000";
  const auto result = std::to_chars(buffer.data(), buffer.data() + buffer.size(), rounded);
  return {buffer.data(), result.ptr};
}

std::string count_text(double value) {
  if (!std::isfinite(value) || std::abs(value) >= 1e15) return significant(value);
  if (value != std::floor(value)) return significant(value);
  std::string digits = std::to_string(static_cast<long long>(std::abs(value)));
  for (std::size_t at = digits.size(); at > 3; at -= 3) digits.insert(at - 3, 1, ',');
  return value < 0 ? "-" + digits : digits;
}

std::string percent_text(double fraction) { return significant(100 * fraction, 3) + " %"; }

std::string seconds_text(double seconds) {
  if (!std::isfinite(seconds) || seconds < 0) return significant(seconds);
  if (seconds > 0 && seconds < 1e-3) return significant(1e6 * seconds, 3) + " µs";
  if (seconds < 1) return significant(1000 * seconds, 3) + " ms";
  if (seconds < 120) return significant(seconds, 3) + " s";
  const auto whole = static_cast<long long>(std::min(seconds, 1e15) + 0.5);
  const bool hours = whole >= 7200;
  const std::string high = std::to_string(hours ? whole / 3600 : whole / 60);
  const long long rest = hours ? whole % 3600 / 60 : whole % 60;
  std::string low = std::to_string(rest);
  if (rest < 10) low.insert(0, 1, '0');
  return high + (hours ? " h " : " min ") + low + (hours ? " min" : " s");
}

std::string bytes_text(double bytes) {
  static constexpr std::array kUnits = {"B", "KiB", "MiB", "GiB", "TiB", "PiB"};
  std::size_t unit = 0;
  while (std::abs(bytes) >= 1024 && unit + 1 < kUnits.size()) {
    bytes /= 1024;
    ++unit;
  }
  return significant(bytes, 3) + " " + kUnits[unit];
}

}  // namespace lightbatch::report
