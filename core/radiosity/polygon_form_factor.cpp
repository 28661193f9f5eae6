// Point-to-polygon form factor by the contour formula (Lambert, Photometria, 1760; Baum, Rushmeier
// and Winget 1989): F = 1/(2 pi) sum over edges of angle * (normal . edge plane's normal).
//
// Deviations from the textbook: the ratio angle / sine of an edge is a polynomial in the cosine, so
// no inverse trigonometric function is called; cross products are taken with the edge vector
// instead of the second vertex, so that small and distant polygons keep their digits; the polygon
// is clipped to the horizon on the fly.
#include "core/radiosity/polygon_form_factor.h"

#include <algorithm>
#include <cmath>

#include "core/math/sampling.h"

namespace lightbatch::radiosity {
namespace {

/// acos(x) / sqrt(1 - x^2) for x in [0, 1]: Chebyshev expansion of degree 14 about 1/2, relative
/// error below 2e-12 (the nearest singularity is at x = -1).
inline double angle_over_sine(double x) {
  const double t = 2 * x - 1;
  const double t2 = t * t, t4 = t2 * t2, t8 = t4 * t4;
  const double p0 = (1.209199576155862 - 0.2636001413067765 * t) +
                    (0.0697331920880834 - 0.0198371459790609 * t) * t2;
  const double p1 = (0.0058616282251060525 - 0.001772938532519497 * t) +
                    (0.0005447799150609001 - 0.0001692627547186021 * t) * t2;
  const double p2 = (5.3050804737608814e-05 - 1.6861771280218817e-05 * t) +
                    (5.361941816772742e-06 - 1.5519366797889236e-06 * t) * t2;
  const double p3 =
      (4.877821766058333e-07 - 2.611146101116901e-07 * t) + 8.648430593893863e-08 * t2;
  return (p0 + p1 * t4) + (p2 + p3 * t4) * t8;
}

/// angle * (normal . unit(a x edge)) of the edge from a to b = a + edge, seen from the origin.
inline double edge_term(const Vec3d& a, const Vec3d& edge, const Vec3d& b, const Vec3d& normal) {
  const Vec3d c = cross(a, edge);
  const double along = dot(normal, c);
  const double inverse = 1 / std::sqrt(std::max(dot(a, a) * dot(b, b), 1e-300));
  const double cosine = std::min(1.0, dot(a, b) * inverse);
  if (cosine >= 0) return along * inverse * angle_over_sine(cosine);
  const double size = length(c);
  if (!(size > 0)) return 0;
  return along * (kPiDouble / size - inverse * angle_over_sine(std::min(1.0, -cosine)));
}

template <typename Vertex>
double factor(const Vec3d& point, const Vec3d& normal, std::size_t count, Vertex vertex,
              double plane_slack) {
  if (count < 3) return 0;
  const Vec3d start = vertex(0) - point;
  Vec3d doubled_area;
  for (std::size_t i = 2; i < count; ++i) {
    doubled_area += cross(vertex(i - 1) - vertex(0), vertex(i) - vertex(0));
  }
  const double height = -dot(doubled_area, start);
  if (!(height > plane_slack * length(doubled_area))) return 0;

  double sum = 0;
  Vec3d exit, entry;  // where the contour goes below the horizon, and where it comes back
  bool below = false, entered_first = false, crossed = false;
  Vec3d a = start;
  double za = dot(normal, a);
  for (std::size_t i = 0; i < count; ++i) {
    const bool last = i + 1 == count;
    const Vec3d b = last ? start : vertex(i + 1) - point;
    const Vec3d edge = last ? vertex(0) - vertex(i) : vertex(i + 1) - vertex(i);
    const double zb = dot(normal, b);
    if (za >= 0 && zb >= 0) {
      sum += edge_term(a, edge, b, normal);
    } else if (za >= 0) {
      const Vec3d part = edge * (za / (za - zb));
      exit = a + part;
      sum += edge_term(a, part, exit, normal);
      below = crossed = true;
    } else if (zb >= 0) {
      const Vec3d part = edge * (zb / (zb - za));
      const Vec3d here = b - part;
      sum += edge_term(here, part, b, normal);
      if (below) {
        sum += edge_term(exit, here - exit, here, normal);
        below = false;
      } else {
        entry = here;
        entered_first = true;
      }
      crossed = true;
    }
    a = b;
    za = zb;
  }
  if (!crossed && za < 0) return 0;
  if (below && entered_first) sum += edge_term(exit, entry - exit, entry, normal);
  return std::clamp(-sum / (2 * kPiDouble), 0.0, 1.0);
}

}  // namespace

double point_to_polygon(const Vec3d& point, const Vec3d& normal, std::span<const Vec3d> polygon,
                        double plane_slack) {
  return factor(
      point, normal, polygon.size(), [&](std::size_t i) -> const Vec3d& { return polygon[i]; },
      plane_slack);
}

double point_to_triangle(const Vec3d& point, const Vec3d& normal,
                         const std::array<Vec3f, 3>& triangle, double plane_slack) {
  const std::array<Vec3d, 3> corners = {to_double(triangle[0]), to_double(triangle[1]),
                                        to_double(triangle[2])};
  return factor(
      point, normal, 3, [&](std::size_t i) -> const Vec3d& { return corners[i]; }, plane_slack);
}

}  // namespace lightbatch::radiosity
