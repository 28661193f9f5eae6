#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "core/gltf/document.h"
#include "core/pipeline/light_stage.h"
#include "core/pipeline/report_json.h"

namespace lightbatch::pipeline {

/// A light group as report.json tells of it and relight reads it: what a file's light, material or
/// sky was when it was baked.
struct GroupEntry {
  std::string layer;  // in light_groups_K.exr
  std::string kind;   // "light", "material", "sky", "others"
  std::uint32_t index = 0;
  std::string name;
  /// Light: color and intensity (cd or lux); material: emissiveFactor and emissiveStrength; sky:
  /// white and nits, or a factor of the sky's own picture where it has one.
  std::array<double, 3> color{1, 1, 1};
  double intensity = 1;

  /// What light is in proportion to.
  Rgbd light() const { return Rgbd{color[0], color[1], color[2]} * intensity; }
};

/// The file with the layers of a page.
std::string light_groups_file(std::size_t page);

/// The entries of a bake, in the order of its groups; a black sky has none.
std::vector<GroupEntry> group_entries(const JobOptions& options, const Prepared& p,
                                      const std::vector<radiosity::LightGroup>& groups);

Json to_json(const GroupEntry& entry);
/// Nothing where the entry is not of this form.
std::optional<GroupEntry> group_entry(const Json& json);

/// The new values that a relight asks for, into `entries`. `lights`: JSON as in the README,
/// {"lights": {NAME: {...}}, "materials": {NAME: {...}}, "sky": ...}. BAD_OPTION names what is
/// unknown, out of range, or cannot be changed.
Status change_entries(const Json& lights, const std::string& place,
                      std::vector<GroupEntry>& entries);

}  // namespace lightbatch::pipeline
