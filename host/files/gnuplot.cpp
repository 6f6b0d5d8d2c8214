#include "files/gnuplot.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <spawn.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <fstream>
#include <optional>
#include <string_view>
#include <system_error>
#include <thread>

#include "base/error.h"
#include "base/input_file.h"
#include "base/number_text.h"
#include "files/file.h"

extern char** environ;

namespace quoin {

namespace {

namespace fs = std::filesystem;

class Descriptor {
 public:
  explicit Descriptor(int number) : number_(number) {}
  ~Descriptor() {
    if (number_ >= 0) close(number_);
  }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  int number() const { return number_; }

 private:
  int number_;
};

struct Drawing {
  std::string fault;     // empty: the drawing is complete
  std::string messages;  // output of gnuplot
};

std::string system_message() { return std::error_code(errno, std::generic_category()).message(); }

// Whether the file ends in `last`. A full disk truncates a drawing, and gnuplot does not always report it.
bool is_whole(const fs::path& file, std::string_view last) {
  std::string end(last.size(), ' ');
  std::ifstream stream(file, std::ios::binary);
  stream.seekg(-static_cast<std::streamoff>(last.size()), std::ios::end);
  stream.read(end.data(), static_cast<std::streamsize>(end.size()));
  return stream && end == last;
}
bool is_whole_picture(const fs::path& file) {
  return is_whole(file, "IEND\xae\x42\x60\x82") || is_whole(file, "</svg>\n\n") || is_whole(file, "</svg>\n");
}

bool is_control(unsigned char code) { return code < 0x20 || code == 0x7f; }

constexpr const char* kInterrupted = "interrupted";

std::atomic<bool> last_was_late{false};

// Time limit of a drawing, s. A plot program that never ends must not block the results of a run.
double longest_drawing() {
  double seconds = 0.0;
  const char* given = std::getenv("QUOIN_PLOT_SECONDS");
  const double most = given != nullptr && parse_number(given, seconds) && seconds > 0.0 ? seconds : 300.0;
  return last_was_late ? most / 10.0 : most;  // a program that hangs does so in every picture
}

// Exit status of the child, or nothing after the time limit, s, or stop_drawing, when its process group is killed.
std::optional<int> wait_for(pid_t child, double seconds) {
  using Clock = std::chrono::steady_clock;
  const auto begin = Clock::now();
  auto pause = std::chrono::milliseconds(1);
  int status = 0;
  for (;;) {
    const pid_t ended = waitpid(child, &status, WNOHANG);
    if (ended == child) return status;
    if (ended < 0 && errno != EINTR) return std::nullopt;
    if (std::chrono::duration<double>(Clock::now() - begin).count() > seconds || stop_drawing) break;
    std::this_thread::sleep_for(pause);
    pause = std::min(2 * pause, std::chrono::milliseconds(20));
  }
  kill(-child, SIGKILL);
  while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  return std::nullopt;
}

// gnuplot reads the script from its standard input and writes the drawing to its standard output. Its command line has
// no file name or other text.
Drawing run_gnuplot(const fs::path& working_folder, const std::string& script, const fs::path& picture) {
  const Descriptor input(memfd_create("script", MFD_CLOEXEC)), messages(memfd_create("messages", MFD_CLOEXEC));
  const fs::path part = begin_file(picture);
  const Descriptor output(open(part.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644));
  if (input.number() < 0 || messages.number() < 0 || output.number() < 0)
    throw Error(Exit::bad_input, fmt::format("{}: cannot be written: {}", picture.string(), system_message()));
  for (size_t done = 0; done < script.size();) {
    const ssize_t n = write(input.number(), script.data() + done, script.size() - done);
    if (n < 0) throw Error(Exit::numerical, "no memory for the script of " + picture.string());
    done += static_cast<size_t>(n);
  }
  lseek(input.number(), 0, SEEK_SET);

  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, input.number(), STDIN_FILENO);
  posix_spawn_file_actions_adddup2(&actions, output.number(), STDOUT_FILENO);
  posix_spawn_file_actions_adddup2(&actions, messages.number(), STDERR_FILENO);
  posix_spawn_file_actions_addchdir_np(&actions, working_folder.c_str());
  // -d: ignores the user's settings. With a named input the first error ends gnuplot; from "-" it reads byte by byte,
  // with a system call each.
  std::array<std::string, 3> words{"gnuplot", "-d", "/dev/stdin"};
  std::array<char*, 4> arguments{words[0].data(), words[1].data(), words[2].data(), nullptr};
  posix_spawnattr_t attributes;  // a process group of its own, with what a wrapper script starts
  posix_spawnattr_init(&attributes);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP);
  pid_t child = 0;
  const int no_start =
      stop_drawing ? EINTR : posix_spawnp(&child, "gnuplot", &actions, &attributes, arguments.data(), environ);
  posix_spawnattr_destroy(&attributes);
  posix_spawn_file_actions_destroy(&actions);

  Drawing drawing;
  if (no_start == EINTR) {
    drawing.fault = kInterrupted;
  } else if (no_start == ENOENT) {
    drawing.fault = "gnuplot is not installed (apt-get install gnuplot-nox)";
  } else if (no_start != 0) {
    drawing.fault =
        fmt::format("gnuplot cannot be started: {}", std::error_code(no_start, std::generic_category()).message());
  } else {
    const double limit = longest_drawing();
    const std::optional<int> status = wait_for(child, limit);
    last_was_late = !status;
    if (!status && stop_drawing)
      drawing.fault = kInterrupted;
    else if (!status)
      drawing.fault = fmt::format("gnuplot was stopped after {:g} s (QUOIN_PLOT_SECONDS allows more)", limit);
    else if (!WIFEXITED(*status) || WEXITSTATUS(*status) != 0 || !is_whole_picture(part))
      drawing.fault = "gnuplot failed";
  }
  lseek(messages.number(), 0, SEEK_SET);
  std::array<char, 4096> buffer{};
  for (ssize_t n = 0; (n = read(messages.number(), buffer.data(), buffer.size())) > 0;)
    drawing.messages.append(buffer.data(), static_cast<size_t>(n));
  if (drawing.fault.empty()) {
    finish_file(picture);
  } else {
    std::error_code ignored;
    fs::remove(part, ignored);
  }
  return drawing;
}

}  // namespace

std::string gnuplot_text(const std::string& text) {
  constexpr size_t kLongest = 300;  // bytes; far more than fits into a drawing, far less than gnuplot's buffers
  size_t size = std::min(text.size(), kLongest);
  if (size < text.size()) {
    while (size > 0 && (static_cast<unsigned char>(text[size]) & 0xc0) == 0x80) --size;  // not within a character
  }
  // As a number, since gnuplot's rules for quotes within quotes have exceptions (a leading '' is an empty string).
  std::string result = "\"";
  bool as_number = false;
  for (const char c : text.substr(0, size)) {
    const auto code = static_cast<unsigned char>(c);
    const bool octal_digit = c >= '0' && c <= '7';  // would extend the number before it
    const bool plain = code >= 0x80 || (std::isalnum(code) != 0 && !(as_number && octal_digit)) ||
                       std::string_view(" .,:;()/+-=_").find(c) != std::string_view::npos;
    as_number = !plain && !is_control(code);
    result += as_number ? fmt::format("\\{:03o}", code) : std::string(1, plain ? c : ' ');
  }
  return result + (size < text.size() ? "...\"" : "\"");
}

std::string draw_picture(const fs::path& folder, const std::string& name, const std::string& script) {
  const fs::path plots = folder / "plots";
  make_folder(plots);
  write_file(
      plots / (name + ".gp"),
      fmt::format("# Run again, after changes, in this folder: gnuplot {0}.gp\nset output '../{0}.png'\n", name) +
          script);
  const Drawing drawing = run_gnuplot(plots, script, folder / (name + ".png"));
  write_file(plots / (name + ".log"), drawing.messages);
  if (drawing.fault.empty()) return {};
  return fmt::format("no {}.png: {}; its script and messages are kept in {}", name, drawing.fault, plots.string());
}

std::string draw_as_svg(const fs::path& folder, const std::string& name) {
  const fs::path plots = folder / "plots";
  std::string script = read_input_file((plots / (name + ".gp")).string());
  script.erase(0, script.find("\nset terminal ") + 1);  // drops the `set output` at the head of the file
  constexpr std::string_view png = "set terminal pngcairo";
  if (!script.starts_with(png)) return fmt::format("no {}.svg: its script draws no PNG", name);
  // Font points are 96/72 pixels in a PNG, and one pixel in an SVG.
  script.replace(0, png.size(), "set terminal svg fontscale 1.33333");
  const Drawing drawing = run_gnuplot(plots, script, folder / (name + ".svg"));
  return drawing.fault.empty() ? std::string{} : fmt::format("no {}.svg: {}", name, drawing.fault);
}

void draw_picture_alone(const fs::path& picture, const std::string& script) {
  const fs::path folder = picture.parent_path();
  if (!folder.empty()) make_folder(folder);
  const fs::path place = named_place(picture);
  if (std::error_code error; fs::exists(place, error) && !fs::is_regular_file(place, error))
    throw Error(Exit::bad_input, place.string() + ": is no regular file; give another folder");
  const Drawing drawing = run_gnuplot("/", script, place);
  if (!drawing.fault.empty())
    throw Error(Exit::bad_input, fmt::format("{}: {} {}", picture.string(), drawing.fault, drawing.messages));
}

}  // namespace quoin
