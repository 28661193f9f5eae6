#pragma once

#include "core/base/status.h"
#include "core/pipeline/prepare.h"
#include "core/pipeline/report_json.h"

namespace lightbatch::pipeline {

/// The rows of hierarchy.compare: the scene's hierarchy built in every way, what each costs and
/// what rays make of it; and, when something gives light, what linked radiosity over it needs at
/// the same threshold and how far it ends from its own solution of a quarter of it. CANCELLED.
Result<Json> compare_builders(const JobOptions& options, const Prepared& p,
                              const Progress& progress);
/// The same for people.
std::string comparison_text(const Json& rows);

}  // namespace lightbatch::pipeline
