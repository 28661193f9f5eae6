#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "lightbatch/client.h"

namespace lightbatch::cli {

/// Results go to stdout, everything else to stderr.

/// "lightbatch: message (at place) [REASON]" on stderr and, with json, {"error"} on stdout.
/// Returns the exit code.
int report_error(const client::Error& error, bool json);

/// Bad usage: the message on stderr; returns kBadUsage.
int usage_error(const std::string& message);

/// A job for programs: name, state, verdict, summary, artifacts, error, seconds.
nlohmann::json job_json(const v1::Job& job);

/// "QUEUED", "RUNNING"...
std::string state_word(v1::JobState state);
/// "bake", "plan"...: as the commands are called.
std::string kind_word(v1::JobKind kind);

/// Seconds that the last attempt took; 0 while unknown.
double run_seconds(const v1::Job& job);

/// Full "jobs/..." name of what a user typed.
std::string job_name(const std::string& typed);

}  // namespace lightbatch::cli
