#pragma once

#include <vector>

#include "core/batches/assignment.h"
#include "core/batches/fates.h"
#include "core/batches/instance_cuts.h"
#include "core/batches/key_cuts.h"
#include "core/batches/measure.h"
#include "core/hierarchy/hierarchy.h"

namespace lightbatch::batches {

/// What is planned, whatever is copied and at whatever prices.
struct Subject {
  const scene::Scene& scene;
  const hierarchy::Hierarchy& tree;
  const BatchOptions& options;
  const KeyMap& keys;
  const ViewDistribution& views;
  Prices prices;  // the profile's
  std::uint32_t max_vertices = 0;
};

/// us; at this price nothing is split any more.
inline constexpr double kDearestDraw = 1e7;

/// Draws of a view from inside, by the model.
double expected_inside_draws(const std::vector<DrawItem>& draws, const ViewDistribution& views);

/// All that is cut, once it is decided what is copied.
class Problem {
 public:
  Problem(const Subject& subject, Fates fates);

  /// The frame of the cheapest cuts, without what is left alone.
  Frame solve(const Prices& prices) const;
  /// The least price of a draw (the others are the profile's) at which views from inside draw at
  /// most `limit` times, within 2 %. When nothing reaches that, the price at which nothing changes
  /// any more.
  Prices least_prices(double limit) const;
  /// What views from inside draw at least, however dear a draw is.
  double fewest_inside_draws() const;
  /// The batches and cells that are cheapest at these prices, and what is left alone.
  void fill(const Prices& prices, BatchPlan& result) const;

  const Fates& fates() const { return fates_; }
  const KeyCuts& merged() const { return cuts_; }

 private:
  const Subject& subject_;
  Fates fates_;
  std::vector<bool> is_merged_;  // by triangle
  KeyCuts cuts_;
  std::vector<InstanceCuts> instanced_;
  double left_inside_draws_ = 0;
};

}  // namespace lightbatch::batches
