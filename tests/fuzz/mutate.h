#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "core/base/random.h"
#include "core/gltf/document.h"

/// Seeded damage to glTF scenes: the same seed gives the same damage everywhere.
namespace lightbatch::fuzz {

/// A scene as its two parts; a .gltf has no binary.
struct Parts {
  gltf::Json json;
  Bytes binary;
};
/// nullopt for what is no readable container; damage() still takes its bytes.
std::optional<Parts> split(const Bytes& file);

/// One to `most` changes: JSON values replaced by telling ones, removed, copied from elsewhere or
/// repeated; bytes of the binary changed; or bytes of the whole file, header included.
Bytes damage(const Bytes& file, const std::optional<Parts>& parts, Random& random,
             std::uint64_t most = 4);

}  // namespace lightbatch::fuzz
