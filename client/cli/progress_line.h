#pragma once

#include <chrono>
#include <cstdint>
#include <string>

namespace lightbatch::cli {

/// What a person sees while waiting, on stderr: a bar that moves on a terminal, otherwise a line
/// when the phase changes and every ten seconds. Silent when quiet.
class ProgressLine {
 public:
  explicit ProgressLine(bool quiet);
  ~ProgressLine();  // clear()
  ProgressLine(const ProgressLine&) = delete;
  ProgressLine& operator=(const ProgressLine&) = delete;

  /// fraction in [0, 1]; remaining seconds < 0: not known.
  void show(const std::string& phase, double fraction, double remaining);
  /// Takes the bar off the terminal before other text is written.
  void clear();

 private:
  const bool quiet_;
  const bool terminal_;
  std::string phase_;
  std::chrono::steady_clock::time_point shown_;
  bool drawn_ = false;
};

/// Bytes on their way; small transfers are over before a line would help.
void show_transfer(ProgressLine& line, const char* phase, std::int64_t done, std::int64_t total);

}  // namespace lightbatch::cli
