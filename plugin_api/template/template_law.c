/* A minimal complete contact law: linear elasticity in C99, which needs only the headers of plugin_api/include.
 *
 *   cc -std=c99 -O2 -fPIC -shared -I plugin_api/include -Wl,--version-script=plugin_api/quoin.map \
 *      plugin_api/template/template_law.c -o template_law.so
 *
 * Copy it, put your equations at the comments EQUATIONS, describe your properties and states in the tables, then run
 * quoin-check-law on the result. Clause numbers (C6.4) refer to plugin_api/README.md. */
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "quoin/quoin.h"

/* ---- Metadata (C3) ----------------------------------------------------------------------------------------------- */

enum { NORMAL_STIFFNESS, SHEAR_STIFFNESS, PROPERTY_COUNT };

static const quoin_property_info property_table[PROPERTY_COUNT] = {
    {sizeof(quoin_property_info), "normal_stiffness", "kn", "Pa/m", "elastic stiffness across the joint",
     QUOIN_PROPERTY_NUMBER, QUOIN_PROPERTY_REQUIRED | QUOIN_PROPERTY_LOWER_OPEN, 0.0, 0.0, HUGE_VAL, NULL, NULL, 0,
     NULL},
    {sizeof(quoin_property_info), "shear_stiffness", "ks", "Pa/m", "elastic stiffness along the joint",
     QUOIN_PROPERTY_NUMBER, QUOIN_PROPERTY_LOWER_OPEN, 0.0, 0.0, HUGE_VAL, "normal_stiffness", NULL, 0, NULL},
};
static const quoin_property_info* const properties[PROPERTY_COUNT] = {&property_table[0], &property_table[1]};
/* No states. A law with one state has STATE_COUNT = 1 and, with its pointer, the table entry {sizeof(quoin_state_info),
 * "slip", "m", "accumulated slip", QUOIN_ROLE_HISTORY, QUOIN_STATE_SCALAR, QUOIN_STATE_MONOTONIC, 0, 0.0, HUGE_VAL}. */
enum { STATE_COUNT = 0 };
static const quoin_state_info* const states[STATE_COUNT + 1] = {NULL};
static const char* const initial_states[] = {"bonded"};
static const quoin_convention convention = {sizeof(quoin_convention), 1, 1, 1, 1, 1, 1};

struct quoin_material {
  double kn, ks;
};

/* ---- Text: within the caller's buffer, and always with the full length (C2) -------------------------------------- */

static quoin_text* usable(quoin_text* text) {
  return text != NULL && text->struct_size >= sizeof(quoin_text) ? text : NULL;
}

static void say_nothing(quoin_text* text) {
  if ((text = usable(text)) == NULL) return;
  text->length = 0;
  if (text->data != NULL && text->capacity > 0) text->data[0] = 0;
}

static void say(quoin_text* text, const char* format, ...) {
  char line[512]; /* a longer line is cut here */
  uint64_t i;
  va_list arguments;
  if ((text = usable(text)) == NULL) return;
  va_start(arguments, format);
  vsnprintf(line, sizeof line, format, arguments);
  va_end(arguments);
  for (i = 0; line[i] != 0; ++i, ++text->length) {
    if (text->data == NULL || text->length + 1 >= text->capacity) continue;
    text->data[text->length] = line[i];
    text->data[text->length + 1] = 0;
  }
}

/* ---- Materials (C4) ---------------------------------------------------------------------------------------------- */

static quoin_status create_material(const quoin_law* law, uint64_t value_count,
                                    const quoin_property_value* const* values, quoin_material** material,
                                    quoin_text* text) {
  double number[PROPERTY_COUNT] = {0.0, 0.0};
  int given[PROPERTY_COUNT] = {0, 0};
  int faults = 0;
  uint64_t v;
  int p;

  say_nothing(text);
  if (material != NULL) *material = NULL;
  if (law == NULL || (value_count > 0 && values == NULL)) return QUOIN_ERROR_ARGUMENT;
  for (v = 0; v < value_count; ++v) {
    const quoin_property_value* value = values[v];
    if (value == NULL || value->struct_size < sizeof *value || value->id == NULL) return QUOIN_ERROR_ARGUMENT;
    for (p = 0; p < PROPERTY_COUNT && strcmp(value->id, property_table[p].id) != 0; ++p) {
    }
    if (p == PROPERTY_COUNT) {
      say(text, "%s: unknown property; this law has normal_stiffness, shear_stiffness\n", value->id);
      ++faults;
    } else if (value->number_count != 1 || value->numbers == NULL || given[p]) {
      say(text, "%s: give one number, once\n", value->id);
      ++faults;
    } else {
      number[p] = value->numbers[0];
      given[p] = 1;
    }
  }
  if (!given[NORMAL_STIFFNESS]) {
    say(text, "normal_stiffness: missing; it has no default\n");
    ++faults;
  }
  if (!given[SHEAR_STIFFNESS]) number[SHEAR_STIFFNESS] = number[NORMAL_STIFFNESS];
  for (p = 0; p < PROPERTY_COUNT; ++p) {
    if (given[p] && !(number[p] > property_table[p].lower && number[p] < property_table[p].upper)) { /* NaN too */
      say(text, "%s = %g: must be finite and greater than 0 %s\n", property_table[p].id, number[p],
          property_table[p].unit);
      ++faults;
    }
  }
  if (faults > 0) return QUOIN_ERROR_PROPERTY;
  if (material == NULL) return QUOIN_OK; /* null: only validate */
  *material = malloc(sizeof **material);
  if (*material == NULL) return QUOIN_ERROR_MEMORY;
  (*material)->kn = number[NORMAL_STIFFNESS];
  (*material)->ks = number[SHEAR_STIFFNESS];
  return QUOIN_OK;
}

static void destroy_material(quoin_material* material) { free(material); }

static quoin_status material_number(const quoin_material* material, const char* id, double* value) {
  if (material == NULL || id == NULL || value == NULL) return QUOIN_ERROR_ARGUMENT;
  if (strcmp(id, "normal_stiffness") == 0) {
    *value = material->kn;
  } else if (strcmp(id, "shear_stiffness") == 0) {
    *value = material->ks;
  } else {
    return QUOIN_ERROR_ARGUMENT;
  }
  return QUOIN_OK;
}

static quoin_status initial_state(const quoin_material* material, const char* id, double* values) {
  int k;
  if (material == NULL || id == NULL || strcmp(id, initial_states[0]) != 0) return QUOIN_ERROR_ARGUMENT;
  if (STATE_COUNT > 0 && values == NULL) return QUOIN_ERROR_ARGUMENT;
  for (k = 0; k < STATE_COUNT; ++k) values[k] = 0.0;
  return QUOIN_OK;
}

static quoin_status stiffness_bounds(const quoin_material* material, quoin_stiffness_bounds* bounds) {
  if (material == NULL || bounds == NULL || bounds->struct_size < sizeof *bounds) return QUOIN_ERROR_ARGUMENT;
  bounds->normal = material->kn;
  bounds->shear = material->ks;
  return QUOIN_OK;
}

/* ---- Evaluation (C5 to C8) --------------------------------------------------------------------------------------- */

/* Column access: the index is signed, because strides may be negative (C6.3). */
static double get(quoin_in column, uint64_t i) { return column.data[(int64_t)i * column.stride]; }

static void put(quoin_out column, uint64_t i, double value) {
  if (column.data != NULL) column.data[(int64_t)i * column.stride] = value; /* null: not requested (C6.7) */
}

static void put_u32(quoin_out_u32 column, uint64_t i, uint32_t value) {
  if (column.data != NULL) column.data[(int64_t)i * column.stride] = value;
}

/* True if each history state has both columns, and each diagnostic state has both columns or no new one (C6.8). */
static int well_formed_states(const quoin_batch* batch) {
  int k;
  if (STATE_COUNT > 0 && (batch->state_old == NULL || batch->state_new == NULL)) return 0;
  for (k = 0; k < STATE_COUNT; ++k) {
    const int has_old = batch->state_old[k].data != NULL, has_new = batch->state_new[k].data != NULL;
    if (states[k]->role == QUOIN_ROLE_HISTORY && !(has_old && has_new)) return 0;
    if (has_new && (!has_old || batch->state_new[k].stride == 0)) return 0;
  }
  return 1;
}

static int well_formed(const quoin_batch* batch) { /* C6.11 */
  int k, ok;
  if (batch->count == 0) return 1;
  ok = batch->normal_jump.data != NULL && batch->property_column_count == 0 && well_formed_states(batch);
  for (k = 0; k < 2; ++k) ok = ok && batch->slip_increment[k].data != NULL;
  for (k = 0; k < 3; ++k)
    ok = ok && batch->traction_old[k].data != NULL && batch->traction_new[k].data != NULL &&
         batch->traction_new[k].stride != 0;
  for (k = 0; k < 9; ++k) ok = ok && (batch->tangent[k].data == NULL || batch->tangent[k].stride != 0);
  for (k = 0; k < QUOIN_DISSIPATED_COUNT; ++k)
    ok = ok && (batch->dissipated[k].data == NULL || batch->dissipated[k].stride != 0);
  return ok && (batch->energy_stored.data == NULL || batch->energy_stored.stride != 0) &&
         (batch->flags.data == NULL || batch->flags.stride != 0) &&
         (batch->status.data == NULL || batch->status.stride != 0);
}

static int asks_for_damage(const quoin_batch* batch) {
  int k, asked = 0;
  if (batch->struct_size < sizeof *batch) return 0;
  for (k = 0; k < QUOIN_DAMAGE_COUNT; ++k) asked = asked || batch->damage[k].data != NULL;
  return asked;
}

static quoin_status evaluate(const quoin_material* material, quoin_batch* batch) {
  uint64_t i;
  int k;
  /* Hosts of version 1.0 have a shorter quoin_batch, whose later fields must not be accessed (C1.4). */
  if (material == NULL || batch == NULL || batch->struct_size < QUOIN_BATCH_SIZE_1_0 || !well_formed(batch))
    return QUOIN_ERROR_ARGUMENT;
  if (asks_for_damage(batch)) return QUOIN_ERROR_UNSUPPORTED; /* not in the capabilities (C6.7) */
  batch->clamped_count = 0;
  batch->failed_count = 0;
  batch->worst_status = QUOIN_POINT_OK;
  batch->any_yielding = 0;

  for (i = 0; i < batch->count; ++i) {
    /* Read every input of the point before writing any output: old and new may be the same memory (C6.4). */
    const double d_n = get(batch->normal_jump, i);
    const double dd_s = get(batch->slip_increment[0], i);
    const double dd_t = get(batch->slip_increment[1], i);
    const double sigma_old = get(batch->traction_old[0], i);
    const double tau_s_old = get(batch->traction_old[1], i);
    const double tau_t_old = get(batch->traction_old[2], i);

    /* EQUATIONS: sigma from the total opening, tau from the sliding increment. */
    double sigma = material->kn * d_n;
    double tau_s = tau_s_old + material->ks * dd_s;
    double tau_t = tau_t_old + material->ks * dd_t;
    double stored = sigma * d_n / 2 + (tau_s * tau_s + tau_t * tau_t) / (2 * material->ks);
    const double tangent[3] = {material->kn, material->ks, material->ks};
    uint32_t flags = d_n > 0 ? QUOIN_FLAG_OPEN : 0;
    uint32_t status = QUOIN_POINT_OK;

    /* A value is not finite: only this point fails, and it keeps its old values (C7.1). */
    const int failed = !(isfinite(d_n) && isfinite(sigma_old) && isfinite(sigma) && isfinite(tau_s) &&
                         isfinite(tau_t) && isfinite(stored));
    if (failed) {
      sigma = sigma_old;
      tau_s = tau_s_old;
      tau_t = tau_t_old;
      stored = 0;
      flags = 0;
      status = QUOIN_POINT_FAILED;
      ++batch->failed_count;
      batch->worst_status = QUOIN_POINT_FAILED;
    }

    put(batch->traction_new[0], i, sigma);
    put(batch->traction_new[1], i, tau_s);
    put(batch->traction_new[2], i, tau_t);
    for (k = 0; k < STATE_COUNT; ++k) /* EQUATIONS of your states: here they do not change */
      if (batch->state_new[k].data != NULL) put(batch->state_new[k], i, get(batch->state_old[k], i));
    put(batch->energy_stored, i, stored);
    for (k = 0; k < QUOIN_DISSIPATED_COUNT; ++k) put(batch->dissipated[k], i, 0.0);
    for (k = 0; k < 9; ++k) put(batch->tangent[k], i, k % 4 == 0 && !failed ? tangent[k / 4] : 0.0);
    put_u32(batch->flags, i, flags);
    put_u32(batch->status, i, status);
  }
  return QUOIN_OK;
}

/* ---- The law and the library (C1) -------------------------------------------------------------------------------- */

static const quoin_law law = {
    sizeof(quoin_law),
    "template_elastic",
    "Template: linear elastic joint",
    "1.0.0",
    "Hooke, De potentia restitutiva, 1678",
    "sigma = kn d_n, tau = ks d_s, without limit",
    QUOIN_CAN_ENERGY | QUOIN_CAN_TANGENT | QUOIN_CAN_FLAGS,
    &convention,
    PROPERTY_COUNT,
    properties,
    STATE_COUNT,
    states,
    1,
    initial_states,
    UINT64_C(0x74656d706c000001), /* state schema: any number; change it whenever the states change */
    create_material,
    destroy_material,
    material_number,
    initial_state,
    stiffness_bounds,
    evaluate,
    NULL, /* migrate_state: not offered */
};
static const quoin_law* const laws[] = {&law};
static const quoin_library library = {
    sizeof(quoin_library), QUOIN_ABI_MAJOR, QUOIN_ABI_MINOR, "quoin template", "1.0.0", 1, laws, NULL};

const quoin_library* quoin_library_v1(const quoin_host_info* host, quoin_text* text) {
  say_nothing(text);
  if (host == NULL || host->struct_size < sizeof *host) {
    say(text, "quoin template: the host did not describe itself (null or short quoin_host_info)");
    return NULL;
  }
  if (host->abi_major != QUOIN_ABI_MAJOR) {
    say(text, "quoin template: built for ABI %u.%u, the host asks for %u.%u", QUOIN_ABI_MAJOR, QUOIN_ABI_MINOR,
        (unsigned)host->abi_major, (unsigned)host->abi_minor);
    return NULL;
  }
  return &library;
}
