// Loading and evaluation of a law through its shared library, with little code.
#pragma once

#include <dlfcn.h>

#include <cstdlib>
#include <fstream>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "quoin.hpp"

namespace quoin::test {

inline const quoin_law& load_law_file(const std::string& path) {
  void* handle = dlopen(path.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (handle == nullptr) throw std::runtime_error(dlerror());
  const auto entry = reinterpret_cast<quoin_library_function>(dlsym(handle, QUOIN_LIBRARY_SYMBOL));
  return *api::library(entry, "tests", "1").laws[0];
}
#ifdef QUOIN_LAWS  // folder of the built laws
inline std::string law_file(const std::string& name) {
  const char* other = std::getenv("QUOIN_LAW_PATH");  // folder of another build, as for the host
  const std::string file = other == nullptr ? "" : std::string(other) + "/" + name + ".so";
  return std::ifstream(file).good() ? file : std::string(QUOIN_LAWS) + "/" + name + ".so";
}
inline const quoin_law& load_law(const std::string& name) { return load_law_file(law_file(name)); }
#endif

struct Values {
  std::vector<std::pair<std::string, double>> numbers;
  std::vector<std::pair<std::string, std::string>> words;
  std::vector<double> table;
};

inline api::Material make_material(const quoin_law& law, const Values& given) {
  std::vector<api::Value> values;
  for (const auto& [id, number] : given.numbers) values.push_back({id, {number}});
  for (const auto& [id, word] : given.words) values.push_back({id, {}, word});
  if (!given.table.empty()) values.push_back({"softening_table", given.table});
  return {law, values};
}

// Columns of a batch with stride 1, new columns separate from old ones, all outputs.
struct Batch {
  std::size_t count, states;
  std::vector<std::vector<double>> in,
      out;  // in: jump, 2 slips, 3 tractions, states; out: 3 tractions, states, 1 + 4 + 9
  std::vector<uint32_t> flags, status;

  Batch(const quoin_law& law, std::size_t count_)
      : count(count_),
        states(law.state_count),
        in(6 + states, std::vector<double>(count, 0.0)),
        out(3 + states + 14, std::vector<double>(count, 0.0)),
        flags(count, 0),
        status(count, 0) {}

  // Returns a batch of points [first, first + n); extras: with energies, tangent, flags, status.
  quoin_batch view(std::size_t first, std::size_t n, bool extras, std::vector<quoin_in>& old_states,
                   std::vector<quoin_out>& new_states) {
    quoin_batch b{};
    b.struct_size = sizeof b;
    b.count = n;
    const auto input = [&](std::size_t k) { return quoin_in{in[k].data() + first, 1}; };
    const auto output = [&](std::size_t k) { return quoin_out{out[k].data() + first, 1}; };
    b.normal_jump = input(0);
    b.slip_increment[0] = input(1);
    b.slip_increment[1] = input(2);
    for (std::size_t k = 0; k < 3; ++k) b.traction_old[k] = input(3 + k), b.traction_new[k] = output(k);
    old_states.clear(), new_states.clear();
    for (std::size_t k = 0; k < states; ++k) old_states.push_back(input(6 + k)), new_states.push_back(output(3 + k));
    b.state_old = old_states.data();
    b.state_new = new_states.data();
    if (extras) {
      b.energy_stored = output(3 + states);
      for (std::size_t k = 0; k < 4; ++k) b.dissipated[k] = output(4 + states + k);
      for (std::size_t k = 0; k < 9; ++k) b.tangent[k] = output(8 + states + k);
      b.flags = {flags.data() + first, 1};
      b.status = {status.data() + first, 1};
    }
    return b;
  }

  quoin_batch evaluate(const api::Material& material, bool extras = true) {
    std::vector<quoin_in> old_states;
    std::vector<quoin_out> new_states;
    quoin_batch b = view(0, count, extras, old_states, new_states);
    material.evaluate(b);
    return b;
  }

  // Copies the new traction and state to the old ones.
  void advance() {
    for (std::size_t k = 0; k < 3; ++k) in[3 + k] = out[k];
    for (std::size_t k = 0; k < states; ++k) in[6 + k] = out[3 + k];
  }
};

}  // namespace quoin::test
