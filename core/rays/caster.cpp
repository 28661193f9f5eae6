#include "core/rays/caster.h"

#include "core/base/check.h"
#include "core/rays/caster_tree.h"

namespace lightbatch::rays {

bool has_avx2() {
#if defined(__x86_64__)
  return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") &&
         __builtin_cpu_supports("bmi") && __builtin_cpu_supports("popcnt");
#else
  return false;
#endif
}

bool has_avx512() {
#if defined(__x86_64__)
  return has_avx2() && __builtin_cpu_supports("bmi2") && __builtin_cpu_supports("avx512f") &&
         __builtin_cpu_supports("avx512vl") && __builtin_cpu_supports("avx512dq") &&
         __builtin_cpu_supports("avx512bw");
#else
  return false;
#endif
}

const Kernel& kernel() {
#if defined(__x86_64__)
  static const Kernel& best = has_avx512() ? avx512_kernel()
                              : has_avx2() ? avx2_kernel()
                                           : baseline_kernel();
  return best;
#else
  return baseline_kernel();
#endif
}

Caster::Caster(const hierarchy::Hierarchy& tree, std::span<const Vec3f> positions,
               std::span<const std::array<std::uint32_t, 3>> triangles,
               std::span<const Surface> surfaces, Grids grids)
    : tree_(new Tree{collapse(tree, positions, triangles, surfaces, grids), &kernel()}) {}
Caster::~Caster() = default;
Caster::Caster(Caster&&) noexcept = default;
Caster& Caster::operator=(Caster&&) noexcept = default;

Hit Caster::closest(const Ray& ray, std::uint32_t exclude, HitFilter* filter) const {
  return tree_->kernel->closest(tree_->wide, ray, exclude, filter);
}

bool Caster::occluded(const Ray& ray, std::uint32_t exclude_a, std::uint32_t exclude_b,
                      HitFilter* filter) const {
  return tree_->kernel->occluded(tree_->wide, ray, exclude_a, exclude_b, filter);
}

void Caster::occluded(std::span<const Segment> segments, std::span<std::uint32_t> stopped) const {
  LB_CHECK(stopped.size() == (segments.size() + kBundle - 1) / kBundle,
           "one word for every 16 segments");
  tree_->kernel->bundles(tree_->wide, segments, stopped);
}

std::span<const GridNode> Caster::grids() const { return tree_->wide.grids; }

const GridNode& Caster::refused_grid() const { return tree_->wide.refused; }

std::size_t Caster::memory_bytes() const { return tree_->wide.memory_bytes(); }

}  // namespace lightbatch::rays
