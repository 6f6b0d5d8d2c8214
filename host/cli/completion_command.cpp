#include "cli/completion_command.h"

#include <fmt/chrono.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <sys/stat.h>

#include <CLI/CLI.hpp>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "cli/shipped.h"

namespace quoin {

namespace {

using CLI::App;
using CLI::Option;

// Kind of word after an option, or as a positional argument.
enum class Kind { nothing, free_text, choices, folder, law, file };
struct Values {
  Kind kind;
  std::vector<std::string> choices = {};
};

Values values_of(const Option& option) {
  if (option.get_items_expected_max() == 0) return {Kind::nothing};
  const std::string type = option.get_type_name();
  const auto holds = [&](const char* word) { return type.find(word) != std::string::npos; };
  if (const size_t open = type.find('{'), close = type.find('}'); open < close && close != std::string::npos)
    return {Kind::choices, CLI::detail::split(type.substr(open + 1, close - open - 1), ',')};
  if (holds("DIR")) return {Kind::folder};
  if (holds("NAME_OR_PATH") || option.check_lname("law")) return {Kind::law};
  if (holds("INT") || holds("FLOAT") || option.check_lname("set")) return {Kind::free_text};
  return {Kind::file};
}

bool is_repeated(const Option& option) { return option.get_expected_max() > 1; }

std::vector<const App*> commands_of(const App& app) {
  return app.get_subcommands([](const App*) { return true; });
}
std::vector<const Option*> options_of(const App& command, bool positional) {
  return command.get_options([&](const Option* o) { return o->get_positional() == positional; });
}
std::vector<std::string> names_of(const Option& option) {
  std::vector<std::string> names;
  for (const std::string& name : option.get_snames()) names.push_back("-" + name);
  for (const std::string& name : option.get_lnames()) names.push_back("--" + name);
  return names;
}
std::vector<std::string> option_names(const App& command) {
  std::vector<std::string> names;
  for (const Option* option : options_of(command, false))
    for (const std::string& name : names_of(*option)) names.push_back(name);
  return names;
}
std::vector<std::string> command_names(const App& app) {
  std::vector<std::string> names;
  for (const App* command : commands_of(app)) names.push_back(command->get_name());
  return names;
}

// Text with a backslash before each of the given characters.
std::string escaped(std::string_view text, std::string_view characters) {
  std::string result;
  for (const char c : text) {
    if (characters.find(c) != std::string_view::npos) result += '\\';
    result += c;
  }
  return result;
}
// Text in single quotes of a POSIX shell.
std::string single_quoted(std::string_view text) {
  std::string result = "'";
  for (const char c : text) result += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return result + "'";
}

// command of any shell that lists installed laws, one a line
constexpr const char* kLaws = "quoin models 2>/dev/null | cut -d ' ' -f 1";

std::string bash_values(const Values& values) {
  switch (values.kind) {
    case Kind::choices:
      return fmt::format("-W {}", single_quoted(fmt::format("{}", fmt::join(values.choices, " "))));
    case Kind::folder:
      return "-d";
    case Kind::law:
      return fmt::format("-f -W \"$({})\"", kLaws);
    case Kind::file:
      return "-f";
    default:
      return "-W ''";
  }
}

// One function that completes the word at the cursor by compgen. COMP_WORDBREAKS contains '=', so that --out=x is three
// words.
std::string bash_completion(const App& app) {
  std::string text =
      "# Completion of quoin for bash, as `quoin completion bash` prints it.\n"
      "_quoin() {\n"
      "  local word=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD-1]} command=${COMP_WORDS[1]}\n"
      "  if [[ $before == '=' ]]; then before=${COMP_WORDS[COMP_CWORD-2]}; fi\n"
      "  if [[ $word == '=' ]]; then word=; fi\n"
      "  local -a how\n";
  text += fmt::format(
      "  if ((COMP_CWORD == 1)); then how=(-W {}); else\n    case \"$command $before\" in\n",
      single_quoted(fmt::format("{} {}", fmt::join(command_names(app), " "), fmt::join(option_names(app), " "))));
  for (const App* command : commands_of(app)) {
    for (const Option* option : options_of(*command, false)) {
      const Values values = values_of(*option);
      if (values.kind == Kind::nothing) continue;
      std::vector<std::string> patterns;
      for (const std::string& name : names_of(*option))
        patterns.push_back(single_quoted(command->get_name() + " " + name));
      text += fmt::format("      {}) how=({}) ;;\n", fmt::join(patterns, "|"), bash_values(values));
    }
  }
  text += "      *) case \"$command $word\" in\n";
  for (const App* command : commands_of(app)) {
    const std::string names = fmt::format("{}", fmt::join(option_names(*command), " "));
    text += fmt::format("        {}' -'*) how=(-W {}) ;;\n", single_quoted(command->get_name()), single_quoted(names));
    const auto arguments = options_of(*command, true);
    const std::string values =
        arguments.empty() ? bash_values({Kind::free_text}) : bash_values(values_of(*arguments[0]));
    const bool first_only = arguments.size() > 1;  // whether the first argument is of another kind than the later ones
    if (first_only) {
      text += fmt::format("        {}' '*) if ((COMP_CWORD == 2)); then how=({}); else how=({}); fi ;;\n",
                          single_quoted(command->get_name()), values, bash_values(values_of(*arguments[1])));
    } else {
      text += fmt::format("        {}' '*) how=({}) ;;\n", single_quoted(command->get_name()), values);
    }
  }
  return text +
         "      esac ;;\n"
         "    esac\n"
         "  fi\n"
         "  [[ ${how[0]} == -[fd] ]] && compopt -o filenames 2>/dev/null\n"
         "  mapfile -t COMPREPLY < <(compgen \"${how[@]}\" -- \"$word\")\n"
         "}\n"
         "complete -F _quoin quoin\n";
}

std::string zsh_values(const Values& values) {
  switch (values.kind) {
    case Kind::choices:
      return fmt::format("({})", fmt::join(values.choices, " "));
    case Kind::folder:
      return "_files -/";
    case Kind::law:
      return "_quoin_laws";
    case Kind::file:
      return "_files";
    default:
      return " ";
  }
}

std::string zsh_completion(const App& app) {
  std::string text = fmt::format(
      "#compdef quoin\n"
      "# Completion of quoin for zsh, as `quoin completion zsh` prints it.\n"
      "_quoin_laws() {{ compadd -- ${{(f)\"$({})\"}}; _files }}\n"
      "_quoin() {{\n"
      "  local -a commands=(\n",
      kLaws);
  for (const App* command : commands_of(app))
    text +=
        fmt::format("    {}\n", single_quoted(command->get_name() + ":" + escaped(command->get_description(), ":")));
  text +=
      "  )\n"
      "  if ((CURRENT == 2)); then _describe -t commands command commands; return; fi\n"
      "  local command=$words[2]\n"
      "  shift words; ((CURRENT--))\n"
      "  case $command in\n";
  for (const App* command : commands_of(app)) {
    text += fmt::format("    {}) _arguments", command->get_name());
    for (const Option* option : options_of(*command, false)) {
      const Values values = values_of(*option);
      for (const std::string& name : names_of(*option)) {
        std::string entry =
            (is_repeated(*option) ? "*" : "") + name + "[" + escaped(option->get_description(), "[]\\") + "]";
        if (values.kind != Kind::nothing) entry += ":value:" + zsh_values(values);
        text += " \\\n      " + single_quoted(entry);
      }
    }
    for (const Option* argument : options_of(*command, true)) {
      text += " \\\n      " + single_quoted((is_repeated(*argument) ? "*:" : ":") + argument->get_name(true) + ":" +
                                            zsh_values(values_of(*argument)));
    }
    text += " ;;\n";
  }
  return text + "  esac\n}\n_quoin \"$@\"\n";
}

// End of a line of fish: the words that may follow.
std::string fish_values(const Values& values) {
  switch (values.kind) {
    case Kind::nothing:
      return "";
    case Kind::choices:
      return fmt::format(" -x -a {}", single_quoted(fmt::format("{}", fmt::join(values.choices, " "))));
    case Kind::folder:
      return " -x -a '(__fish_complete_directories)'";
    case Kind::law:
      return fmt::format(" -r -F -a {}", single_quoted(fmt::format("(command {})", kLaws)));
    case Kind::file:
      return " -r -F";
    default:
      return " -x";
  }
}

std::string fish_completion(const App& app) {
  std::string text = "# Completion of quoin for fish, as `quoin completion fish` prints it.\n";
  for (const App* command : commands_of(app)) {
    const std::string name = command->get_name();
    text += fmt::format("complete -c quoin -n __fish_use_subcommand -f -a {} -d {}\n", name,
                        single_quoted(command->get_description()));
    const std::string of_command = fmt::format("complete -c quoin -n '__fish_seen_subcommand_from {}'", name);
    for (const Option* argument : options_of(*command, true)) {
      const Values values = values_of(*argument);
      if (values.kind == Kind::choices)
        text += fmt::format("{} -a {}\n", of_command, single_quoted(fmt::format("{}", fmt::join(values.choices, " "))));
    }
    for (const Option* option : options_of(*command, false)) {
      text += of_command;
      for (const std::string& letter : option->get_snames()) text += " -s " + letter;
      for (const std::string& word : option->get_lnames()) text += " -l " + word;
      text += fmt::format("{} -d {}\n", fish_values(values_of(*option)), single_quoted(option->get_description()));
    }
  }
  return text;
}

// Text of a manual page: no macro at the start of a line, minus signs for copying, lists with line breaks.
std::string roff(std::string_view text) {
  std::string result;
  bool line_begins = true;
  for (const char c : text) {
    if (line_begins && (c == '.' || c == '\'')) result += "\\&";
    if (c == '\\')
      result += "\\e";
    else if (c == '-')
      result += "\\-";
    else if (c == ',')
      result += ",\\:";
    else
      result += c;
    line_begins = c == '\n';
  }
  return result;
}
// Lines without filling, as examples require.
std::string roff_lines(std::string_view text) {
  while (text.starts_with('\n')) text.remove_prefix(1);
  return text.empty() ? "" : fmt::format(".PP\n.nf\n{}\n.fi\n", roff(text));
}

class RoffOptions : public CLI::Formatter {
 public:
  std::string entry(const Option& option) const {
    const bool positional = option.get_positional();
    const std::string description = option.get_description();
    return fmt::format(".TP\n\\fB{}\\fR{}\n{}\n", roff(make_option_name(&option, positional)),
                       roff(make_option_opts(&option)), roff(description));
  }
  std::string usage_words(const App& command) const {
    std::string words;
    for (const Option* argument : options_of(command, true)) words += " " + make_option_usage(argument);
    return words;
  }
};

// Date of the program file.
std::string day_of_program() {
  struct stat status {};
  const bool known = stat("/proc/self/exe", &status) == 0;
  return fmt::format("{:%Y-%m-%d}", fmt::gmtime(known ? status.st_mtime : 0));
}

// share: folder of installed scenes and pages; empty: next to the program, or in the source tree.
std::string manual_page(const App& app, const std::string& share) {
  const RoffOptions options;
  const std::string description = app.get_description();
  const size_t examples = description.find("\n\n");
  std::string text = fmt::format(
      ".TH QUOIN 1 {} \"Quoin {}\" \"User Commands\"\n"
      ".ad l\n"
      ".SH NAME\nquoin \\- discrete-element analysis of masonry\n"
      ".SH SYNOPSIS\n.B quoin\n.I COMMAND\n[OPTIONS]\n"
      ".SH DESCRIPTION\n{}\n{}.SH COMMANDS\n",
      day_of_program(), QUOIN_VERSION, roff(description.substr(0, examples)),
      examples == std::string::npos ? "" : roff_lines(description.substr(examples)));
  for (const App* command : commands_of(app)) {
    text += fmt::format(".SS quoin {}{}\n{}\n", roff(command->get_name()), roff(options.usage_words(*command)),
                        roff(command->get_description()));
    for (const bool positional : {true, false})
      for (const Option* option : options_of(*command, positional))
        if (!option->check_lname("help")) text += options.entry(*option);
    text += roff_lines(with_shipped_places(command->get_footer(), share));
  }
  text += ".SH EXIT STATUS\n" + roff(app.get_footer()) + "\n";
  return with_shipped_places(text, share);
}

}  // namespace

void add_completion_command(App& app) {
  struct Options {
    std::string of, share;
  };
  auto options = std::make_shared<Options>();
  App* command = app.add_subcommand("completion", "Print completions for a shell, or the manual page");
  command->add_option("of", options->of, "Shell, or man for the page that `man quoin` shows")
      ->required()
      ->type_name("OF")
      ->check(CLI::IsMember({"bash", "zsh", "fish", "man"}));
  command->add_option("--share", options->share, "Where scenes and pages are installed (of the manual page)")
      ->type_name("DIR");
  command->footer(
      "Installed programs have them in place. From the build folder:\n"
      "  source <(quoin completion bash)\n"
      "  quoin completion zsh > ~/.zfunc/_quoin\n"
      "  quoin completion fish > ~/.config/fish/completions/quoin.fish\n"
      "  quoin completion man | man -l -");
  command->callback([&app, options] {
    const std::string text = options->of == "bash"   ? bash_completion(app)
                             : options->of == "zsh"  ? zsh_completion(app)
                             : options->of == "fish" ? fish_completion(app)
                                                     : manual_page(app, options->share);
    fmt::print("{}", text);
  });
}

}  // namespace quoin
