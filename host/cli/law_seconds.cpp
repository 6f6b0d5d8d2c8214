#include "cli/law_seconds.h"

#include <cmath>

#include "base/number_text.h"
#include "law/law_trial.h"

namespace quoin {

std::string is_number(const std::string& text) {
  double value = 0.0;
  return parse_number(text, value) && std::isfinite(value) ? "" : "'" + text + "' is no number";
}

void add_law_seconds(CLI::App& command, double& seconds) {
  command
      .add_option("--law-seconds", seconds,
                  "Seconds that a law has for one batch, or to be loaded, before the " + command.get_name() +
                      " ends and names it; 0: any time (default: 60, and 10 to be loaded)")
      ->type_name("SECONDS")
      ->check(CLI::Range(0.0, 1e9))
      ->check(is_number);
}

LawWatchdog limit_laws(double seconds) {
  if (seconds != kLawSeconds) law_loading_seconds = seconds;
  return {seconds, end_program(seconds, "--law-seconds")};
}

}  // namespace quoin
