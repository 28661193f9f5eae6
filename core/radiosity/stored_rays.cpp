// First stage, stored-ray mode: every element shoots cosine rays once; the elements they hit are
// its links, all of weight 1 / rays; the system is then solved in place, with one energy
// correction an iteration (a one-cell coarse grid), so that the number of iterations does not grow
// with reflectance. Energy is conserved by construction; new lights need no new ray.
//
// Gather form of Monte Carlo radiosity (Keller 1996, Quasi-Monte Carlo Radiosity; Bekaert 1999)
// with the hits kept.

#include <algorithm>
#include <cmath>

#include "core/base/parallel.h"
#include "core/base/random.h"
#include "core/math/sampling.h"
#include "core/math/sobol.h"
#include "core/radiosity/hemisphere_walk.h"
#include "core/radiosity/reflection.h"
#include "core/radiosity/solver.h"

namespace lightbatch::radiosity {
namespace {

constexpr int kMaxIterations = 400;
constexpr std::size_t kGrain = 256;

/// The stored hits: rows by element. Weights only where a scene has sheets (else all are 1).
struct Links {
  std::vector<std::uint64_t> start;  // per element and one past
  std::vector<ElementId> source;
  std::vector<Rgb> weight;
  std::vector<float> scale;  // 1 / rays of the row
  std::uint64_t memory_bytes() const {
    return start.capacity() * 8 + source.capacity() * 4 + weight.capacity() * 12 +
           scale.capacity() * 4;
  }
};

int ray_count(const Elements& elements, ElementId e, int rays) {
  const double half = 0.5 * elements.edge();
  const double share = std::min(1.0, static_cast<double>(elements.area(e)) / (half * half));
  return std::max(2, static_cast<int>(std::lround(rays * share)));
}

/// Shoots the rays of every element. sky: irradiance from escaping rays; crowding: as in Solution.
Links shoot(const SolverInput& input, const SolverOptions& options, std::vector<Rgb>& sky,
            std::vector<float>& crowding, RayCounts& counts, const Progress& progress) {
  const Elements& elements = input.elements;
  const bool sheets = input.optics.filtered_count() > 0;
  const std::size_t blocks = (elements.count() + kGrain - 1) / kGrain;
  struct Block {
    std::vector<ElementId> source;
    std::vector<Rgb> weight;
    std::vector<std::uint32_t> row;  // links of each element
    RayCounts counts;
  };
  std::vector<Block> block(blocks);
  Links links;
  links.scale.resize(elements.count());
  sky.assign(elements.count(), Rgb{});
  crowding.assign(elements.count(), 0.0f);
  const auto near = static_cast<float>(1.5 * elements.edge());
  parallel_for(elements.count(), kGrain, [&](std::size_t begin, std::size_t end) {
    if (progress.cancelled()) return;
    Block& out = block[begin / kGrain];
    for (std::size_t i = begin; i < end; ++i) {
      const auto e = static_cast<ElementId>(i);
      const int rays = ray_count(elements, e, options.rays);
      const OwenSobol8 sequence(static_cast<std::uint32_t>(item_seed(options.seed, e, 3)));
      const std::size_t before = out.source.size();
      Rgbd from_sky;
      int near_hits = 0;
      for (std::uint32_t k = 0; k < static_cast<std::uint32_t>(rays); ++k) {
        const Vec2f ab = sequence.pair(k, 2);
        const ElementPoint p = elements.point(e, ab.x, ab.y);
        const auto frame = optics::surface_frame(input.scene, p.triangle, p.u, p.v,
                                                 elements.is_back(e), input.direct.lift());
        const Vec3f direction =
            Frame::about(frame.normal).to_world(cosine_hemisphere(sequence.pair(k, 0)));
        walk_hemisphere_ray(
            input.optics, input.caster, {frame.origin, direction}, p.triangle, out.counts,
            [&](const rays::Hit& hit, const Rgb& weight) {
              if (hit.t < near) ++near_hits;
              ElementId source = input.lookup.at(hit);
              if (source == kNoElement) return;
              // A cell of two rooms, of which this element is in one: it is taken to be as bright.
              if (input.lookup.is_split(source)) source = e;
              out.source.push_back(source);
              if (sheets) out.weight.push_back(weight);
            },
            [&](const Rgb& weight) {
              from_sky += to_double(weight * input.sky.radiance(direction));
            });
      }
      crowding[e] = static_cast<float>(near_hits) / static_cast<float>(rays);
      links.scale[e] = 1.0f / static_cast<float>(rays);
      sky[e] = to_float(from_sky * (kPiDouble / rays));
      out.row.push_back(static_cast<std::uint32_t>(out.source.size() - before));
    }
  });
  links.start.reserve(elements.count() + 1);
  links.start.push_back(0);
  std::uint64_t total = 0;
  for (const Block& b : block) total += b.source.size();
  links.source.reserve(total);
  if (sheets) links.weight.reserve(total);
  for (Block& b : block) {
    for (const std::uint32_t n : b.row) links.start.push_back(links.start.back() + n);
    links.source.insert(links.source.end(), b.source.begin(), b.source.end());
    links.weight.insert(links.weight.end(), b.weight.begin(), b.weight.end());
    counts += b.counts;
    b = Block{};
  }
  return links;
}

/// (K x)_e: what the linked elements send to e.
Rgbd row_sum(const Links& links, ElementId e, const std::vector<Rgb>& x) {
  Rgbd sum;
  if (links.weight.empty()) {
    for (auto k = links.start[e]; k < links.start[e + 1]; ++k) {
      sum += to_double(x[links.source[k]]);
    }
  } else {
    for (auto k = links.start[e]; k < links.start[e + 1]; ++k) {
      sum += to_double(x[links.source[k]] * links.weight[k]);
    }
  }
  return sum * static_cast<double>(links.scale[e]);
}

Rgbd area_sum(const Elements& elements, const auto& value_of) {
  return deterministic_reduce(
      elements.count(), 4096, Rgbd{},
      [&](std::size_t begin, std::size_t end) {
        Rgbd sum;
        for (std::size_t i = begin; i < end; ++i) {
          const auto e = static_cast<ElementId>(i);
          sum += value_of(e) * static_cast<double>(elements.area(e));
        }
        return sum;
      },
      [](Rgbd a, const Rgbd& b) { return a + b; });
}

Rgbd divide(const Rgbd& a, const Rgbd& b) {
  const auto ratio = [](double x, double y) { return std::fabs(y) > 1e-300 ? x / y : 0.0; };
  return {ratio(a.r, b.r), ratio(a.g, b.g), ratio(a.b, b.b)};
}

/// first / held per channel; 1 where nothing is held, and never a wild step.
Rgbd correction(const Rgbd& first, const Rgbd& held) {
  const auto ratio = [](double f, double h) {
    return h > 0 && f > 0 ? std::clamp(f / h, 1e-3, 1e3) : 1.0;
  };
  return {ratio(first.r, held.r), ratio(first.g, held.g), ratio(first.b, held.b)};
}

/// B = B0 + rho K B (and tau K B of what lies behind), solved in place.
class StoredRaySystem {
 public:
  StoredRaySystem(const Elements& elements, const Links& links, const SolverOptions& options)
      : elements_(elements), links_(links), options_(options) {}

  struct Answer {
    std::vector<Rgb> radiosity;
    std::vector<Rgb> gathered;  // K B, lux
    int iterations = 0;
    double residual = 0;
  };
  /// start: B0. CANCELLED.
  Result<Answer> solve(const std::vector<Rgb>& start, const Progress& progress) const {
    const std::uint32_t count = elements_.count();
    Answer answer;
    answer.radiosity = start;
    answer.gathered.resize(count);
    if (links_.source.empty()) return answer;
    std::vector<Rgb>& radiosity = answer.radiosity;
    // What the first bounce brings in all: sum A rho K B0.
    const Rgbd first_bounce = area_sum(elements_, [&](ElementId e) { return bounced(e, start); });
    std::vector<Rgb> next(count), indirect(count);
    for (int iteration = 1; iteration <= kMaxIterations; ++iteration) {
      if (progress.cancelled()) return cancelled();
      sweep(start, radiosity, next);
      const Rgbd change = area_sum(elements_, [&](ElementId e) {
        const Rgbd d = to_double(next[e] - radiosity[e]);
        return Rgbd{std::fabs(d.r), std::fabs(d.g), std::fabs(d.b)};
      });
      const Rgbd size = area_sum(elements_, [&](ElementId e) { return to_double(next[e]); });
      radiosity.swap(next);
      // Energy correction: the indirect part I = B - B0 is scaled by s so that what it and the
      // first bounce bring balances what it holds, sum A (rho K (B0 + s I) - s I) = 0. A factor
      // leaves dark rooms dark, where an added constant would light them.
      for (ElementId e = 0; e < count; ++e) indirect[e] = radiosity[e] - start[e];
      const Rgbd held = area_sum(
          elements_, [&](ElementId e) { return to_double(indirect[e]) - bounced(e, indirect); });
      const Rgbd scale = correction(first_bounce, held);
      for (ElementId e = 0; e < count; ++e) {
        radiosity[e] = start[e] + indirect[e] * to_float(scale);
      }
      answer.iterations = iteration;
      const Rgbd relative = divide(change, size);
      const Rgbd off = scale - Rgbd{1, 1, 1};
      answer.residual =
          std::max({relative.max(), std::fabs(off.r), std::fabs(off.g), std::fabs(off.b)});
      if (answer.residual < options_.tolerance) break;
    }
    for (ElementId e = 0; e < count; ++e) {
      answer.gathered[e] = to_float(row_sum(links_, e, radiosity));
    }
    return answer;
  }

 private:
  Rgbd bounced(ElementId e, const std::vector<Rgb>& x) const {
    return sent_back(elements_, e, [&](ElementId o) { return row_sum(links_, o, x); });
  }

  /// In place inside a chunk, last iteration's values outside: the same on any thread count.
  void sweep(const std::vector<Rgb>& start, const std::vector<Rgb>& radiosity,
             std::vector<Rgb>& next) const {
    constexpr std::size_t kChunk = 4096;
    parallel_for(start.size(), kChunk, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        const auto e = static_cast<ElementId>(i);
        Rgbd sum;
        for (auto k = links_.start[e]; k < links_.start[e + 1]; ++k) {
          const ElementId s = links_.source[k];
          const Rgb& b = s >= begin && s < i ? next[s] : radiosity[s];
          sum += links_.weight.empty() ? to_double(b) : to_double(b * links_.weight[k]);
        }
        const Rgb through = to_float(
            sent_through(elements_, e, [&](ElementId o) { return row_sum(links_, o, radiosity); }));
        next[e] = start[e] + through +
                  elements_.reflectance(e) * to_float(sum * static_cast<double>(links_.scale[e]));
      }
    });
  }

  const Elements& elements_;
  const Links& links_;
  const SolverOptions& options_;
};

/// The share of every light group in what the elements send out: one more solution each, on the
/// same rays. direct, sky: lux. On entry solution.unresolved_by_group holds irradiance.
Status solve_groups(const StoredRaySystem& system, const Elements& elements,
                    const GroupedLight& direct, const std::vector<Rgb>& sky, Solution& solution,
                    const Progress& progress) {
  const std::size_t last = direct.groups() - 1;
  std::vector<Rgb> start(elements.count());
  for (std::size_t g = 0; g <= last; ++g) {
    const auto arrives = [&](ElementId e) {
      return to_double(g == last ? sky[e] : direct.of(e)[g]);
    };
    for (ElementId e = 0; e < elements.count(); ++e) {
      start[e] = to_float(sent_back(elements, e, arrives));
    }
    LB_ASSIGN_OR_RETURN(const auto answer, system.solve(start, progress));
    const auto in_all = [&](ElementId e) { return arrives(e) + to_double(answer.gathered[e]); };
    for (ElementId e = 0; e < elements.count(); ++e) {
      Rgb& own = solution.unresolved_by_group.of(e)[g];
      own = elements.reflectance(e) * (own + answer.gathered[e] + (g == last ? sky[e] : Rgb{})) +
            to_float(sent_through(elements, e, in_all));
    }
  }
  return {};
}

}  // namespace

Result<Solution> solve_stored_rays(const SolverInput& input, const SolverOptions& options,
                                   const Progress& progress) {
  const Elements& elements = input.elements;
  const std::uint32_t count = elements.count();
  GroupedLight direct_by_group;
  Solution solution =
      measure_direct(input, options, progress, input.groups > 0 ? &direct_by_group : nullptr);
  Solution::Statistics& statistics = solution.statistics;
  statistics.elements = count;
  if (progress.cancelled()) return cancelled();

  std::vector<Rgb> sky(count);
  Links links;
  if (options.interreflection || !input.sky.is_black()) {
    links = shoot(input, options, sky, solution.crowding, statistics.rays, progress);
    if (progress.cancelled()) return cancelled();
  }
  if (!options.interreflection) links = Links{};
  statistics.links = links.source.size();

  // B0 = rho (direct + sky); then B = B0 + rho K B.
  std::vector<Rgb> start(count);
  for (ElementId e = 0; e < count; ++e) {
    start[e] = to_float(sent_back(
        elements, e, [&](ElementId o) { return to_double(solution.irradiance[o] + sky[o]); }));
  }
  statistics.emitted =
      area_sum(elements, [&](ElementId e) { return to_double(solution.irradiance[e] + sky[e]); });
  const StoredRaySystem system(elements, links, options);
  LB_ASSIGN_OR_RETURN(auto answer, system.solve(start, progress));
  statistics.iterations = answer.iterations;
  statistics.residual = answer.residual;
  const std::vector<Rgb>& radiosity = answer.radiosity;
  const std::vector<Rgb>& gathered = answer.gathered;
  if (input.groups > 0) {
    LB_RETURN_IF_ERROR(solve_groups(system, elements, direct_by_group, sky, solution, progress));
  }

  statistics.absorbed = Rgbd{};
  const Rgbd reflected = area_sum(elements, [&](ElementId e) { return to_double(radiosity[e]); });
  const Rgbd arrived = area_sum(elements, [&](ElementId e) { return to_double(gathered[e]); });
  statistics.escaped = reflected - arrived;
  statistics.absorbed = area_sum(elements, [&](ElementId e) {
    const Rgbd total = to_double(solution.irradiance[e] + sky[e] + gathered[e]);
    return total * absorbed_share(elements, e);
  });
  solution.indirect.resize(count);
  for (ElementId e = 0; e < count; ++e) {
    const Rgb rest = sky[e] + gathered[e];
    solution.indirect[e] = rest;
    solution.irradiance[e] += rest;
    solution.unresolved[e] = elements.reflectance(e) * (solution.unresolved[e] + rest);
  }
  add_through(elements, solution);
  solution.radiosity = std::move(answer.radiosity);
  statistics.memory_bytes =
      links.memory_bytes() + elements.memory_bytes() + std::uint64_t{count} * (5 * sizeof(Rgb) + 2);
  return solution;
}

}  // namespace lightbatch::radiosity
