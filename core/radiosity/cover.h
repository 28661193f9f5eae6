#pragma once

#include <cstdint>
#include <vector>

#include "core/optics/optics.h"
#include "core/rays/caster.h"
#include "core/scene/scene.h"

namespace lightbatch::radiosity {

/// How closely the sides of triangles are covered, against the edge of an element: sides of
/// different cover do not see the same light.
class Covers {
 public:
  /// large: per triangle; these are not asked for. No caster: all lie open.
  Covers(const scene::Scene& scene, const optics::Optics& optics, const rays::Caster* caster,
         double edge, const std::vector<std::uint8_t>& large);

  /// 0: open; equal kinds may share an element.
  int of(std::uint32_t triangle, bool back) const {
    return cover_.empty() ? 0 : cover_[2 * std::size_t{triangle} + (back ? 1 : 0)];
  }

 private:
  std::vector<std::uint8_t> cover_;  // per triangle: front, back
};

}  // namespace lightbatch::radiosity
