#include "core/base/status.h"

namespace lightbatch {

std::string Status::to_string() const {
  if (ok()) return "OK";
  std::string text = message_;
  if (!place_.empty()) text += " (at " + place_ + ")";
  text += " [" + reason_ + "]";
  return text;
}

Status malformed(std::string place, std::string message) {
  return {StatusCode::kInvalidArgument, "INPUT_MALFORMED", std::move(message), std::move(place)};
}
Status over_budget(std::string place, std::string message) {
  return {StatusCode::kResourceExhausted, "INPUT_OVER_BUDGET", std::move(message),
          std::move(place)};
}
Status unsupported(std::string place, std::string message) {
  return {StatusCode::kInvalidArgument, "INPUT_UNSUPPORTED", std::move(message), std::move(place)};
}
Status bad_option(std::string message) {
  return {StatusCode::kInvalidArgument, "BAD_OPTION", std::move(message)};
}
Status cancelled() { return {StatusCode::kCancelled, "CANCELLED", "cancelled by the caller"}; }
Status io_error(std::string place, std::string message) {
  return {StatusCode::kUnavailable, "IO_ERROR", std::move(message), std::move(place)};
}

}  // namespace lightbatch
