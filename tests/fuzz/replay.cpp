// Without a fuzzer: every file of a corpus as it is, then mutations of them, always the same ones, for some seconds.
// Usage: fuzz_TARGET SECONDS FILE_OR_FOLDER...
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <string>
#include <vector>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

constexpr std::size_t kLargest = 1 << 16;  // bytes

void try_input(const std::string& bytes) {
  LLVMFuzzerTestOneInput(reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size());
}

// Some bytes changed, taken out or repeated, or a piece of another file put in.
std::string mutated(std::string bytes, const std::vector<std::string>& corpus, std::mt19937& random) {
  const auto below = [&](std::size_t n) { return n == 0 ? 0 : random() % n; };
  for (std::size_t changes = 1 + below(4); changes > 0; --changes) {
    const std::size_t at = below(bytes.size()), length = below(std::min<std::size_t>(64, bytes.size() - at + 1));
    switch (below(5)) {
      case 0:
        if (!bytes.empty()) bytes[at] = static_cast<char>(random());
        break;
      case 1:
        bytes.erase(at, length);
        break;
      case 2:
        bytes.insert(at, bytes.substr(at, length));
        break;
      case 3: {
        const std::string& other = corpus[below(corpus.size())];
        bytes.insert(at, other.substr(below(other.size()), below(64)));
        break;
      }
      default: {
        static const char* const kWords[] = {"nan",  "inf", "-1", "1e300", "1e-300", "99999999999999999999",
                                             "[[[[", "=",   "\"", "\n",    ",",      "{}"};
        bytes.insert(at, kWords[below(std::size(kWords))]);
      }
    }
  }
  return bytes.substr(0, kLargest);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 3) {
    std::fputs("usage: fuzz_TARGET SECONDS FILE_OR_FOLDER...\n", stderr);
    return 2;
  }
  std::vector<std::string> corpus;
  const auto take = [&](const fs::path& file) {
    std::ifstream stream(file, std::ios::binary);
    corpus.emplace_back(std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>());
    try_input(corpus.back());
  };
  for (int i = 2; i < argc; ++i) {
    if (!fs::is_directory(argv[i])) {
      take(argv[i]);
      continue;
    }
    for (const auto& entry : fs::directory_iterator(argv[i])) take(entry.path());
  }
  if (corpus.empty()) {
    std::fputs("no file to begin with\n", stderr);
    return 2;
  }
  std::mt19937 random(20260718);
  const auto end = Clock::now() + std::chrono::duration<double>(std::atof(argv[1]));
  long tried = 0;
  for (; Clock::now() < end; ++tried) try_input(mutated(corpus[random() % corpus.size()], corpus, random));
  std::printf("%zu files and %ld mutations of them: no fault\n", corpus.size(), tried);
  return 0;
}
