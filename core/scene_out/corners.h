#pragma once

#include <array>
#include <vector>

#include "core/math/mat.h"
#include "core/scene_out/mesh_builder.h"
#include "core/scene_out/writer.h"

namespace lightbatch::scene_out {

/// Which attributes of a source go into a world-aligned mesh, and under which names.
struct CornerPlan {
  std::vector<std::size_t> source;   // index into SourcePrimitive::types
  std::vector<AttributeType> types;  // as written: POSITION becomes float; else as read
};
/// moved_set: where TEXCOORD_1 goes (kNone: it stays, unless drop_uv1).
CornerPlan plan_corners(const std::vector<AttributeType>& types, bool drop_uv1,
                        std::uint32_t moved_set);

/// Whether directions of integers stay integers: right angles, one scale.
bool leads_to_integers(const Affine& m);
/// Directions of bytes become shorts, so that turns do not round them a second time.
void widen_directions(CornerPlan& plan);

/// Appends the corner (source vertex v) of an object to the streams: position relative to `frame`,
/// normal and tangent turned with the object, the rest as stored.
class CornerCopier {
 public:
  CornerCopier(const CornerPlan& plan, const SourcePrimitive& source, const scene::Object& object,
               const Vec3d& frame);
  /// In the object's own frame.
  CornerCopier(const CornerPlan& plan, const SourcePrimitive& source);
  void copy(std::uint32_t vertex, std::vector<CornerStream>& streams) const;
  /// The same for the point that mixes three vertices by their weights, which sum to 1.
  void mix(const std::array<std::uint32_t, 3>& vertices, const std::array<double, 3>& weights,
           std::vector<CornerStream>& streams) const;

 private:
  /// From one type to the other.
  void push_direction(const AttributeType& type, const AttributeType& to, const Vec3d& direction,
                      Bytes& out) const;

  const CornerPlan& plan_;
  const SourcePrimitive& source_;
  Affine to_frame_;
  bool mirrored_ = false;
};

/// Component i of an element: normalised integers mapped as glTF 3.6.2.2 says, others as they are.
double component(const AttributeType& type, const std::byte* element, std::size_t i);
/// The reverse, rounded and clamped to what the type holds.
void push_component(const AttributeType& type, double value, Bytes& bytes);

/// Bytes of a value at the end of a stream.
void push_floats(Bytes& bytes, const float* values, std::size_t count);

}  // namespace lightbatch::scene_out
