#pragma once

#include <cstdint>

#include "core/base/bytes.h"
#include "core/base/status.h"

namespace lightbatch::generate {

inline constexpr std::uint64_t kFewestTriangles = 1'000;
inline constexpr std::uint64_t kMostTriangles = 40'000'000;

/// A made-up office building as .glb: floors of rooms on both sides of a corridor, walls with
/// thickness, door and window openings, workplaces, chairs, shelves of books, lamps. Metres, +Y up,
/// reflectances of real materials, luminances of real lamps (nits, candela).
///
/// The triangles drawn (instances counted each) differ from `triangles` by less than 3 %. Furniture
/// nodes share meshes. Same numbers, same bytes. BAD_OPTION outside the bounds above.
Result<Bytes> office_glb(std::uint64_t triangles, std::uint64_t seed);

}  // namespace lightbatch::generate
