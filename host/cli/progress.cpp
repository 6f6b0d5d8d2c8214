#include "cli/progress.h"

#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numeric>

#include "files/notice.h"

namespace quoin {

namespace {

constexpr double kLineInterval = 5.0;  // s between lines without a terminal

std::string time_left(double seconds) {
  if (!(seconds >= 0 && seconds < 100 * 3600)) return "--:--";  // not known, or a guess from a ramp
  const long s = std::lround(seconds);
  return s < 3600 ? fmt::format("{}:{:02}", s / 60, s % 60)
                  : fmt::format("{}:{:02}:{:02}", s / 3600, s / 60 % 60, s % 60);
}

// 0 for values that would be printed as -0.00.
double without_sign_of_zero(double value, double last_digit) { return std::abs(value) < last_digit / 2 ? 0.0 : value; }

// Bar with a resolution of eighths of a character.
std::string bar(double fraction, int width) {
  static const char* const kEighths[] = {" ", "▏", "▎", "▍", "▌", "▋", "▊", "▉"};
  const int eighths = static_cast<int>(std::clamp(fraction, 0.0, 1.0) * width * 8);
  std::string result;
  for (int i = 0; i < width; ++i) result += eighths >= 8 * (i + 1) ? "█" : kEighths[std::max(0, eighths - 8 * i)];
  return result;
}

}  // namespace

ProgressLine::ProgressLine() : terminal_(isatty(STDERR_FILENO) != 0) {}

void ProgressLine::clear() {
  if (drawn_) std::fputs("\r\033[K", stderr);
  drawn_ = false;
}

void ProgressLine::message(const std::string& text) {
  clear();
  notice(text);
}

void ProgressLine::show(const Progress& p, const RunSoFar& so_far) {
  const auto now = std::chrono::steady_clock::now();
  const bool new_stage = p.stage != last_stage_;
  if (!terminal_ && !new_stage && std::chrono::duration<double>(now - last_).count() < kLineInterval) return;
  last_ = now;
  last_stage_ = p.stage;
  const std::string stage = fmt::format("{}/{} {}", p.stage + 1, p.stage_count, p.settings ? p.settings->name : "");
  const std::string numbers =
      fmt::format("{:3.0f} %  left {}  {:.3f} mm  {:.2f} kN  peak {:.2f} kN  unbalanced {:.1e}  {:.0f} steps/s",
                  100 * p.fraction, time_left(p.seconds_left), without_sign_of_zero(so_far.displacement * 1e3, 1e-3),
                  without_sign_of_zero(so_far.force / 1e3, 1e-2), without_sign_of_zero(so_far.peak / 1e3, 1e-2),
                  p.unbalanced_ratio, p.steps_per_second);
  if (!terminal_) {
    notice(fmt::format("[{}] {}", stage, numbers));
  } else {
    winsize size{};
    const int columns = ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0 ? size.ws_col : 80;
    const int room = columns - static_cast<int>(stage.size() + numbers.size()) - 6;
    std::string line = stage + " ";
    if (room >= 6) line += "│" + bar(p.fraction, std::min(room, 40)) + "│ ";
    line += numbers;
    if (room < -4) line.resize(static_cast<size_t>(std::max(0, columns - 1)));  // too narrow for a bar: cut
    std::fputs(("\r\033[K" + line).c_str(), stderr);
    std::fflush(stderr);
    drawn_ = true;
  }
}

std::string phases_text(const PhaseTimes& times, double whole) {
  const char* const names[kPhases] = {"jumps of contact points",
                                      "law",
                                      "contact forces",
                                      "internal forces",
                                      "motion of blocks",
                                      "detection",
                                      "measurements",
                                      "watch",
                                      "output",
                                      "other ranks",
                                      "members"};
  std::string text = "time:";
  // Phases are timed in one of kTimedSteps steps: on a loaded machine their sum can exceed the time of the run.
  whole = std::max(whole, std::accumulate(times.seconds.begin(), times.seconds.end(), 0.0));
  double rest = whole;
  for (std::size_t k = 0; k < kPhases; ++k) {
    rest -= times.seconds[k];
    const double share = 100.0 * times.seconds[k] / whole;
    if (share >= 0.5) text += fmt::format(" {} {:.0f} %,", names[k], share);
  }
  return text + fmt::format(" set-up and the rest {:.0f} %", std::max(0.0, 100.0 * rest / whole));
}

std::string ranks_text(const std::vector<RankTraffic>& ranks) {
  RankTraffic most, sum;
  for (const RankTraffic& r : ranks) {
    most.halo_bytes = std::max(most.halo_bytes, r.halo_bytes);
    most.halo_messages = std::max(most.halo_messages, r.halo_messages);
    most.blocks = std::max(most.blocks, r.blocks);
    sum.waiting_seconds += r.waiting_seconds, sum.gathering_seconds += r.gathering_seconds;
    sum.step_seconds += r.step_seconds;
    sum.blocks += r.blocks;
    sum.points += r.points, sum.shared_points += r.shared_points;
  }
  const RankTraffic& first = ranks.front();
  const double steps = std::max(1.0, first.steps), count = static_cast<double>(ranks.size());
  const std::string divided =
      first.repartitions > 0.0
          ? fmt::format("; divided anew {:.0f} times by measured cost, most / mean of it {:.2f} before, {:.2f} at last",
                        first.repartitions, first.uneven_before, first.uneven)
          : "";
  return fmt::format(
      "ranks: {}; at most {:.2f} kB in {:.3g} messages a rank and step; waiting {:.1f} %, gathering {:.1f} % ({:.0f} "
      "times {:.3g} MB); at most {:.3g} times the mean of blocks, {:.0f} % of contact points on borders{}",
      ranks.size(), most.halo_bytes / steps / 1e3, most.halo_messages / steps,
      100.0 * sum.waiting_seconds / sum.step_seconds, 100.0 * sum.gathering_seconds / sum.step_seconds, first.gathers,
      first.gathers > 0.0 ? first.gathered_bytes / first.gathers / 1e6 : 0.0, count * most.blocks / sum.blocks,
      100.0 * sum.shared_points / std::max(1.0, sum.points), divided);
}

}  // namespace quoin
