#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "core/base/status.h"

namespace lightbatch::batches {

/// What drawing costs on a kind of machine, and who looks at the scene. The expected cost of a
/// frame is the sum, over every primitive of every batch, of its chance of being in the view times
///   draw + state + vertices * vertex + triangles * triangle   (microseconds)
struct Profile {
  std::string name = "desktop";
  double draw = 5;                     // us for one draw call, viewer's work included
  double state = 1;                    // us for the change of material that comes with it
  double vertex = 0.002;               // us
  double triangle = 0.002;             // us
  std::uint32_t max_vertices = 65535;  // of one primitive; 65535: indices of 16 bits always fit
  double inside = 0.9;                 // share of views from where people stand; the rest look in
  double field_of_view = 60;           // vertical, degrees
  double aspect = 16.0 / 9.0;
  double eye_height = 1.6;  // metres; lowered in scenes that are small against it
};

/// desktop, webgl or mobile. BAD_OPTION for any other name.
Result<Profile> preset_profile(std::string_view name);

/// A profile as JSON text: an object with any of the members of Profile ("base" names the preset
/// that the others start from, default desktop). Unknown members and values out of range are
/// INPUT_MALFORMED with a pointer.
Result<Profile> read_profile(std::string_view json, const std::string& place);

}  // namespace lightbatch::batches
