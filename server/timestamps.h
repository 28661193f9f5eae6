#pragma once

#include <google/protobuf/duration.pb.h>
#include <google/protobuf/timestamp.pb.h>

#include <cstdint>

namespace lightbatch::server {

/// Microseconds since 1970 -> Timestamp.
inline google::protobuf::Timestamp to_timestamp(std::int64_t us) {
  google::protobuf::Timestamp time;
  time.set_seconds(us / 1'000'000);
  time.set_nanos(static_cast<std::int32_t>(us % 1'000'000) * 1000);
  return time;
}

inline google::protobuf::Duration to_duration(double seconds) {
  google::protobuf::Duration duration;
  const auto whole = static_cast<std::int64_t>(seconds);
  duration.set_seconds(whole);
  duration.set_nanos(static_cast<std::int32_t>((seconds - static_cast<double>(whole)) * 1e9));
  return duration;
}

inline double to_seconds(const google::protobuf::Duration& duration) {
  return static_cast<double>(duration.seconds()) + duration.nanos() * 1e-9;
}
inline double to_seconds(const google::protobuf::Timestamp& time) {
  return static_cast<double>(time.seconds()) + time.nanos() * 1e-9;
}

}  // namespace lightbatch::server
