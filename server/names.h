#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "core/base/status.h"
#include "lightbatch/v1/types.pb.h"

namespace lightbatch::server {

/// Rules for the words that come in with requests.

/// BAD_DIGEST unless 64 lower-case hexadecimal digits and a size >= 0. `place` names the field.
Status check_digest(const v1::Digest& digest, std::string_view place);
/// BAD_PATH unless a manifest may hold this path (SceneFile.path in the interface).
Status check_path(std::string_view path);
/// "jobs/abc" with prefix "jobs/" -> "abc"; BAD_REQUEST for another shape.
Result<std::string> parse_name(std::string_view name, std::string_view prefix);

/// 16 random hexadecimal digits from the kernel.
std::string random_id();
/// Microseconds since 1970.
std::int64_t now_us();

/// Opaque page tokens: the row to go on below, bound to the filter it was made for.
std::string make_page_token(std::int64_t before, std::int64_t filter);
/// BAD_PAGE_TOKEN for strangers and for another filter. Empty: the first page (INT64_MAX).
Result<std::int64_t> parse_page_token(std::string_view token, std::int64_t filter);
/// page_size of a request -> rows to give; BAD_REQUEST when negative.
Result<std::int64_t> page_rows(std::int32_t page_size);

}  // namespace lightbatch::server
