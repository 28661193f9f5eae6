#pragma once

#include <cstdint>
#include <vector>

#include "core/base/progress.h"
#include "core/radiosity/linked_tree.h"

namespace lightbatch::radiosity {

/// Light on its way from a source node to a receiver node.
struct Link {
  LinkTree::Node receiver = 0;
  LinkTree::Node source = 0;
  /// Between flat nodes: irradiance over radiosity. Else: the share of sight lines that are open,
  /// each weighted by (distance of centres / its length)^2.
  float factor = kUnmeasured;

  static constexpr float kUnmeasured = -2;
  /// Too close for any formula: the receiver's cosine rays tell.
  static constexpr float kNear = -1;
  bool measured() const { return factor >= 0; }
  bool near() const { return factor == kNear; }
};

/// Refines links, starting with the root linked to itself, until the error estimate of each is
/// below the threshold; measures visibility of the new ones by rays.
class Refiner {
 public:
  Refiner(const SolverInput& input, const LinkTree& tree, const SolverOptions& options)
      : input_(input), tree_(tree), options_(options) {}

  /// Judges every link anew with the radiosity that the solution has now. `threshold` is a flux,
  /// lm. Links whose sight is blocked are judged as if it were open, so that none is lost by
  /// chance.
  void refine(const LinkTree::Outgoing& radiosity, double threshold, std::vector<Link>& links,
              RayCounts& counts, const Progress& progress);

 private:
  struct Judgement {
    bool drop = false;  // no light can pass
    bool near = false;
    bool keep = false;
    bool split_receiver = false;
  };
  Judgement judge(LinkTree::Node r, LinkTree::Node s, double threshold) const;
  /// Stops splitting once `out` holds `room` links.
  void descend(const Link& link, double threshold, std::size_t room, std::vector<Link>& out) const;
  void measure(Link& link, RayCounts& counts) const;
  struct Point;
  Point pick(LinkTree::Node n, const Vec3f& towards, bool by_radiosity, double a, float b,
             float c) const;
  bool behind(LinkTree::Node flat, LinkTree::Node other) const;

  const SolverInput& input_;
  const LinkTree& tree_;
  const SolverOptions& options_;
  const LinkTree::Outgoing* radiosity_ = nullptr;
  double ambient_ = 0;
  std::vector<float> deviation_;  // of radiosity within each node
  void measure_deviation();
};

}  // namespace lightbatch::radiosity
