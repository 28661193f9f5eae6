#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "core/math/rgb.h"

namespace lightbatch::radiosity {

/// What changes together when a bake is relit: light is linear in its sources, so that the part of
/// each group, scaled, is the part of the changed group.
struct LightGroup {
  enum class Kind {
    kPunctual,  // one definition of KHR_lights_punctual, however many nodes it hangs on
    kEmitter,   // one material that emits
    kSky,
    kOthers,  // punctual lights and emitters beyond kMostGroups; they cannot be changed one by one
  };
  Kind kind = Kind::kOthers;
  std::uint32_t index = 0;  // glTF light or material
  std::string name;
  Rgb baked;  // cd, lux or nits; the sky and the others: 1
};

/// Groups of a scene, the sky included; the strongest get one of their own.
constexpr std::size_t kMostGroups = 16;

/// Sources on their way into groups.
class Grouping {
 public:
  /// The provisional number of a source's group; power in any unit, summed up over its sources.
  std::uint32_t add(const LightGroup& group, double power);
  struct Groups {
    std::vector<LightGroup> groups;       // kMostGroups - 1 at most
    std::vector<std::uint32_t> renumber;  // of each provisional number
  };
  Groups finish() const;

 private:
  std::vector<LightGroup> groups_;
  std::vector<double> power_;
  std::map<std::pair<LightGroup::Kind, std::uint32_t>, std::uint32_t> number_;
};

/// Light of many items (elements, texels) by group, or nothing at all.
class GroupedLight {
 public:
  GroupedLight() = default;
  GroupedLight(std::size_t items, std::size_t groups) : groups_(groups), light_(items * groups) {}

  std::size_t groups() const { return groups_; }
  bool is_empty() const { return groups_ == 0; }
  /// One value a group; empty when there are none.
  std::span<Rgb> of(std::size_t item) { return std::span(light_).subspan(item * groups_, groups_); }
  std::span<const Rgb> of(std::size_t item) const {
    return std::span(light_).subspan(item * groups_, groups_);
  }
  GroupedLight& operator+=(const GroupedLight& o) {
    for (std::size_t i = 0; i < light_.size(); ++i) light_[i] += o.light_[i];
    return *this;
  }
  std::uint64_t memory_bytes() const { return light_.capacity() * sizeof(Rgb); }

 private:
  std::size_t groups_ = 0;
  std::vector<Rgb> light_;
};

}  // namespace lightbatch::radiosity
