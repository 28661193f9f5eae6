#include "client/cli/progress_line.h"

#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "client/cli/units.h"

namespace lightbatch::cli {
namespace {

constexpr auto kRedraw = std::chrono::milliseconds(100);
constexpr std::int64_t kShownTransfer = std::int64_t{8} << 20;
constexpr auto kPlainLine = std::chrono::seconds(10);

int terminal_width() {
  winsize size = {};
  return ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0 ? size.ws_col : 80;
}

}  // namespace

ProgressLine::ProgressLine(bool quiet) : quiet_(quiet), terminal_(isatty(STDERR_FILENO) == 1) {}

ProgressLine::~ProgressLine() { clear(); }

void ProgressLine::show(const std::string& phase, double fraction, double remaining) {
  if (quiet_) return;
  const auto now = std::chrono::steady_clock::now();
  const bool new_phase = phase != phase_;
  if (!new_phase && now - shown_ < (terminal_ ? std::chrono::steady_clock::duration(kRedraw)
                                              : std::chrono::steady_clock::duration(kPlainLine))) {
    return;
  }
  phase_ = phase;
  shown_ = now;
  const double clamped = std::clamp(fraction, 0.0, 1.0);
  char figures[96];
  std::snprintf(figures, sizeof figures, "%3.0f %%", clamped * 100);
  std::string text = figures;
  if (remaining >= 0) text += "  " + format_seconds(remaining) + " left";
  if (!terminal_) {
    // A line when a phase begins; figures once there is something to count.
    if (fraction > 0) {
      std::fprintf(stderr, "%-20s %s\n", phase.c_str(), text.c_str());
    } else {
      std::fprintf(stderr, "%s\n", phase.c_str());
    }
    return;
  }
  const int cells = std::clamp(terminal_width() - 58, 8, 40);
  const auto filled = static_cast<int>(std::lround(clamped * cells));
  const std::string bar = std::string(static_cast<std::size_t>(filled), '#') +
                          std::string(static_cast<std::size_t>(cells - filled), '.');
  std::fprintf(stderr, "\r\033[K%-20.20s [%s] %s", phase.c_str(), bar.c_str(), text.c_str());
  std::fflush(stderr);
  drawn_ = true;
}

void ProgressLine::clear() {
  if (drawn_) std::fprintf(stderr, "\r\033[K");
  std::fflush(stderr);
  drawn_ = false;
}

void show_transfer(ProgressLine& line, const char* phase, std::int64_t done, std::int64_t total) {
  if (total < kShownTransfer) return;
  line.show(phase, static_cast<double>(done) / static_cast<double>(total), -1);
}

}  // namespace lightbatch::cli
