#pragma once

#include <span>

#include "core/math/vec.h"

namespace lightbatch::radiosity {

/// Area form factor F_ab of two planar convex polygons: the fraction of the power leaving the front
/// of a, a diffuse emitter, that arrives at the front of b, nothing between. A_a F_ab = A_b F_ba.
/// Fronts are the counter-clockwise sides. Holds for touching, nearly touching, tiny, distant and
/// sliver pairs; 0 where the fronts do not face or a polygon has no area.
double form_factor(std::span<const Vec3d> a, std::span<const Vec3d> b,
                   double relative_tolerance = 1e-6);

/// Twice the area as a vector along the normal (Newell).
Vec3d doubled_area(std::span<const Vec3d> polygon);

}  // namespace lightbatch::radiosity
