#pragma once

#include <cstdint>
#include <string>

#include "client/cli/session.h"

namespace lightbatch::cli {

/// Commands on jobs that a daemon (or a --data-dir) keeps. All return the exit code.
int list_jobs(const ServerOptions& server, int most, bool json);
int watch_job(const ServerOptions& server, const std::string& job, bool json, bool quiet);
int cancel_job(const ServerOptions& server, const std::string& job, bool json);
int fetch_job(const ServerOptions& server, const std::string& job, const std::string& folder,
              bool json, bool quiet);

/// A made-up office building as .glb; needs no server.
int make_office(std::uint64_t triangles, std::uint64_t seed, const std::string& file);

}  // namespace lightbatch::cli
