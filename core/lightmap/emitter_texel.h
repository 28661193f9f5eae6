#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include "core/lightmap/bake.h"
#include "core/lightmap/texel_points.h"

namespace lightbatch::lightmap {

/// How a texel sees one source of emitted light: a lamp, or a node of the emitter tree that holds
/// several.
struct SourceState {
  enum State : std::uint32_t { kDark, kLit, kMixed };
  std::uint32_t source : 30;
  std::uint32_t state : 2;
};

/// The states to refine a texel with: a source is mixed where the texel's own pilot, or that of a
/// neighbour, saw it in part, and where the two differ. All by source, in order.
std::vector<SourceState> doubtful_states(std::span<const SourceState> own,
                                         std::span<const std::span<const SourceState>> neighbours);

/// Emitters' light at a texel.
struct EmitterPart {
  Rgb arrives;
  Rgb open;          // without shadows
  float slack = 0;   // of the visible share: three standard errors, about
  float uneven = 0;  // lux: range over the points of the texel, shadows' edges apart
};

/// Measures emitters' light at texels. Unoccluded irradiance is exact at each point (polygons,
/// formulas), only visibility is sampled, each source's by itself: rays go where a source is seen
/// in part, and none to lamps that are wholly seen or, as those of other rooms, wholly hidden.
/// Holds scratch memory: one for each thread.
class EmitterTexel {
 public:
  EmitterTexel(const BakeInput& input, const GatherSettings& settings);

  /// Share of the allowed error that the next texel may be off by.
  void allow(double share);

  /// A few rays to every source that matters, more where `thorough`. states: gets how these are
  /// seen; by_group: what arrives from each light group, empty: not asked.
  EmitterPart pilot(std::uint32_t t, bool thorough, std::vector<SourceState>& states,
                    std::span<Rgb> by_group, BakeCounts& counts);

  /// Whether the pilot's answer will not do.
  bool is_to_be_refined(const EmitterPart& pilot, std::span<const SourceState> states) const;

  /// As many rays to mixed sources as the allowed error asks for, as many points as uneven light
  /// does; sources that are known to be dark or lit get no ray.
  EmitterPart refined(std::uint32_t t, const EmitterPart& pilot,
                      std::span<const SourceState> states, std::span<Rgb> by_group,
                      BakeCounts& counts);

 private:
  /// A square of the share of one of the texel's points. Light of emitters that are not close is
  /// that of the whole share, however often it is cut.
  struct Cell {
    std::uint32_t point = 0;
    Vec2f low;  // of [0, 1)^2
    float edge = 1;
    float share = 0;  // of the texel
    float far = 0;    // light without shadows in its middle, summed over channels: of others than
    float light = 0;  // the close emitters; of all
    float most = 0;   // that the close emitters may bring to a part of it
    float doubt = 0;  // how far its middle may be off its mean, times the share
    bool cut = false;

    /// What the close emitters may bring beside what its middle sees.
    float unseen() const { return std::max(0.0f, most - light); }
  };
  /// A term in the middle of a cell, times its share.
  struct Record {
    radiosity::EmitterTerms::Term term;
    std::uint32_t cell;
  };
  struct Sums;

  /// A point of a cell.
  radiosity::Receiver receiver(const Cell& cell, Vec2f within);
  /// Sets the light of a point's whole share and appends its terms to the records.
  void add_terms(std::uint32_t t, std::uint32_t cell, float turn, BakeCounts& counts);
  /// The same of a part of it, for the close emitters alone.
  void add_close_terms(std::uint32_t cell, BakeCounts& counts);
  void add_record(radiosity::EmitterTerms::Term term, std::uint32_t cell);
  /// What the close emitters may bring to a part of the cell, channel sum: each all of its light,
  /// if it comes nearer than the cell is large.
  float most_of_close(const Cell& cell, const radiosity::Receiver& middle) const;
  std::span<const std::uint32_t> close_to(const Cell& cell) const;
  /// Cells at the texel's first `points` points.
  void start(std::uint32_t t, std::uint32_t points, BakeCounts& counts);
  /// Cuts cells until their middles tell the mean of light that is uneven.
  void cut(BakeCounts& counts);
  void sort_records();
  EmitterPart measure(std::uint32_t t, int fewest_rays, std::span<const SourceState> known,
                      std::vector<SourceState>* states, std::span<Rgb> by_group,
                      BakeCounts& counts);
  radiosity::VisibilitySum cast(std::uint32_t t, std::span<const Record> records, int rays,
                                BakeCounts& counts);
  int rays_for_edge(double light, std::size_t edges) const;

  const BakeInput& input_;
  const GatherSettings& settings_;
  Receivers receivers_;
  double allowed_ = 0;     // lux that visibility may be off by
  double negligible_ = 0;  // lux of a source that is not worth a ray of its own
  TexelPoints grid_;
  std::vector<Cell> cells_;
  radiosity::EmitterTerms terms_;
  std::vector<Record> records_, weak_;
  std::vector<std::uint32_t> close_, close_begin_;  // emitters, by point
  std::vector<float> up_to_, light_at_;
};

}  // namespace lightbatch::lightmap
