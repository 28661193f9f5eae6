#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>

namespace lightbatch::report {

/// Text as HTML or SVG content or attribute value: & < > " ' escaped; bytes that are not UTF-8 and
/// control characters replaced by U+FFFD.
std::string escape(std::string_view text);

std::string base64(std::span<const std::byte> bytes);

/// Shortest decimal of `digits` significant digits, no exponent between 1e-4 and 1e15: "0.0173".
std::string significant(double value, int digits = 4);
/// Coordinates of drawings: at most two decimals.
std::string coordinate(double value);
/// "1,188,348"
std::string count_text(double value);
/// 0.0173 -> "1.73 %"
std::string percent_text(double fraction);
/// "420 ms", "12.3 s", "3 min 12 s", "2 h 05 min"
std::string seconds_text(double seconds);
/// "1.21 GiB"
std::string bytes_text(double bytes);

}  // namespace lightbatch::report
