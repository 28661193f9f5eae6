#include "core/pipeline/light_groups_json.h"

#include <cmath>

namespace lightbatch::pipeline {
namespace {

using radiosity::LightGroup;

/// Of light; as scene_in bounds it.
constexpr double kMostIntensity = 1e30;

const char* kind_of(LightGroup::Kind kind) {
  switch (kind) {
    case LightGroup::Kind::kPunctual:
      return "light";
    case LightGroup::Kind::kEmitter:
      return "material";
    case LightGroup::Kind::kSky:
      return "sky";
    case LightGroup::Kind::kOthers:
      return "others";
  }
  return "others";
}

/// Three numbers of at least 0; false where there are others.
bool read_color(const Json& json, std::array<double, 3>& color, double most) {
  if (!json.is_array() || json.size() != 3) return false;
  for (std::size_t k = 0; k < 3; ++k) {
    if (!json[k].is_number()) return false;
    color[k] = json[k].get<double>();
    if (!(color[k] >= 0 && color[k] <= most)) return false;
  }
  return true;
}

bool read_intensity(const Json& json, double& intensity) {
  if (!json.is_number()) return false;
  intensity = json.get<double>();
  return intensity >= 0 && intensity <= kMostIntensity;
}

/// The fields' own names for colour and intensity.
struct Fields {
  const char* color;
  const char* intensity;
};
constexpr Fields kLightFields{"color", "intensity"};
constexpr Fields kMaterialFields{"emissiveFactor", "emissiveStrength"};

Status change_one(const Json& values, const std::string& place, const Fields& fields,
                  GroupEntry& entry) {
  if (!values.is_object()) return bad_option(place + ": an object is wanted");
  for (const auto& [key, value] : values.items()) {
    if (key == fields.color) {
      if (!read_color(value, entry.color, 1)) {
        return bad_option(place + "/" + key + ": three numbers from 0 to 1 are wanted");
      }
    } else if (key == fields.intensity) {
      if (!read_intensity(value, entry.intensity)) {
        return bad_option(place + "/" + key + ": a number of at least 0 is wanted");
      }
    } else {
      return bad_option(place + "/" + key + ": there is no such field; " + fields.color + " and " +
                        fields.intensity + " can change");
    }
  }
  return {};
}

Status change_named(const Json& by_name, const std::string& place, const std::string& kind,
                    const Fields& fields, std::vector<GroupEntry>& entries) {
  if (!by_name.is_object()) return bad_option(place + ": an object with names is wanted");
  for (const auto& [name, values] : by_name.items()) {
    bool found = false;
    std::string known;
    for (GroupEntry& entry : entries) {
      if (entry.kind != kind) continue;
      if (!known.empty()) known.append(", ");
      if (!entry.name.empty()) known.append(entry.name).append(" or ");
      known.append(std::to_string(entry.index));
      if (entry.name != name && std::to_string(entry.index) != name) continue;
      found = true;
      LB_RETURN_IF_ERROR(change_one(values, place + "/" + name, fields, entry));
    }
    if (found) continue;
    return bad_option(place + "/" + name + ": the bake keeps no " + kind + " of this name apart; " +
                      (known.empty() ? "it keeps none" : "it keeps " + known));
  }
  return {};
}

Status change_sky(const Json& value, const std::string& place, std::vector<GroupEntry>& entries) {
  for (GroupEntry& entry : entries) {
    if (entry.kind != "sky") continue;
    if (value.is_array()) {
      entry.intensity = 1;
      if (read_color(value, entry.color, kMostIntensity)) return {};
    } else if (read_intensity(value, entry.intensity)) {
      entry.color = {1, 1, 1};
      return {};
    }
    return bad_option(place + ": a number of at least 0, or three, is wanted");
  }
  return bad_option(place + ": the scene was baked without a sky");
}

}  // namespace

std::string light_groups_file(std::size_t page) {
  return "light_groups_" + std::to_string(page) + ".exr";
}

std::vector<GroupEntry> group_entries(const JobOptions& options, const Prepared& p,
                                      const std::vector<LightGroup>& groups) {
  std::vector<GroupEntry> entries;
  for (const LightGroup& group : groups) {
    GroupEntry entry;
    entry.kind = kind_of(group.kind);
    entry.index = group.index;
    entry.name = group.name;
    entry.layer = entry.kind;
    const bool numbered =
        group.kind == LightGroup::Kind::kPunctual || group.kind == LightGroup::Kind::kEmitter;
    if (numbered) entry.layer.append("_").append(std::to_string(group.index));
    if (numbered) {
      // The strength is the largest channel, as far as the colour's range of 1 asks for it.
      const Rgbd baked = to_double(group.baked);
      entry.intensity =
          group.kind == LightGroup::Kind::kPunctual ? baked.max() : std::max(1.0, baked.max());
      if (entry.intensity > 0) {
        entry.color = {baked.r / entry.intensity, baked.g / entry.intensity,
                       baked.b / entry.intensity};
      }
    } else if (group.kind == LightGroup::Kind::kSky) {
      if (p.whole_sky.is_black()) continue;
      if (options.sky_file.empty()) entry.intensity = options.sky_nits;
    }
    entries.push_back(std::move(entry));
  }
  return entries;
}

Json to_json(const GroupEntry& entry) {
  return {{"layer", entry.layer}, {"kind", entry.kind},   {"index", entry.index},
          {"name", entry.name},   {"color", entry.color}, {"intensity", entry.intensity}};
}

std::optional<GroupEntry> group_entry(const Json& json) {
  GroupEntry entry;
  if (!json.is_object()) return std::nullopt;
  for (const char* key : {"layer", "kind", "name"}) {
    if (!json.contains(key) || !json[key].is_string()) return std::nullopt;
  }
  entry.layer = json["layer"].get<std::string>();
  entry.kind = json["kind"].get<std::string>();
  entry.name = json["name"].get<std::string>();
  if (!json.contains("index") || !json["index"].is_number_unsigned()) return std::nullopt;
  entry.index = json["index"].get<std::uint32_t>();
  if (!json.contains("color") || !read_color(json["color"], entry.color, kMostIntensity) ||
      !json.contains("intensity") || !read_intensity(json["intensity"], entry.intensity)) {
    return std::nullopt;
  }
  return entry;
}

Status change_entries(const Json& lights, const std::string& place,
                      std::vector<GroupEntry>& entries) {
  if (!lights.is_object()) return bad_option(place + ": an object is wanted");
  for (const auto& [key, value] : lights.items()) {
    const std::string at = place + "#/" + key;
    if (key == "lights") {
      LB_RETURN_IF_ERROR(change_named(value, at, "light", kLightFields, entries));
    } else if (key == "materials") {
      LB_RETURN_IF_ERROR(change_named(value, at, "material", kMaterialFields, entries));
    } else if (key == "sky") {
      LB_RETURN_IF_ERROR(change_sky(value, at, entries));
    } else {
      return bad_option(at + ": there is no such field; lights, materials and sky can change");
    }
  }
  return {};
}

}  // namespace lightbatch::pipeline
