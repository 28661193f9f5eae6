#include "core/scene_out/probes_file.h"

#include <charconv>
#include <nlohmann/json.hpp>

namespace lightbatch::scene_out {
namespace {

using Json = nlohmann::json;

/// The double with the fewest digits that is this float again.
double shortest(float value) {
  char text[32];
  const auto end = std::to_chars(text, text + sizeof text, value).ptr;
  double result = 0;
  std::from_chars(text, end, result);
  return result;
}

Json vector(const Vec3d& v) { return Json::array({v.x, v.y, v.z}); }

Json volume(const probes::Volume& v) {
  Json cells = Json::array();
  for (const probes::Cell& cell : v.cells) {
    Json row = Json::array({cell.at[0], cell.at[1], cell.at[2], cell.size});
    for (const std::uint32_t p : cell.probe) row.push_back(p);
    cells.push_back(std::move(row));
  }
  return {{"origin", vector(v.origin)}, {"step", v.step},   {"extent", v.extent},
          {"largest", v.largest},       {"nodes", v.nodes}, {"cells", std::move(cells)}};
}

}  // namespace

std::string probes_file(const probes::LightProbes& probes) {
  Json volumes = Json::array(), positions = Json::array(), irradiance = Json::array();
  for (const probes::Volume& v : probes.grid.volumes) volumes.push_back(volume(v));
  for (const Vec3d& p : probes.grid.positions) positions.push_back(vector(p));
  for (const probes::ShIrradiance& sh : probes.irradiance) {
    Json row = Json::array();
    for (const Rgb& c : sh.coefficient) {
      for (const float v : {c.r, c.g, c.b}) row.push_back(shortest(v));
    }
    irradiance.push_back(std::move(row));
  }
  const Json file = {
      {"version", 1},
      {"convention",
       {{"quantity", "irradiance, lux, linear Rec. 709"},
        {"axes", "world axes of scene.glb, metres"},
        {"formula", "E(n) = sum over k of irradiance[k] * Y[k](n), n the unit normal"},
        {"basis", Json::array({"0.28209479", "0.48860251*y", "0.48860251*z", "0.48860251*x",
                               "1.09254843*x*y", "1.09254843*y*z", "0.31539157*(3*z*z-1)",
                               "1.09254843*x*z", "0.54627422*(x*x-y*y)"})},
        {"cosine_lobe", "folded in"},
        {"order", "k major: r, g, b of k = 0, then of k = 1..."}}},
      {"volumes", std::move(volumes)},
      {"probes",
       {{"position", std::move(positions)},
        {"valid", probes.valid},
        {"irradiance", std::move(irradiance)}}}};
  return file.dump() + "\n";
}

}  // namespace lightbatch::scene_out
