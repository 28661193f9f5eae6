#include "tests/server/test_engine.h"

#include <dirent.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <new>
#include <string>
#include <thread>
#include <vector>

#include "core/base/bytes.h"

namespace lightbatch::server::test {
namespace {

using Clock = std::chrono::steady_clock;

[[noreturn]] void eat_memory() {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  throw std::bad_alloc();  // these builds run without the limit
#else
  std::vector<std::vector<char> > eaten;
  while (true) eaten.emplace_back(std::size_t{16} << 20);
#endif
}

/// Whether the ways out are open. Sanitized builds have no filter of calls: there execl would end
/// the worker.
std::string forbidden_text() {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  return "";
#else
  return " network=" + std::to_string(socket(AF_INET, SOCK_STREAM, 0) >= 0) +
         " programs=" + std::to_string(execl("/bin/true", "true", nullptr) == 0 || errno != EPERM);
#endif
}

std::string limits_text() {
  rlimit memory = {};
  rlimit core = {};
  rlimit cpu = {};
  getrlimit(RLIMIT_AS, &memory);
  getrlimit(RLIMIT_CORE, &core);
  getrlimit(RLIMIT_CPU, &cpu);
  int open_files = 0;
  if (DIR* folder = opendir("/proc/self/fd")) {
    while (readdir(folder) != nullptr) ++open_files;
    closedir(folder);
  }
  std::string variables;
  for (char** entry = environ; *entry != nullptr; ++entry) variables += std::string(*entry) + ";";
  return "memory=" + std::to_string(memory.rlim_cur) + " core=" + std::to_string(core.rlim_cur) +
         " cpu_limited=" + std::to_string(cpu.rlim_cur != RLIM_INFINITY) +
         " no_new_privs=" + std::to_string(prctl(PR_GET_NO_NEW_PRIVS, 0, 0, 0, 0)) +
         // ".", "..", the listing itself, 0, 1, 2 and the frame pipe
         " extra_files=" + std::to_string(open_files - 7) + forbidden_text() +
         " environment=" + variables;
}

/// Reports progress for `seconds` or until cancelled.
Status spend(double seconds, const Progress& progress) {
  const auto start = Clock::now();
  for (double at = 0; at < seconds;
       at = std::chrono::duration<double>(Clock::now() - start).count()) {
    progress.report("spend", at / seconds);
    if (progress.cancelled()) return cancelled();
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  return {};
}

Result<pipeline::JobOutcome> run(const pipeline::JobOptions&, const pipeline::JobInput& input,
                                 const std::filesystem::path& output, const Progress& progress) {
  LB_ASSIGN_OR_RETURN(const Bytes bytes, read_file(input.files.at(input.scene)));
  std::string text(as_text(bytes));
  const std::string word = text.substr(0, text.find_first_of(" \n"));
  progress.report("begin", 0);
  pipeline::JobOutcome outcome;
  if (word == "malformed") return malformed("scene.gltf#/nodes/3", "a node names no mesh");
  if (word == "slow") LB_RETURN_IF_ERROR(spend(1e6, progress));
  if (word == "sleep") LB_RETURN_IF_ERROR(spend(std::stod(text.substr(6)) / 1000, progress));
  if (word == "deaf") std::this_thread::sleep_for(std::chrono::hours(1));
  if (word == "crash") std::raise(SIGSEGV);
  if (word == "abort") LB_CHECK(word.empty(), "broken on purpose");
  if (word == "exit") std::_Exit(3);
  if (word == "oom") eat_memory();
  if (word == "oom-thread") std::thread(eat_memory).join();
  if (word == "limits") text = limits_text();
  if (word == "missed") outcome.verdict = pipeline::Verdict::kMissedTarget;
  LB_RETURN_IF_ERROR(write_file(output / "result.txt", as_bytes(text)));
  LB_RETURN_IF_ERROR(write_file(output / "report.html", as_bytes("<p>report of a test")));
  outcome.artifacts = {"report.html", "result.txt"};
  outcome.summary = "a test job\n";
  progress.report("end", 1);
  return outcome;
}

Status check(const pipeline::JobOptions& options) {
  return options.target_error > 0 && options.time_budget > 0
             ? bad_option("target_error and time_budget exclude each other")
             : Status();
}

std::string build() { return "test build"; }

}  // namespace

Engine engine() { return {run, check, build}; }

}  // namespace lightbatch::server::test
