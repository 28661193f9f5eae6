#pragma once

#include <initializer_list>
#include <string>
#include <string_view>
#include <utility>

namespace lightbatch::server {

enum class LogLevel { kDebug, kInfo, kWarning, kError, kOff };

/// Sets the least level that is written, and whether lines are JSON or key=value. stderr.
void configure_log(LogLevel least, bool json);

/// One line per event: a dotted word ("job.ended") and fields. Values may hold anything; they are
/// escaped. Thread-safe.
void log_event(LogLevel level, std::string_view event,
               std::initializer_list<std::pair<std::string_view, std::string>> fields = {});

}  // namespace lightbatch::server
