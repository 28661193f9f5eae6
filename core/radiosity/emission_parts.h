#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/math/rgb.h"
#include "core/math/vec.h"
#include "core/optics/optics.h"

namespace lightbatch::radiosity {

/// What a triangle emits, by parts: it is cut in four again and again, measured where it is cut
/// most finely, and put together where that is about even.
class EmissionParts {
 public:
  using Part = std::array<Vec2f, 3>;  // by barycentric places

  /// uneven: how many triangles of the scene are; many share the work that one may have.
  EmissionParts(const optics::Optics& optics, std::uint32_t triangle, std::size_t uneven);

  /// One point does not tell what the triangle emits.
  static bool is_uneven(const optics::Optics& optics, std::uint32_t triangle) {
    return optics.emits(triangle) &&
           (optics.textured_emission(triangle) || optics.covered_in_part(triangle));
  }

  /// Calls visit(part, its mean luminance) for parts that are about even, for the whole if not
  /// `cut`. Parts are equal in area where they are of one level.
  template <typename Visit>
  void for_each(bool cut, const Visit& visit) const {
    visit_even(kWhole, 0, 0, cut, visit);
  }

 private:
  static constexpr Part kWhole{Vec2f{0, 0}, Vec2f{1, 0}, Vec2f{0, 1}};
  static std::array<Part, 4> quarters_of(const Part& part);

  Rgb measure(const Part& part, int level, std::size_t index);
  Rgb mean_of(const Part& part, std::size_t index) const;
  Rgb sampled(const Part& part, int side, Vec2f shift, bool& even) const;
  bool is_even(int level, std::size_t index) const;
  Rgb mean(int level, std::size_t index) const {
    return means_[static_cast<std::size_t>(level)][index];
  }

  template <typename Visit>
  void visit_even(const Part& part, int level, std::size_t index, bool cut,
                  const Visit& visit) const {
    if (!cut || level == levels_ || is_even(level, index)) {
      visit(part, mean(level, index));
      return;
    }
    const std::array<Part, 4> quarters = quarters_of(part);
    for (std::size_t k = 0; k < 4; ++k) {
      visit_even(quarters[k], level + 1, 4 * index + k, cut, visit);
    }
  }

  const optics::Optics& optics_;
  std::uint32_t triangle_;
  int levels_ = 0;
  int most_samples_ = 0;                 // of an uneven part, each way; 0: one point serves
  std::vector<std::vector<Rgb>> means_;  // by level; quarters of a part lie side by side
};

}  // namespace lightbatch::radiosity
