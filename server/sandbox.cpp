#include "server/sandbox.h"

#include <linux/audit.h>
#include <linux/filter.h>
#include <linux/seccomp.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstddef>
#include <cstdlib>
#include <vector>

#include "core/base/check.h"

namespace lightbatch::server {
namespace {

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr bool kSanitizer = true;
#else
constexpr bool kSanitizer = false;
#endif

#if defined(__x86_64__)
constexpr std::uint32_t kArchitecture = AUDIT_ARCH_X86_64;
#elif defined(__aarch64__)
constexpr std::uint32_t kArchitecture = AUDIT_ARCH_AARCH64;
#else
constexpr std::uint32_t kArchitecture = 0;  // no filter
#endif

/// Calls that fail with EPERM: the ways to the network, to other programs, to other processes and
/// to the machine's settings. Threads, memory and files of one's own stay.
constexpr long kForbidden[] = {
    SYS_socket,
    SYS_socketpair,
    SYS_connect,
    SYS_bind,
    SYS_listen,
    SYS_accept,
    SYS_accept4,
    SYS_sendto,
    SYS_io_uring_setup,
    SYS_execve,
    SYS_execveat,
    SYS_ptrace,
    SYS_process_vm_readv,
    SYS_process_vm_writev,
    SYS_kill,
    SYS_pidfd_open,
    SYS_mount,
    SYS_umount2,
    SYS_pivot_root,
    SYS_chroot,
    SYS_unshare,
    SYS_setns,
    SYS_bpf,
    SYS_perf_event_open,
    SYS_userfaultfd,
    SYS_keyctl,
    SYS_add_key,
    SYS_request_key,
    SYS_init_module,
    SYS_finit_module,
    SYS_kexec_load,
    SYS_reboot,
    SYS_swapon,
    SYS_swapoff,
    SYS_setuid,
    SYS_setgid,
#if defined(__x86_64__)
    SYS_fork,
    SYS_vfork,
#endif
};

sock_filter step(unsigned code, std::uint32_t value, std::size_t if_true = 0,
                 std::size_t if_false = 0) {
  return {static_cast<std::uint16_t>(code), static_cast<std::uint8_t>(if_true),
          static_cast<std::uint8_t>(if_false), value};
}

void filter_calls() {
  constexpr std::size_t kCount = std::size(kForbidden);
  static_assert(kCount < 200, "jumps reach 255 steps");
  std::vector<sock_filter> program = {
      step(BPF_LD | BPF_W | BPF_ABS, offsetof(seccomp_data, arch)),
      step(BPF_JMP | BPF_JEQ | BPF_K, kArchitecture, 1, 0),
      step(BPF_RET | BPF_K, SECCOMP_RET_KILL_PROCESS),
      step(BPF_LD | BPF_W | BPF_ABS, offsetof(seccomp_data, nr)),
      // The other numbering of x86-64 (x32) would walk around the list.
      step(BPF_JMP | BPF_JGE | BPF_K, 0x40000000u, kCount + 1, 0),
  };
  for (std::size_t i = 0; i < kCount; ++i) {
    program.push_back(
        step(BPF_JMP | BPF_JEQ | BPF_K, static_cast<std::uint32_t>(kForbidden[i]), kCount - i, 0));
  }
  program.push_back(step(BPF_RET | BPF_K, SECCOMP_RET_ALLOW));
  program.push_back(step(BPF_RET | BPF_K, SECCOMP_RET_ERRNO | EPERM));
  const sock_fprog filter = {static_cast<unsigned short>(program.size()), program.data()};
  // A kernel without seccomp still has the limits around this call.
  static_cast<void>(prctl(PR_SET_SECCOMP, SECCOMP_MODE_FILTER, &filter));
}

void limit(__rlimit_resource resource, std::int64_t value) {
  const rlimit bound = {static_cast<rlim_t>(value), static_cast<rlim_t>(value)};
  LB_CHECK(setrlimit(resource, &bound) == 0, "a process can lower its own limits");
}

}  // namespace

void enter_sandbox(const SandboxLimits& limits) {
  LB_CHECK(prctl(PR_SET_PDEATHSIG, SIGKILL) == 0, "a worker dies with its server");
  if (getppid() != limits.parent) std::_Exit(1);  // it died already
  LB_CHECK(prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) == 0, "no new privileges");
  close_range(static_cast<unsigned>(limits.highest_descriptor) + 1, ~0u, 0);
  limit(RLIMIT_CORE, 0);
  if (limits.cpu_seconds > 0) limit(RLIMIT_CPU, limits.cpu_seconds);
  if (kSanitizer) return;
  if (limits.memory_bytes > 0) limit(RLIMIT_AS, limits.memory_bytes);
  if (kArchitecture != 0) filter_calls();
}

}  // namespace lightbatch::server
