#include "core/batches/profile.h"

#include <array>
#include <cmath>
#include <nlohmann/json.hpp>

namespace lightbatch::batches {
namespace {

// Costs of one draw: a native viewer spends 1 to 3 us in driver and engine, a WebGL viewer 7 to 12
// us (three.js, measured per draw), a phone twice that at a third of the vertex rate. Half a
// billion vertices a second, and as many triangles, is what small desktop chips do.
constexpr double kDesktopDraw = 2, kWebglDraw = 9, kMobileDraw = 20;

struct Field {
  const char* name;
  double Profile::*member;
  double low, high;
};
constexpr std::array<Field, 8> kFields{{
    {"draw", &Profile::draw, 0, 1e6},
    {"state", &Profile::state, 0, 1e6},
    {"vertex", &Profile::vertex, 0, 1e3},
    {"triangle", &Profile::triangle, 0, 1e3},
    {"inside", &Profile::inside, 0, 1},
    {"field_of_view", &Profile::field_of_view, 1, 170},
    {"aspect", &Profile::aspect, 0.1, 10},
    {"eye_height", &Profile::eye_height, 0, 1e6},
}};

}  // namespace

Result<Profile> preset_profile(std::string_view name) {
  Profile p;
  p.name = name;
  if (name == "desktop") {
    p.draw = kDesktopDraw;
  } else if (name == "webgl") {
    p.draw = kWebglDraw;
    p.state = 2;
  } else if (name == "mobile") {
    p.draw = kMobileDraw;
    p.state = 5;
    p.vertex = 0.004;
    p.triangle = 0.006;
    p.aspect = 9.0 / 16.0;
  } else {
    return bad_option("unknown profile '" + std::string(name) +
                      "': use desktop, webgl, mobile, or a JSON file");
  }
  return p;
}

Result<Profile> read_profile(std::string_view json, const std::string& place) {
  const auto root = nlohmann::json::parse(json, nullptr, false);
  if (!root.is_object()) return malformed(place, "a profile must be one JSON object");
  std::string base = "desktop";
  if (const auto it = root.find("base"); it != root.end()) {
    if (!it->is_string()) return malformed(place + "#/base", "must be the name of a preset");
    base = it->get<std::string>();
  }
  LB_ASSIGN_OR_RETURN(Profile profile, preset_profile(base));
  for (const auto& [key, value] : root.items()) {
    const std::string where = place + "#/" + key;
    if (key == "base") continue;
    if (key == "name") {
      if (!value.is_string()) return malformed(where, "must be a string");
      profile.name = value.get<std::string>();
      continue;
    }
    if (!value.is_number()) return malformed(where, "must be a number");
    const double number = value.get<double>();
    if (key == "max_vertices") {
      if (!(number >= 3 && number <= 4294967294.0) || number != std::floor(number))
        return malformed(where, "must be a whole number of at least 3");
      profile.max_vertices = static_cast<std::uint32_t>(number);
      continue;
    }
    const Field* field = nullptr;
    for (const Field& f : kFields)
      if (key == f.name) field = &f;
    if (field == nullptr) return malformed(where, "unknown member; see the README of batches");
    if (!(number >= field->low && number <= field->high))
      return malformed(where, "out of range: must lie in [" + std::to_string(field->low) + ", " +
                                  std::to_string(field->high) + "]");
    profile.*(field->member) = number;
  }
  return profile;
}

}  // namespace lightbatch::batches
