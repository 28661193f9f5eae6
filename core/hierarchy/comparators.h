#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "core/hierarchy/hierarchy.h"

namespace lightbatch::hierarchy {

/// Other ways to build the same kind of tree, to compare with; plain and single-threaded. All keep
/// the promises of Hierarchy (depth bounded, one primitive a leaf).
enum class Method {
  kSweep,             // every split position, as Mueller, Schaefer, Fellner 1999
  kSweepReinsertion,  // and reinsertion: what build() does by default
  kBinned,            // surface area heuristic over 16 bins an axis (Wald 2007)
  kMedianCut,         // half of the primitives each, along the longest axis of their centres
  kInsertion,         // one primitive after another (Goldsmith, Salmon 1987), in shuffled order
  kMorton,            // along a space-filling curve (Lauterbach et al. 2009)
  kAsModelled,        // the order of the file: halves of the list of objects, then of triangles
};
inline constexpr Method kMethods[] = {
    Method::kSweep,     Method::kSweepReinsertion, Method::kBinned,    Method::kMedianCut,
    Method::kInsertion, Method::kMorton,           Method::kAsModelled};
std::string method_name(Method method);

/// objects: the object of each primitive, in any numbering (or empty: all one); used by kAsModelled
/// alone. Nothing when the method has no tree of bounded depth for the input (kInsertion only).
std::optional<Hierarchy> build_with(Method method, std::span<const Aabb> boxes,
                                    std::span<const std::uint32_t> objects);

}  // namespace lightbatch::hierarchy
