#pragma once

#include "core/radiosity/solver.h"

namespace lightbatch::radiosity {

/// Linked mode: hierarchical radiosity with clusters. The root of a hierarchy over the elements is
/// linked to itself; links are refined while their error estimate exceeds options.threshold (a
/// share of the flux that elements first reflect), in passes of falling threshold that judge every
/// link anew; gathered, pushed and pulled until options.tolerance. CANCELLED when asked to stop.
Result<Solution> solve_linked(const SolverInput& input, const SolverOptions& options,
                              const Progress& progress);

}  // namespace lightbatch::radiosity
