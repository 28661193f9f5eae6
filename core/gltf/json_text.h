#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "core/base/status.h"
#include "core/gltf/document.h"

namespace lightbatch::gltf {

/// Strict JSON (RFC 8259): UTF-8 without a byte order mark, no duplicate names, finite numbers,
/// nothing after the value. At most `depth` arrays and objects inside each other. What the tree
/// takes in memory is estimated while it grows; beyond max_memory it is refused.
/// `place` names the text; errors add "@offset", counted from `base_offset`.
Result<Json> parse_json(std::string_view text, const std::string& place, int depth,
                        std::uint64_t max_memory, std::uint64_t base_offset = 0);

/// Compact text: keys sorted (as Json keeps them), numbers in the shortest form that reads back
/// equal. INTERNAL when a number is not finite or a string is not UTF-8.
Result<std::string> write_json(const Json& json);

}  // namespace lightbatch::gltf
