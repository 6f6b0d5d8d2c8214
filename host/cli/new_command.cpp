#include "cli/new_command.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <iterator>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "base/error.h"
#include "base/printable.h"
#include "cli/new_texts.h"
#include "files/file.h"
#include "scene/read_scene.h"

namespace quoin {

namespace {

namespace fs = std::filesystem;

struct Beginning {
  std::string_view kind, text, ending, next;  // ending: extension of the file name; next: last line printed
};
constexpr Beginning kBeginnings[] = {
    {"wall", kNewWall, ".toml", "quoin run {}"},
    {"arch", kNewArch, ".toml", "quoin run {}"},
    {"facade", kNewFacade, ".toml", "quoin run {} --report"},
    {"law", kNewLaw, ".c", "the command at the head of {} builds it; then quoin models ./NAME.so"},
};

const Beginning& beginning_of(const std::string& kind) {
  std::vector<std::string> kinds;
  for (const Beginning& b : kBeginnings) {
    if (b.kind == kind) return b;
    kinds.emplace_back(b.kind);
  }
  throw Error(Exit::bad_input, fmt::format("{}: nothing of this kind can be begun{} There are: wall, arch, facade, law",
                                           printable(kind), did_you_mean(kind, kinds)));
}

void replace_all(std::string& text, std::string_view from, std::string_view to) {
  for (std::size_t at = text.find(from); at != std::string::npos; at = text.find(from, at + to.size()))
    text.replace(at, from.size(), to);
}

// Names the headers and the version script of an installed program, in place of those of the source tree.
void name_installed_files(std::string& text) {
  std::error_code fault;
  const fs::path prefix = fs::read_symlink("/proc/self/exe", fault).parent_path().parent_path();
  const fs::path headers = prefix / "include", script = prefix / "share/quoin/quoin.map";
  if (!fs::exists(headers / "quoin/quoin.h", fault) || !fs::exists(script, fault)) return;
  replace_all(text, "plugin_api/include", printable(headers.string()));
  replace_all(text, "plugin_api/quoin.map", printable(script.string()));
}

void begin(const std::string& kind, const fs::path& file, bool force) {
  const Beginning& b = beginning_of(kind);
  if (file.extension() != b.ending) {
    throw Error(Exit::bad_input, fmt::format("{}: a {} is kept in a file whose name ends in {}",
                                             printable(file.string()), kind, b.ending));
  }
  std::error_code fault;
  if (!force && fs::exists(fs::symlink_status(file, fault))) {
    throw Error(Exit::bad_input, fmt::format("{}: is there already; choose another name, or write over it with --force",
                                             printable(file.string())));
  }
  std::string text(b.text);
  replace_all(text, "{file}", printable(file.string()));
  replace_all(text, "{name}", printable(file.stem().string()));
  replace_all(text, "plugin_api/template/template_law.c", printable(file.string()));
  replace_all(text, "template_law.so", printable(file.stem().string() + ".so"));
  name_installed_files(text);
  write_named_file(file, text);
  fmt::print("{} written. Next: {}\n", printable(file.string()),
             fmt::format(fmt::runtime(b.next), printable(file.string())));
}

}  // namespace

void add_new_command(CLI::App& app) {
  struct Options {
    std::string kind, file;
    bool force = false;
  };
  auto options = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand("new", "Write a commented scene or law to begin with");
  command->add_option("kind", options->kind, "wall, arch, facade or law")
      ->required()
      ->type_name("KIND:{wall,arch,facade,law}");
  command->add_option("file", options->file, "File to write: NAME.toml; of a law NAME.c")
      ->required()
      ->type_name("FILE");
  command->add_flag("--force", options->force, "Write over a file that is there");
  command->footer(
      "\nExamples:\n"
      "  quoin new wall my.toml        a wall of bricks in mortar, pressed and pushed\n"
      "  quoin new arch arch.toml      a dry arch, pushed until it falls\n"
      "  quoin new facade house.toml   a facade with openings, shaken\n"
      "  quoin new law my_law.c        the smallest contact law, in C");
  command->callback([options] { begin(options->kind, options->file, options->force); });
}

}  // namespace quoin
