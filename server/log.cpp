#include "server/log.h"

#include <spdlog/sinks/stdout_sinks.h>
#include <spdlog/spdlog.h>

#include <atomic>
#include <memory>
#include <nlohmann/json.hpp>

namespace lightbatch::server {
namespace {

std::atomic<bool> json_lines = false;

spdlog::level::level_enum spdlog_level(LogLevel level) {
  switch (level) {
    case LogLevel::kDebug:
      return spdlog::level::debug;
    case LogLevel::kInfo:
      return spdlog::level::info;
    case LogLevel::kWarning:
      return spdlog::level::warn;
    case LogLevel::kError:
      return spdlog::level::err;
    case LogLevel::kOff:
      return spdlog::level::off;
  }
  return spdlog::level::info;
}

spdlog::logger& logger() {
  static const auto instance = std::make_shared<spdlog::logger>(
      "lightbatch", std::make_shared<spdlog::sinks::stderr_sink_mt>());
  return *instance;
}

std::string quoted(const std::string& value) {
  return nlohmann::json(value).dump(-1, ' ', true, nlohmann::json::error_handler_t::replace);
}

}  // namespace

void configure_log(LogLevel least, bool json) {
  json_lines = json;
  logger().set_level(spdlog_level(least));
  logger().flush_on(spdlog::level::debug);
  logger().set_pattern(json ? R"({"time":"%Y-%m-%dT%H:%M:%S.%e%z","level":"%l",%v})"
                            : "time=%Y-%m-%dT%H:%M:%S.%e%z level=%l %v");
}

void log_event(LogLevel level, std::string_view event,
               std::initializer_list<std::pair<std::string_view, std::string>> fields) {
  if (!logger().should_log(spdlog_level(level))) return;
  const bool json = json_lines;
  std::string line(json ? "\"event\":" : "event=");
  line += json ? quoted(std::string(event)) : std::string(event);
  for (const auto& [key, value] : fields) {
    if (json) {
      line += ',';
      line += quoted(std::string(key));
      line += ':';
      line += quoted(value);
    } else {
      const bool plain = !value.empty() && value.find_first_of(" \"=\\\n\t") == std::string::npos;
      line += ' ';
      line += key;
      line += '=';
      line += plain ? value : quoted(value);
    }
  }
  logger().log(spdlog_level(level), line);
}

}  // namespace lightbatch::server
