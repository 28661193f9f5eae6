#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>

#include "core/math/aabb.h"
#include "core/rays/caster.h"

namespace lightbatch::rays {

/// Many segments between the same two boxes, as a radiosity link asks for. The node where
/// the last one was stopped is tried first; once several have passed it, what can stand between the
/// boxes is gathered (shaft culling) and later segments look at that alone. Answers are those of
/// Caster::occluded, bit for bit, in any order of asking. Keeps a reference to the caster; for one
/// thread.
class Bundle {
 public:
  Bundle(const Caster& caster, const Aabb& from, const Aabb& to);
  ~Bundle();
  Bundle(Bundle&&) noexcept;
  Bundle& operator=(Bundle&&) noexcept;

  /// Whether nothing at all reaches into the space between: then every segment is free. Gathers.
  bool is_clear();
  /// A segment that does not run from one box to the other is cast the ordinary way.
  bool occluded(const Ray& segment, std::uint32_t exclude_a = kNoTriangle,
                std::uint32_t exclude_b = kNoTriangle, HitFilter* filter = nullptr);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace lightbatch::rays
