/* The template law with one fault, chosen when it is loaded by the environment variable QUOIN_BAD_LAW. */
#define quoin_library_v1 template_library_v1
#include "../../plugin_api/template/template_law.c"
#undef quoin_library_v1

#include <unistd.h>

QUOIN_EXPORT const quoin_library* quoin_library_v1(const quoin_host_info* host, quoin_text* text);
extern void throw_int(void);
extern void throw_words(void);

static const char* fault(void) {
  const char* name = getenv("QUOIN_BAD_LAW");
  return name != NULL ? name : "";
}
static int is(const char* name) { return strcmp(fault(), name) == 0; }

static void crash(void) {
  volatile int* nowhere = NULL;
  *nowhere = 1;
}

static void wait_for_ever(void) {
  for (;;) pause();
}

static void misbehave(void) {
  if (is("wait")) wait_for_ever();
  if (is("crash")) crash();
  if (is("exit")) exit(0);
  if (is("throw")) throw_int();
  if (is("throw words")) throw_words();
  if (is("abort")) abort();
}

/* Correct in the first calls, then wrong. */
static quoin_status late(const quoin_material* material, quoin_batch* batch) {
  static int calls;
  if (__atomic_add_fetch(&calls, 1, __ATOMIC_RELAXED) >= 100) misbehave();
  if (is("throw at once")) throw_words();
  return evaluate(material, batch);
}

/* Sets wrong text lengths: one larger than any buffer, and one that grows with every buffer. */
static quoin_status talk(const quoin_law* self, uint64_t count, const quoin_property_value* const* values,
                         quoin_material** material, quoin_text* text) {
  const quoin_status status = create_material(self, count, values, material, text);
  if (is("throw at creation")) throw_words();
  if (is("huge text") && text != NULL) text->length = UINT64_MAX;
  if (is("growing text") && text != NULL) text->length = text->capacity + 1;
  return status;
}

static const quoin_state_info odd_state = {sizeof(quoin_state_info),
                                           "a<b>&\"c\"",
                                           "-",
                                           "an id that means something to XML",
                                           QUOIN_ROLE_HISTORY,
                                           QUOIN_STATE_SCALAR,
                                           0,
                                           0,
                                           -HUGE_VAL,
                                           HUGE_VAL};
static const quoin_state_info* const odd_states[] = {&odd_state};
static quoin_status start(const quoin_material* material, const char* id, double* values) {
  if (is("throw at start")) throw_words();
  if (is("odd state")) values[0] = 0.0;
  return initial_state(material, id, values);
}

static quoin_law changed_law;
static const quoin_law* const changed_laws[] = {&changed_law};
static quoin_library changed_library;

const quoin_library* quoin_library_v1(const quoin_host_info* host, quoin_text* text) {
  if (is("crash at load")) crash();
  if (is("exit at load")) exit(0);
  if (is("wait at load")) wait_for_ever();
  if (template_library_v1(host, text) == NULL) return NULL;
  changed_library = library;
  changed_law = law;
  changed_library.laws = changed_laws;
  changed_law.id = "bad_law";
  changed_law.create_material = talk;
  changed_law.evaluate = late;
  changed_law.initial_state = start;
  if (is("null texts")) {
    changed_law.name = changed_law.version = changed_law.citation = changed_law.description = NULL;
  }
  if (is("no energies")) changed_law.capabilities &= ~(uint64_t)QUOIN_CAN_ENERGY;
  if (is("odd state")) {
    changed_law.state_count = 1;
    changed_law.states = odd_states;
  }
  return &changed_library;
}
