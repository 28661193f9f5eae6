#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace lightbatch::pipeline {

/// What a stage took.
struct Stage {
  std::string name;
  double seconds = 0;            // wall
  double cpu_seconds = 0;        // user and system, all threads
  std::uint64_t peak_bytes = 0;  // resident, of the process so far
};

/// Times the stages of a job, one after another.
class StageClock {
 public:
  StageClock();
  /// Ends the running stage, if any, and starts the next.
  void start(std::string name);
  void stop();
  const std::vector<Stage>& stages() const { return stages_; }
  /// Since construction.
  double seconds() const;
  double cpu_seconds() const;

 private:
  std::vector<Stage> stages_;
  std::string running_;
  double began_ = 0, cpu_began_ = 0;
  double first_ = 0, cpu_first_ = 0;
};

}  // namespace lightbatch::pipeline
