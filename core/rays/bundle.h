#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>

#include "core/math/aabb.h"
#include "core/rays/caster.h"

namespace lightbatch::rays {

/// Many segments between the same two boxes, as a radiosity link asks for: what can stand between
/// the boxes is gathered once (shaft culling), and each segment looks at that alone. Answers are
/// those of Caster::occluded, bit for bit. Worth it from about four segments. Keeps a reference to
/// the caster. Not shared between threads while it is made; then safe to read.
class Bundle {
 public:
  Bundle(const Caster& caster, const Aabb& from, const Aabb& to);
  ~Bundle();
  Bundle(Bundle&&) noexcept;
  Bundle& operator=(Bundle&&) noexcept;

  /// Nothing at all reaches into the space between: every segment is free.
  bool is_clear() const;
  /// A segment that does not run from one box to the other is cast the ordinary way.
  bool occluded(const Ray& segment, std::uint32_t exclude_a = kNoTriangle,
                std::uint32_t exclude_b = kNoTriangle, HitFilter* filter = nullptr) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace lightbatch::rays
