#include "core/scene_out/gather.h"

namespace lightbatch::scene_out {

Result<Gathered> gather(Writer& w, std::span<const batches::Piece> pieces, const CornerPlan& plan,
                        const Vec3d* frame, bool lit) {
  Gathered result;
  for (const AttributeType& type : plan.types) result.streams.push_back({type, {}});
  if (lit) result.streams.push_back({{"TEXCOORD_1", 5126, false, "VEC2", 2}, {}});
  std::vector<std::uint32_t> row_of_vertex, touched;
  std::uint32_t rows = 0;
  for (const batches::Piece& piece : pieces) {
    const scene::Object& object = w.scene.objects[piece.object];
    LB_ASSIGN_OR_RETURN(const SourcePrimitive* source,
                        w.sources.get(object.mesh, object.primitive));
    const CornerCopier copier = frame != nullptr ? CornerCopier(plan, *source, object, *frame)
                                                 : CornerCopier(plan, *source);
    if (row_of_vertex.size() < source->vertex_count())
      row_of_vertex.resize(source->vertex_count(), kNone);
    const auto first = static_cast<std::uint32_t>(result.row_of.size());
    const std::uint32_t first_row = rows;
    for (const batches::Range& range : piece.ranges)
      for (std::uint32_t t = range.first; t < range.first + range.count; ++t) {
        for (const std::uint32_t v : w.source_vertices(*source, t)) {
          std::uint32_t row = lit ? kNone : row_of_vertex[v];
          if (row == kNone) {
            row = rows++;
            copier.copy(v, result.streams);
            if (!lit) {
              row_of_vertex[v] = row;
              touched.push_back(v);
            }
          }
          result.row_of.push_back(row);
        }
        if (lit)
          for (const Vec2f& uv : w.uv1_of(t)) push_floats(result.streams.back().bytes, &uv.x, 2);
      }
    for (const std::uint32_t v : touched) row_of_vertex[v] = kNone;
    touched.clear();
    const auto last = static_cast<std::uint32_t>(result.row_of.size());
    result.ranges.push_back({piece.object, first, last - first});
    result.rows_of_piece.push_back({piece.object, first_row, rows - first_row});
  }
  return result;
}

}  // namespace lightbatch::scene_out
