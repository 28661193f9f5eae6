#include "core/pipeline/stage_clock.h"

#include <sys/resource.h>
#include <time.h>

namespace lightbatch::pipeline {
namespace {

double read_clock(clockid_t clock) {
  timespec now{};
  ::clock_gettime(clock, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}
double wall() { return read_clock(CLOCK_MONOTONIC); }
double cpu() { return read_clock(CLOCK_PROCESS_CPUTIME_ID); }

std::uint64_t peak_bytes() {
  rusage usage{};
  ::getrusage(RUSAGE_SELF, &usage);
  return static_cast<std::uint64_t>(usage.ru_maxrss) * 1024;
}

}  // namespace

StageClock::StageClock() : first_(wall()), cpu_first_(cpu()) {}

void StageClock::start(std::string name) {
  stop();
  running_ = std::move(name);
  began_ = wall();
  cpu_began_ = cpu();
}

void StageClock::stop() {
  if (running_.empty()) return;
  stages_.push_back({std::move(running_), wall() - began_, cpu() - cpu_began_, peak_bytes()});
  running_.clear();
}

double StageClock::seconds() const { return wall() - first_; }
double StageClock::cpu_seconds() const { return cpu() - cpu_first_; }

}  // namespace lightbatch::pipeline
