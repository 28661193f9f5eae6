#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/base/bytes.h"
#include "core/base/status.h"

namespace lightbatch::gltf {

using Json = nlohmann::json;

/// The only files a scene may name: relative glTF uri (percent-decoded, normalised, '/' between
/// parts) -> file on disk. Nothing outside this map is ever opened; no network exists.
using FileMap = std::map<std::string, std::filesystem::path>;

/// Bounds on what a scene may make us allocate or walk. Exceeding one is INPUT_OVER_BUDGET.
struct ReadLimits {
  std::uint64_t json_bytes = std::uint64_t{64} << 20;
  int json_depth = 64;
  std::uint64_t decoded_bytes = std::uint64_t{4} << 30;  // all buffers and decoded accessors
  std::uint64_t nodes = 4'000'000;
  std::uint64_t triangles = 40'000'000;  // after instancing
  std::uint64_t image_pixels = std::uint64_t{1} << 26;
};

/// A validated glTF 2.0 asset in plain form: buffers resident, Draco and meshopt views decoded into
/// ordinary buffer views and accessors, fallback buffers gone, so that readers and writers meet
/// core glTF only. Every index, range and count in `json` that lightbatch follows was checked.
/// What is not understood stays in `json` untouched.
struct Document {
  Json json;
  std::vector<Bytes> buffers;  // buffers[i] holds json["buffers"][i].byteLength bytes at least
  std::vector<Bytes> images;   // encoded bytes per json["images"] entry; empty where unreadable
  std::string name;            // main file's name, for places in errors
  std::string sha256;          // of the main file
  bool had_draco = false;
  bool had_meshopt = false;
  std::uint64_t input_bytes = 0;  // all files read
  std::vector<std::string> warnings;
};

/// Reads `main` (a key of files; .gltf or .glb by content). INPUT_MALFORMED with a JSON pointer or
/// byte offset, INPUT_UNSUPPORTED for an unknown required extension (by name), INPUT_OVER_BUDGET,
/// SCENE_URI_FORBIDDEN for a uri outside the map.
Result<Document> read_document(const FileMap& files, const std::string& main,
                               const ReadLimits& limits = {});

}  // namespace lightbatch::gltf
