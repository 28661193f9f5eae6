#include "tests/unit/report/sample_report.h"

#include <algorithm>
#include <array>
#include <string_view>

namespace lightbatch::report {

nlohmann::json sample_report() {
  return nlohmann::json::parse(R"json({
  "schema": 1, "kind": "bake",
  "input": {"name": "small_room.draco_webp.glb", "bytes": 428436,
    "sha256": "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad",
    "files": [{"name": "small_room.draco_webp.glb", "bytes": 428436}]},
  "options": {"target_error": 0.02, "texels_per_metre": 0, "sky_nits": 500, "carrier": "lightmap",
    "seed": 1, "threads": 2, "profile": "desktop", "effects": []},
  "build": {"version": "0.1.0", "compiler": "GCC 12.2"},
  "scene": {"triangles": 47402, "unique_triangles": 47402, "nodes": 19, "meshes": 17, "materials": 16,
    "lights": 0, "emitters": 1, "dropped": {"zero area": 12}},
  "plan": {"effects": [
    {"name": "area_emitters", "on": true, "why": "1 material emits", "evidence": ["material \"Lamp\""],
     "cost_share": 0.22, "counters": {"shadow_rays": 8123456}},
    {"name": "sky", "on": true, "overridden": true, "why": "asked for, and rays escape", "cost_share": 0.1,
     "counters": {"escaped_rays": 912345}},
    {"name": "interreflection", "on": true, "why": "reflectance reaches 0.8: 9 bounces for 2 %",
     "evidence": ["a", "b", "c", "d", "e", "f", "g", "h"], "cost_share": 0.55, "counters": {"links": 1234567}},
    {"name": "alpha_cut_out", "on": false, "why": "no material has alphaMode MASK"},
    {"name": "punctual_lights", "on": false, "why": "the scene has none"}]},
  "hierarchy": {"sah_cost": 61.27, "depth": 31, "void_area": 0.31, "nodes": 94803, "build_seconds": 0.41,
    "levels": [{"level": 0, "nodes": 1, "area": 1, "void_share": 0.62, "triangles_most": 47402},
      {"level": 4, "nodes": 16, "area": 3.2, "void_share": 0.4, "triangles_most": 9001},
      {"level": 8, "nodes": 230, "area": 5.1, "void_share": 0.22, "triangles_most": 800},
      {"level": 13, "nodes": 4100, "area": 7.0, "void_share": 0.11, "triangles_most": 60}],
    "compare": [{"builder": "sweep SAH, reinsertion", "sah_cost": 61.27, "seconds": 0.41},
      {"builder": "binned SAH", "sah_cost": 66.0, "seconds": 0.1}]},
  "radiosity": {"mode": "stored rays", "elements": 60123, "iterations": 11, "residual": 0.0004,
    "residuals": [0.9, 0.4, 0.1, 0.03, 0.01, 0.004, 0.0011, 0.0004],
    "links": {"cluster": 1000, "leaf": 90000},
    "energy": {"emitted": 12000.5, "absorbed": 9000.1, "escaped": 2995.2, "error": 0.0004}},
  "lightmaps": {"charts": 1203, "texels": 812345, "texels_per_metre_asked": 10, "texels_per_metre_given": 10,
    "utilisation": 0.81, "pages": [
      {"name": "lightmap_0", "width": 1024, "height": 1024, "texels": 700000, "charts": 900,
       "utilisation": 0.83, "intensity": 1520.5},
      {"name": "lightmap_1", "width": 512, "height": 512, "texels": 112345, "charts": 303,
       "utilisation": 0.7, "intensity": 900}]},
  "accuracy": {"target": 0.02, "certified": 0.0174, "low": 0.0161, "high": 0.0188, "p95": 0.041,
    "bias": -0.0021, "probes": 4096, "passed": true},
  "borders": {"seams": [
      {"surface": "flat", "metres": 12.5, "points": 130, "rms": 0.0123, "p95": 0.025, "largest": 0.04},
      {"surface": "folded", "metres": 3.5, "points": 40, "rms": 0.05, "p95": 0.09, "largest": 0.11}],
    "divided_metres": 1.5, "leaks": {"points": 6144, "leaks": 7, "area_share": 0.0013, "largest": 0.31,
      "brightest_on": "Skirting", "hidden": 5}},
  "batches": {"count": 41, "profile": "desktop", "views": 512,
    "before": {"draws": 171, "triangles": 40120}, "after": {"draws": 38, "triangles": 33010},
    "curve": [{"draws": 16, "triangles": 47000, "cost": 2}, {"draws": 38, "triangles": 33010, "cost": 1.4,
      "chosen": true}, {"draws": 120, "triangles": 28000, "cost": 1.9}],
    "left_alone": [{"name": "Fox", "reason": "skinned"}]},
  "stages": [{"name": "read", "seconds": 0.3, "cpu_seconds": 0.3, "peak_bytes": 90000000},
    {"name": "hierarchy", "seconds": 0.41, "cpu_seconds": 0.7, "peak_bytes": 120000000},
    {"name": "charts", "seconds": 1.9, "cpu_seconds": 3.4, "peak_bytes": 210000000},
    {"name": "radiosity", "seconds": 6.2, "cpu_seconds": 12, "peak_bytes": 512000000},
    {"name": "gather", "seconds": 71.5, "cpu_seconds": 141, "peak_bytes": 612000000},
    {"name": "certify", "seconds": 9.1, "cpu_seconds": 18, "peak_bytes": 612000000},
    {"name": "write", "seconds": 1.1, "cpu_seconds": 1.2, "peak_bytes": 640000000}],
  "total": {"seconds": 90.5, "cpu_seconds": 176.6, "peak_bytes": 640000000},
  "warnings": ["texture 3 is KTX2: its material's constant factor was used",
    {"message": "reflectance above 0.999 was lowered", "place": "scene.glb#/materials/2", "count": 12}],
  "quote": [{"error": 0.1, "seconds": 4.1, "low": 3, "high": 6}, {"error": 0.05, "seconds": 12},
    {"error": 0.02, "seconds": 80}, {"error": 0.01, "seconds": 260}, {"error": 0.005, "seconds": 900}]
})json");
}

std::string tag_fault(const std::string& markup) {
  static constexpr std::array<std::string_view, 4> kVoid = {"meta", "img", "br", "!doctype"};
  std::vector<std::string> open;
  for (std::size_t at = markup.find('<'); at != std::string::npos; at = markup.find('<', at)) {
    const std::size_t end = markup.find('>', at);
    if (end == std::string::npos) return "a tag without end";
    std::string tag = markup.substr(at + 1, end - at - 1);
    at = end;
    if (tag.empty() || tag[0] == '?') continue;
    const bool closing = tag[0] == '/';
    const std::string name =
        tag.substr(closing ? 1 : 0, tag.find_first_of(" \n") - (closing ? 1 : 0));
    if (std::count(tag.begin(), tag.end(), '"') % 2 != 0) return "odd quotes in <" + tag + ">";
    if (std::find(kVoid.begin(), kVoid.end(), name) != kVoid.end() || tag.back() == '/') continue;
    if (!closing) {
      open.push_back(name);
    } else if (open.empty() || open.back() != name) {
      return "</" + name + "> closes " + (open.empty() ? "nothing" : "<" + open.back() + ">");
    } else {
      open.pop_back();
    }
  }
  return open.empty() ? std::string() : "<" + open.back() + "> is never closed";
}

}  // namespace lightbatch::report
