#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/lightmap/borders.h"
#include "core/lightmap/pages.h"

namespace lightbatch::lightmap {

/// Makes charts that meet on one surface show the same light along their border. A linear map of
/// page values, made once, so that pages by light group still add up to the whole.
class Stitches {
 public:
  Stitches() = default;
  /// pages: all light, gutters filled. allowed: lux; texels are changed by no more than this in the
  /// root mean square over the covered area, so that where texels are too coarse for the light
  /// steps stay rather than errors grow. Nothing is carried over a border from light into darkness.
  Stitches(const atlas::Layout& layout, const Borders& borders, const std::vector<PageImage>& pages,
           double allowed);

  /// pages: of the same layout, gutters filled. The same bytes on any number of threads.
  void apply(std::vector<PageImage>& pages) const;

 private:
  /// The difference of two bilinear look-ups.
  struct Row {
    std::array<std::uint32_t, 8> pixel{};  // into held_
    std::array<float, 8> weight{};
    double texels = 0;  // of border that it stands for
  };
  struct Place {
    std::uint32_t page = 0;
    std::size_t at = 0;
  };
  using Light = std::vector<Rgbd>;

  void add_row(const atlas::Layout& layout, const BorderPoint& point,
               const std::vector<PageImage>& pages, std::vector<std::vector<std::uint32_t>>& known);
  void index_uses();
  /// Firmness of covered texels, against an agreement along a texel of border.
  void hold_covered(double firmness);
  Light values_of(const std::vector<PageImage>& pages) const;
  Light changes(const Light& values) const;
  Light difference(const Light& values) const;
  Light spread(const Light& differences) const;
  Light times_matrix(const Light& x) const;

  std::vector<Row> rows_;
  std::vector<Place> held_;      // the pixels that rows read
  std::vector<float> coverage_;  // of each
  std::vector<double> hold_;     // how firmly each keeps its value
  std::vector<double> diagonal_;
  std::vector<std::uint32_t> first_use_, use_;  // of each pixel: rows times 8 plus place
};

}  // namespace lightbatch::lightmap
