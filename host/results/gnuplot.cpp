#include "results/gnuplot.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/wait.h>
#include <unistd.h>

#include "results/file.h"

namespace quoin {

std::string gnuplot_text(const std::string& text) {
  std::string result;
  for (const char c : text) {
    if (c == '"' || c == '\\') result += '\\';
    result += c == '\n' ? ' ' : c;
  }
  return "\"" + result + "\"";
}

std::string enhanced(const std::string& text) {
  std::string result;
  for (const char c : text) {
    if (std::string("_^{}@&~\\").find(c) != std::string::npos) result += '\\';
    result += c;
  }
  return result;
}

std::string draw_picture(const std::filesystem::path& folder, const std::string& name, const std::string& script) {
  make_folder(folder / "plots");
  const std::filesystem::path plots = folder / "plots", picture = folder / (name + ".png");
  const std::string head = fmt::format(
      "# Run again, after changes, with: cd {} && gnuplot {}.gp\n"
      "if (!exists(\"target\")) target = \"../{}.png\"\n"
      "set output target\n",
      plots.string(), name, name);
  write_file(plots / (name + ".gp"), head + script);

  const std::string target = fmt::format("target='../{}.png.part'", name), file = name + ".gp";
  const std::string log_file = plots / (name + ".log");
  const pid_t child = fork();
  if (child == 0) {  // no allocation from here on: other threads may hold its lock
    const int null = open("/dev/null", O_WRONLY);
    const int log = open(log_file.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0644);
    dup2(null, STDOUT_FILENO);
    dup2(log >= 0 ? log : null, STDERR_FILENO);
    if (chdir(plots.c_str()) == 0) execlp("gnuplot", "gnuplot", "-e", target.c_str(), file.c_str(), nullptr);
    _exit(127);
  }
  int status = 0;
  if (child < 0 || waitpid(child, &status, 0) < 0 || !WIFEXITED(status) || WEXITSTATUS(status) != 0) {
    std::error_code ignored;
    std::filesystem::remove(part_name(picture), ignored);
    if (WIFEXITED(status) && WEXITSTATUS(status) == 127)
      return fmt::format("no {}.png: gnuplot is not installed (apt-get install gnuplot-nox); its script is kept in {}",
                         name, plots.string());
    return fmt::format("no {}.png: gnuplot failed, see {}", name, (plots / (name + ".log")).string());
  }
  finish_file(picture);
  return {};
}

}  // namespace quoin
