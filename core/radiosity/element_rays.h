#pragma once

#include <algorithm>

#include "core/math/sampling.h"
#include "core/math/sobol.h"
#include "core/optics/surface_frame.h"
#include "core/radiosity/solver.h"

namespace lightbatch::radiosity {

/// An element's part of the rays of a full-sized one, in (0, 1]: half an edge across is full.
inline double share_of_rays(const Elements& elements, ElementId e) {
  const double half = 0.5 * elements.edge();
  return std::min(1.0, static_cast<double>(elements.area(e)) / (half * half));
}

/// The point of an element for random ab in [0, 1)^2, as a receiver on the element's side.
inline Receiver receiver_on(const scene::Scene& scene, const Elements& elements, ElementId e,
                            Vec2f ab, float lift) {
  const ElementPoint p = elements.point(e, ab.x, ab.y);
  return {optics::surface_frame(scene, p.triangle, p.u, p.v, elements.is_back(e), lift),
          p.triangle};
}

/// A cosine ray and the triangle that it leaves.
struct ElementRay {
  rays::Ray ray;
  std::uint32_t triangle;
};

/// The k-th of a sequence of cosine rays, from area-uniform points of the element.
inline ElementRay element_ray(const SolverInput& input, ElementId e, const OwenSobol8& sequence,
                              std::uint32_t k) {
  const Receiver from =
      receiver_on(input.scene, input.elements, e, sequence.pair(k, 2), input.direct.lift());
  const Vec3f direction =
      Frame::about(from.frame.normal).to_world(cosine_hemisphere(sequence.pair(k, 0)));
  return {{from.frame.origin, direction}, from.triangle};
}

}  // namespace lightbatch::radiosity
