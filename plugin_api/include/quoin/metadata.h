/* Metadata of a law: properties, states, sign convention, capabilities. Hosts match properties and states by id, never
 * by position. All metadata is constant and valid while the library is loaded. [thread-safe] */
#ifndef QUOIN_METADATA_H
#define QUOIN_METADATA_H

#include "quoin/base.h"

#ifdef __cplusplus
extern "C" {
#endif

/* quoin_property_info.kind */
#define QUOIN_PROPERTY_NUMBER 1u
#define QUOIN_PROPERTY_CHOICE 2u /* one of a list of words */
#define QUOIN_PROPERTY_TABLE 3u  /* pairs x0, y0, x1, y1, ... */

/* quoin_property_info.flags */
#define QUOIN_PROPERTY_REQUIRED 1u   /* has no default */
#define QUOIN_PROPERTY_PER_POINT 2u  /* may be given as a column in a batch */
#define QUOIN_PROPERTY_LOWER_OPEN 4u /* the lower bound itself is refused */
#define QUOIN_PROPERTY_UPPER_OPEN 8u /* the upper bound itself is refused */

typedef struct quoin_property_info {
  uint64_t struct_size;
  const char* id;          /* lower case with underscores, unique within the law */
  const char* symbol;      /* symbol in the law's equations */
  const char* unit;        /* "Pa/m", "Pa", "deg", "J/m2", "-" */
  const char* description; /* one line */
  uint32_t kind;
  uint32_t flags;
  double default_value;     /* default of a number without REQUIRED and without default_from */
  double lower, upper;      /* numbers: allowed interval; infinite: no bound */
  const char* default_from; /* id of the property whose value is the default, or null */
  const char* default_text; /* choices and tables: the default as text, or null */
  uint64_t choice_count;
  const char* const* choices;
} quoin_property_info;

/* quoin_state_info.role */
#define QUOIN_ROLE_HISTORY 1u    /* input of the next step */
#define QUOIN_ROLE_DIAGNOSTIC 2u /* output for plots; not computed if its columns have null data */

/* quoin_state_info.kind: how a host rotates the state when the (s, t) frame rotates about n */
#define QUOIN_STATE_SCALAR 1u
#define QUOIN_STATE_PAIR_S 2u /* s component of a vector; the next state is its t component */
#define QUOIN_STATE_PAIR_T 3u

/* quoin_state_info.flags */
#define QUOIN_STATE_MONOTONIC 1u /* never decreases */

typedef struct quoin_state_info {
  uint64_t struct_size;
  const char* id;
  const char* unit;
  const char* description;
  uint32_t role;
  uint32_t kind;
  uint32_t flags;
  uint32_t reserved;   /* 0 */
  double lower, upper; /* every value that the law writes lies in [lower, upper] */
} quoin_state_info;

/* Sign and frame convention, as numbers with which an adapter can be generated or checked. Version 1 has one: local
 * frame (n, s, t), n from block A to block B; jump = u_B - u_A, d_n > 0 opens; sigma > 0 is tension. Traction is force
 * per area; the force on A is +traction * area, the force on B -traction * area. */
typedef struct quoin_convention {
  uint64_t struct_size;
  int32_t tension_sign;         /* +1: sigma > 0 is tension */
  int32_t opening_sign;         /* +1: d_n > 0 opens */
  int32_t force_on_a_sign;      /* +1: force on A is +traction * area */
  int32_t normal_is_total;      /* 1: normal_jump is the total at the end of the step */
  int32_t sliding_is_increment; /* 1: slip_increment is the sliding over the step */
  int32_t traction_is_stress;   /* 1: force per area */
} quoin_convention;

/* quoin_law.capabilities */
#define QUOIN_CAN_ENERGY UINT64_C(1)           /* stored energy and dissipation outputs */
#define QUOIN_CAN_TANGENT UINT64_C(2)          /* consistent tangent output */
#define QUOIN_CAN_PROPERTY_COLUMNS UINT64_C(4) /* per-point properties */
#define QUOIN_CAN_FLAGS UINT64_C(8)            /* per-point flags */
#define QUOIN_CAN_MIGRATE UINT64_C(16)         /* migrate_state */
#define QUOIN_CAN_DAMAGE UINT64_C(32)          /* since 1.1: damage outputs */

#ifdef __cplusplus
}
#endif
#endif
