#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/batches/assignment.h"

namespace lightbatch::batches {

enum class Fate : std::uint8_t { kMerged, kInstanced, kLeft };

/// The objects of every placement (node, GPU instance) of a mesh, by primitive.
using Placements = std::vector<std::vector<std::uint32_t>>;

inline constexpr const char* kBlendedReason = "blended: viewers sort it by object";
inline constexpr const char* kInstancedReason = "instanced: copies would exceed the allowed growth";

/// What becomes of every object, before any cut: merged into batches, drawn by instance cells, or
/// left in its node with a reason. The growth in bytes is predicted here.
struct Fates {
  std::vector<Fate> of_object;
  std::vector<std::string> reason;  // of kLeft and kInstanced
  std::vector<Placements> shared;   // of each mesh to be drawn by instance cells
  double geometry_bytes = 0;
  double copied_bytes = 0;
  double next_bytes_of_draw = 0;  // that would copy more; 0: nothing would
};
/// Growth that is allowed whatever it brings.
inline constexpr double kLittleGrowth = 0.25;

/// What copies of shared meshes may take.
struct CopyLimits {
  double growth = 1;         // of all bytes
  double bytes_of_draw = 0;  // for each draw that they save; at least 16 KiB, with lightmaps 64
};
Fates decide_fates(const scene::Scene& scene, const BatchOptions& options, const KeyMap& keys,
                   const CopyLimits& limits);

}  // namespace lightbatch::batches
