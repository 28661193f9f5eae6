#pragma once

#include <string>
#include <string_view>

#include "core/base/bytes.h"
#include "core/base/status.h"

namespace lightbatch::gltf {

enum class UriKind { kData, kRelative, kAbsolute };

/// kAbsolute: has a scheme (http:, file:, C:) or starts with a slash or backslash.
/// INPUT_MALFORMED for what is no uri at all (empty, ":").
Result<UriKind> classify_uri(std::string_view uri, const std::string& place);

/// Percent-decodes a relative uri, joins it to `folder` ("" or "a/b"), removes "." and "..".
/// INPUT_MALFORMED for a bad escape or a control character, SCENE_URI_FORBIDDEN when it climbs out
/// of the scene's folder.
Result<std::string> resolve_uri(std::string_view uri, std::string_view folder,
                                const std::string& place);

struct DataUri {
  std::string media_type;  // lower case, without parameters
  Bytes bytes;
};

/// RFC 2397, strict: base64 with correct padding and nothing else in it, or percent-encoded text.
Result<DataUri> decode_data_uri(std::string_view uri, const std::string& place);

Status uri_forbidden(const std::string& place, const std::string& message);

}  // namespace lightbatch::gltf
