#include "core/atlas/border.h"

#include <algorithm>
#include <cmath>
#include <tuple>
#include <vector>

namespace lightbatch::atlas {
namespace {

struct Crossing {
  std::int32_t row = 0;
  std::int32_t turn = 0;  // layers gained when crossed towards +x
  double x = 0;
};

constexpr double kRowsPerTexel = 2;
constexpr double kNarrow = 0.25;  // texels

void add_crossings(const Vec2d& a, const Vec2d& b, std::vector<Crossing>& crossings) {
  const double ya = a.y * kRowsPerTexel - 0.5, yb = b.y * kRowsPerTexel - 0.5;
  const double low = std::ceil(std::min(ya, yb)), high = std::ceil(std::max(ya, yb));
  for (double row = low; row < high; ++row) {
    const double x = a.x + (b.x - a.x) * ((row - ya) / (yb - ya));
    crossings.push_back({static_cast<std::int32_t>(row), ya > yb ? 1 : -1, x});
  }
}

}  // namespace

bool border_overlaps(const Mesh& mesh, const FlatChart& chart,
                     std::span<const std::uint32_t> chart_of, const Vec2d& scale) {
  if (chart.triangles.size() <= 2) return false;
  if (chart.width * scale.x < 1 && chart.height * scale.y < 1) return false;
  std::vector<Crossing> crossings;
  for (const std::uint32_t t : chart.triangles) {
    for (std::uint32_t k = 0; k < 3; ++k) {
      const std::uint32_t twin = mesh.twin[3 * t + k];
      if (twin != scene::kNone && chart_of[twin / 3] == chart_of[t]) continue;
      const Vec2d a = chart.map(mesh.points[mesh.corners[t][k]]);
      const Vec2d b = chart.map(mesh.points[mesh.corners[t][(k + 1) % 3]]);
      add_crossings({a.x * scale.x, a.y * scale.y}, {b.x * scale.x, b.y * scale.y}, crossings);
    }
  }
  std::sort(crossings.begin(), crossings.end(), [](const Crossing& a, const Crossing& b) {
    return std::tie(a.row, a.x, a.turn) < std::tie(b.row, b.x, b.turn);
  });
  int layers = 0;
  for (std::size_t i = 0; i + 1 < crossings.size(); ++i) {
    layers += crossings[i].turn;
    if (layers > 1 && crossings[i + 1].row == crossings[i].row &&
        crossings[i + 1].x - crossings[i].x > kNarrow) {
      return true;
    }
  }
  return false;
}

}  // namespace lightbatch::atlas
