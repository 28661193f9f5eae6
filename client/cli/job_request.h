#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <variant>

#include "client/cli/job_commands.h"

namespace lightbatch::cli {

/// A job as the service wants it, and the files that go beside the scene in its manifest.
struct JobRequest {
  v1::JobOptions options;
  std::map<std::string, std::filesystem::path> extra_files;  // manifest path -> file
};

/// Words -> request; a string says what is wrong with the words.
std::variant<JobRequest, std::string> make_request(v1::JobKind kind, const JobWords& words);

}  // namespace lightbatch::cli
