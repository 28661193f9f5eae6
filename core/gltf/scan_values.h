#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/gltf/document.h"
#include "core/gltf/json_path.h"

namespace lightbatch::gltf {

/// Looks at the values of every accessor that has data: floats must be finite; min and max must be
/// those of the data, else a warning. For accessors in `decoded` (whose data came from a lossy
/// stream) min and max are set instead. Bytes looked at are bounded by what the buffers hold.
Status scan_values(Document& document, const JsonPath& root,
                   const std::vector<std::uint32_t>& decoded, std::vector<std::string>& warnings);

}  // namespace lightbatch::gltf
