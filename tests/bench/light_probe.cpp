// Bakes the light of a scene and compares it with irradiance known at points: either the receivers
// of a case of analytic.json, or a CSV of points with reference irradiance (x,y,z,nx,ny,nz,r,g,b).
//
//   light_probe SCENE.glb [--target 0.02] [--sky NITS] [--texels D] [--points FILE.csv]
//               [--analytic FILE.json] [--picture FILE.png] [--save FILE] [--against FILE]
//
// --save writes the texels' irradiance (raw floats), --against compares with such a file.

#include <cmath>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <span>
#include <sstream>
#include <string>
#include <vector>

#include "core/accuracy/path_tracer.h"
#include "core/base/bytes.h"
#include "core/base/random.h"
#include "core/image/codecs.h"
#include "core/lightmap/look_up.h"
#include "core/lightmap/texel_points.h"
#include "core/pipeline/certify_stage.h"
#include "core/pipeline/light_stage.h"
#include "core/pipeline/tune.h"

namespace {

using namespace lightbatch;

struct Reference {
  Vec3d position, normal;
  Rgbd irradiance;
};

std::vector<Reference> read_points(const std::string& path) {
  std::vector<Reference> points;
  std::ifstream in(path);
  std::string line;
  std::getline(in, line);
  while (std::getline(in, line)) {
    for (char& c : line) c = c == ',' ? ' ' : c;
    std::istringstream fields(line);
    Reference r;
    fields >> r.position.x >> r.position.y >> r.position.z >> r.normal.x >> r.normal.y >>
        r.normal.z >> r.irradiance.r >> r.irradiance.g >> r.irradiance.b;
    points.push_back(r);
  }
  return points;
}

std::vector<Reference> read_case(const std::string& path, const std::string& scene, double& sky,
                                 double& tolerance) {
  std::vector<Reference> points;
  std::ifstream in(path);
  const auto json = nlohmann::json::parse(in);
  for (const auto& c : json["cases"]) {
    if (scene.find(c["file"].get<std::string>()) == std::string::npos) continue;
    sky = c["environment_nits"];
    tolerance = c["tolerance_relative"];
    for (const auto& r : c["receivers"]) {
      const auto& p = r["position"];
      const auto& n = r["normal"];
      const auto& e = r["irradiance_lux"];
      points.push_back({{p[0], p[1], p[2]}, {n[0], n[1], n[2]}, {e[0], e[1], e[2]}});
    }
  }
  return points;
}

}  // namespace

int main(int argc, char** argv) {
  std::map<std::string, std::string> option;
  for (int i = 2; i + 1 < argc; i += 2) option[argv[i]] = argv[i + 1];
  const auto number = [&](const char* name, double otherwise) {
    return option.contains(name) ? std::stod(option[name]) : otherwise;
  };
  const std::string path = argc > 1 ? argv[1] : "";
  pipeline::JobOptions options;
  options.target_error = number("--target", 0.02);
  options.sky_nits = number("--sky", 0);
  options.texels_per_metre = number("--texels", 0);
  options.seed = static_cast<std::uint64_t>(number("--seed", 1));
  double tolerance = 0.02;
  std::vector<Reference> points;
  if (option.contains("--points")) points = read_points(option["--points"]);
  if (option.contains("--analytic")) {
    points = read_case(option["--analytic"], path, options.sky_nits, tolerance);
  }
  pipeline::JobInput input;
  input.scene = "scene.glb";
  input.files[input.scene] = path;
  pipeline::StageClock clock;
  const Progress silent;
  auto prepared = pipeline::prepare(options, input, clock, silent);
  if (!prepared.ok()) {
    std::fprintf(stderr, "%s\n", prepared.status().to_string().c_str());
    return 3;
  }
  const pipeline::Prepared& p = *prepared;
  auto places = pipeline::make_places(options, p, clock, silent);
  if (!places.ok()) {
    std::fprintf(stderr, "%s\n", places.status().to_string().c_str());
    return 3;
  }
  accuracy::Rungs rungs{options.target_error, options.target_error, options.target_error,
                        options.target_error};
  std::shared_ptr<const pipeline::FirstStage> first;  // the pilot's; --fresh: not taken
  if (!option.contains("--untuned")) {
    clock.start("pilot");
    const auto tuned = pipeline::tune(options, p, *places, options.target_error, silent);
    clock.stop();
    rungs = tuned->rungs;
    if (!option.contains("--fresh")) first = tuned->first;
    const auto show = [](const char* name, const accuracy::PartPilot& part, double rung) {
      std::printf("%s: error %.3f %% at rung %.3f %%, read at %.3f %%; cost %.3g rays\n", name,
                  100 * part.error, 100 * part.rung, 100 * rung, part.cost);
    };
    show("direct", tuned->pilot.direct, rungs.direct);
    show("indirect", tuned->pilot.indirect, rungs.gather);
    std::printf("first stage at rung %.3f %%, read at %.3f %%; cost %.3g rays\n",
                100 * tuned->pilot.stage_rung, 100 * rungs.first, tuned->pilot.stage_rays);
    std::printf("excess %.2f\n", tuned->pilot.excess);
    std::printf("expected %.3f %%, %.2f s\n", 100 * pipeline::error_at(tuned->pilot, rungs),
                pipeline::seconds_at(tuned->pilot, rungs));
  }
  auto settings =
      accuracy::settings_for(rungs, pipeline::measure_for_settings(p, *places), options.seed);
  // Single settings, to see what each of them is worth.
  settings.elements.edge = number("--edge", settings.elements.edge);
  settings.solver.rays = static_cast<int>(number("--stored-rays", settings.solver.rays));
  settings.solver.direct_samples =
      static_cast<int>(number("--direct-samples", settings.solver.direct_samples));
  settings.gather.rays = static_cast<int>(number("--gather-rays", settings.gather.rays));
  settings.gather.block = static_cast<int>(number("--block", settings.gather.block));
  settings.gather.tolerance = number("--tolerance", settings.gather.tolerance);
  settings.gather.reach = number("--reach", settings.gather.reach);
  settings.gather.deeper = number("--deeper", settings.gather.deeper);
  settings.gather.pilot_rays = static_cast<int>(number("--pilot-rays", settings.gather.pilot_rays));
  settings.gather.direct_error = number("--direct-error", settings.gather.direct_error);
  settings.gather.linked = number("--linked", settings.gather.linked);
  settings.gather.virtual_lights =
      static_cast<int>(number("--virtual-lights", settings.gather.virtual_lights));
  settings.gather.virtual_rays =
      static_cast<int>(number("--virtual-rays", settings.gather.virtual_rays));
  std::vector<std::uint8_t> selected;
  if (option.contains("--only")) {
    selected.resize(places->texels.texels.size());
    std::istringstream list(option["--only"]);
    for (std::size_t t; list >> t;) selected[t] = 1;
  }
  auto bake = pipeline::bake_light(options, p, *places, settings, clock, silent,
                                   {selected.empty() ? nullptr : &selected, false, first});
  for (std::size_t t = 0; t < selected.size(); ++t) {
    const auto& texel = places->texels.texels[t];
    const auto pts = lightmap::texel_points(places->texels, texel);
    if (selected[t] != 0) {
      std::printf("texel %zu: %.6g direct %.6g chart %u fragments %zu points %u\n", t,
                  static_cast<double>(bake->baked.irradiance[t].g),
                  static_cast<double>(bake->baked.direct[t].g), texel.chart,
                  places->texels.fragments_of(texel).size(), pts.count);
    }
  }
  if (!selected.empty()) return 0;
  if (option.contains("--save")) {
    const auto& texels = bake->baked.irradiance;
    if (!write_file(option["--save"], std::as_bytes(std::span(texels))).ok()) return 1;
  }
  if (option.contains("--against")) {
    const auto saved = read_file(option["--against"]);
    std::vector<Rgb> truth(places->texels.texels.size());
    if (!saved.ok() || saved->size() != truth.size() * sizeof(Rgb)) return 1;
    std::memcpy(truth.data(), saved->data(), saved->size());
    double off = 0, mean = 0, bias = 0, area = 0;
    for (std::size_t t = 0; t < truth.size(); ++t) {
      const double a = places->texels.surface_of(places->texels.texels[t]);
      const Rgbd d = to_double(bake->baked.irradiance[t]) - to_double(truth[t]);
      off += a * (d * d).sum() / 3;
      bias += a * d.sum() / 3;
      mean += a * to_double(truth[t]).sum() / 3;
      area += a;
    }
    std::printf("against saved: relRMSE %.3f %% bias %+.3f %%\n",
                100 * std::sqrt(off / area) / (mean / area), 100 * bias / mean);
    if (option.contains("--brief")) {
      for (const auto& stage : clock.stages()) {
        std::printf("%-10s %7.3f s  %7.3f CPU s\n", stage.name.c_str(), stage.seconds,
                    stage.cpu_seconds);
      }
      return 0;
    }
  }
  const auto pages = lightmap::make_pages(places->layout, places->texels, bake->baked.irradiance);
  const auto certificate = pipeline::certify(options, p, *places, *bake, clock, silent);
  for (const auto& stage : clock.stages()) {
    std::printf("%-10s %7.3f s  %7.3f CPU s  %5.0f MB\n", stage.name.c_str(), stage.seconds,
                stage.cpu_seconds, static_cast<double>(stage.peak_bytes) / 1e6);
  }
  std::printf(
      "certified %.3f %% (%.3f to %.3f) bias %+.3f %% (%+.3f to %+.3f) p95 %.2f %% probes %llu "
      "paths %.2f M\n",
      100 * certificate->relrmse, 100 * certificate->low, 100 * certificate->high,
      100 * certificate->bias, 100 * certificate->bias_low, 100 * certificate->bias_high,
      100 * certificate->p95, static_cast<unsigned long long>(certificate->probes),
      static_cast<double>(certificate->paths) * 1e-6);
  const auto& counts = bake->baked.counts;
  std::printf(
      "triangles %zu elements %llu edge %.4g links %llu iterations %d residual %.2g mean %.5g\n",
      p.scene->triangles.size(), static_cast<unsigned long long>(bake->radiosity.elements),
      bake->element_edge, static_cast<unsigned long long>(bake->radiosity.links),
      bake->radiosity.iterations, bake->radiosity.residual, bake->mean_irradiance);
  std::printf(
      "direct %.3f s pages %zu charts %zu texels %zu density %.4g computed %.3f refined %.3f "
      "hemisphere %.1f M "
      "deeper %.2f M\n",
      bake->baked.direct_seconds, places->layout.pages.size(), places->layout.charts.size(),
      places->texels.texels.size(), places->layout.texels_per_metre,
      static_cast<double>(counts.computed_texels) / static_cast<double>(counts.texels),
      static_cast<double>(counts.refined_texels) / static_cast<double>(counts.texels),
      static_cast<double>(counts.rays.hemisphere) * 1e-6,
      static_cast<double>(counts.deeper_gathers) * 1e-6);
  double squares = 0, mean = 0, bias = 0, worst = 0;
  std::size_t used = 0;
  std::vector<double> errors;
  for (const Reference& r : points) {
    const float eps = 1e-4f * p.scene->box.diagonal();
    const Vec3d local = r.position - p.scene->origin;
    rays::Ray ray{to_float(local + r.normal * static_cast<double>(eps)), to_float(-r.normal)};
    ray.t_max = 2 * eps;
    const rays::Hit hit = p.caster->closest(ray);
    if (!hit.found()) continue;
    const Rgb got = lightmap::irradiance_at(places->layout, pages, hit.triangle, hit.u, hit.v);
    const Rgbd d = to_double(got) - r.irradiance;
    squares += (d.r * d.r + d.g * d.g + d.b * d.b) / 3;
    mean += r.irradiance.sum() / 3;
    bias += d.sum() / 3;
    errors.push_back(d.sum() / 3);
    ++used;
    if (points.size() < 20) {
      const double relative =
          r.irradiance.g > 0 ? d.g / r.irradiance.g : static_cast<double>(got.g);
      worst = std::max(worst, std::fabs(relative));
      std::printf("  (%8.3f %8.3f %8.3f) want %11.5g got %11.5g  off %8.4f %%\n", r.position.x,
                  r.position.y, r.position.z, r.irradiance.g, static_cast<double>(got.g),
                  100 * relative);
    }
  }
  if (used > 0) {
    const double n = static_cast<double>(used);
    std::sort(errors.begin(), errors.end(),
              [](double a, double b) { return std::fabs(a) < std::fabs(b); });
    std::printf(
        "points %zu of %zu: relRMSE %.2f %% bias %+.2f %% median %.2f %% p95 %.2f %% worst %.3f %% "
        "tolerance %.2f %%%s\n",
        used, points.size(), 100 * std::sqrt(squares / n) / (mean / n), 100 * bias / mean,
        100 * std::fabs(errors[used / 2]) / (mean / n),
        100 * std::fabs(errors[used * 95 / 100]) / (mean / n), 100 * worst, 100 * tolerance,
        points.size() < 20 && worst > tolerance ? "  <-- MISSED" : "");
  }
  if (option.contains("--worst")) {
    // The texels that differ most from path tracing, among some at random.
    const accuracy::PathTracer tracer(*p.caster, *p.optics, p.sky);
    struct Row {
      double off;
      Rgb got;
      Rgbd want;
      Vec3f at;
      std::uint32_t triangle;
      std::uint32_t texel;
      accuracy::PointSource points;
    };
    std::vector<Row> rows;
    Random random(5);
    std::vector<double> up_to;
    double total = 0, squared = 0, truth = 0;
    for (const auto& texel : places->texels.texels) {
      total += places->texels.surface_of(texel);
      up_to.push_back(total);
    }
    constexpr int kTexels = 3000;
    for (int k = 0; k < kTexels; ++k) {
      const auto t = static_cast<std::size_t>(
          std::upper_bound(up_to.begin(), up_to.end() - 1, random.next_double() * total) -
          up_to.begin());
      const auto surface_at = pipeline::points_of(*places, places->texels.texels[t]);
      const auto half = tracer.irradiance(surface_at, 512, random.next_u64());
      const auto sum = tracer.irradiance(surface_at, 512, random.next_u64());
      const Rgb got = bake->baked.irradiance[t];
      const Rgbd off1 = to_double(got) - half.irradiance, off2 = to_double(got) - sum.irradiance;
      squared += (off1 * off2).sum() / 3 / kTexels;
      truth += (half.irradiance + sum.irradiance).sum() / 6 / kTexels;
      const auto centre = surface_at(0.5f, {0.5f, 0.5f});
      const auto frame =
          optics::surface_frame(*p.scene, centre.triangle, centre.u, centre.v, false, 0);
      rows.push_back({std::fabs(static_cast<double>(got.sum()) - sum.irradiance.sum()), got,
                      sum.irradiance, frame.position, centre.triangle,
                      static_cast<std::uint32_t>(t), surface_at});
    }
    std::printf("area-uniform texels: relRMSE %.2f %%\n",
                100 * std::sqrt(std::max(0.0, squared)) / truth);
    const auto by_error = [](const Row& a, const Row& b) { return a.off > b.off; };
    std::sort(rows.begin(), rows.end(), by_error);
    // The foremost once more, so that the path tracer's own noise is not what is listed.
    rows.resize(std::min<std::size_t>(rows.size(), 60));
    for (Row& r : rows) {
      const auto sum = tracer.irradiance(r.points, 1 << 16, random.next_u64());
      r.want = sum.irradiance;
      r.off = std::fabs(static_cast<double>(r.got.sum()) - r.want.sum());
    }
    std::sort(rows.begin(), rows.end(), by_error);
    for (std::size_t k = 0; k < static_cast<std::size_t>(number("--worst", 10)); ++k) {
      const Row& r = rows[k];
      std::printf("  off %9.4g got %9.4g want %9.4g at %7.3f %7.3f %7.3f %s texel %u\n", r.off,
                  static_cast<double>(r.got.g), r.want.g, static_cast<double>(r.at.x),
                  static_cast<double>(r.at.y), static_cast<double>(r.at.z),
                  p.scene->objects[p.scene->triangles[r.triangle].object].name.c_str(), r.texel);
    }
  }
  if (option.contains("--picture")) {
    for (std::size_t i = 0; i < pages.size(); ++i) {
      const Bytes png = image::encode_png(lightmap::preview(pages[i]), false);
      if (!write_file(option["--picture"] + std::to_string(i) + ".png", png).ok()) return 1;
    }
  }
  return 0;
}
