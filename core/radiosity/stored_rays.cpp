// First stage, stored-ray mode: every element shoots cosine rays once; the elements they hit are
// its links, all of weight 1 / rays; the system is then solved in place, with one energy
// correction an iteration (a one-cell coarse grid), so that the number of iterations does not grow
// with reflectance. Energy is conserved by construction; new lights need no new ray.
//
// Gather form of Monte Carlo radiosity (Keller 1996, Quasi-Monte Carlo Radiosity; Bekaert 1999)
// with the hits kept.

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/base/parallel.h"
#include "core/radiosity/area_sum.h"
#include "core/radiosity/reflection.h"
#include "core/radiosity/solver.h"
#include "core/radiosity/stored_links.h"

namespace lightbatch::radiosity {
namespace {

constexpr int kMaxIterations = 400;

/// Energy correction of one channel. With few rays small bright elements may be hit too often, so
/// that what is held seems to be nothing, or less: factors that do not settle are left out, and
/// after some of these all further ones; iteration alone converges, as no element takes more than
/// all of what it sees.
class Correction {
 public:
  /// most: reflectance of all elements, transmittance included; all bounces bring at most
  /// 1 / (1 - most) times the first.
  explicit Correction(float most)
      : most_(static_cast<double>(std::min(most, optics::kMaxReflectance))) {}

  /// first / held; 1 where nothing is held, and never more than all bounces.
  double operator()(double first, double held) {
    if (has_given_up()) return 1;
    const double factor =
        held > 0 && first > 0 ? std::clamp(first / held, 1 - most_, 1 / (1 - most_)) : 1.0;
    const double off = std::fabs(std::log(factor));
    const bool settles = off <= kSettling * last_ || (off <= kSmall && off <= last_);
    last_ = off;
    if (settles) return factor;
    ++failures_;
    return 1;
  }
  /// What an iteration that changed the light by a share leaves undone, as a share at most.
  double residual(double change) const {
    return has_given_up() ? change * most_ / (1 - most_) : std::max(change, last_);
  }

 private:
  bool has_given_up() const { return failures_ >= kMostFailures; }

  /// Of the factor before, in logarithms. The first is taken, and small ones that do not grow.
  static constexpr double kSettling = 0.9;
  static constexpr double kSmall = 0.05;
  static constexpr int kMostFailures = 5;
  double most_;
  double last_ = std::numeric_limits<double>::infinity();
  int failures_ = 0;
};

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
    const Rgb most = most_sent_back();
    std::array<Correction, 3> correct{Correction(most.r), Correction(most.g), Correction(most.b)};
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
      const Rgbd scale{correct[0](first_bounce.r, held.r), correct[1](first_bounce.g, held.g),
                       correct[2](first_bounce.b, held.b)};
      for (ElementId e = 0; e < count; ++e) {
        radiosity[e] = start[e] + indirect[e] * to_float(scale);
      }
      answer.iterations = iteration;
      const Rgbd relative = divide(change, size);
      answer.residual = std::max({correct[0].residual(relative.r), correct[1].residual(relative.g),
                                  correct[2].residual(relative.b)});
      if (answer.residual < options_.tolerance) break;
    }
    for (ElementId e = 0; e < count; ++e) {
      answer.gathered[e] = to_float(row_sum(links_, e, radiosity));
    }
    return answer;
  }

 private:
  /// The largest reflectance and transmittance, together, of all elements.
  Rgb most_sent_back() const {
    Rgb most;
    for (ElementId e = 0; e < elements_.count(); ++e) {
      const Rgb sent = elements_.reflectance(e) + elements_.transmittance(e);
      most = {std::max(most.r, sent.r), std::max(most.g, sent.g), std::max(most.b, sent.b)};
    }
    return most;
  }

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

/// Direct light of the elements, lux, by element: what the start of a solution is made of.
template <typename Rest, typename Resolved>
std::vector<Rgb> first_sent(const Elements& elements, const Rest& rest, const Resolved& resolved) {
  std::vector<Rgb> start(elements.count());
  for (ElementId e = 0; e < elements.count(); ++e) {
    start[e] = to_float(sent_back(elements, e, rest) + sent_through(elements, e, resolved));
  }
  return start;
}

/// The share of every light group in what the elements send out: one more solution each, on the
/// same rays. direct: lux. On entry solution.unresolved_by_group holds irradiance.
Status solve_groups(const StoredRaySystem& system, const Elements& elements,
                    const GroupedLight& direct, const Shot& shot, Solution& solution,
                    const Progress& progress) {
  const std::size_t last = direct.groups() - 1;
  for (std::size_t g = 0; g <= last; ++g) {
    const auto unresolved = [&](ElementId e) {
      return to_double(solution.unresolved_by_group.of(e)[g]);
    };
    const auto rest = [&](ElementId e) {
      Rgbd arrives = unresolved(e) + to_double(shot.resolved_by_group.of(e)[g]);
      if (g == last) arrives += to_double(shot.sky[e]);
      return arrives;
    };
    const auto resolved = [&](ElementId e) { return to_double(direct.of(e)[g]) - unresolved(e); };
    LB_ASSIGN_OR_RETURN(const auto answer,
                        system.solve(first_sent(elements, rest, resolved), progress));
    for (ElementId e = 0; e < elements.count(); ++e) {
      solution.unresolved_by_group.of(e)[g] = answer.radiosity[e];
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

  Shot shot(input);
  if (options.interreflection || !input.sky.is_black()) {
    shot = shoot(input, options, solution, statistics.rays, progress);
    if (progress.cancelled()) return cancelled();
  }
  if (!options.interreflection) shot.drop_links();
  statistics.links = shot.links.source.size();

  // Resolved light is no part of B: what it brings where rays land has been found by the rays.
  const auto resolved = [&](ElementId e) {
    return to_double(solution.irradiance[e] - solution.unresolved[e]);
  };
  const auto rest = [&](ElementId e) {
    return to_double(solution.unresolved[e] + shot.sky[e] + shot.resolved[e]);
  };
  statistics.emitted = area_sum(
      elements, [&](ElementId e) { return to_double(solution.irradiance[e] + shot.sky[e]); });
  const StoredRaySystem system(elements, shot.links, options);
  LB_ASSIGN_OR_RETURN(auto answer, system.solve(first_sent(elements, rest, resolved), progress));
  statistics.iterations = answer.iterations;
  statistics.residual = answer.residual;
  if (input.groups > 0) {
    LB_RETURN_IF_ERROR(solve_groups(system, elements, direct_by_group, shot, solution, progress));
  }

  solution.radiosity.resize(count);
  solution.indirect.resize(count);
  for (ElementId e = 0; e < count; ++e) {
    solution.radiosity[e] = answer.radiosity[e] + elements.reflectance(e) * to_float(resolved(e));
    solution.indirect[e] = shot.sky[e] + shot.resolved[e] + answer.gathered[e];
  }
  for (ElementId e = 0; e < count; ++e) solution.irradiance[e] += solution.indirect[e];
  solution.unresolved = std::move(answer.radiosity);
  solution.crowding = std::move(shot.crowding);
  statistics.escaped = area_sum(elements, [&](ElementId e) {
    return to_double(solution.radiosity[e]) - to_double(solution.indirect[e] - shot.sky[e]);
  });
  statistics.absorbed = area_sum(elements, [&](ElementId e) {
    return to_double(solution.irradiance[e]) * absorbed_share(elements, e);
  });
  statistics.memory_bytes = shot.links.memory_bytes() + elements.memory_bytes() +
                            std::uint64_t{count} * (6 * sizeof(Rgb) + 2);
  return solution;
}

}  // namespace lightbatch::radiosity
