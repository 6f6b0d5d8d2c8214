// Runs without a fuzzer: every file of a corpus unchanged, then mutations of the files. Each mutation depends only on
// its number, so that a range of them can be repeated or continued.
//   fuzz_TARGET SECONDS FILE_OR_FOLDER...
//   fuzz_TARGET FIRST:LAST FILE_OR_FOLDER...   mutations of these numbers, without LAST
// An input that crashes, or takes more than 10 s or 4 GB, is saved as fault_of_TARGET.
#include <fcntl.h>
#include <sys/resource.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include "judge.h"

extern "C" {
int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);
// Mutator of targets with structured input, with the interface of libFuzzer.
[[gnu::weak]] std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size, std::size_t most,
                                                  unsigned int seed);
[[gnu::weak]] void __sanitizer_set_death_callback(void (*callback)());
}

namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

constexpr std::size_t kLargest = 1 << 16;  // bytes
constexpr std::size_t kLong = 1 << 13;     // bytes: such files are mutated kRarely times less often
constexpr unsigned kRarely = 32;
constexpr unsigned kLongest = 10;         // limit of time, s
constexpr rlim_t kMostMemory = 4l << 30;  // bytes

std::vector<std::string> corpus;
std::string fault_file;
long number = -1;  // number of the current mutation
std::string at_work;

// Changes, removes or repeats some bytes, or inserts part of another file.
void mutate_bytes(std::string* bytes, std::mt19937_64& random) {
  const auto below = [&](std::size_t n) { return n == 0 ? 0 : random() % n; };
  for (std::size_t changes = 1 + below(4); changes > 0; --changes) {
    const std::size_t at = below(bytes->size()), length = below(std::min<std::size_t>(64, bytes->size() - at + 1));
    switch (below(5)) {
      case 0:
        if (!bytes->empty()) (*bytes)[at] = static_cast<char>(random());
        break;
      case 1:
        bytes->erase(at, length);
        break;
      case 2:
        bytes->insert(at, bytes->substr(at, length));
        break;
      case 3: {
        const std::string& other = corpus[below(corpus.size())];
        bytes->insert(at, other.substr(below(other.size()), below(64)));
        break;
      }
      default: {
        static const char* const kWords[] = {"nan",  "inf", "-1", "1e300", "1e-300", "99999999999999999999",
                                             "[[[[", "=",   "\"", "\n",    ",",      "{}"};
        bytes->insert(at, kWords[below(std::size(kWords))]);
      }
    }
  }
  if (bytes->size() > kLargest) bytes->resize(kLargest);
}

void mutate(std::string* bytes, std::mt19937_64& random) {
  if (!LLVMFuzzerCustomMutator) return mutate_bytes(bytes, random);
  const std::size_t size = std::min(bytes->size(), kLargest);
  bytes->resize(kLargest);
  bytes->resize(LLVMFuzzerCustomMutator(reinterpret_cast<std::uint8_t*>(bytes->data()), size, kLargest,
                                        static_cast<unsigned int>(random())));
}

void try_input() {
  alarm(kLongest);
  LLVMFuzzerTestOneInput(reinterpret_cast<const std::uint8_t*>(at_work.data()), at_work.size());
  alarm(0);
}

void keep_input() {
  std::fprintf(stderr, "a fault of input %ld, kept as %s\n", number, fault_file.c_str());
  const int file = open(fault_file.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
  if (write(file, at_work.data(), at_work.size()) < 0) std::perror(fault_file.c_str());
}

void end_with_input(int signal) {
  std::fprintf(stderr, "%s\n", signal == SIGALRM ? "not done in time" : strsignal(signal));
  keep_input();
  _exit(1);
}

void watch_for_faults() {
  static std::vector<char> stack(1 << 16);  // for signals when the stack of the program is full
  stack_t other{};
  other.ss_sp = stack.data(), other.ss_size = stack.size();
  sigaltstack(&other, nullptr);
  struct sigaction action {};
  action.sa_handler = end_with_input;
  action.sa_flags = SA_ONSTACK;
  sigaction(SIGALRM, &action, nullptr);
  if (__sanitizer_set_death_callback) return __sanitizer_set_death_callback(keep_input);
  for (const int signal : {SIGABRT, SIGSEGV, SIGBUS, SIGFPE, SIGILL}) sigaction(signal, &action, nullptr);
  const rlimit limit{kMostMemory, kMostMemory};
  setrlimit(RLIMIT_AS, &limit);
}

void take(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  at_work.assign(std::istreambuf_iterator<char>(stream), {});
  corpus.push_back(at_work);
  try_input();
}

}  // namespace

extern "C" std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t most) {
  static std::mt19937_64 random;
  random.seed(static_cast<std::uint64_t>(number));
  std::string bytes(reinterpret_cast<const char*>(data), size);
  mutate_bytes(&bytes, random);
  bytes.resize(std::min(bytes.size(), most));
  std::memcpy(data, bytes.data(), bytes.size());
  return bytes.size();
}

int main(int argc, char** argv) {
  if (argc < 3) {
    std::fputs("usage: fuzz_TARGET SECONDS|FIRST:LAST FILE_OR_FOLDER...\n", stderr);
    return 2;
  }
  fault_file = "fault_of_" + fs::path(argv[0]).filename().string().substr(5);
  watch_for_faults();
  for (int i = 2; i < argc; ++i) {
    std::vector<fs::path> files{argv[i]};
    if (fs::is_directory(argv[i])) files.assign(fs::directory_iterator(argv[i]), {});
    std::sort(files.begin(), files.end());
    for (const fs::path& file : files) take(file);
  }
  if (corpus.empty()) {
    std::fputs("no file to begin with\n", stderr);
    return 2;
  }

  const char* const last = std::strchr(argv[1], ':');
  const long first = last ? std::atol(argv[1]) : 0, end = last ? std::atol(last + 1) : std::numeric_limits<long>::max();
  const auto begin = Clock::now();
  const auto seconds = [&] { return std::chrono::duration<double>(Clock::now() - begin).count(); };
  std::mt19937_64 random;
  for (number = first; number < end && (last || seconds() < std::atof(argv[1])); ++number) {
    random.seed(static_cast<std::uint64_t>(number));
    do {
      at_work = corpus[random() % corpus.size()];
    } while (at_work.size() > kLong && random() % kRarely != 0);
    mutate(&at_work, random);
    try_input();
  }
  std::printf("%zu files and %ld mutations of them in %.0f s: no fault; by exit code", corpus.size(), number - first,
              seconds());
  for (const auto& [code, count] : ends()) std::printf("  %d: %ld", static_cast<int>(code), count);
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  std::printf("; at most %ld MB\n", usage.ru_maxrss >> 10);
  return 0;
}
