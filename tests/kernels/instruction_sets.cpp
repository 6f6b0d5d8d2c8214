// The laws with two instruction sets: one run writes the outputs of every kernel, another compares.
//
//   instruction_sets write|compare FILE LAWS_FOLDER    with the best set of this machine
//   instruction_sets avx512 FILE LAWS_FOLDER           writes with AVX2, compares with AVX-512, on a machine with both
//
// Every material, with and without property columns, with and without optional outputs, 60 steps of 61 points. Each
// step of a comparison starts from the old state in the file, so that differences do not propagate. Prints one line for
// each law; the exit code is 1 if any bit differs. instruction_sets.sh runs it with an emulated processor.
#include <termios.h>
#include <unistd.h>

#include <algorithm>
#include <cstdint>
#include <cstdio>

#include "population.h"
#ifdef __x86_64__
#include "hwy/highway.h"
#include "hwy/targets.h"
#endif

namespace {

using quoin::test::Batch;
using quoin::test::Values;

// Returns the instruction set that the laws use; the lowest bit is the best set.
std::string instruction_set() {
#ifdef __x86_64__
  const std::int64_t usable = hwy::SupportedTargets() & HWY_TARGETS;
  return hwy::TargetName(usable & -usable);
#else
  return "NEON";
#endif
}

struct Comparison {
  std::FILE* file;
  bool writes;
  std::size_t values = 0, different = 0;
  double largest = 0.0;

  // Writes the column, or compares it with that of the file and replaces it by that.
  template <class Number>
  void column(std::vector<Number>& mine) {
    values += mine.size();
    if (writes) {
      if (std::fwrite(mine.data(), sizeof(Number), mine.size(), file) != mine.size()) throw std::runtime_error("write");
      return;
    }
    std::vector<Number> other(mine.size());
    if (std::fread(other.data(), sizeof(Number), other.size(), file) != other.size()) throw std::runtime_error("read");
    for (std::size_t i = 0; i < mine.size(); ++i) {
      if (std::memcmp(&mine[i], &other[i], sizeof(Number)) == 0) continue;
      ++different;
      const double a = static_cast<double>(mine[i]), b = static_cast<double>(other[i]);
      const double larger = std::max(std::abs(a), std::abs(b));
      const double difference = larger > 0.0 ? std::abs(a - b) / larger : 0.0;  // 0: zeros of different sign
      largest = difference <= largest ? largest : difference;
    }
    mine = other;
  }
};

// Random per-point properties; some points would snap back, so they fail.
struct PropertyColumns {
  std::vector<double> friction, stiffness;
  quoin_property_column columns[2];

  PropertyColumns(std::size_t count, std::mt19937_64& random) : friction(count), stiffness(count) {
    for (std::size_t i = 0; i < count; ++i) {
      friction[i] = 36.0 + 9.0 * quoin::test::unit(random);
      stiffness[i] = std::ldexp(82e9, -static_cast<int>(random() % 12));
    }
    columns[0] = {"friction_angle", {friction.data(), 1}};
    columns[1] = {"normal_stiffness", {stiffness.data(), 1}};
  }
};

void run(const quoin_law& law, const Values& values, bool with_columns, Comparison& comparison) {
  const quoin::api::Material material = quoin::test::make_material(law, values);
  std::mt19937_64 random(7);
  Batch batch(law, 61);
  PropertyColumns properties(batch.count, random);
  for (int step = 0; step < 60; ++step) {
    quoin::test::randomise(batch, random);
    quoin::test::make_some_extreme(batch, random);
    for (const bool extras : {false, true}) {
      std::vector<quoin_in> old_states;
      std::vector<quoin_out> new_states;
      quoin_batch view = batch.view(0, batch.count, extras, old_states, new_states);
      if (with_columns) {
        const bool angles = std::strcmp(law.id, "elastic") != 0 && std::strcmp(law.id, "bond_slip") != 0;
        view.property_columns = angles ? properties.columns : properties.columns + 1;
        view.property_column_count = angles ? 2 : 1;
      }
      material.evaluate(view);
      const std::size_t wanted = extras ? batch.out.size() : 3 + batch.states;
      for (std::size_t k = 0; k < wanted; ++k) comparison.column(batch.out[k]);
      if (extras) comparison.column(batch.flags), comparison.column(batch.status);
    }
    batch.advance();
  }
}

// Returns the exit code; 0: written, or bitwise identical.
int run_laws(const char* name, bool writes, const std::string& folder) {
  std::FILE* const file = std::fopen(name, writes ? "wb" : "rb");
  if (file == nullptr) {
    std::perror(name);
    return 2;
  }
  bool same = true;
  for (const char* id : quoin::test::laws) {
    const quoin_law& law = quoin::test::load_law_file(folder + "/" + id + ".so");
    Comparison comparison{file, writes};
    for (const Values& values : quoin::test::materials(id)) {
      for (const bool with_columns : {false, true}) run(law, values, with_columns, comparison);
    }
    std::printf("%s, %s: ", instruction_set().c_str(), id);
    if (writes) {
      std::printf("%zu values written\n", comparison.values);
    } else if (comparison.different == 0) {
      std::printf("identical bits, %zu values\n", comparison.values);
    } else {
      std::printf("%zu of %zu values differ, largest relative difference %.2e\n", comparison.different,
                  comparison.values, comparison.largest);
      same = false;
    }
    std::fflush(stdout);
    tcdrain(STDOUT_FILENO);  // an emulated machine stops when its first process ends
  }
  return std::fclose(file) == 0 && same ? 0 : 1;
}

int avx512_beside_avx2([[maybe_unused]] const char* file, [[maybe_unused]] const std::string& folder) {
#ifdef __x86_64__
  if ((hwy::SupportedTargets() & HWY_AVX3) != 0) {
    for (const std::int64_t target : {HWY_AVX2, HWY_AVX3}) {
      hwy::SetSupportedTargetsForTest(target);
      hwy::GetChosenTarget().Update(hwy::SupportedTargets());
      if (const int status = run_laws(file, target == HWY_AVX2, folder); status != 0) return status;
    }
    std::remove(file);
    return 0;
  }
#endif
  std::printf("no AVX-512 on this machine\n");
  return 77;
}

}  // namespace

int main(int argc, char** argv) {
  const std::string mode = argc == 4 ? argv[1] : "";
  if (mode == "write" || mode == "compare") return run_laws(argv[2], mode == "write", argv[3]);
  if (mode == "avx512") return avx512_beside_avx2(argv[2], argv[3]);
  std::fprintf(stderr, "usage: instruction_sets write|compare|avx512 FILE LAWS_FOLDER\n");
  return 2;
}
