#include "core/optics/duplicates.h"

#include <algorithm>
#include <array>
#include <tuple>

namespace lightbatch::optics {
namespace {

using Point = std::tuple<float, float, float>;

struct Placed {
  std::array<Point, 3> corner;  // from the least on, so that equal means same place and same facing
  std::uint32_t triangle = 0;
  auto operator<=>(const Placed&) const = default;
};

}  // namespace

std::vector<std::uint32_t> hidden_duplicates(const scene::Scene& scene,
                                             std::span<const std::uint32_t> triangles) {
  std::vector<Placed> placed;
  placed.reserve(triangles.size());
  for (const std::uint32_t t : triangles) {
    Placed p;
    p.triangle = t;
    const auto corners = scene.corners(t);
    for (std::size_t i = 0; i < 3; ++i) {
      p.corner[i] = {corners[i].x, corners[i].y, corners[i].z};
    }
    std::rotate(p.corner.begin(), std::min_element(p.corner.begin(), p.corner.end()),
                p.corner.end());
    placed.push_back(p);
  }
  std::sort(placed.begin(), placed.end());
  std::vector<std::uint32_t> hidden;
  for (std::size_t i = 1; i < placed.size(); ++i) {
    if (placed[i].corner == placed[i - 1].corner) hidden.push_back(placed[i].triangle);
  }
  std::sort(hidden.begin(), hidden.end());
  return hidden;
}

}  // namespace lightbatch::optics
