#pragma once

#include <filesystem>
#include <string>

#include "core/pipeline/job.h"

namespace lightbatch::server {

/// What the service needs of the pipeline. The programs pass pipeline::run_job and its
/// neighbours; tests pass jobs of their own that crash, hang or eat memory.
struct Engine {
  Result<pipeline::JobOutcome> (*run_job)(const pipeline::JobOptions&, const pipeline::JobInput&,
                                          const std::filesystem::path& output, const Progress&);
  Status (*validate)(const pipeline::JobOptions&);
  std::string (*build_id)();
};

}  // namespace lightbatch::server
