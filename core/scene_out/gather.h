#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/scene_out/corners.h"

namespace lightbatch::scene_out {

/// Triangles of several objects as corners of one mesh to be.
struct Gathered {
  std::vector<CornerStream> streams;      // by row
  std::vector<std::uint32_t> row_of;      // by corner
  std::vector<IndexRange> ranges;         // corners of each piece
  std::vector<IndexRange> rows_of_piece;  // rows of each piece
};

/// A source vertex is one row for all corners of a piece that it is at; with lightmaps every corner
/// has a row, and the last stream is TEXCOORD_1. frame: what positions are relative to; null: each
/// object's own frame.
Result<Gathered> gather(Writer& writer, std::span<const batches::Piece> pieces,
                        const CornerPlan& plan, const Vec3d* frame, bool lit);

}  // namespace lightbatch::scene_out
