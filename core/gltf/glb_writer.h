#pragma once

#include <span>

#include "core/base/bytes.h"
#include "core/gltf/document.h"

namespace lightbatch::gltf {

/// One .glb of a JSON document whose buffer 0 is `binary` (byteLength is set here). Deterministic
/// bytes: keys sorted, numbers in their shortest form that reads back equal. OVER_BUDGET beyond
/// 4 GiB, which the format cannot hold.
Result<Bytes> write_glb(Json json, std::span<const std::byte> binary);

}  // namespace lightbatch::gltf
