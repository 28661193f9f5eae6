#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include "core/radiosity/solver.h"
#include "tests/unit/accuracy/scene_kit.h"

namespace lightbatch::radiosity {

/// A scene with everything the solvers take.
struct Bench {
  explicit Bench(const accuracy::SceneKit& kit, double edge,
                 const optics::Environment& environment = {})
      : sky(environment),
        sources(kit.scene(), kit.optics(), {}),
        direct(kit.optics(), kit.caster(), sources),
        elements(kit.scene(), kit.tree(), kit.optics(), {edge, 4'000'000}),
        lookup(kit.scene(), kit.caster(), elements, direct.lift()),
        input{kit.scene(), kit.tree(), kit.optics(), kit.caster(), elements, direct, sky, lookup} {}
  optics::Environment sky;
  LightSources sources;
  DirectLight direct;
  Elements elements;
  ElementLookup lookup;
  SolverInput input;

  /// Mean and largest relative deviation of the irradiance from a value, by area.
  std::array<double, 2> against(const Solution& s, double exact) const {
    double mean = 0, area = 0, worst = 0;
    for (ElementId e = 0; e < elements.count(); ++e) {
      const double value = static_cast<double>(s.irradiance[e].g);
      mean += value * static_cast<double>(elements.area(e));
      area += static_cast<double>(elements.area(e));
      worst = std::max(worst, std::abs(value / exact - 1));
    }
    return {mean / area / exact, worst};
  }
};

}  // namespace lightbatch::radiosity
