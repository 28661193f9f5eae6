#include "core/atlas/split.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/atlas/border.h"
#include "core/atlas/grid.h"

namespace lightbatch::atlas {
namespace {

using scene::kNone;

class Splitter {
 public:
  Splitter(const Mesh& mesh, double density, int max_side, ChartSet& set)
      : mesh_(mesh), density_(density), max_side_(max_side), set_(set) {}

  void run() {
    for (std::uint32_t c = 0; c < set_.charts.size(); ++c) {  // grows while it runs
      while (cut_wide(c)) {
      }
      if (c < first_new_ + kMaxPeels) peel(c);
    }
  }

 private:
  /// Chart numbers beyond the first by which peeling gives up: only endless spirals get there.
  static constexpr std::uint32_t kMaxPeels = 1u << 16;

  /// The chart keeps `stay`; the connected parts of `leave` become charts of their own.
  void divide(std::uint32_t chart, std::vector<std::uint32_t> stay,
              const std::vector<std::uint32_t>& leave) {
    constexpr std::uint32_t kLeaving = kNone - 1;
    for (const std::uint32_t t : leave) set_.of[t] = kLeaving;
    std::vector<std::vector<std::uint32_t>> parts;
    const std::uint32_t next = static_cast<std::uint32_t>(set_.charts.size());
    for (const std::uint32_t seed : leave) {
      if (set_.of[seed] != kLeaving) continue;
      const std::uint32_t id = next + static_cast<std::uint32_t>(parts.size());
      std::vector<std::uint32_t> part{seed};
      set_.of[seed] = id;
      for (std::size_t head = 0; head < part.size(); ++head) {
        for (std::uint32_t k = 0; k < 3; ++k) {
          const std::uint32_t twin = mesh_.twin[3 * part[head] + k];
          if (twin == kNone || set_.of[twin / 3] != kLeaving) continue;
          set_.of[twin / 3] = id;
          part.push_back(twin / 3);
        }
      }
      std::sort(part.begin(), part.end());
      parts.push_back(std::move(part));
    }
    std::sort(stay.begin(), stay.end());
    const Vec3d axis = set_.charts[chart].axis;
    set_.charts[chart] = project_chart(mesh_, std::move(stay), axis, set_.of, scratch_);
    for (auto& part : parts) {
      set_.charts.push_back(project_chart(mesh_, std::move(part), axis, set_.of, scratch_));
    }
  }

  /// Halves a chart that is wider than a page across its longer side, between triangles.
  bool cut_wide(std::uint32_t c) {
    const FlatChart& chart = set_.charts[c];
    const double limit = max_side_ - 1;
    const bool across_u = chart.width >= chart.height;
    const double size = across_u ? chart.width : chart.height;
    if (size * density_ <= limit || chart.triangles.size() < 2) return false;
    std::vector<std::uint32_t> low, high;
    double widest = 0;
    for (const std::uint32_t t : chart.triangles) {
      double from = std::numeric_limits<double>::infinity(), to = -from;
      for (const std::uint32_t p : mesh_.corners[t]) {
        const Vec2d q = chart.map(mesh_.points[p]);
        from = std::min(from, across_u ? q.x : q.y);
        to = std::max(to, across_u ? q.x : q.y);
      }
      widest = std::max(widest, to - from);
      (from + to < size ? low : high).push_back(t);
    }
    // A triangle that fills the page by itself would be squeezed all the same.
    if (widest > 0.6 * size || low.empty() || high.empty()) return false;
    divide(c, std::move(low), high);
    return true;
  }

  GridTriangle grid_triangle(const FlatChart& chart, const Vec2d& scale, std::uint32_t t) const {
    GridTriangle g;
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec2d p = chart.map(mesh_.points[mesh_.corners[t][k]]);
      g[k] = {static_cast<std::int32_t>(std::lround(p.x * scale.x * kUnits)),
              static_cast<std::int32_t>(std::lround(p.y * scale.y * kUnits))};
    }
    return g;
  }

  /// Triangles in connected order from the largest one.
  std::vector<std::uint32_t> walk(const FlatChart& chart) {
    const std::uint32_t id = set_.of[chart.triangles[0]];
    std::vector<std::uint32_t> seeds = chart.triangles;
    std::sort(seeds.begin(), seeds.end(), [&](std::uint32_t a, std::uint32_t b) {
      return mesh_.areas[a] != mesh_.areas[b] ? mesh_.areas[a] > mesh_.areas[b] : a < b;
    });
    seen_.resize(mesh_.size(), false);
    std::vector<std::uint32_t> order;
    for (const std::uint32_t seed : seeds) {
      if (seen_[seed]) continue;
      seen_[seed] = true;
      order.push_back(seed);
      for (std::size_t head = order.size() - 1; head < order.size(); ++head) {
        for (std::uint32_t k = 0; k < 3; ++k) {
          const std::uint32_t twin = mesh_.twin[3 * order[head] + k];
          if (twin == kNone || set_.of[twin / 3] != id || seen_[twin / 3]) continue;
          seen_[twin / 3] = true;
          order.push_back(twin / 3);
        }
      }
    }
    for (const std::uint32_t t : order) seen_[t] = false;
    return order;
  }

  void peel(std::uint32_t c) {
    const FlatChart& chart = set_.charts[c];
    const Vec2d scale = chart_scale(chart, density_, max_side_);
    if (!border_overlaps(mesh_, chart, set_.of, scale)) return;
    constexpr std::int32_t kStep = kUnits / 2;
    const std::size_t stride = static_cast<std::size_t>(chart.width * scale.x * 2) + 2;
    const std::size_t rows = static_cast<std::size_t>(chart.height * scale.y * 2) + 2;
    std::vector<bool> covered(stride * rows, false);
    std::vector<std::uint32_t> stay, leave;
    for (const std::uint32_t t : walk(chart)) {
      const GridTriangle g = grid_triangle(chart, scale, t);
      bool hit = false;
      const auto each = [&](auto&& visit) {
        sample_spans(g, kStep, [&](std::int64_t row, std::int64_t first, std::int64_t last) {
          const std::int64_t base = row * static_cast<std::int64_t>(stride);
          for (std::int64_t i = first; i <= last; ++i) visit(static_cast<std::size_t>(base + i));
        });
      };
      each([&](std::size_t at) { hit = hit || covered[at]; });
      if (hit) {
        leave.push_back(t);
        continue;
      }
      each([&](std::size_t at) { covered[at] = true; });
      stay.push_back(t);
    }
    if (!leave.empty()) divide(c, std::move(stay), leave);
  }

  const Mesh& mesh_;
  const double density_;
  const int max_side_;
  ChartSet& set_;
  const std::uint32_t first_new_ = static_cast<std::uint32_t>(set_.charts.size());
  ProjectScratch scratch_;
  std::vector<bool> seen_;  // all false between walks
};

}  // namespace

Vec2d chart_scale(const FlatChart& chart, double density, int max_side) {
  const double limit = max_side - 1;
  return {chart.width * density > limit ? limit / chart.width : density,
          chart.height * density > limit ? limit / chart.height : density};
}

void split_charts(const Mesh& mesh, double density, int max_side, ChartSet& set) {
  Splitter(mesh, density, max_side, set).run();
}

}  // namespace lightbatch::atlas
