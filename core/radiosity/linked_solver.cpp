// Hierarchical radiosity with clusters (Hanrahan, Salzman, Aupperle 1991; Smits, Arvo, Greenberg
// 1994; Sillion, Drettakis, Soler 1995; Mueller, Schaefer, Fellner 1999). Where we deviate: order-2
// harmonics for clusters; the near field by the receiver's cosine rays, which also measure the row
// sums that all links are scaled to; an energy correction an iteration (a one-cell coarse grid), so
// that the number of iterations does not grow with reflectance.
#include "core/radiosity/linked_solver.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/base/parallel.h"
#include "core/radiosity/area_sum.h"
#include "core/radiosity/linked_rays.h"
#include "core/radiosity/linked_refine.h"
#include "core/radiosity/linked_transport.h"
#include "core/radiosity/linked_tree.h"
#include "core/radiosity/reflection.h"

namespace lightbatch::radiosity {
namespace {

constexpr int kMaxIterations = 200;
/// Thresholds of the passes over the last one's.
constexpr std::array<double, 3> kPasses = {64, 8, 1};
/// Solving between passes need only tell bright from dark.
constexpr double kRoughTolerance = 0.03;

Rgbd magnitude(const Rgbd& c) { return {std::fabs(c.r), std::fabs(c.g), std::fabs(c.b)}; }

/// B = start + rho K B, from the given B on. Returns K B of the last B.
std::vector<Rgb> iterate(const Elements& elements, const Transport& transport,
                         const std::vector<Rgb>& start, double tolerance,
                         std::vector<Rgb>& radiosity, Solution::Statistics& statistics,
                         const Progress& progress) {
  const std::uint32_t count = elements.count();
  // What is sent back of equal light on both sides.
  std::vector<Rgb> rho(count);
  for (ElementId e = 0; e < count; ++e)
    rho[e] = elements.reflectance(e) + elements.transmittance(e);
  // What adding rho to every B changes: sum A (rho - rho K rho).
  const std::vector<Rgb> correction = transport.apply(rho);
  const Rgbd response = area_sum(elements, [&](ElementId e) {
    return to_double(rho[e]) * (Rgbd{1, 1, 1} - to_double(correction[e]));
  });
  std::vector<Rgb> arriving;
  for (int i = 1; i <= kMaxIterations && !progress.cancelled(); ++i) {
    arriving = transport.apply(radiosity);
    const auto sent = [&](ElementId e) {
      return to_double(start[e]) + sent_back(elements, e, lux_of(arriving));
    };
    const Rgbd imbalance =
        area_sum(elements, [&](ElementId e) { return sent(e) - to_double(radiosity[e]); });
    const Rgb c = to_float(divide(imbalance, response));
    for (ElementId e = 0; e < count; ++e) arriving[e] += correction[e] * c;
    const Rgbd change = area_sum(
        elements, [&](ElementId e) { return magnitude(sent(e) - to_double(radiosity[e])); });
    for (ElementId e = 0; e < count; ++e) radiosity[e] = to_float(sent(e));
    const Rgbd size = area_sum(elements, [&](ElementId e) { return to_double(radiosity[e]); });
    statistics.iterations += 1;
    statistics.residual = divide(change, size).max();
    if (statistics.residual < tolerance) break;
  }
  return arriving;
}

}  // namespace

Result<Solution> solve_linked(const SolverInput& input, const SolverOptions& options,
                              const Progress& progress) {
  const Elements& elements = input.elements;
  const std::uint32_t count = elements.count();
  Solution solution = measure_direct(input, options, progress);
  Solution::Statistics& statistics = solution.statistics;
  statistics.elements = count;
  if (progress.cancelled()) return cancelled();
  const LinkTree tree(input);
  CosineRays rays = shoot_cosine_rays(input, tree, options, statistics.rays, progress);
  if (progress.cancelled()) return cancelled();

  std::vector<Rgb> start(count);
  for (ElementId e = 0; e < count; ++e) {
    start[e] = to_float(sent_back(
        elements, e, [&](ElementId o) { return to_double(solution.irradiance[o] + rays.sky[o]); }));
  }
  statistics.emitted = area_sum(
      elements, [&](ElementId e) { return to_double(solution.irradiance[e] + rays.sky[e]); });
  const Rgbd first = area_sum(elements, [&](ElementId e) { return to_double(start[e]); });
  const Rgbd area = area_sum(elements, [](ElementId) { return Rgbd{1, 1, 1}; });

  std::vector<Rgb> radiosity = start;
  std::vector<Rgb> gathered(count);
  if (options.interreflection && count > 0 && first.sum() > 0) {
    // An ambient guess, so that the first pass does not leave dark sources on top-level links.
    const Rgb ambient = to_float(divide(first, area));
    for (ElementId e = 0; e < count; ++e) radiosity[e] += elements.reflectance(e) * ambient;
    std::vector<Link> links = {Link{0, 0}};
    Refiner refiner(input, tree, options);
    const double flux = first.sum() / 3 * std::clamp(options.threshold, 1e-12, 1.0);
    for (std::size_t pass = 0; pass < kPasses.size(); ++pass) {
      LinkTree::Outgoing out;
      tree.pull(radiosity, out);
      refiner.refine(out, flux * kPasses[pass], links, statistics.rays, progress);
      if (progress.cancelled()) return cancelled();
      const Transport transport(tree, links, rays);
      const bool last = pass + 1 == kPasses.size();
      gathered = iterate(elements, transport, start, last ? options.tolerance : kRoughTolerance,
                         radiosity, statistics, progress);
      if (progress.cancelled()) return cancelled();
      progress.report("links", static_cast<double>(pass + 1) / kPasses.size());
      statistics.links = links.size();
      statistics.memory_bytes = transport.memory_bytes() + links.capacity() * sizeof(Link);
    }
  }

  const Rgbd reflected = area_sum(elements, [&](ElementId e) { return to_double(radiosity[e]); });
  const Rgbd arrived = area_sum(elements, [&](ElementId e) { return to_double(gathered[e]); });
  statistics.escaped = reflected - arrived;
  statistics.absorbed = area_sum(elements, [&](ElementId e) {
    const Rgbd total = to_double(solution.irradiance[e] + rays.sky[e] + gathered[e]);
    return total * absorbed_share(elements, e);
  });
  solution.indirect.resize(count);
  for (ElementId e = 0; e < count; ++e) {
    const Rgb rest = rays.sky[e] + gathered[e];
    solution.indirect[e] = rest;
    solution.irradiance[e] += rest;
    solution.unresolved[e] = elements.reflectance(e) * (solution.unresolved[e] + rest);
  }
  add_through(elements, solution);
  solution.radiosity = std::move(radiosity);
  statistics.memory_bytes += tree.memory_bytes() + rays.memory_bytes() + elements.memory_bytes() +
                             std::uint64_t{count} * 8 * sizeof(Rgb);
  return solution;
}

}  // namespace lightbatch::radiosity
