#include "core/atlas/density.h"

#include <cmath>

#include "core/base/parallel.h"

namespace lightbatch::atlas {

double ChartedShape::area() const {
  double sum = 0;
  for (const double a : mesh.areas) sum += a;
  double uses_sum = 0;
  for (const Instance& i : shape.instances) uses_sum += i.scale * i.scale;
  return sum * uses_sum;
}

std::vector<ChartedShape::Use> group_by_scale(const Shape& shape) {
  std::vector<ChartedShape::Use> uses;
  for (std::uint32_t i = 0; i < shape.instances.size(); ++i) {
    const double scale = shape.instances[i].scale;
    ChartedShape::Use* found = nullptr;
    for (ChartedShape::Use& use : uses) {
      if (std::abs(use.scale / scale - 1) < 1e-3) {
        found = &use;
        break;
      }
    }
    if (found == nullptr) found = &uses.emplace_back(ChartedShape::Use{scale, {}});
    found->instances.push_back(i);
  }
  return uses;
}

double texels_estimate(const std::vector<ChartedShape>& shapes, double density, int max_side) {
  constexpr double kFill = 0.93;  // of silhouettes, packed
  const double sum = deterministic_reduce(
      shapes.size(), 16, 0.0,
      [&](std::size_t begin, std::size_t end) {
        double part = 0;
        for (std::size_t s = begin; s < end; ++s) {
          for (const ChartedShape::Use& use : shapes[s].uses) {
            double once = 0;
            for (const FlatChart& chart : shapes[s].charts.charts) {
              once += footprint_estimate(chart, density * use.scale, max_side);
            }
            part += once * static_cast<double>(use.instances.size());
          }
        }
        return part;
      },
      [](double a, double b) { return a + b; });
  return sum / kFill;
}

double solve_density(const std::vector<ChartedShape>& shapes, double texels, double highest,
                     int max_side) {
  if (texels_estimate(shapes, highest, max_side) <= texels) return highest;
  double low = highest * 1e-9, high = highest;
  constexpr double kTolerance = 1e-3;
  while (high > low * (1 + kTolerance)) {
    const double middle = std::sqrt(low * high);
    (texels_estimate(shapes, middle, max_side) <= texels ? low : high) = middle;
  }
  return low;
}

}  // namespace lightbatch::atlas
