#pragma once

#include <optional>

#include "server/log.h"
#include "server/service.h"

namespace lightbatch::server {

struct DaemonConfig {
  ServiceConfig service;
  LogLevel log_level = LogLevel::kInfo;
  bool log_json = false;
};

/// Options of lightbatchd from the command line, the environment (LIGHTBATCHD_...) and a config
/// file, in that order. Prints help or what is wrong; then the exit code comes back instead.
struct ParsedConfig {
  DaemonConfig config;
  std::optional<int> exit_code;
};
ParsedConfig parse_config(int argc, char** argv, const std::string& version);

}  // namespace lightbatch::server
