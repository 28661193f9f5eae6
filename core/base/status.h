#pragma once

#include <optional>
#include <string>
#include <utility>
#include <variant>

#include "core/base/check.h"

namespace lightbatch {

/// Canonical codes, numerically equal to gRPC's, so that one function converts them at the door.
enum class StatusCode : int {
  kOk = 0,
  kCancelled = 1,
  kInvalidArgument = 3,
  kDeadlineExceeded = 4,
  kNotFound = 5,
  kAlreadyExists = 6,
  kPermissionDenied = 7,
  kResourceExhausted = 8,
  kFailedPrecondition = 9,
  kAborted = 10,
  kOutOfRange = 11,
  kUnimplemented = 12,
  kInternal = 13,
  kUnavailable = 14,
  kDataLoss = 15,
};

/// Outcome of an operation on data from outside (files, requests). Broken invariants are not
/// statuses: they abort through CHECK.
///
/// `reason` is a stable upper-snake word of at most 63 characters (INPUT_MALFORMED, BLOB_MISSING);
/// `place` says where: a file name with a JSON pointer ("scene.gltf#/accessors/3/count") or with a
/// byte offset ("scene.glb@20"). The message says what is wrong and what to do.
class [[nodiscard]] Status {
 public:
  Status() = default;
  Status(StatusCode code, std::string reason, std::string message, std::string place = {})
      : code_(code),
        reason_(std::move(reason)),
        message_(std::move(message)),
        place_(std::move(place)) {}

  bool ok() const { return code_ == StatusCode::kOk; }
  StatusCode code() const { return code_; }
  const std::string& reason() const { return reason_; }
  const std::string& message() const { return message_; }
  const std::string& place() const { return place_; }
  /// "message (at place) [REASON]" for people.
  std::string to_string() const;

 private:
  StatusCode code_ = StatusCode::kOk;
  std::string reason_;
  std::string message_;
  std::string place_;
};

/// The scene itself is at fault: INPUT_MALFORMED.
Status malformed(std::string place, std::string message);
/// The scene asks for more than the budget allows: INPUT_OVER_BUDGET.
Status over_budget(std::string place, std::string message);
/// The scene needs something that is not supported: INPUT_UNSUPPORTED.
Status unsupported(std::string place, std::string message);
/// A request or option is wrong: BAD_OPTION.
Status bad_option(std::string message);
/// The caller asked to stop: CANCELLED.
Status cancelled();
/// An operating-system call failed: IO_ERROR; the message should hold strerror.
Status io_error(std::string place, std::string message);

/// A value, or the status that says why there is none. value() on an error aborts.
template <typename T>
class [[nodiscard]] Result {
 public:
  Result(T value) : data_(std::move(value)) {}  // NOLINT(google-explicit-constructor)
  Result(Status status) : data_(std::move(status)) {  // NOLINT(google-explicit-constructor)
    LB_CHECK(!std::get<Status>(data_).ok(), "a Result needs a value or an error");
  }

  bool ok() const { return std::holds_alternative<T>(data_); }
  T& value() & {
    check_value();
    return std::get<T>(data_);
  }
  const T& value() const& {
    check_value();
    return std::get<T>(data_);
  }
  T&& value() && {
    check_value();
    return std::move(std::get<T>(data_));
  }
  T& operator*() & { return value(); }
  const T& operator*() const& { return value(); }
  T&& operator*() && { return std::move(*this).value(); }
  T* operator->() { return &value(); }
  const T* operator->() const { return &value(); }
  /// OK when a value is held.
  Status status() const { return ok() ? Status() : std::get<Status>(data_); }

 private:
  void check_value() const {
    LB_CHECK(ok(), std::get<Status>(data_).message().c_str());
  }
  std::variant<T, Status> data_;
};

}  // namespace lightbatch

/// Returns the error from the enclosing function.
#define LB_RETURN_IF_ERROR(expression)                     \
  do {                                                     \
    if (::lightbatch::Status lb_status_ = (expression); !lb_status_.ok()) return lb_status_; \
  } while (false)

#define LB_CONCAT_INNER(a, b) a##b
#define LB_CONCAT(a, b) LB_CONCAT_INNER(a, b)
/// LB_ASSIGN_OR_RETURN(auto x, make_x()): declares x, or returns the error.
#define LB_ASSIGN_OR_RETURN(declaration, expression) \
  LB_ASSIGN_OR_RETURN_INNER(LB_CONCAT(lb_result_, __LINE__), declaration, expression)
#define LB_ASSIGN_OR_RETURN_INNER(result, declaration, expression) \
  auto result = (expression);                                      \
  if (!result.ok()) return result.status();                        \
  declaration = std::move(result).value()
