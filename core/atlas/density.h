#pragma once

#include <cstdint>
#include <vector>

#include "core/atlas/shapes.h"
#include "core/atlas/split.h"

namespace lightbatch::atlas {

/// A shape with its charts, and its instances grouped by size: those of one size share texel work.
struct ChartedShape {
  struct Use {
    double scale = 1;
    std::vector<std::uint32_t> instances;  // into shape.instances
  };
  Shape shape;
  Mesh mesh;
  ChartSet charts;
  std::vector<Use> uses;

  double area() const;  // of all instances together, m2
};

/// Groups the instances whose scales agree to 0.1 %.
std::vector<ChartedShape::Use> group_by_scale(const Shape& shape);

/// Texels of all pages to expect at a density. Grows with the density like a d^2 + b d + charts.
double texels_estimate(const std::vector<ChartedShape>& shapes, double density, int max_side);

/// The density at which about `texels` are expected; at most `highest`.
double solve_density(const std::vector<ChartedShape>& shapes, double texels, double highest,
                     int max_side);

}  // namespace lightbatch::atlas
