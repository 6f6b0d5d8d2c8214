/* Loads a law with dlopen or LoadLibrary, drives 257 points along fixed paths and prints tractions and states with all
 * digits every 20 steps. Its outputs on two systems show whether a law gives the same results on both.
 * usage: print_path LIB [property=value]... */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "quoin/layout_asserts.h"

#if defined(_WIN32)
#include <windows.h>
static quoin_library_function open_entry(const char* path) {
  quoin_library_function entry = NULL;
  HMODULE module = LoadLibraryA(path);
  FARPROC address = module != NULL ? GetProcAddress(module, QUOIN_LIBRARY_SYMBOL) : NULL;
  if (module == NULL) fprintf(stderr, "LoadLibrary: error %lu\n", GetLastError());
  memcpy(&entry, &address, sizeof entry);
  return entry;
}
#else
#include <dlfcn.h>
static quoin_library_function open_entry(const char* path) {
  quoin_library_function entry = NULL;
  void* module = dlopen(path, RTLD_NOW | RTLD_LOCAL);
  void* address = module != NULL ? dlsym(module, QUOIN_LIBRARY_SYMBOL) : NULL;
  if (address == NULL) fprintf(stderr, "%s\n", dlerror());
  memcpy(&entry, &address, sizeof entry);
  return entry;
}
#endif

enum { COUNT = 257, STEPS = 400, MAX_STATES = 16, MAX_PROPERTIES = 32 };
static double jump[COUNT], slip[2][COUNT], traction[3][COUNT], state[MAX_STATES][COUNT];

int main(int argc, char** argv) {
  static char message[16384];
  quoin_text text = {sizeof text, message, sizeof message, 0};
  const quoin_host_info me = {sizeof me, QUOIN_ABI_MAJOR, QUOIN_ABI_MINOR, "print_path", "1.0"};
  quoin_library_function entry = argc > 1 ? open_entry(argv[1]) : NULL;
  const quoin_library* library = entry != NULL ? entry(&me, &text) : NULL;
  const quoin_law* law;
  quoin_material* material = NULL;
  quoin_property_value values[MAX_PROPERTIES];
  const quoin_property_value* pointers[MAX_PROPERTIES];
  double numbers[MAX_PROPERTIES], initial[MAX_STATES];
  quoin_in state_old[MAX_STATES];
  quoin_out state_new[MAX_STATES];
  quoin_batch batch;
  uint64_t count = 0, s, failed = 0;
  int i, k, step;

  if (library == NULL) {
    fprintf(stderr, "not loaded: %s\n", message);
    return 1;
  }
  law = library->laws[0];
  for (i = 2; i < argc && count < MAX_PROPERTIES; ++i, ++count) {
    char* equals = strchr(argv[i], '=');
    char* end = NULL;
    if (equals == NULL) return 2;
    *equals = 0;
    numbers[count] = strtod(equals + 1, &end);
    values[count].struct_size = sizeof values[count];
    values[count].id = argv[i];
    values[count].number_count = *end == 0 ? 1 : 0;
    values[count].numbers = *end == 0 ? &numbers[count] : NULL;
    values[count].text = *end == 0 ? NULL : equals + 1;
    pointers[count] = &values[count];
  }
  if (law->state_count > MAX_STATES || law->create_material(law, count, pointers, &material, &text) != QUOIN_OK) {
    fprintf(stderr, "%s\n", message);
    return 1;
  }
  if (law->initial_state(material, law->initial_states[0], initial) != QUOIN_OK) return 1;
  memset(&batch, 0, sizeof batch);
  batch.struct_size = sizeof batch;
  batch.count = COUNT;
  batch.normal_jump.data = jump;
  batch.normal_jump.stride = 1;
  for (k = 0; k < 2; ++k) {
    batch.slip_increment[k].data = slip[k];
    batch.slip_increment[k].stride = 1;
  }
  for (k = 0; k < 3; ++k) {
    batch.traction_old[k].data = batch.traction_new[k].data = traction[k];
    batch.traction_old[k].stride = batch.traction_new[k].stride = 1;
  }
  for (s = 0; s < law->state_count; ++s) {
    for (i = 0; i < COUNT; ++i) state[s][i] = initial[s];
    state_old[s].data = state_new[s].data = state[s];
    state_old[s].stride = state_new[s].stride = 1;
  }
  batch.state_old = state_old;
  batch.state_new = state_new;
  for (step = 0; step < STEPS; ++step) {
    for (i = 0; i < COUNT; ++i) { /* only exactly rounded operations: the inputs are bitwise identical on all systems */
      const double phase = (double)((step + i) % 100) / 50 - 1, ramp = phase < 0 ? -phase : phase;
      jump[i] = (ramp - 0.5) * 1e-6 * (1 + i);
      slip[0][i] = 2e-8 * (1 + i % 17) * (step < STEPS / 2 ? 1 : -1);
      slip[1][i] = 1e-8 * (i % 5);
    }
    if (law->evaluate(material, &batch) != QUOIN_OK) return 1;
    failed += batch.failed_count;
    if (step % 20 != 19) continue;
    for (i = 0; i < COUNT; ++i) {
      for (k = 0; k < 3; ++k) printf("%.17g ", traction[k][i]);
      for (s = 0; s < law->state_count; ++s) printf("%.17g ", state[s][i]);
      printf("\n");
    }
  }
  fprintf(stderr, "%s %s: %d points, %d steps, %d failed\n", law->id, law->version, COUNT, STEPS, (int)failed);
  law->destroy_material(material);
  return failed == 0 ? 0 : 1;
}
