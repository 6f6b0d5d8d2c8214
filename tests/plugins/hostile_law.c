/* The template law with one fault, which the environment variable QUOIN_HOSTILE selects at loading. "TABLE WORD VALUE"
 * replaces an 8-byte word of a table (its index, hexadecimal value). Otherwise it is the name of a wrong action. */
#define quoin_library_v1 template_library_v1
#include "../../plugin_api/template/template_law.c"
#undef quoin_library_v1

#include <unistd.h>

QUOIN_EXPORT const quoin_library* quoin_library_v1(const quoin_host_info* host, quoin_text* text);

static quoin_library wrong_library;
static quoin_law wrong_law;
static quoin_property_info wrong_property;
static quoin_state_info wrong_state = {sizeof(quoin_state_info),
                                       "count",
                                       "-",
                                       "steps so far, at most 1e9",
                                       QUOIN_ROLE_HISTORY,
                                       QUOIN_STATE_SCALAR,
                                       0,
                                       0,
                                       0.0,
                                       1e9};
static quoin_convention wrong_convention;
static const quoin_law* const wrong_laws[] = {&wrong_law};
static const quoin_property_info* wrong_properties[PROPERTY_COUNT];
static const quoin_state_info* const wrong_states[] = {&wrong_state};

static volatile int* nowhere;

static int does(const char* deed) {
  const char* what = getenv("QUOIN_HOSTILE");
  return what != NULL && strcmp(what, deed) == 0;
}

/* Returns the number after an action, as in "energy 3"; 1 if another action is selected. */
static double times_of(const char* deed) {
  const char* what = getenv("QUOIN_HOSTILE");
  size_t length = strlen(deed);
  return what != NULL && strncmp(what, deed, length) == 0 && what[length] == ' ' ? strtod(what + length, NULL) : 1.0;
}

__attribute__((constructor)) static void loaded(void) {
  if (does("_exit at load")) _exit(0);
  if (does("sleep at load"))
    for (;;) pause();
}

static quoin_status start(const quoin_material* material, const char* id, double* values) {
  if (wrong_law.state_count > 0) values[0] = 0.0;
  return initial_state(material, id, values);
}

static quoin_status bound(const quoin_material* material, quoin_stiffness_bounds* bounds) {
  const quoin_status status = stiffness_bounds(material, bounds);
  bounds->normal *= times_of("normal bound");
  bounds->shear *= times_of("shear bound");
  return status;
}

/* Evaluates with the selected wrong action; most actions begin after 400 calls. */
static quoin_status answer(const quoin_material* material, quoin_batch* batch) {
  static int calls;
  quoin_status status = evaluate(material, batch);
  if (does("hang at once"))
    for (;;) pause();
  if (status == QUOIN_OK && wrong_law.state_count > 0) {
    uint64_t i;
    for (i = 0; i < batch->count; ++i)
      batch->state_new[0].data[(int64_t)i * batch->state_new[0].stride] =
          batch->state_old[0].data[(int64_t)i * batch->state_old[0].stride] + 1.0;
  }
  if (batch->energy_stored.data != NULL) {
    uint64_t i;
    for (i = 0; i < batch->count; ++i)
      batch->energy_stored.data[(int64_t)i * batch->energy_stored.stride] *= times_of("energy");
  }
  if (batch->tangent[0].data != NULL) batch->tangent[0].data[0] *= times_of("stiff");
  if (__atomic_add_fetch(&calls, 1, __ATOMIC_RELAXED) < 400 || batch->count == 0) return status;
  if (does("nan")) batch->traction_new[0].data[0] = NAN;
  if (does("infinite")) batch->traction_new[1].data[0] = HUGE_VAL;
  if (wrong_law.state_count == 0) return status;
  if (does("state")) batch->state_new[0].data[0] = -7.0;
  if (does("state nan")) batch->state_new[0].data[0] = NAN;
  if (does("status")) return 77;
  if (does("counts")) batch->failed_count = UINT64_MAX;
  if (does("hang"))
    for (;;) pause();
  if (does("spin"))
    for (;;) calls = 400;
  if (does("crash")) *nowhere = 1;
  if (does("exit")) exit(0);
  if (does("abort")) abort();
  return status;
}

static quoin_status talk(const quoin_law* self, uint64_t count, const quoin_property_value* const* values,
                         quoin_material** material, quoin_text* text) {
  const quoin_status status = create_material(self, count, values, material, text);
  if (does("escape in words")) say(text, "\033[31mred\377\n");
  return status;
}

static int change(const char* table, void* words, size_t bytes) {
  unsigned long word;
  unsigned long long value;
  char name[32];
  const char* what = getenv("QUOIN_HOSTILE");
  if (what == NULL || sscanf(what, "%31s %lu %llx", name, &word, &value) != 3 || strcmp(name, table) != 0) return 0;
  if (8 * (word + 1) > bytes) return 0;
  memcpy((char*)words + 8 * word, &value, 8);
  return 1;
}

const quoin_library* quoin_library_v1(const quoin_host_info* host, quoin_text* text) {
  int k;
  if (template_library_v1(host, text) == NULL) return NULL;
  if (does("escape in refusal")) {
    say(text, "\033[31mred\377\n");
    return NULL;
  }
  wrong_library = library;
  wrong_law = law;
  wrong_property = property_table[0];
  wrong_convention = convention;
  for (k = 0; k < PROPERTY_COUNT; ++k) wrong_properties[k] = &property_table[k];
  wrong_properties[0] = &wrong_property;
  wrong_library.laws = wrong_laws;
  wrong_law.id = "hostile_law";
  wrong_law.convention = &wrong_convention;
  wrong_law.properties = wrong_properties;
  wrong_law.states = wrong_states;
  wrong_law.state_count = 1;
  wrong_law.initial_state = start;
  wrong_law.stiffness_bounds = bound;
  wrong_law.evaluate = answer;
  wrong_law.create_material = talk;
  if (does("escape in name")) wrong_law.name = "\033[31mred";
  change("library", &wrong_library, sizeof wrong_library);
  change("law", &wrong_law, sizeof wrong_law);
  change("property", &wrong_property, sizeof wrong_property);
  change("state", &wrong_state, sizeof wrong_state);
  change("convention", &wrong_convention, sizeof wrong_convention);
  return &wrong_library;
}
