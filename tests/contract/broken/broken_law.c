/* Laws that each break one clause of the contract: the template law in a wrapper with one fault. BROKEN is the number
 * of the fault; 0 and 55 are the wrapper without a fault, which the checker must accept. faults.cmake has the fault of
 * each number and the clause that the checker must report. */
#define _GNU_SOURCE
#define quoin_library_v1 template_library_v1
#include "../../../plugin_api/template/template_law.c"
#undef quoin_library_v1

#include <fenv.h>
#include <sched.h>

QUOIN_EXPORT const quoin_library* quoin_library_v1(const quoin_host_info* host, quoin_text* text);

/* ---- The template with two states: the slip path (history) and the number of steps (diagnostic). ----------------- */

static const quoin_state_info state_table[2] = {
    {sizeof(quoin_state_info), "slid", "m", "length slid so far", QUOIN_ROLE_HISTORY, QUOIN_STATE_SCALAR,
     QUOIN_STATE_MONOTONIC, 0, 0.0, HUGE_VAL},
    {sizeof(quoin_state_info), "steps", "-", "steps with an increment", QUOIN_ROLE_DIAGNOSTIC,
     BROKEN == 54 ? QUOIN_STATE_PAIR_T : QUOIN_STATE_SCALAR, 0, 0, 0.0, BROKEN == 32 ? 3.0 : HUGE_VAL},
};
static const quoin_state_info* const state_list[2] = {&state_table[0], &state_table[1]};

/* ---- For faults that need more of a law: per-point stiffness and a strength. 55 has both and no fault. ------------
 */

#define HAS_COLUMNS (BROKEN == 55 || BROKEN == 56 || BROKEN == 57)
#define HAS_STRENGTH (BROKEN == 55 || BROKEN == 58 || BROKEN == 59 || BROKEN == 71)

#define HAS_DAMAGE (BROKEN >= 61 && BROKEN <= 64)

#if HAS_STRENGTH
static const quoin_property_info strength_info = {sizeof(quoin_property_info),
                                                  "tensile_strength",
                                                  "ft",
                                                  "Pa",
                                                  "strength across the joint, without effect",
                                                  QUOIN_PROPERTY_NUMBER,
                                                  QUOIN_PROPERTY_UPPER_OPEN,
                                                  1e5,
                                                  0.0,
                                                  HUGE_VAL,
                                                  NULL,
                                                  NULL,
                                                  0,
                                                  NULL};

struct strong_material {
  quoin_material elastic; /* first member: the template reads only this */
  double strength;
};

static quoin_status make_strong(const quoin_law* self, uint64_t count, const quoin_property_value* const* values,
                                quoin_material** material, quoin_text* text) {
  const quoin_property_value* kept[16] = {NULL};
  struct strong_material* strong;
  double strength = strength_info.default_value;
  int given = 0, faults = 0;
  uint64_t i, n = 0;
  quoin_status status;
  if (values == NULL) return create_material(self, count, values, material, text);
  if (count > 16) return QUOIN_ERROR_ARGUMENT;
  for (i = 0; i < count; ++i) {
    if (values[i] == NULL || values[i]->struct_size < sizeof *values[i] || values[i]->id == NULL ||
        strcmp(values[i]->id, strength_info.id) != 0) {
      kept[n++] = values[i];
    } else {
      faults += given++ || values[i]->number_count != 1 || values[i]->numbers == NULL;
      if (values[i]->number_count == 1 && values[i]->numbers != NULL) strength = values[i]->numbers[0];
    }
  }
  status = create_material(self, n, kept, material, text);
  faults += !(strength >= 0 && strength < HUGE_VAL);
#if BROKEN == 58 || BROKEN == 71
  faults += strength == 0; /* a mode that is switched off counts as a fault */
#endif
  if (faults > 0) {
    if (material != NULL) destroy_material(*material);
    if (material != NULL) *material = NULL;
#if BROKEN == 71
    say(text, "normal_stiffness: not with tensile_strength = %g\n", strength);
#else
    say(text, "tensile_strength = %g: one number from 0 on\n", strength);
#endif
    return QUOIN_ERROR_PROPERTY;
  }
  if (status != QUOIN_OK || material == NULL) return status;
  strong = realloc(*material, sizeof *strong);
  if (strong == NULL) {
    destroy_material(*material);
    *material = NULL;
    return QUOIN_ERROR_MEMORY;
  }
  strong->strength = strength;
  *material = &strong->elastic;
  return QUOIN_OK;
}
#endif

#if HAS_COLUMNS
/* Returns the column of the only per-point property; *ok: the batch has no other property columns. */
static quoin_in stiffness_column(const quoin_batch* batch, int* ok) {
  quoin_in column = {NULL, 0};
  uint64_t c;
  for (c = 0; c < batch->property_column_count && *ok; ++c) {
    const quoin_property_column* const given = &batch->property_columns[c];
    *ok = given->id != NULL && strcmp(given->id, "normal_stiffness") == 0 && given->values.data != NULL;
    column = given->values;
  }
  return column;
}

static int refused(quoin_in column, uint64_t i) {
  const double kn = column.data != NULL ? get(column, i) : 1;
#if BROKEN == 56
  if (isnan(kn)) return 0; /* NaN is accepted */
#endif
  return !(kn > 0 && kn < HUGE_VAL);
}
#endif

#if BROKEN == 3 || BROKEN == 4
static void loud(quoin_text* text) {
  static const char message[] = "this is the reason, told at some length and without looking at the buffer's end";
  if (text == NULL || text->struct_size < sizeof *text || text->data == NULL) return;
#if BROKEN == 3
  memcpy(text->data, message, sizeof message);
  text->length = sizeof message - 1;
#else
  if (text->capacity > 0) {
    const size_t n = text->capacity - 1 < sizeof message - 1 ? (size_t)text->capacity - 1 : sizeof message - 1;
    memcpy(text->data, message, n);
    text->data[n] = 0;
    text->length = n;
  }
#endif
}
#endif

static quoin_status make(const quoin_law* self, uint64_t count, const quoin_property_value* const* values,
                         quoin_material** material, quoin_text* text) {
#if BROKEN == 9 || BROKEN == 11 || BROKEN == 12
  /* Accepts values that it should refuse: NaN, values below the bound, unknown properties. */
  const quoin_property_value* kept[16];
  quoin_property_value changed[16];
  static const double one = 1e9;
  uint64_t i, n = 0;
  for (i = 0; i < count && i < 16 && values != NULL; ++i) {
    const quoin_property_value* value = values[i];
    changed[n] = *value;
    if (BROKEN == 9 && value->number_count == 1 && isnan(value->numbers[0])) changed[n].numbers = &one;
    if (BROKEN == 11 && value->number_count == 1 && value->numbers[0] <= 0) changed[n].numbers = &one;
    if (BROKEN == 12 && strcmp(value->id, "no_such_property") == 0) continue;
    kept[n] = &changed[n];
    ++n;
  }
  return create_material(self, n, values != NULL ? kept : NULL, material, text);
#elif BROKEN == 10
  /* Only the first fault is reported. */
  quoin_status status = create_material(self, count, values, material, text);
  char* end = text != NULL && text->data != NULL && text->capacity > 0 ? strchr(text->data, '\n') : NULL;
  if (end != NULL) {
    *end = 0;
    text->length = (uint64_t)(end - text->data);
  }
  return status;
#elif BROKEN == 33
  static void* volatile lost;
  lost = malloc(100);
  (void)lost;
  return create_material(self, count, values, material, text);
#elif HAS_STRENGTH
  return make_strong(self, count, values, material, text);
#elif BROKEN == 60
  if (text != NULL) text->length = 0; /* whatever its struct_size */
  return create_material(self, count, values, material, text);
#elif BROKEN == 52
  if (values == NULL && count > 0) return QUOIN_OK; /* null counts as no values */
  return create_material(self, count, values, material, text);
#elif BROKEN == 53
  say_nothing(text);
  if (material != NULL) *material = NULL;
  say(text, "normal_stiffness: never good enough\n");
  (void)self;
  (void)count;
  (void)values;
  return QUOIN_ERROR_PROPERTY;
#elif BROKEN == 42
  quoin_status status = create_material(self, count, values, material, text);
  if (status == QUOIN_ERROR_PROPERTY && material != NULL) *material = (quoin_material*)&state_table;
  return status;
#else
  return create_material(self, count, values, material, text);
#endif
}

#if BROKEN == 13
/* Keeps a pointer to the caller's values and reads it at every evaluation. */
static const double* remembered;
static quoin_status remember(const quoin_law* self, uint64_t count, const quoin_property_value* const* values,
                             quoin_material** material, quoin_text* text) {
  quoin_status status = make(self, count, values, material, text);
  if (status == QUOIN_OK && material != NULL && count > 0) remembered = values[0]->numbers;
  return status;
}
#endif

static quoin_status number_of(const quoin_material* material, const char* id, double* value) {
  quoin_status status = material_number(material, id, value);
#if HAS_STRENGTH
  if (status != QUOIN_OK && material != NULL && id != NULL && value != NULL && strcmp(id, strength_info.id) == 0) {
    *value = ((const struct strong_material*)material)->strength;
    status = QUOIN_OK;
  }
#endif
#if BROKEN == 43
  if (status == QUOIN_OK) *value *= 2;
#endif
  return status;
}

static quoin_status begin(const quoin_material* material, const char* id, double* values) {
#if BROKEN == 38
  id = initial_states[0];
#endif
  if (material == NULL || id == NULL || values == NULL || strcmp(id, initial_states[0]) != 0)
    return QUOIN_ERROR_ARGUMENT;
  values[0] = values[1] = 0;
  return QUOIN_OK;
}

static quoin_status bounds_of(const quoin_material* material, quoin_stiffness_bounds* bounds) {
  quoin_status status = stiffness_bounds(material, bounds);
#if BROKEN == 29
  if (status == QUOIN_OK) bounds->shear *= 0.9;
#endif
  return status;
}

static double hidden; /* global state of faults that keep one */

#if BROKEN == 18
static double scratch[1024];
#endif

static quoin_status step(const quoin_material* material, quoin_batch* batch) {
  quoin_status status;
  uint64_t i;
  int k, in_place;
  double* slid;
  double* steps;
  double* sigma_before = NULL;
  unsigned char* bad;
  quoin_batch inner;
  int columns_ok = 1;
#if HAS_COLUMNS
  quoin_in kn_column;
#endif
  if (material == NULL || batch == NULL) return QUOIN_ERROR_ARGUMENT;
#if BROKEN == 40
  if (batch->struct_size < QUOIN_BATCH_SIZE_1_0) return QUOIN_OK; /* a short batch is not refused */
#endif
#if BROKEN == 65
  if (batch->struct_size < sizeof *batch) return QUOIN_ERROR_ARGUMENT; /* refuses batches of version 1.0 */
#endif
  if (batch->struct_size < QUOIN_BATCH_SIZE_1_0) return QUOIN_ERROR_ARGUMENT;
#if BROKEN == 22
  if (batch->count == 0) return QUOIN_ERROR_ARGUMENT;
#endif
#if BROKEN == 36
  if (batch->normal_jump.data == NULL && batch->count > 0) abort();
#endif
#if BROKEN == 20
  if (batch->count > 0 && batch->status.data == NULL && batch->struct_size == sizeof *batch) *(volatile int*)NULL = 1;
#endif
#if BROKEN == 34
  puts("evaluating");
  fflush(stdout);
#endif
#if BROKEN == 35
  fesetround(FE_UPWARD);
#endif
  if (batch->count > 0) {
    if (batch->state_old == NULL || batch->state_new == NULL || batch->state_old[0].data == NULL ||
        batch->state_new[0].data == NULL)
      return QUOIN_ERROR_ARGUMENT;
#if BROKEN == 21
    if (batch->state_old[1].data == NULL) return QUOIN_ERROR_ARGUMENT; /* requires columns of diagnostics */
#endif
  }

  /* States first, into scratch memory, since the template may overwrite the old tractions. */
  slid = malloc((size_t)(batch->count + 1) * sizeof *slid);
  steps = malloc((size_t)(batch->count + 1) * sizeof *steps);
  bad = malloc((size_t)(batch->count + 1));
  inner = *batch;
#if BROKEN == 70
  inner.traction_old[0] = batch->normal_jump; /* finite */
#endif
#if HAS_DAMAGE
  memset(inner.damage, 0, sizeof inner.damage); /* the template has no damage */
#endif
#if HAS_COLUMNS
  inner.property_column_count = 0; /* the template has no property columns */
  kn_column = stiffness_column(batch, &columns_ok);
#endif
  if (slid == NULL || steps == NULL || bad == NULL || !columns_ok || !well_formed(&inner)) {
    free(slid);
    free(steps);
    free(bad);
    return QUOIN_ERROR_ARGUMENT;
  }
  for (i = 0; i < batch->count; ++i) {
    const double dd_s = get(batch->slip_increment[0], i), dd_t = get(batch->slip_increment[1], i);
    slid[i] = get(batch->state_old[0], i) + sqrt(dd_s * dd_s + dd_t * dd_t);
    steps[i] = batch->state_old[1].data != NULL ? get(batch->state_old[1], i) + (dd_s * dd_s + dd_t * dd_t > 0) : 0;
    bad[i] = !isfinite(slid[i]);
    for (k = BROKEN == 70 ? 1 : 0; k < 3; ++k) bad[i] = bad[i] || !isfinite(get(batch->traction_old[k], i));
    bad[i] = bad[i] || !isfinite(get(batch->normal_jump, i));
#if HAS_COLUMNS
    bad[i] = bad[i] || refused(kn_column, i);
#endif
#if BROKEN == 31
    if (!bad[i] && get(batch->normal_jump, i) < 0) slid[i] *= 0.9; /* heals */
#endif
#if BROKEN == 67
    if (!bad[i] && slid[i] > 1e-3) slid[i] *= 0.9; /* heals after a long slip */
#endif
#if BROKEN == 68
    if (fabs(dd_s) > 1e-3) {
      puts("a long slip");
      fflush(stdout);
    }
#endif
#if BROKEN == 37
    ((quoin_material*)(uintptr_t)material)->ks *= 1 + 1e-9; /* history kept in the material */
#endif
  }
  in_place = batch->count > 0 && batch->traction_old[0].data == batch->traction_new[0].data;
  (void)in_place;
  (void)sigma_before;
#if BROKEN == 17
  if (in_place) { /* clears the output before it reads the input */
    for (i = 0; i < batch->count; ++i) put(batch->traction_new[1], i, 0.0);
  }
#endif

#if BROKEN == 16
  inner.normal_jump.stride = inner.normal_jump.stride < 0 ? -inner.normal_jump.stride : inner.normal_jump.stride;
  if (batch->normal_jump.stride < 0) inner.normal_jump.data -= (batch->count - 1) * (uint64_t)inner.normal_jump.stride;
#endif
#if BROKEN == 13
  {
    quoin_material borrowed = *material;
    if (remembered != NULL) borrowed.kn = *remembered;
    status = evaluate(&borrowed, &inner);
  }
#else
  status = evaluate(material, &inner);
#endif
  batch->clamped_count = inner.clamped_count;
  batch->failed_count = inner.failed_count;
  batch->worst_status = inner.worst_status;
  batch->any_yielding = 0;
  if (status != QUOIN_OK) {
    free(slid);
    free(steps);
    free(bad);
    return status;
  }

  for (i = 0; i < batch->count; ++i) {
    const double old = get(batch->state_old[0], i);
    int bad_here = !isfinite(old);
#if HAS_COLUMNS
    bad_here = bad_here || refused(kn_column, i);
#endif
    if (bad[i] && isfinite(get(batch->normal_jump, i)) && bad_here) {
      /* A value that only the wrapper refuses: the point fails here. Tests do not use its tractions in place. */
      for (k = 0; k < 3; ++k) put(batch->traction_new[k], i, get(batch->traction_old[k], i));
      put(batch->energy_stored, i, 0.0);
      for (k = 0; k < 9; ++k) put(batch->tangent[k], i, 0.0);
      put_u32(batch->flags, i, 0);
      put_u32(batch->status, i, QUOIN_POINT_FAILED);
      ++batch->failed_count;
      batch->worst_status = QUOIN_POINT_FAILED;
    }
    if (bad[i]) {
      put(batch->state_new[0], i, old);
      if (batch->state_new[1].data != NULL) put(batch->state_new[1], i, get(batch->state_old[1], i));
    } else {
      if (slid[i] != old) {
        batch->any_yielding = 1;
        if (batch->flags.data != NULL) {
          batch->flags.data[(int64_t)i * batch->flags.stride] |= QUOIN_FLAG_YIELDING;
        }
      }
      put(batch->state_new[0], i, slid[i]);
      if (batch->state_new[1].data != NULL) put(batch->state_new[1], i, steps[i]);
    }
#if HAS_COLUMNS
    if (!bad[i] && kn_column.data != NULL && isfinite(get(kn_column, i)) && BROKEN != 57) {
      const double d_n = get(batch->normal_jump, i), kn = get(kn_column, i);
      put(batch->traction_new[0], i, kn * d_n);
      put(batch->tangent[0], i, kn);
      if (batch->energy_stored.data != NULL) {
        batch->energy_stored.data[(int64_t)i * batch->energy_stored.stride] += (kn - material->kn) * d_n * d_n / 2;
      }
    }
#endif
#if BROKEN >= 14
    if (!bad[i]) {
      const double sigma = get((quoin_in){batch->traction_new[0].data, batch->traction_new[0].stride}, i);
      const double tau_s = get((quoin_in){batch->traction_new[1].data, batch->traction_new[1].stride}, i);
      const double tau_t = get((quoin_in){batch->traction_new[2].data, batch->traction_new[2].stride}, i);
      (void)sigma;
      (void)tau_s;
      (void)tau_t;
#if BROKEN == 14
      if (hidden != 0 && i == 0)
        put(batch->traction_new[0], i, sigma * (1 + 1e-15 * hidden)); /* depends on the last call */
#elif BROKEN == 15
      if (i + 1 == batch->count && batch->count % 2 == 1) put(batch->traction_new[0], i, sigma * (1 + 4e-16));
#elif BROKEN == 18
      scratch[i % 1024] = sigma; /* shared by all threads */
      if (i + 1 == batch->count) {
        uint64_t j;
        sched_yield(); /* so that one processor shows the race as well as many */
        for (j = 0; j < batch->count; ++j) {
          if (!bad[j]) put(batch->traction_new[0], j, scratch[j % 1024]);
        }
      }
#elif BROKEN == 66
      if (get(batch->normal_jump, i) < -1e-4) put(batch->traction_new[0], i, NAN);
#elif BROKEN == 19
      if (batch->traction_new[0].stride > 1)
        batch->traction_new[0].data[(int64_t)i * batch->traction_new[0].stride - 1] = 0;
#elif BROKEN == 24
      if (i == 3) batch->failed_count += 1;
#elif BROKEN == 25
      put(batch->traction_new[1], i, tau_s * (1 - 1e-7)); /* creeps */
#elif BROKEN == 26
      put(batch->traction_new[1], i, tau_s > 1e5 ? 1e5 : tau_s); /* a limit for s only */
#elif BROKEN == 27
      put(batch->energy_stored, i, sigma * sigma / (2 * material->kn)); /* without the shear part */
#elif BROKEN == 28
      put(batch->dissipated[QUOIN_DISSIPATED_FRICTION], i, -1e-6 * (slid[i] - old) * fabs(sigma));
#elif BROKEN == 69
      put(batch->traction_new[0], i, -sigma); /* with the energy and the tangent of such a spring */
      put(batch->energy_stored, i,
          (tau_s * tau_s + tau_t * tau_t) / (2 * material->ks) - sigma * sigma / (2 * material->kn));
      put(batch->tangent[0], i, -material->kn);
#elif BROKEN == 70
      put(batch->dissipated[QUOIN_DISSIPATED_FRICTION], i, (slid[i] - old) * fabs(get(batch->traction_old[0], i)));
#elif BROKEN == 30
      put(batch->tangent[4], i, material->ks * 1.1);
#elif BROKEN == 39
      batch->any_yielding = 0;
#elif BROKEN == 59
      /* 0 / 0 where there is no strength. */
      put(batch->traction_new[0], i,
          sigma * (((const struct strong_material*)material)->strength /
                   ((const struct strong_material*)material)->strength));
#elif BROKEN == 44
      put(batch->energy_stored, i, 2 * (sigma * sigma / material->kn + (tau_s * tau_s + tau_t * tau_t) / material->ks));
#endif
    }
#endif
#if HAS_DAMAGE
    if (batch->struct_size >= sizeof *batch) {
      const double lost = slid[i] / (slid[i] + 1e-4);
      put(batch->damage[QUOIN_DAMAGE_TENSION], i, 0.0);
      put(batch->damage[QUOIN_DAMAGE_CRUSHING], i, 0.0);
#if BROKEN == 62
      put(batch->damage[QUOIN_DAMAGE_COHESION], i, bad[i] ? 0.0 : 1 - lost); /* the remaining share, not the lost one */
#elif BROKEN == 63
      put(batch->damage[QUOIN_DAMAGE_COHESION], i, bad[i] ? 0.0 : 100 * lost); /* per cent */
#elif BROKEN == 64
      put(batch->damage[QUOIN_DAMAGE_COHESION], i, bad[i] ? 1.0 : lost); /* a failed point is not a broken joint */
#else
      put(batch->damage[QUOIN_DAMAGE_COHESION], i, bad[i] ? 0.0 : lost);
#endif
      if (!bad[i] && lost > 0 && batch->flags.data != NULL)
        batch->flags.data[(int64_t)i * batch->flags.stride] |= QUOIN_FLAG_SHEAR_DAMAGED;
    }
#endif
#if BROKEN == 23
    /* A failed point gets zeros instead of its old values. */
    if (bad[i]) put(batch->traction_new[0], i, 0.0);
#endif
#if BROKEN == 45
    /* A failed point changes the next one. */
    if (i > 0 && bad[i - 1] && !bad[i]) put(batch->traction_new[0], i, 0.0);
#endif
  }
#if BROKEN == 14
  hidden = batch->count > 0 ? (double)(batch->count % 97) : 0;
#endif
  free(slid);
  free(steps);
  free(bad);
  return QUOIN_OK;
}

#if BROKEN == 41
/* Converts the states, but without the shift of the normal jump. */
static quoin_status migrate(const quoin_material* material, quoin_migration* m, quoin_text* text) {
  uint64_t i, s, k;
  (void)material;
  say_nothing(text);
  m->failed_count = 0;
  for (i = 0; i < m->count; ++i) {
    put(m->normal_shift, i, 1e-6);
    put(m->energy_jump, i, 0.0);
    put_u32(m->status, i, QUOIN_POINT_OK);
    for (s = 0; s < 2; ++s) {
      put(m->state_new[s], i, 0.0);
      for (k = 0; k < m->from_state_count; ++k) {
        if (strcmp(m->from_state_ids[k], state_table[s].id) == 0) put(m->state_new[s], i, get(m->from_states[k], i));
      }
    }
  }
  return QUOIN_OK;
}
#endif

#if BROKEN == 1
QUOIN_EXPORT int quoin_helper(void);
int quoin_helper(void) { return 1; }
#endif

static quoin_property_info changed_properties[PROPERTY_COUNT + 1];
static const quoin_property_info* const changed_list[PROPERTY_COUNT + 1] = {
    &changed_properties[0], &changed_properties[1], &changed_properties[2]};
static quoin_convention changed_convention;
static quoin_law changed_law;
static const quoin_law* const changed_laws[] = {&changed_law};
static quoin_library changed_library;

const quoin_library* quoin_library_v1(const quoin_host_info* host, quoin_text* text) {
  const quoin_library* from;
#if BROKEN == 48
  static const quoin_host_info nobody = {sizeof nobody, QUOIN_ABI_MAJOR, QUOIN_ABI_MINOR, "nobody", "0"};
  if (host == NULL) host = &nobody;
#elif BROKEN == 49
  if (host != NULL && host->struct_size >= sizeof *host && host->abi_minor > QUOIN_ABI_MINOR) return NULL;
#elif BROKEN == 51
  text->length = 0;
#endif
#if BROKEN == 2
  if (host != NULL && host->struct_size >= sizeof *host) {
    quoin_host_info pretended = *host;
    pretended.abi_major = QUOIN_ABI_MAJOR;
    from = template_library_v1(&pretended, text);
  } else {
    from = NULL;
  }
#else
  from = template_library_v1(host, text);
#endif
#if BROKEN == 3 || BROKEN == 4
  if (from == NULL) loud(text);
#endif
  if (from == NULL) return NULL;
  (void)hidden;
  changed_library = *from;
  changed_law = law;
  changed_convention = convention;
  memcpy(changed_properties, property_table, sizeof property_table);
  changed_library.laws = changed_laws;
#if BROKEN == 50
  changed_library.abi_major = QUOIN_ABI_MAJOR + 1;
#endif
  changed_law.convention = &changed_convention;
  changed_law.properties = changed_list;
  changed_law.state_count = 2;
  changed_law.states = state_list;
  changed_law.create_material = make;
  changed_law.material_number = number_of;
  changed_law.initial_state = begin;
  changed_law.stiffness_bounds = bounds_of;
  changed_law.evaluate = step;
#if HAS_STRENGTH
  changed_properties[PROPERTY_COUNT] = strength_info;
  changed_law.property_count = PROPERTY_COUNT + 1;
#endif
#if HAS_COLUMNS
  changed_properties[NORMAL_STIFFNESS].flags |= QUOIN_PROPERTY_PER_POINT;
  changed_law.capabilities |= QUOIN_CAN_PROPERTY_COLUMNS;
#endif
#if HAS_DAMAGE
  changed_law.capabilities |= QUOIN_CAN_DAMAGE;
#endif
#if BROKEN == 5
  changed_properties[1].default_from = NULL;
  changed_properties[1].default_value = -1;
#elif BROKEN == 6
  changed_properties[1].unit = "psi/in";
#elif BROKEN == 7
  changed_properties[1].id = "normal_stiffness";
#elif BROKEN == 8
  changed_convention.tension_sign = -1;
#elif BROKEN == 13
  changed_law.create_material = remember;
#elif BROKEN == 41
  changed_law.migrate_state = migrate;
  changed_law.capabilities |= QUOIN_CAN_MIGRATE;
#elif BROKEN == 46
  changed_law.capabilities |= QUOIN_CAN_MIGRATE; /* without the function */
#elif BROKEN == 47
  changed_properties[1].default_from = "bulk_stiffness";
#endif
  return &changed_library;
}
