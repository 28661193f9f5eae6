#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "core/rays/caster.h"
#include "tests/bench/bench_rays.h"
#include "tests/bench/bench_scenes.h"

namespace lightbatch::bench {

/// Embree 3 as the distribution packages it, build quality MEDIUM (binned SAH). Test-only.
class EmbreePeer {
 public:
  EmbreePeer(const Scene& scene, int threads, bool robust = false);
  ~EmbreePeer();

  /// Builds anew: rtcCommitScene alone.
  void build();
  double bytes_per_triangle() const;
  /// SAH cost (1, 1) of the binary tree of rtcBuildBVH, leaves of at most 8.
  double sah_cost() const;

  enum class Way { kSingle, kPacket8, kPacket16, kStream };
  /// Number of hits.
  std::size_t cast(const RaySet& set, Way way) const;
  std::uint32_t closest(const rays::Ray& ray, float& t) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace lightbatch::bench
