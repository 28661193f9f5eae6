#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace lightbatch::cli {

/// "2%" or "0.02" -> 0.02. Empty when it is neither, or not in (0, 1].
std::optional<double> parse_error_bound(std::string_view text);
/// "30s", "2m", "1.5h", "500ms", "30" (seconds) -> seconds > 0.
std::optional<double> parse_duration(std::string_view text);
/// A number alone: "1000", "2.5e3".
std::optional<double> parse_number(std::string_view text);
/// Digits alone that fit 64 bits.
bool is_whole_number(std::string_view text);
/// "HOST:PORT", with the port from 1 to 65535; "unix:PATH" and other schemes with a slash pass.
bool is_server_address(std::string_view text);
/// "a,b,c" -> parts without surrounding blanks; empty parts are kept.
std::vector<std::string> split_list(std::string_view text);

/// "1.2 MiB"
std::string format_bytes(double bytes);
/// "42 s", "3 min 20 s", "2 h 05 min"
std::string format_seconds(double seconds);

}  // namespace lightbatch::cli
