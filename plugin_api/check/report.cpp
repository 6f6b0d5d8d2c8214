#include "report.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cfenv>
#include <csignal>
#include <cstdarg>
#include <cstdio>
#include <cstdlib>
#include <cstring>

#if defined(__x86_64__)
#include <xmmintrin.h>
#endif

namespace check {
namespace {

constexpr int kDetailsPerClause = 3;
constexpr std::size_t kLongestId = 64;  // bytes, of a clause

std::string formatted(const char* format, va_list arguments) {
  char text[1024];
  std::vsnprintf(text, sizeof text, format, arguments);
  for (char* c = text; *c != 0; ++c) {
    if (*c == '\n') *c = ' ';
  }
  return text;
}

// Returns the rounding mode and, on x86, MXCSR without its exception flags.
unsigned floating_point_mode() {
  unsigned mode = static_cast<unsigned>(std::fegetround());
#if defined(__x86_64__)
  mode ^= (_mm_getcsr() & ~0x3fu) << 1;
#endif
  return mode;
}

// Returns the beginning of a file, in one line.
std::string beginning_of(std::FILE* file) {
  constexpr std::size_t kLongest = 300;
  std::string text;
  std::rewind(file);
  for (int c = 0; text.size() < kLongest && (c = std::fgetc(file)) != EOF;)
    text += c < ' ' ? ' ' : static_cast<char>(c);
  return text;
}

}  // namespace

const std::vector<Clause>& clauses() {
  static const std::vector<Clause> all = {
      {"C1.1", "a library exports exactly one symbol, quoin_library_v1"},
      {"C1.2", "another major version is refused with null and a reason in the text"},
      {"C1.3", "a null or short quoin_host_info is refused with null"},
      {"C1.4", "a newer minor version and longer structs are accepted"},
      {"C1.5", "the library description is complete, of this major version and constant"},
      {"C1.6", "no output, exit, signal, exception or change of floating-point mode crosses the boundary"},
      {"C2.1", "null text and null data are allowed everywhere"},
      {"C2.2", "at most capacity bytes are written, the final zero included"},
      {"C2.3", "length is the whole message's, whatever the capacity"},
      {"C2.4", "a quoin_text shorter than version 1.0's is treated as null"},
      {"C3.1", "every text and function is there; ids are well formed and unique"},
      {"C3.2", "the sign convention is version 1's, and opening and closing keep it"},
      {"C3.3", "properties: known kind, ordered bounds, default inside them, default_from a number of this law"},
      {"C3.4", "units are known"},
      {"C3.5", "states: known role and kind, pairs complete, ordered bounds"},
      {"C3.6", "there is an initial state; capability bits are known and agree with the functions"},
      {"C4.1", "values within the bounds make a material"},
      {"C4.2", "values outside the bounds are refused with QUOIN_ERROR_PROPERTY and no material"},
      {"C4.3", "all faults are in one message, each with its property and value"},
      {"C4.4", "unknown, missing, repeated, wrong-kind and not-a-number properties are refused"},
      {"C4.5", "null arguments and short structs are QUOIN_ERROR_ARGUMENT; null material validates only"},
      {"C4.6", "material_number gives the values in force, defaults included"},
      {"C4.7", "the order of values does not matter and the law keeps no pointer into them"},
      {"C4.8", "destroy_material frees everything and allows null"},
      {"C4.9", "a strength of zero, where the bounds allow it, switches its mode off"},
      {"C5.1", "every initial state is given in full within the state bounds; an unknown id is refused"},
      {"C5.2", "every state written lies within its bounds and every output is finite"},
      {"C5.3", "monotonic states never decrease"},
      {"C5.4", "the state columns are the whole memory: saved and restored, the path goes on with the same bits"},
      {"C6.1", "the same inputs give the same bits, whatever was evaluated in between"},
      {"C6.2", "bits do not depend on batch size, partition or order"},
      {"C6.3", "any stride: structures, unaligned starts, negative, and 0 on inputs"},
      {"C6.4", "old and new may be the same memory"},
      {"C6.5", "batches may be evaluated by any threads at once with one material"},
      {"C6.6", "only the elements of output columns are written, and no input"},
      {"C6.7", "null optional outputs are allowed and change no other output"},
      {"C6.8", "null columns of diagnostic states are allowed and change nothing else"},
      {"C6.9", "a property column gives what a material of that value gives; a refused value fails its point alone"},
      {"C6.10", "a batch of 0 touches no data"},
      {"C6.11", "an ill-formed batch is refused and nothing is written"},
      {"C7.1", "an input that is not finite fails its point: traction and state stay old, nothing is dissipated"},
      {"C7.2", "a failed point changes no other point of its batch"},
      {"C7.3", "the summary agrees with the per-point status"},
      {"C7.4", "any_yielding is 0 only when no internal variable moved"},
      {"C8.1", "a zero increment changes nothing beyond rounding"},
      {"C8.2", "rotating (s, t) rotates the tractions and vector states and changes nothing else"},
      {"C8.3", "work equals stored plus dissipated energy to first order in the step"},
      {"C8.4", "dissipation is never negative"},
      {"C8.5", "stiffness bounds are never below an observed d sigma/d d_n or d tau/d d_s"},
      {"C8.6", "the tangent is consistent with finite differences of the step"},
      {"C8.7", "damage is in [0, 1], never decreases and agrees with the flags"},
      {"C9.1", "migrated points keep their traction; the law's own states are taken over exactly"},
  };
  return all;
}

void Report::section(const std::string& name, const std::function<void(Report&)>& run) {
  int ends[2];
  std::FILE* output = std::tmpfile();
  void* shared = mmap(nullptr, kLongestId, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  if (pipe(ends) != 0 || output == nullptr || shared == MAP_FAILED) {
    notes_.push_back(name + ": cannot start a child process");
    outcomes_["C1.6"].failures++;
    return;
  }
  current_ = std::strcpy(static_cast<char*>(shared), "C1.6");
  std::fflush(nullptr);
  const pid_t child = fork();
  if (child == 0) {
    close(ends[0]);
    pipe_ = ends[1];
    dup2(fileno(output), STDOUT_FILENO);
    dup2(fileno(output), STDERR_FILENO);
    run_as_child(name, run);
  }
  close(ends[1]);
  const bool finished = receive_all(ends[0]);
  close(ends[0]);
  int status = 0;
  waitpid(child, &status, 0);
  if (const std::string printed = beginning_of(output); !printed.empty()) {
    outcomes_["C1.6"].failures++;
    outcomes_["C1.6"].details.push_back(name + ": something was printed: " + printed);
  }
  std::fclose(output);
  if (!finished) {
    // The failure is reported for the clause that was current when the process ended.
    Outcome& outcome = outcomes_[current_];
    outcome.failures++;
    hangs_ = WIFSIGNALED(status) && WTERMSIG(status) == SIGALRM;
    const std::string how = hangs_ ? "did not return from a call within " + std::to_string(law_seconds) +
                                         " s (--law-seconds); the other sections are left out"
                            : WIFSIGNALED(status) ? std::string("killed by signal ") + strsignal(WTERMSIG(status))
                                                  : "the process was ended from inside";
    outcome.details.push_back(name + ": " + how);
  }
  munmap(shared, kLongestId);
}

// C1.6: what crosses the boundary beside results.
void Report::run_as_child(const std::string& name, const std::function<void(Report&)>& run) {
  outcomes_.clear();
  outcome_ = &outcomes_[current_];
  alarm(law_seconds);  // evaluate() restarts it
  const unsigned mode = floating_point_mode();
  int status = 0;
  try {
    run(*this);
    clause("C1.6");
    expect(floating_point_mode() == mode, "%s: the floating-point mode was changed", name.c_str());
  } catch (const std::exception& error) {
    expect(false, "%s: an exception came through: %s", name.c_str(), error.what());
    status = 1;
  }
  send('E', "");
  _exit(status);
}

bool Report::receive_all(int pipe) {
  std::string line;
  bool finished = false;
  char bytes[4096];
  for (ssize_t n = 0; (n = read(pipe, bytes, sizeof bytes)) > 0;) {
    for (ssize_t i = 0; i < n; ++i) {
      if (bytes[i] != '\n') {
        line += bytes[i];
        continue;
      }
      finished = finished || line[0] == 'E';
      receive(line);
      line.clear();
    }
  }
  return finished;
}

// Writes one line to the parent: kind, clause, a space, text.
void Report::send(char kind, const std::string& text) {
  const std::string line = kind + std::string(current_) + " " + text + "\n";
  if (write(pipe_, line.data(), line.size()) < 0) _exit(3);
}

void Report::receive(const std::string& line) {
  const std::size_t space = line.find(' ');
  if (space == std::string::npos) return;
  const std::string text = line.substr(space + 1);
  Outcome& outcome = outcomes_[line.substr(1, space - 1)];
  switch (line[0]) {
    case '+':
      outcome.expectations += std::atoi(text.c_str());
      break;
    case 'F':
      outcome.failures++;
      if (outcome.details.size() < kDetailsPerClause) outcome.details.push_back(text);
      break;
    case 'S':
      outcome.skipped.push_back(text);
      break;
    case 'N':
      notes_.push_back(text);
      break;
    default:
      break;
  }
}

void Report::clause(const char* id) {
  if (std::strcmp(current_, id) == 0) return;
  std::strncpy(current_, id, kLongestId - 1);
  const auto [entry, first_time] = outcomes_.try_emplace(id);
  outcome_ = &entry->second;
  if (first_time) send('+', "0");
}

bool Report::expect(bool holds, const char* format, ...) {
  if (holds) {
    const int count = ++outcome_->expectations;
    if ((count & (count - 1)) == 0) send('+', std::to_string(count - count / 2));  // sent at powers of two
    return true;
  }
  if (++outcome_->failures <= kDetailsPerClause) {
    va_list arguments;
    va_start(arguments, format);
    send('F', formatted(format, arguments));
    va_end(arguments);
  }
  return false;
}

void Report::skip(const char* format, ...) {
  va_list arguments;
  va_start(arguments, format);
  send('S', formatted(format, arguments));
  va_end(arguments);
}

void Report::note(const char* format, ...) {
  va_list arguments;
  va_start(arguments, format);
  send('N', formatted(format, arguments));
  va_end(arguments);
}

bool Report::passed() const {
  for (const auto& [id, outcome] : outcomes_) {
    if (outcome.failures > 0) return false;
  }
  return true;
}

}  // namespace check
