#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/base/bytes.h"
#include "tests/fuzz/mutate.h"

namespace lightbatch::fuzz {

/// A scene to damage.
struct Seed {
  std::string name;
  Bytes file;
  std::optional<Parts> parts;
};

/// Much in little: instances, lights, textures, a skin, morph targets, animation, sparse values.
Bytes rich_scene();
/// The rich scene first; then those of tests/data/reference, and the small ones of badinput/ and
/// scenes/ where these are present.
std::vector<Seed> seeds();

}  // namespace lightbatch::fuzz
