#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/math/rgb.h"
#include "core/math/vec.h"
#include "core/optics/optics.h"

namespace lightbatch::radiosity {

/// What a triangle emits, by parts: it is cut in four again and again, measured where it is cut
/// most finely, and put together where that is about even. What holds much of its light in a small
/// part is cut on.
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
    if (!cut) {
      visit(kWhole, mean(0, 0));
      return;
    }
    for (const Measured& m : parts_) visit(m.part, m.mean);
  }

 private:
  static constexpr Part kWhole{Vec2f{0, 0}, Vec2f{1, 0}, Vec2f{0, 1}};
  static std::array<Part, 4> quarters_of(const Part& part);

  struct Measured {
    Part part;
    Rgb mean;
    float range = 0;  // largest channel's, over the samples
    int level = 0;
  };

  Rgb measure(const Part& part, int level, std::size_t index);
  Measured mean_of(const Part& part, int level, std::size_t index) const;
  Measured sampled(const Part& part, int side, Vec2f shift) const;
  void find_even(const Part& part, int level, std::size_t index);
  /// Cuts the finest parts on where they hold much.
  void cut_on();
  bool is_even(int level, std::size_t index) const;
  float slack(int level) const;
  Rgb mean(int level, std::size_t index) const {
    return means_[static_cast<std::size_t>(level)][index];
  }

  const optics::Optics& optics_;
  std::uint32_t triangle_;
  int levels_ = 0;
  double texels_ = 0;
  double samples_ = 0;                   // that the triangle may have
  int most_samples_ = 0;                 // of an uneven part, each way; 0: one point serves
  std::vector<std::vector<Rgb>> means_;  // by level; quarters of a part lie side by side
  std::vector<float> range_;             // of the finest
  std::vector<Measured> parts_;
};

}  // namespace lightbatch::radiosity
