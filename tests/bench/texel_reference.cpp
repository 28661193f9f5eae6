// True irradiance of random texels of the lightmap that a bake lays out: means of many paths of the
// path tracer of core/accuracy over the surface of each texel, in two independent halves.
//
//   texel_reference SCENE.glb OUT.csv [--sky NITS] [--texels-per-metre D] [--count N] [--paths N]
//
// Texels are drawn uniformly by area from those that one triangle covers wholly, so that every
// baker means the same by them (Cycles samples the triangle at a texel's centre and no other). One
// row each: page, x, y, then red, green, blue of either half, lux.

#include <algorithm>
#include <cstdio>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "core/accuracy/path_tracer.h"
#include "core/base/parallel.h"
#include "core/base/random.h"
#include "core/pipeline/certify_stage.h"
#include "core/pipeline/light_stage.h"

namespace {

using namespace lightbatch;

constexpr float kWhole = 0.999f;

/// Texels drawn with replacement, in the order of the map.
std::vector<std::uint32_t> draw(const pipeline::LightmapPlaces& places, std::size_t count) {
  const auto& texels = places.texels.texels;
  std::vector<double> up_to(texels.size());
  double total = 0;
  for (std::size_t t = 0; t < texels.size(); ++t) {
    const bool usable = texels[t].coverage >= kWhole && texels[t].fragment_count == 1 &&
                        !places.texels.is_back(texels[t].chart) &&
                        !places.layout.charts[texels[t].chart].tiny;
    if (usable) total += places.texels.surface_of(texels[t]);
    up_to[t] = total;
  }
  std::vector<std::uint32_t> drawn;
  Random random(item_seed(1, 0, 50));
  for (std::size_t k = 0; k < count && total > 0; ++k) {
    const double at =
        total * (static_cast<double>(k) + random.next_double()) / static_cast<double>(count);
    drawn.push_back(static_cast<std::uint32_t>(std::upper_bound(up_to.begin(), up_to.end(), at) -
                                               up_to.begin()));
  }
  return drawn;
}

Status run(const std::string& scene, const std::string& out,
           std::map<std::string, std::string>& option) {
  const auto number = [&](const char* name, double otherwise) {
    return option.contains(name) ? std::stod(option[name]) : otherwise;
  };
  pipeline::JobOptions options;
  options.target_error = 0.01;
  options.sky_nits = number("--sky", 0);
  options.texels_per_metre = number("--texels-per-metre", 0);
  pipeline::JobInput input;
  input.scene = "scene.glb";
  input.files[input.scene] = scene;
  pipeline::StageClock clock;
  LB_ASSIGN_OR_RETURN(const pipeline::Prepared p,
                      pipeline::prepare(options, input, clock, Progress()));
  LB_ASSIGN_OR_RETURN(const pipeline::LightmapPlaces places,
                      pipeline::make_places(options, p, clock, Progress()));
  const auto drawn = draw(places, static_cast<std::size_t>(number("--count", 1000)));
  const auto paths = static_cast<std::uint32_t>(number("--paths", 4096));
  const accuracy::PathTracer tracer(*p.caster, *p.optics, p.sky);
  std::vector<std::array<Rgbd, 2>> truth(drawn.size());
  parallel_for(drawn.size(), 4, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const auto points = pipeline::points_of(places, places.texels.texels[drawn[i]]);
      for (std::size_t half = 0; half < 2; ++half) {
        truth[i][half] = tracer.irradiance(points, paths, item_seed(2, i, half)).irradiance;
      }
    }
  });
  std::string csv = "page,x,y,r1,g1,b1,r2,g2,b2\n";
  for (std::size_t i = 0; i < drawn.size(); ++i) {
    const atlas::Texel& t = places.texels.texels[drawn[i]];
    char row[256];
    std::snprintf(row, sizeof row, "%u,%u,%u,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g\n", unsigned{t.page},
                  unsigned{t.x}, unsigned{t.y}, truth[i][0].r, truth[i][0].g, truth[i][0].b,
                  truth[i][1].r, truth[i][1].g, truth[i][1].b);
    csv += row;
  }
  return write_file(out, std::as_bytes(std::span(csv)));
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 3) {
    std::fprintf(stderr, "usage: texel_reference SCENE.glb OUT.csv [option value]...\n");
    return 2;
  }
  std::map<std::string, std::string> option;
  for (int i = 3; i + 1 < argc; i += 2) option[argv[i]] = argv[i + 1];
  const Status status = run(argv[1], argv[2], option);
  if (!status.ok()) std::fprintf(stderr, "%s\n", status.to_string().c_str());
  return status.ok() ? 0 : 1;
}
