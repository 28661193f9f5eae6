#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/lightmap/bake.h"
#include "core/lightmap/blocks.h"
#include "core/lightmap/dim.h"
#include "core/lightmap/smooth.h"

namespace lightbatch::lightmap {

/// What is there of a texel's light from the hemisphere.
enum class TexelState : std::uint8_t { kUnknown, kRequested, kComputed, kShared };

/// What gathering works on, per texel.
struct GatheredMap {
  GatheredMap(std::size_t texels, std::size_t groups)
      : by_group(groups == 0 ? 0 : texels, groups), texel(texels), state(texels) {}

  bool is_computed(std::uint32_t t) const { return state[t] == TexelState::kComputed; }
  bool is_shared(std::uint32_t t) const { return state[t] == TexelState::kShared; }
  /// Computed or shared.
  bool is_known(std::size_t t) const { return state[t] >= TexelState::kComputed; }

  radiosity::GroupedLight by_group;
  std::vector<GatheredTexel> texel;
  std::vector<TexelState> state;
};

/// Blocks of texels whose light is told by that of their corners and their middle.
class SharedBlocks {
 public:
  SharedBlocks(const BakeInput& input, const GatherSettings& settings, const DimShares& dim,
               GatheredMap& map)
      : input_(input), settings_(settings), dim_(dim), map_(map) {}

  /// visit(texel): those that tell whether a block can be shared; kNone where none is.
  template <typename Visit>
  void for_each_asked(const Block& b, Visit visit) const {
    for (const std::uint32_t t : corners(b)) visit(t);
    const Place m = middle(b);
    visit(m.texel);
    if (is_strip(b)) visit(opposite(b, m).texel);
  }
  /// Whether what is between the corners follows from them. All asked texels are computed or
  /// shared.
  bool is_predicted(const Block& b) const;
  /// Gives a block's texels that are not computed their share.
  void fill(const Block& b);
  /// Takes that back.
  void clear(const Block& b);
  /// Adds a block's (up to) four parts; `next` gets none of a block that is but a square of texels.
  static void cut(const Block& b, std::vector<Block>& next);

 private:
  struct Place {
    int x = 0, y = 0;
    std::uint32_t texel = 0;
  };

  /// Two rows of texels, both borders: neither tells of the other.
  static bool is_strip(const Block& b) { return (b.x1 - b.x0 == 1) != (b.y1 - b.y0 == 1); }

  Place place(const Block& b, int x, int y) const;
  std::array<std::uint32_t, 4> corners(const Block& b) const;
  /// Of a strip: in the row that tells something.
  Place middle(const Block& b) const;
  /// In the strip's other row.
  Place opposite(const Block& b, const Place& middle) const;
  bool follows(const Block& b, const std::array<std::uint32_t, 4>& corner, const Place& at) const;

  const BakeInput& input_;
  const GatherSettings& settings_;
  const DimShares& dim_;
  GatheredMap& map_;
};

}  // namespace lightbatch::lightmap
