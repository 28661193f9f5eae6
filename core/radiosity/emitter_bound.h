#pragma once

#include <algorithm>
#include <cstdint>

#include "core/hierarchy/hierarchy.h"
#include "core/radiosity/direct_light.h"
#include "core/radiosity/light_sources.h"

namespace lightbatch::radiosity {

/// A triangle does not light itself.
inline bool is_own(const Emitter& e, const Receiver& at) {
  return !e.is_point() && e.triangle == at.triangle;
}

/// How far an emitter's highest corner is above the plane that rays start from, metres: what lies
/// below it, or touches the surface, brings nothing.
inline float highest_of(const Emitter& e, const Receiver& at) {
  const Vec3f& n = at.frame.normal;
  return dot(e.a - at.frame.origin, n) + std::max({0.0f, dot(e.b - e.a, n), dot(e.c - e.a, n)});
}

/// How much a node of the emitters' hierarchy may bring, lux summed over channels: its power as
/// from the middle of its box; and how far that may be off, by what the nearest point of the box
/// may bring.
struct EmitterBound {
  float importance = 0;
  float uncertainty = 0;
};
EmitterBound bound_of(const LightSources& sources, hierarchy::Hierarchy::NodeId node,
                      const Receiver& at);

/// One of all emitters, about in proportion to what each may bring: down the hierarchy by
/// bounds, among the last few by each triangle's own place. Never the receiver's own triangle.
/// random in [0, 1). The density of the choice is what matters where a large triangle passes close
/// by: an emitter that is chosen too seldom for what it brings makes single bright samples.
struct ChosenEmitter {
  std::uint32_t emitter = 0;
  double probability = 0;  // 0: none
};
ChosenEmitter choose_emitter(const LightSources& sources, const Receiver& at, double random);

}  // namespace lightbatch::radiosity
