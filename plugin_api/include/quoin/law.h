/* A law: metadata and functions. A library holds one law or more and exports exactly one symbol, quoin_library_v1.
 *
 * Life of a law: the host calls quoin_library_v1 once, reads the metadata, creates materials from property values,
 * asks for the initial state and the stiffness bounds, evaluates batches from any number of threads, destroys the
 * materials, unloads the library. A law keeps no state per contact and no global that a call changes. */
#ifndef QUOIN_LAW_H
#define QUOIN_LAW_H

#include "quoin/batch.h"
#include "quoin/metadata.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Immutable once created; may be shared freely by threads; owned by the host until destroy_material. */
typedef struct quoin_material quoin_material;

/* One property value. Numbers: numbers[0], number_count 1. Tables: 2 n numbers. Choices: text. */
typedef struct quoin_property_value {
  uint64_t struct_size;
  const char* id;
  uint64_t number_count;
  const double* numbers;
  const char* text;
} quoin_property_value;

/* Upper bounds over all states of the material, for the time step. Softening (a negative slope, a brittle drop) does
 * not count, and property columns are not included: a host that uses them asks materials of the extreme values. */
typedef struct quoin_stiffness_bounds {
  uint64_t struct_size;
  double normal; /* of d sigma / d d_n, Pa/m */
  double shear;  /* of d tau / d d_s, Pa/m */
} quoin_stiffness_bounds;

/* State of another law, to be taken over with continuous traction. The new reference of the normal jump is
 * normal_jump + normal_shift; states with equal id and unit are copied where the law can hold them. */
typedef struct quoin_migration {
  uint64_t struct_size;
  uint64_t count;
  const char* from_law;
  uint64_t from_schema;
  uint64_t from_state_count;
  const char* const* from_state_ids;
  const quoin_in* from_states; /* from_state_count columns */
  quoin_in normal_jump;        /* d_n seen by the old law, m */
  quoin_in traction[3];        /* to be kept, Pa */
  quoin_in energy_stored;      /* under the old law, J/m2; null data: taken as 0 */
  quoin_out normal_shift;      /* to be added to d_n from now on, m */
  const quoin_out* state_new;  /* state_count columns of the new law */
  quoin_out energy_jump;       /* stored energy after less before, J/m2; may be null */
  quoin_out_u32 status;        /* per point: OK or FAILED (the traction lies outside the strength); may be null */
  uint64_t failed_count;       /* written by the law */
} quoin_migration;

typedef struct quoin_law {
  uint64_t struct_size;
  const char* id;      /* "fracture_energy" */
  const char* name;    /* for people */
  const char* version; /* of the law, "1.0.0" */
  const char* citation;
  const char* description;
  uint64_t capabilities; /* QUOIN_CAN_... */
  const quoin_convention* convention;
  uint64_t property_count;
  const quoin_property_info* const* properties;
  uint64_t state_count;
  const quoin_state_info* const* states;
  uint64_t initial_state_count;
  const char* const* initial_states; /* ids; the first is what a host uses for joints present at the start */
  uint64_t state_schema;             /* changes whenever number, order, ids, units or meaning of the states change */

  /* Validates and, unless material is null, creates. On QUOIN_ERROR_PROPERTY the text holds every fault, one a line:
   * property, value, bound, remedy; also for a property that is unknown, missing, given twice or of the wrong kind. On
   * any error *material is null. On success the text holds warnings, or is empty. The law keeps no pointer into
   * values. [thread-safe] */
  quoin_status (*create_material)(const struct quoin_law* law, uint64_t value_count,
                                  const quoin_property_value* const* values, quoin_material** material,
                                  quoin_text* text);
  /* Null is allowed. [thread-safe for different materials] */
  void (*destroy_material)(quoin_material* material);
  /* Value in force of a number property, defaults included. QUOIN_ERROR_ARGUMENT for an unknown id. [thread-safe] */
  quoin_status (*material_number)(const quoin_material* material, const char* property_id, double* value);
  /* values: state_count doubles. QUOIN_ERROR_ARGUMENT for an unknown id. [thread-safe] */
  quoin_status (*initial_state)(const quoin_material* material, const char* initial_state_id, double* values);
  /* [thread-safe] */
  quoin_status (*stiffness_bounds)(const quoin_material* material, quoin_stiffness_bounds* bounds);
  /* Pure: outputs depend on the material and the inputs of the point alone, bit for bit, whatever the batch size,
   * partition, stride, thread or order. A batch is refused (QUOIN_ERROR_ARGUMENT, nothing written) when a required
   * column has null data, an output has stride 0, or a property column names no PER_POINT property; optional outputs
   * that the law cannot compute are QUOIN_ERROR_UNSUPPORTED. [thread-safe; batches must not share outputs] */
  quoin_status (*evaluate)(const quoin_material* material, quoin_batch* batch);
  /* Null unless QUOIN_CAN_MIGRATE. Refuses with a reason in text when nothing can be carried. [thread-safe] */
  quoin_status (*migrate_state)(const quoin_material* material, quoin_migration* migration, quoin_text* text);
} quoin_law;

typedef struct quoin_host_info {
  uint64_t struct_size;
  uint32_t abi_major; /* what the host was built against */
  uint32_t abi_minor;
  const char* name;
  const char* version;
} quoin_host_info;

typedef struct quoin_library {
  uint64_t struct_size;
  uint32_t abi_major; /* what the library was built against: the host checks it in its turn */
  uint32_t abi_minor;
  const char* name;
  const char* version;
  uint64_t law_count;
  const quoin_law* const* laws;
  /* Draft extensions by string id ("quoin.draft.NAME/1"); null when unknown. May itself be null. [thread-safe] */
  const void* (*extension)(const char* id);
} quoin_library;

/* The one exported symbol. Null means that the library cannot serve this host, with the reason in text. The result is
 * constant and lives until the library is unloaded. [thread-safe] */
typedef const quoin_library* (*quoin_library_function)(const quoin_host_info* host, quoin_text* text);
#define QUOIN_LIBRARY_SYMBOL "quoin_library_v1"
QUOIN_EXPORT const quoin_library* quoin_library_v1(const quoin_host_info* host, quoin_text* text);

#ifdef __cplusplus
}
#endif
#endif
