#pragma once

#include <atomic>
#include <cstdint>
#include <span>
#include <vector>

#include "core/lightmap/bake.h"
#include "core/lightmap/smooth.h"

namespace lightbatch::lightmap {

/// What a texel's irradiance from the hemisphere takes of another texel's.
struct NearLink {
  std::uint32_t texel = 0;
  Rgb weight;
};

/// The texels that rays land on near by, where elements are too coarse to be read. Until their
/// light is known, the first stage stands for it. Thread-safe.
class NearTexels {
 public:
  /// nearest: of a texel's size; what is hit nearer than that differs within a texel.
  NearTexels(const BakeInput& input, double nearest);

  /// The texel that holds the light of the side that was hit; kNone where there is none, where it
  /// is too near or no finer than the element, of `size` metres, or where it lies on both sides of
  /// something that stands on it, half in another room.
  std::uint32_t at(const rays::Hit& hit, float distance, float size) const;
  /// Indirect irradiance of a texel as the first stage has it, lux.
  const std::vector<Rgb>& first() const { return first_; }

 private:
  bool is_whole(std::uint32_t texel) const;
  /// Nothing but the chart's own surface, which may be curved, stands between two points of it.
  bool is_connected(const radiosity::Receiver& a, const radiosity::Receiver& b,
                    std::uint32_t chart) const;

  const BakeInput& input_;
  float nearest_ = 0;
  /// What is_whole found, so that only texels that are hit are looked at: always the same,
  /// whichever thread is first.
  enum Whole : std::uint8_t { kNotAsked, kYes, kNo };
  mutable std::vector<std::atomic<std::uint8_t>> whole_;
  std::vector<float> size_;  // of the texels' surface, metres
  std::vector<Rgb> first_;
};

/// Links of all gathered texels, and the light that they carry.
class NearLinks {
 public:
  explicit NearLinks(std::size_t texels) : row_(texels) {}

  /// Sorted, one link to a texel.
  static void merge(std::vector<NearLink>& links);

  /// Links of texels in turn: counts[i] of texels[i], one after another in `links`, which are kept
  /// where they are: a map may have gigabytes of them.
  void add(std::span<const std::uint32_t> texels, std::span<const std::uint32_t> counts,
           std::vector<NearLink> links);

  /// visit(link), in the order of adding.
  template <typename Visit>
  void for_each(Visit visit) const {
    for (const auto& links : links_) {
      for (const NearLink& link : links) visit(link);
    }
  }

  /// What texels hold before the light of those that they are linked to is known.
  struct Start {
    std::vector<Rgb> irradiance;
    radiosity::GroupedLight by_group;
  };

  /// Puts the light of the linked texels in the place of what the first stage had of it, for all
  /// of them at once, by iteration (Jacobi). known: texels whose light is there. fill(): brings
  /// what is shared between gathered texels up to date. by_group gets the linked light; it holds
  /// nothing of what the first stage had, nor of texels that are not known.
  template <typename Fill>
  void solve(const std::vector<Rgb>& first, const std::vector<std::uint8_t>& known,
             const Start& start, std::vector<GatheredTexel>& texels,
             radiosity::GroupedLight& by_group, Fill fill) const {
    if (links_.empty()) return;
    for (int i = 0; i < kMostIterations; ++i) {
      const double change = iterate(first, known, start, texels, by_group);
      fill();
      if (change < kTolerance) break;
    }
  }

  /// One texel's light as that of the texels that it is linked to makes it.
  Rgb linked(std::size_t t, const std::vector<Rgb>& first, const std::vector<std::uint8_t>& known,
             const Start& start, const std::vector<GatheredTexel>& texels) const;

 private:
  static constexpr int kMostIterations = 50;
  /// Change of an iteration, that of every group included, over the light; roots of mean squares.
  static constexpr double kTolerance = 1e-4;

  double iterate(const std::vector<Rgb>& first, const std::vector<std::uint8_t>& known,
                 const Start& start, std::vector<GatheredTexel>& texels,
                 radiosity::GroupedLight& by_group) const;

  std::vector<std::span<const NearLink>> row_;
  std::vector<std::vector<NearLink>> links_;
};

}  // namespace lightbatch::lightmap
