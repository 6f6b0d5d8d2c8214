/* A law: metadata and functions. A library holds one law or more and exports exactly one symbol, quoin_library_v1.
 *
 * Order of calls: the host calls quoin_library_v1 once, reads the metadata and creates materials from property values.
 * It gets the initial state and the stiffness bounds, and evaluates batches from any number of threads. At the end it
 * destroys the materials and unloads the library. A law keeps no state of contacts and no global variable that a call
 * changes. */
#ifndef QUOIN_LAW_H
#define QUOIN_LAW_H

#include "quoin/batch.h"
#include "quoin/metadata.h"

#ifdef __cplusplus
extern "C" {
#endif

/* A law with its property values. Immutable, so threads may share it. Owned by the host until destroy_material. */
typedef struct quoin_material quoin_material;

/* One property value. Numbers: numbers[0], number_count 1. Tables: 2 n numbers. Choices: text. */
typedef struct quoin_property_value {
  uint64_t struct_size;
  const char* id;
  uint64_t number_count;
  const double* numbers;
  const char* text;
} quoin_property_value;

/* Upper bounds of the stiffness over all states of the material, for the critical time step. Softening (a negative
 * slope, a brittle drop) does not count. Property columns are not included: a host with columns uses the bounds of
 * materials with the extreme values. */
typedef struct quoin_stiffness_bounds {
  uint64_t struct_size;
  double normal; /* bound of d sigma / d d_n, Pa/m */
  double shear;  /* bound of d tau / d d_s, Pa/m */
} quoin_stiffness_bounds;

/* Law swap: states of an old law, to be converted to states of this law at constant traction. With this law the host
 * uses normal_jump + normal_shift as normal jump. States with equal id and unit are copied where this law has them. */
typedef struct quoin_migration {
  uint64_t struct_size;
  uint64_t count;
  const char* from_law;
  uint64_t from_schema;
  uint64_t from_state_count;
  const char* const* from_state_ids;
  const quoin_in* from_states; /* from_state_count columns */
  quoin_in normal_jump;        /* d_n of the old law, m */
  quoin_in traction[3];        /* sigma, tau_s, tau_t, which are kept, Pa */
  quoin_in energy_stored;      /* stored energy of the old law, J/m2; null data: 0 */
  quoin_out normal_shift;      /* shift of d_n for all later steps, m */
  const quoin_out* state_new;  /* state_count columns of this law */
  quoin_out energy_jump;       /* stored energy of this law less that of the old law, J/m2; may be null */
  quoin_out_u32 status;        /* OK, CLAMPED (damage is lost) or FAILED (traction beyond the strength); may be null */
  uint64_t failed_count;       /* written by the law */
} quoin_migration;

typedef struct quoin_law {
  uint64_t struct_size;
  const char* id;      /* "fracture_energy" */
  const char* name;    /* name in messages and plots, "Elastic joint" */
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
  const char* const* initial_states; /* ids; the first is the default for joints present at the start */
  uint64_t state_schema;             /* changes whenever number, order, ids, units or meaning of the states change */

  /* Validates values and, unless material is null, creates a material. On QUOIN_ERROR_PROPERTY the text has every
   * fault, one a line: property, value, bound, remedy. A property that is unknown, missing, given twice or of the wrong
   * kind is such a fault. On any error *material is null. On success the text has warnings or is empty. The law keeps
   * no pointer into values. [thread-safe] */
  quoin_status (*create_material)(const struct quoin_law* law, uint64_t value_count,
                                  const quoin_property_value* const* values, quoin_material** material,
                                  quoin_text* text);
  /* Frees a material; null is allowed. [thread-safe for different materials] */
  void (*destroy_material)(quoin_material* material);
  /* Writes the value of a number property, given or default. QUOIN_ERROR_ARGUMENT for an unknown id. [thread-safe] */
  quoin_status (*material_number)(const quoin_material* material, const char* property_id, double* value);
  /* Writes the state_count values of an initial state. QUOIN_ERROR_ARGUMENT for an unknown id. [thread-safe] */
  quoin_status (*initial_state)(const quoin_material* material, const char* initial_state_id, double* values);
  /* Writes the stiffness bounds of the material. [thread-safe] */
  quoin_status (*stiffness_bounds)(const quoin_material* material, quoin_stiffness_bounds* bounds);
  /* Evaluates a batch. Outputs of a point depend only on the material and the inputs of the point. They are bitwise
   * identical for any batch size, partition, stride, thread or order. Returns QUOIN_ERROR_ARGUMENT, and writes nothing,
   * if a required column has null data, an output of several points has stride 0, or a property column has no PER_POINT
   * property. Returns QUOIN_ERROR_UNSUPPORTED for optional outputs that the law cannot compute. [thread-safe; batches
   * must not share outputs] */
  quoin_status (*evaluate)(const quoin_material* material, quoin_batch* batch);
  /* Null unless QUOIN_CAN_MIGRATE. Converts states of another law. If it cannot keep the traction of a point, the point
   * gets status FAILED, and the law may return an error with the reason in text. [thread-safe] */
  quoin_status (*migrate_state)(const quoin_material* material, quoin_migration* migration, quoin_text* text);
} quoin_law;

typedef struct quoin_host_info {
  uint64_t struct_size;
  uint32_t abi_major; /* ABI version of the headers that the host was built with */
  uint32_t abi_minor;
  const char* name;
  const char* version;
} quoin_host_info;

typedef struct quoin_library {
  uint64_t struct_size;
  uint32_t abi_major; /* ABI version of the headers that the library was built with; the host checks it */
  uint32_t abi_minor;
  const char* name;
  const char* version;
  uint64_t law_count;
  const quoin_law* const* laws;
  /* Returns a draft extension by id ("quoin.draft.NAME/1"), or null. The pointer itself may be null. [thread-safe] */
  const void* (*extension)(const char* id);
} quoin_library;

/* The one exported symbol. Returns the library, which is constant and valid until the shared library is unloaded. Null,
 * with the reason in text, if the library does not support this host. [thread-safe] */
typedef const quoin_library* (*quoin_library_function)(const quoin_host_info* host, quoin_text* text);
#define QUOIN_LIBRARY_SYMBOL "quoin_library_v1"
QUOIN_EXPORT const quoin_library* quoin_library_v1(const quoin_host_info* host, quoin_text* text);

#ifdef __cplusplus
}
#endif
#endif
