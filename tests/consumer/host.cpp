// A host in C++ in a separate project: one point of an elastic or softening joint, closed by 1 um. Prints the law's id
// and the traction, which is stiffness times closure, then the law's message for a wrong property.
#include <dlfcn.h>

#include <cstdio>
#include <quoin.hpp>

int main(int, char** argv) {
  void* const file = dlopen(argv[1], RTLD_NOW | RTLD_LOCAL);
  if (file == nullptr) return 1;
  const auto entry = reinterpret_cast<quoin_library_function>(dlsym(file, QUOIN_LIBRARY_SYMBOL));
  const quoin_law& law = *quoin::api::library(entry, "consumer", "1").laws[0];
  const quoin::api::Material joint(law, {{"normal_stiffness", {4e10}}, {"shear_stiffness", {2e10}}});

  const double jump = -1e-6, none = 0.0;
  const std::vector<double> bonded = joint.initial_state(law.initial_states[0]);
  std::vector<double> state(law.state_count);
  std::vector<quoin_in> state_old;
  std::vector<quoin_out> state_new;
  for (std::size_t k = 0; k < state.size(); ++k)
    state_old.push_back({&bonded[k], 1}), state_new.push_back({&state[k], 1});
  double traction[3];
  quoin_batch batch{};
  batch.struct_size = sizeof batch;
  batch.count = 1;
  batch.normal_jump = {&jump, 1};
  for (quoin_in& slip : batch.slip_increment) slip = {&none, 1};
  for (int k = 0; k < 3; ++k) batch.traction_old[k] = {&none, 1}, batch.traction_new[k] = {&traction[k], 1};
  batch.state_old = state_old.data();
  batch.state_new = state_new.data();
  joint.evaluate(batch);
  std::printf("%s: sigma %g Pa, ks %g Pa/m\n", law.id, traction[0], joint.number("shear_stiffness"));

  try {
    const quoin::api::Material wrong(law, {{"normal_stiffness", {-5.0}}, {"shear_stiffness", {2e10}}});
    return 1;
  } catch (const quoin::api::Error& error) {
    std::printf("%s\n", error.what());
    return error.status == QUOIN_ERROR_PROPERTY && traction[0] == -4e4 ? 0 : 1;
  }
}
