// Projection of incident light onto spherical harmonics (Ramamoorthi and Hanrahan 2001). A ray's
// share of the coefficients above the first is taken against the mean luminance of all rays, whose
// own projection is 0: a constant surrounding has no noise.

#include "core/probes/bake.h"

#include <algorithm>
#include <cmath>

#include "core/base/parallel.h"
#include "core/base/random.h"
#include "core/lightmap/incident.h"

namespace lightbatch::probes {
namespace {

using lightmap::BakeCounts;
using lightmap::IncidentLight;
using radiosity::Incident;
using radiosity::Receiver;

constexpr std::size_t kGrain = 4;
/// Share of the rays that meet absorbing backs, from which on a probe counts as inside something.
constexpr double kInside = 0.25;
/// Invalid probes take from valid ones this many cells away, at most.
constexpr int kFillRounds = 4;

using Coefficients = std::array<Rgbd, 9>;

/// Sums over a run of rays.
struct RaySums {
  Coefficients light{};           // luminance times basis
  std::array<double, 9> basis{};  // of the directions
  Coefficients emitters{};
  std::uint64_t rays = 0;
  std::uint64_t backs = 0;

  RaySums& operator+=(const RaySums& o) {
    for (std::size_t k = 0; k < 9; ++k) {
      light[k] += o.light[k];
      basis[k] += o.basis[k];
      emitters[k] += o.emitters[k];
    }
    rays += o.rays;
    backs += o.backs;
    return *this;
  }

  /// Projection of the incident luminance.
  Coefficients projected() const {
    Coefficients c{};
    const auto count = static_cast<double>(std::max<std::uint64_t>(1, rays));
    // The first basis function is constant.
    const Rgbd mean = basis[0] > 0 ? light[0] / basis[0] : Rgbd{};
    for (std::size_t k = 0; k < 9; ++k) {
      const Rgbd rays_of = k == 0 ? light[k] : light[k] - mean * basis[k];
      c[k] = rays_of * (4 * kPiDouble / count) + emitters[k] / count;
    }
    return c;
  }
};

void add(Coefficients& sum, const Incident& incident) {
  const Sh9 basis = sh_basis(incident.direction);
  const Rgbd light = to_double(incident.light);
  for (std::size_t k = 0; k < 9; ++k) sum[k] += light * static_cast<double>(basis[k]);
}

struct ProbeState {
  RaySums first, second;  // halves of the rays
  Coefficients punctual{};
  bool done = false;

  RaySums all() const {
    RaySums sum = first;
    return sum += second;
  }
  Coefficients irradiance() const {
    Coefficients c = all().projected();
    for (std::size_t k = 0; k < 9; ++k) {
      c[k] = (c[k] + punctual[k]) * static_cast<double>(kShCosine[k]);
    }
    return c;
  }
  /// Mean square over all normals of the irradiance's error, mean over channels, lux^2.
  double variance() const {
    const Coefficients a = first.projected(), b = second.projected();
    double sum = 0;
    for (std::size_t k = 0; k < 9; ++k) {
      const Rgbd d = (a[k] - b[k]) * (0.5 * static_cast<double>(kShCosine[k]));
      sum += (d * d).sum();
    }
    return sum / (3 * 4 * kPiDouble);
  }
};

class Baking {
 public:
  Baking(const lightmap::BakeInput& input, const lightmap::Gather& gather, LightProbes& probes,
         const ProbeSettings& settings, const Progress& progress)
      : input_(input),
        incident_(input, gather),
        probes_(probes),
        settings_(settings),
        progress_(progress),
        state_(probes.grid.positions.size()) {}

  Status run() {
    trace_lights();
    // Rays tell validity too.
    std::uint32_t rays = settings_.fewest_rays;
    trace(0, rays / 2, &ProbeState::first);
    trace(rays / 2, rays, &ProbeState::second);
    const double allowed = std::pow(settings_.error * mean_irradiance(), 2);
    for (; rays < settings_.most_rays; rays *= 2) {
      if (progress_.cancelled()) return cancelled();
      std::size_t left = 0;
      for (ProbeState& p : state_) {
        p.done = p.done || is_inside(p) || p.variance() <= allowed;
        left += p.done ? 0u : 1u;
      }
      progress_.report("probes",
                       1 - static_cast<double>(left) / static_cast<double>(state_.size()));
      if (left == 0) break;
      for (ProbeState& p : state_) {
        if (p.done) continue;
        p.first += p.second;
        p.second = {};
      }
      trace(rays, 2 * rays, &ProbeState::second);
    }
    if (progress_.cancelled()) return cancelled();
    settle();
    return {};
  }

 private:
  Receiver receiver(std::size_t i) const {
    return Receiver::in_space(to_float(probes_.grid.positions[i] - input_.scene.origin));
  }

  static bool is_inside(const ProbeState& p) {
    const RaySums all = p.all();
    return static_cast<double>(all.backs) > kInside * static_cast<double>(all.rays);
  }

  template <typename Visit>
  void for_probes(Visit visit) {
    std::vector<BakeCounts> counts((state_.size() + kGrain - 1) / kGrain);
    parallel_for(state_.size(), kGrain, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end && !progress_.cancelled(); ++i) {
        if (!state_[i].done) visit(i, counts[begin / kGrain]);
      }
    });
    for (const BakeCounts& c : counts) probes_.counts += c;
  }

  void trace_lights() {
    for_probes([&](std::size_t i, BakeCounts& counts) {
      incident_.punctual(receiver(i), {0.5f, 0.5f}, counts,
                         [&](const Incident& light) { add(state_[i].punctual, light); });
    });
  }

  void trace(std::uint32_t begin, std::uint32_t end, RaySums ProbeState::*half) {
    const bool emitters = !input_.direct.sources().emitters().empty();
    for_probes([&](std::size_t i, BakeCounts& counts) {
      const Receiver at = receiver(i);
      const std::uint64_t seed = item_seed(input_.seed, i, 41);
      const OwenSobol8 sequence(static_cast<std::uint32_t>(seed));
      RaySums& sums = state_[i].*half;
      for (std::uint32_t k = begin; k < end; ++k) {
        IncidentLight::Ray ray = incident_.ray(at, sequence, k, seed, counts);
        if (!input_.indirect) ray.luminance = {};
        const Sh9 basis = sh_basis(ray.direction);
        for (std::size_t c = 0; c < 9; ++c) {
          sums.light[c] += ray.luminance * static_cast<double>(basis[c]);
          sums.basis[c] += static_cast<double>(basis[c]);
        }
        ++sums.rays;
        if (ray.meets_back) ++sums.backs;
        if (emitters) add(sums.emitters, incident_.emitter(at, sequence, k, seed, counts));
      }
    });
  }

  /// Of the probes that are not inside something, over all normals, lux, mean over channels.
  double mean_irradiance() const {
    double sum = 0, count = 0;
    for (const ProbeState& p : state_) {
      if (is_inside(p)) continue;
      sum += p.irradiance()[0].sum() / 3 * static_cast<double>(sh_basis({0, 0, 1})[0]);
      ++count;
    }
    return count > 0 ? sum / count : 0;
  }

  void settle() {
    const double mean = mean_irradiance();
    double squares = 0, count = 0;
    probes_.irradiance.resize(state_.size());
    probes_.valid.resize(state_.size());
    for (std::size_t i = 0; i < state_.size(); ++i) {
      probes_.valid[i] = is_inside(state_[i]) ? 0 : 1;
      if (probes_.valid[i] == 0) continue;
      const Coefficients c = state_[i].irradiance();
      for (std::size_t k = 0; k < 9; ++k) probes_.irradiance[i].coefficient[k] = to_float(c[k]);
      squares += state_[i].variance();
      ++count;
    }
    probes_.noise = mean > 0 ? std::sqrt(squares / count) / mean : 0;
    fill_invalid();
  }

  void fill_invalid() {
    std::vector<std::uint8_t> filled = probes_.valid;
    for (int round = 0; round < kFillRounds; ++round) {
      std::vector<Coefficients> sums(state_.size());
      std::vector<int> count(state_.size());
      for (const Volume& volume : probes_.grid.volumes) {
        for (const Cell& cell : volume.cells) {
          for (const std::uint32_t to : cell.probe) {
            if (filled[to] != 0) continue;
            for (const std::uint32_t from : cell.probe) {
              if (filled[from] == 0) continue;
              for (std::size_t k = 0; k < 9; ++k) {
                sums[to][k] += to_double(probes_.irradiance[from].coefficient[k]);
              }
              ++count[to];
            }
          }
        }
      }
      for (std::size_t i = 0; i < state_.size(); ++i) {
        if (count[i] == 0) continue;
        for (std::size_t k = 0; k < 9; ++k) {
          probes_.irradiance[i].coefficient[k] = to_float(sums[i][k] / count[i]);
        }
        filled[i] = 1;
      }
    }
  }

  const lightmap::BakeInput& input_;
  const IncidentLight incident_;
  LightProbes& probes_;
  const ProbeSettings& settings_;
  const Progress& progress_;
  std::vector<ProbeState> state_;
};

}  // namespace

Result<LightProbes> bake_probes(const lightmap::BakeInput& input, const lightmap::Gather& gather,
                                ProbeGrid grid, const ProbeSettings& settings,
                                const Progress& progress) {
  LightProbes probes;
  probes.grid = std::move(grid);
  if (probes.grid.positions.empty()) return probes;
  LB_RETURN_IF_ERROR(Baking(input, gather, probes, settings, progress).run());
  return probes;
}

}  // namespace lightbatch::probes
