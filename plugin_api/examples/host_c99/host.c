/* A host in C99: loads a law, opens and slides four contact points and prints their traction.
 *   cc -std=c99 -I plugin_api/include host.c -ldl -o host && ./host laws/elastic.so normal_stiffness=4e10
 * shear_stiffness=2e10 */
#include <dlfcn.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "quoin/layout_asserts.h"

enum { POINTS = 4, STEPS = 10, MAX_STATES = 32, MAX_PROPERTIES = 32 };

int main(int argc, char** argv) {
  char message[4096];
  quoin_text text = {sizeof text, message, sizeof message, 0};
  const quoin_host_info me = {sizeof me, QUOIN_ABI_MAJOR, QUOIN_ABI_MINOR, "host_c99", "1.0"};
  quoin_library_function entry;
  const quoin_library* library;
  const quoin_law* law;
  quoin_property_value values[MAX_PROPERTIES];
  const quoin_property_value* pointers[MAX_PROPERTIES];
  double numbers[MAX_PROPERTIES];
  uint64_t count = 0, s;
  quoin_material* material = NULL;
  double jump[POINTS], slip[POINTS], zero = 0.0;
  double traction[3][POINTS] = {{0}}, state[MAX_STATES][POINTS], initial[MAX_STATES];
  quoin_in state_old[MAX_STATES];
  quoin_out state_new[MAX_STATES];
  quoin_batch batch;
  void *handle, *symbol;
  int i, k, step;

  if (argc < 2) {
    fprintf(stderr, "usage: %s LIB [property=value]...\n", argv[0]);
    return 2;
  }
  /* 1. Load the law. The library checks the version of the host, and the host that of the library. */
  handle = dlopen(argv[1], RTLD_NOW | RTLD_LOCAL);
  symbol = handle != NULL ? dlsym(handle, QUOIN_LIBRARY_SYMBOL) : NULL;
  if (symbol == NULL) {
    fprintf(stderr, "%s\n", dlerror());
    return 1;
  }
  memcpy(&entry, &symbol, sizeof entry);
  library = entry(&me, &text);
  if (library == NULL || library->abi_major != QUOIN_ABI_MAJOR || library->law_count == 0) {
    fprintf(stderr, "refused: %s\n", message);
    return 1;
  }
  law = library->laws[0];
  printf("%s %s: %s\n", law->id, law->version, law->description);

  /* 2. A material from properties by id. */
  for (i = 2; i < argc && count < MAX_PROPERTIES; ++i, ++count) {
    char* equals = strchr(argv[i], '=');
    if (equals == NULL) return 2;
    *equals = 0;
    numbers[count] = strtod(equals + 1, NULL);
    values[count].struct_size = sizeof values[count];
    values[count].id = argv[i];
    values[count].number_count = 1;
    values[count].numbers = &numbers[count];
    values[count].text = NULL;
    pointers[count] = &values[count];
  }
  if (law->create_material(law, count, pointers, &material, &text) != QUOIN_OK) {
    fprintf(stderr, "%s\n", message);
    return 1;
  }

  /* 3. States belong to the host: one array for each state, filled with the law's initial state. */
  if (law->state_count > MAX_STATES || law->initial_state(material, law->initial_states[0], initial) != QUOIN_OK)
    return 1;
  for (s = 0; s < law->state_count; ++s) {
    for (i = 0; i < POINTS; ++i) state[s][i] = initial[s];
    state_old[s].data = state_new[s].data = state[s];
    state_old[s].stride = state_new[s].stride = 1;
  }

  /* 4. One batch for all steps. Old and new columns are the same arrays. */
  memset(&batch, 0, sizeof batch);
  batch.struct_size = sizeof batch;
  batch.count = POINTS;
  batch.normal_jump.data = jump;
  batch.normal_jump.stride = 1;
  batch.slip_increment[0].data = slip;
  batch.slip_increment[0].stride = 1;
  batch.slip_increment[1].data = &zero; /* stride 0: one value for all points */
  for (k = 0; k < 3; ++k) {
    batch.traction_old[k].data = batch.traction_new[k].data = traction[k];
    batch.traction_old[k].stride = batch.traction_new[k].stride = 1;
  }
  batch.state_old = state_old;
  batch.state_new = state_new;

  /* 5. Steps: point i opens by i micrometres, and all points slide by one micrometre. */
  for (step = 1; step <= STEPS; ++step) {
    for (i = 0; i < POINTS; ++i) {
      jump[i] = 1e-6 * i * step / STEPS;
      slip[i] = 1e-6 / STEPS;
    }
    if (law->evaluate(material, &batch) != QUOIN_OK || batch.failed_count > 0) return 1;
  }
  for (i = 0; i < POINTS; ++i) {
    printf("d_n %.1f um, d_s 1.0 um: sigma %.6g Pa, tau_s %.6g Pa\n", jump[i] * 1e6, traction[0][i], traction[1][i]);
  }
  law->destroy_material(material);
  dlclose(handle);
  return 0;
}
