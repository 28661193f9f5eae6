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

/// A cosine ray and the triangle that it leaves.
struct ElementRay {
  rays::Ray ray;
  std::uint32_t triangle;
};

/// The k-th of a sequence of cosine rays, from area-uniform points of the element.
inline ElementRay element_ray(const SolverInput& input, ElementId e, const OwenSobol8& sequence,
                              std::uint32_t k) {
  const Vec2f at = sequence.pair(k, 2);
  const ElementPoint p = input.elements.point(e, at.x, at.y);
  const auto frame = optics::surface_frame(input.scene, p.triangle, p.u, p.v,
                                           input.elements.is_back(e), input.direct.lift());
  return {
      {frame.origin, Frame::about(frame.normal).to_world(cosine_hemisphere(sequence.pair(k, 0)))},
      p.triangle};
}

}  // namespace lightbatch::radiosity
