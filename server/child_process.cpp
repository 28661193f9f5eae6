#include "server/child_process.h"

#include <fcntl.h>
#include <poll.h>
#include <spawn.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <vector>

#include "server/worker.h"

namespace lightbatch::server {
namespace {

using Clock = std::chrono::steady_clock;

constexpr int kPollMilliseconds = 100;

Status system_error(const char* what, int error) {
  return Status(StatusCode::kInternal, "IO_ERROR", std::string(what) + ": " + std::strerror(error));
}

std::vector<std::string> child_environment() {
  std::vector<std::string> kept;
  for (const char* name : {"ASAN_OPTIONS", "UBSAN_OPTIONS", "TSAN_OPTIONS", "LSAN_OPTIONS"}) {
    if (const char* value = std::getenv(name)) kept.push_back(std::string(name) + "=" + value);
  }
  return kept;
}

Result<pid_t> spawn(const std::filesystem::path& folder, int frames) {
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  const std::string log = folder / "stderr.log";
  posix_spawn_file_actions_addopen(&actions, 0, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_addopen(&actions, 1, "/dev/null", O_WRONLY, 0);
  posix_spawn_file_actions_addopen(&actions, 2, log.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
  posix_spawn_file_actions_adddup2(&actions, frames, kFrameDescriptor);
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  sigset_t none;
  sigset_t all;
  sigemptyset(&none);
  sigfillset(&all);
  posix_spawnattr_setsigmask(&attributes, &none);
  posix_spawnattr_setsigdefault(&attributes, &all);
  posix_spawnattr_setpgroup(&attributes, 0);
  posix_spawnattr_setflags(&attributes,
                           POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF | POSIX_SPAWN_SETPGROUP);
  std::string name = "lightbatch-worker";
  std::string argument = kWorkerArgument;
  std::string where = folder;
  char* arguments[] = {name.data(), argument.data(), where.data(), nullptr};
  std::vector<std::string> environment = child_environment();
  std::vector<char*> pointers;
  for (std::string& entry : environment) pointers.push_back(entry.data());
  pointers.push_back(nullptr);
  pid_t pid = 0;
  const int error =
      posix_spawn(&pid, "/proc/self/exe", &actions, &attributes, arguments, pointers.data());
  posix_spawnattr_destroy(&attributes);
  posix_spawn_file_actions_destroy(&actions);
  if (error != 0) return system_error("cannot start a worker", error);
  return pid;
}

/// Cuts the byte stream of a child into frames.
class FrameReader {
 public:
  /// False when the stream breaks its rules.
  bool feed(std::string_view bytes, const std::function<void(std::string_view)>& on_frame) {
    pending_ += bytes;
    while (pending_.size() >= 4) {
      std::uint32_t size = 0;
      for (std::size_t i = 0; i < 4; ++i) {
        size |= static_cast<std::uint32_t>(static_cast<unsigned char>(pending_[i])) << (8 * i);
      }
      if (size > kMaxFrameBytes) return false;
      if (pending_.size() < 4 + std::size_t{size}) break;
      on_frame(std::string_view(pending_).substr(4, size));
      pending_.erase(0, 4 + std::size_t{size});
    }
    return true;
  }

 private:
  std::string pending_;
};

/// Sends what the parent orders, each signal once.
class Reaper {
 public:
  Reaper(pid_t pid, double grace_seconds) : pid_(pid), grace_(grace_seconds) {}

  void obey(ChildOrder order) {
    if (order == ChildOrder::kKill) kill();
    if (order != ChildOrder::kStop || killed_) return;
    if (!stopped_) {
      stopped_ = true;
      stop_time_ = Clock::now();
      ::kill(pid_, SIGTERM);
    } else if (Clock::now() - stop_time_ > grace_) {
      kill();
    }
  }
  void kill() {
    if (!killed_) ::kill(pid_, SIGKILL);
    killed_ = true;
  }

 private:
  pid_t pid_;
  std::chrono::duration<double> grace_;
  bool stopped_ = false;
  Clock::time_point stop_time_;
  bool killed_ = false;
};

}  // namespace

Result<ChildExit> run_child(const std::filesystem::path& folder, double grace_seconds,
                            const std::function<void(std::string_view)>& on_frame,
                            const std::function<ChildOrder()>& orders) {
  int ends[2];
  if (::pipe2(ends, O_CLOEXEC) != 0) return system_error("pipe", errno);
  auto spawned = spawn(folder, ends[1]);
  ::close(ends[1]);
  if (!spawned.ok()) {
    ::close(ends[0]);
    return spawned.status();
  }
  const pid_t pid = *spawned;
  Reaper reaper(pid, grace_seconds);
  FrameReader reader;
  std::vector<char> block(std::size_t{1} << 16);
  for (bool open = true; open;) {
    pollfd wanted = {ends[0], POLLIN, 0};
    const int ready = ::poll(&wanted, 1, kPollMilliseconds);
    reaper.obey(orders());
    if (ready <= 0) continue;
    const ssize_t got = ::read(ends[0], block.data(), block.size());
    if (got < 0 && errno == EINTR) continue;
    open = got > 0;
    if (open && !reader.feed({block.data(), static_cast<std::size_t>(got)}, on_frame)) {
      reaper.kill();
      open = false;
    }
  }
  ::close(ends[0]);
  // The pipe is closed: the child is ending, or it closed the pipe and must be made to end.
  int wait_status = 0;
  rusage usage = {};
  while (true) {
    const pid_t ended = ::wait4(pid, &wait_status, WNOHANG, &usage);
    if (ended == pid) break;
    if (ended < 0 && errno != EINTR) return system_error("wait", errno);
    reaper.obey(orders() == ChildOrder::kGoOn ? ChildOrder::kStop : ChildOrder::kKill);
    ::usleep(2000);
  }
  ChildExit exit;
  if (WIFSIGNALED(wait_status)) exit.signal = WTERMSIG(wait_status);
  if (WIFEXITED(wait_status)) exit.code = WEXITSTATUS(wait_status);
  exit.peak_memory_bytes = static_cast<std::int64_t>(usage.ru_maxrss) * 1024;
  return exit;
}

}  // namespace lightbatch::server
