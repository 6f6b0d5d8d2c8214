// The program `quoin`: one file per command, each registered here. Exit codes are those of base/error.h.
#include <fcntl.h>
#include <fmt/format.h>
#ifdef __GLIBC__
#include <malloc.h>
#endif
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <iostream>
#include <memory>
#include <new>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/any_error.h"
#include "base/error.h"
#include "base/printable.h"
#include "cli/check_command.h"
#include "cli/completion_command.h"
#include "cli/ensemble_command.h"
#include "cli/fit_command.h"
#ifdef QUOIN_LIMIT
#include "cli/limit_command.h"
#endif
#ifdef QUOIN_MODES
#include "cli/modes_command.h"
#endif
#include "cli/models_command.h"
#include "cli/new_command.h"
#include "cli/path_command.h"
#include "cli/report_command.h"
#include "cli/reproduce_command.h"
#include "cli/rest_command.h"
#include "cli/run_command.h"
#include "cli/shipped.h"
#include "cli/spectrum_command.h"
#include "cli/validate_command.h"
#include "files/notice.h"
#include "law/law_calls.h"
#include "law/law_watch.h"
#include "scene/read_scene.h"

namespace {

using quoin::Exit;
using quoin::notice;

// Fills closed standard descriptors, which the next opened file would get, together with the program's output. The
// replacement fails as a closed descriptor does.
void fill_closed_descriptors() {
  for (const int number : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) {
    if (fcntl(number, F_GETFD) < 0 && errno == EBADF) {
      const int null = open("/dev/null", number == STDIN_FILENO ? O_WRONLY : O_RDONLY);  // takes the lowest free one
      if (null != number && null >= 0) close(null);
    }
  }
}

// Ends the program with a message when memory is short in a place that cannot throw, as a destructor.
[[noreturn]] void end_without_handler() {
  try {
    if (std::current_exception()) throw;
  } catch (const std::bad_alloc&) {
    static const char kWords[] = "quoin: out of memory; make the scene smaller\n";
    if (write(STDERR_FILENO, kWords, sizeof kWords - 1) < 0) _exit(static_cast<int>(Exit::numerical));
    _exit(static_cast<int>(Exit::numerical));
  } catch (...) {  // of a law, perhaps: the handler of SIGABRT names it
  }
  std::abort();
}

// Before the construction of static objects, which allocate memory too.
[[gnu::constructor(101)]] void end_with_words() { std::set_terminate(end_without_handler); }

class Help : public CLI::Formatter {
 public:
  std::string make_help(const CLI::App* app, std::string name, CLI::AppFormatMode mode) const override {
    return quoin::with_shipped_places(CLI::Formatter::make_help(app, std::move(name), mode));
  }
};

// Prints a similar command or option for each unknown one.
void suggest(const CLI::App& app, const std::vector<std::string>& words) {
  std::vector<std::string> commands, options;
  for (const CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; }))
    commands.push_back(command->get_name());
  const bool known = !words.empty() && std::ranges::find(commands, words[0]) != commands.end();
  if (!known && !words.empty() && !words[0].starts_with('-')) {
    const std::string word = quoin::printable(words[0]);
    return notice(fmt::format("quoin: {}: no such command{}", word, quoin::did_you_mean(words[0], commands)));
  }
  if (!known) return;
  const CLI::App* command = app.get_subcommand(words[0]);
  for (const CLI::Option* option : command->get_options())
    for (const std::string& name : option->get_lnames()) options.push_back("--" + name);
  for (const std::string& word : words) {
    const std::string name = word.substr(0, word.find('='));
    if (!name.starts_with("--") || name == "--" || std::ranges::find(options, name) != options.end()) continue;
    notice(fmt::format("quoin {}: {}: no such option{}", words[0], quoin::printable(name),
                       quoin::did_you_mean(name, options)));
  }
}

// A setting without key or "=" is an error of the command line; scenes and laws judge keys and values.
std::string fault_of_setting(const std::string& text) {
  const std::size_t equals = text.find('=');
  if (equals != std::string::npos && equals > 0) return "";
  return fmt::format("'{}': {}; write --set key=value", text, equals == 0 ? "the key is missing" : "it has no '='");
}

int run_command(int argc, char** argv) {
  CLI::App app{
      "Quoin: discrete-element analysis of masonry with contact laws that are loaded at run time.\n\n"
      "Examples:\n"
      "  quoin new wall my.toml                             a commented scene to begin with\n"
      "  quoin run host/scenes/solid_wall_030.toml          a wall test, to out/solid_wall_030\n"
      "  quoin check host/scenes/solid_wall_030.toml        sizes and time step, without running\n"
      "  quoin models fracture_energy                       properties and states of a law\n"
      "  quoin path tests/law/paths/couplet.toml            one contact point along a path, beside its closed form\n"
      "  quoin fit --help                                   properties of a joint from measured curves\n"
      "  quoin reproduce --list                             the studies of the paper\n"
      "  quoin report out/solid_wall_030                    a page of a run, for a browser\n"
      "  quoin ensemble host/studies/solid_wall_030.toml    many walls with scattered joints\n"
      "  quoin spectrum RECORD.AT2 --out out/spectrum       response spectrum of a record"};
  app.name("quoin");
  app.formatter(std::make_shared<Help>());
  app.footer(
      "Exit codes: 0 done, 2 wrong command line, 3 bad input, 4 a law could not be loaded or refused its properties,\n"
      "5 numerical failure, 130 interrupted (what was computed is kept).");
  app.set_version_flag("--version", "quoin " QUOIN_VERSION);
  app.require_subcommand(1);
  app.get_formatter()->column_width(34);

  int exit_code = 0;
  quoin::add_run_command(app, exit_code);
  quoin::add_check_command(app, exit_code);
  quoin::add_new_command(app);
  quoin::add_models_command(app, exit_code);
  quoin::add_path_command(app, exit_code);
  quoin::add_fit_command(app, exit_code);
  quoin::add_reproduce_command(app, exit_code);
  quoin::add_report_command(app);
  quoin::add_ensemble_command(app, exit_code);
  quoin::add_sensitivity_command(app, exit_code);
  quoin::add_spectrum_command(app);
  quoin::add_validate_command(app, exit_code);
#ifdef QUOIN_LIMIT
  quoin::add_limit_command(app);
#endif
#ifdef QUOIN_MODES
  quoin::add_rest_command(app, exit_code);
  quoin::add_modes_command(app);
#endif
  quoin::add_completion_command(app);
  std::optional<quoin::LawWatchdog> watchdog;
  for (CLI::App* command : app.get_subcommands({})) {
    if (command->get_option_no_throw("--law-seconds") == nullptr)  // which has a limit of its own
      command->preparse_callback(
          [&](std::size_t) { watchdog.emplace(quoin::kLawSeconds, quoin::end_program(quoin::kLawSeconds)); });
    if (CLI::Option* out = command->get_option_no_throw("--out"))
      out->check([](const std::string& name) { return std::string(name.empty() ? "an empty name" : ""); }, "");
    if (CLI::Option* set = command->get_option_no_throw("--set")) set->check(fault_of_setting, "");
  }

  std::vector<std::string> words(argv + 1, argv + argc);
  if (!words.empty() && words[0] == "help") {
    words.erase(words.begin());
    const auto is_named = [&](const CLI::App* command) { return command->get_name() == words[0]; };
    if (words.empty() || std::ranges::any_of(app.get_subcommands({}), is_named)) words.emplace_back("--help");
  }
  try {
    std::vector<std::string> last_first(words.rbegin(), words.rend());
    app.parse(std::move(last_first));
  } catch (const CLI::ParseError& error) {
    const bool asked_for = error.get_exit_code() == 0;  // --help, --version
    app.exit(error);
    if (!asked_for) suggest(app, words);
    return asked_for ? 0 : static_cast<int>(Exit::usage);
  } catch (const quoin::Error& error) {
    if (error.exit_code != Exit::interrupted) notice(fmt::format("quoin: {}", error.what()));
    return static_cast<int>(error.exit_code);
  } catch (const std::exception& error) {
    if (std::ferror(stdout) != 0) return exit_code;  // reported by main
    const quoin::Error reported = quoin::any_error(error);
    notice(fmt::format("quoin: {}", reported.what()));
    return static_cast<int>(reported.exit_code);
  }
  return exit_code;
}

// Keeps up to kKept bytes of freed memory. Each contact detection frees and allocates some megabytes: given back, they
// come as new pages, which the system clears.
void keep_freed_memory() {
#ifdef __GLIBC__
  constexpr int kKept = 256 << 20, kLargestArray = 32 << 20;
  mallopt(M_TRIM_THRESHOLD, kKept), mallopt(M_MMAP_THRESHOLD, kLargestArray);
#endif
}

}  // namespace

int main(int argc, char** argv) {
  keep_freed_memory();
  fill_closed_descriptors();
  std::signal(SIGXFSZ, SIG_IGN);  // the size limit of a file becomes an error of the file, with a message
  quoin::watch_laws();
  const int exit_code = run_command(argc, argv);
  quoin::end_of_watch();
  std::cout.flush();
  if (std::fflush(stdout) == 0 && std::ferror(stdout) == 0 && std::cout.good()) return exit_code;
  notice(
      "quoin: the standard output cannot be written (closed, or no space); what was to be read there is not complete");
  return exit_code != 0 ? exit_code : static_cast<int>(Exit::bad_input);
}
