/* One evaluation: N contact points, one explicit step. The host owns all memory; the law keeps no pointer. */
#ifndef QUOIN_BATCH_H
#define QUOIN_BATCH_H

#include "quoin/base.h"

#ifdef __cplusplus
extern "C" {
#endif

/* A column: element i is data[i * stride]. stride counts elements and may be negative. On an input, stride 0 repeats
 * one value; on an output of several points it is not allowed. Hosts with a structure of arrays use stride 1. Hosts
 * with an array of structures use the size of the structure in doubles. Elements have the alignment of double (or
 * uint32_t), not more. The law writes only the count elements of an output column, and no memory between or behind
 * them. Outputs do not overlap each other. With count 0 no data is read or written, and null data is allowed
 * everywhere. */
typedef struct quoin_in {
  const double* data;
  int64_t stride;
} quoin_in;

typedef struct quoin_out {
  double* data;
  int64_t stride;
} quoin_out;

typedef struct quoin_out_u32 {
  uint32_t* data;
  int64_t stride;
} quoin_out_u32;

/* Values of one property by point. Properties without a column have the material's value. Where that is a default, that
 * of another property, the laws that ship limit it to the column of the other; to follow it, it needs a column too. */
typedef struct quoin_property_column {
  const char* id;
  quoin_in values;
} quoin_property_column;

/* Per-point status. FAILED: an input that the law uses (old traction and state included) is not finite, or a per-point
 * property is refused. Traction and state are then copies of the old ones; energies, tangent, flags and damage are 0.
 */
#define QUOIN_POINT_OK 0u
#define QUOIN_POINT_CLAMPED 1u /* an input was outside the law's range and was limited; outputs are valid */
#define QUOIN_POINT_FAILED 2u

/* Per-point flags at the end of the step */
#define QUOIN_FLAG_OPEN 1u                /* effective opening > 0 */
#define QUOIN_FLAG_SLIPPING 2u            /* slipped during this step */
#define QUOIN_FLAG_TENSION_DAMAGED 4u     /* tensile strength reduced */
#define QUOIN_FLAG_TENSION_COMPLETE 8u    /* tensile softening complete */
#define QUOIN_FLAG_SHEAR_DAMAGED 16u      /* cohesion reduced */
#define QUOIN_FLAG_SHEAR_COMPLETE 32u     /* shear softening complete */
#define QUOIN_FLAG_CRUSHED 64u            /* plastic closure > 0 */
#define QUOIN_FLAG_CRUSHING_COMPLETE 128u /* compressive softening complete */
#define QUOIN_FLAG_YIELDING 256u          /* an internal variable changed during this step */
/* Since 1.1, for laws with reversible dilation (a seat of the faces) and residual crack opening */
#define QUOIN_FLAG_RESEATING 512u /* the dilation uplift decreased during this step */
#define QUOIN_FLAG_GAVE_WAY 1024u /* the residual opening decreased during this step */

/* Dissipation outputs */
#define QUOIN_DISSIPATED_TENSION 0
#define QUOIN_DISSIPATED_COHESION 1
#define QUOIN_DISSIPATED_FRICTION 2
#define QUOIN_DISSIPATED_CRUSHING 3
#define QUOIN_DISSIPATED_COUNT 4

/* Damage outputs, since 1.1 */
#define QUOIN_DAMAGE_TENSION 0  /* of the tensile strength */
#define QUOIN_DAMAGE_COHESION 1 /* of the cohesion */
#define QUOIN_DAMAGE_CRUSHING 2 /* of the compressive strength */
#define QUOIN_DAMAGE_COUNT 3

typedef struct quoin_batch {
  uint64_t struct_size;
  uint64_t count;

  /* Inputs, required */
  quoin_in normal_jump;       /* d_n at the END of the step, m */
  quoin_in slip_increment[2]; /* d_s, d_t over the step in the current frame, m */
  quoin_in traction_old[3];   /* sigma, tau_s, tau_t at the start, Pa, rotated by the host into the current frame */
  const quoin_in* state_old;  /* state_count columns in the order of the metadata; null data only for diagnostics */

  /* Outputs, required. Each is either its old column (equal data and stride) or disjoint from every input. */
  quoin_out traction_new[3];
  const quoin_out* state_new; /* state_count columns; null data only where the old column has null data */

  /* Per-point properties, optional */
  uint64_t property_column_count;
  const quoin_property_column* property_columns;

  /* Outputs, optional: those with null data are not computed */
  quoin_out energy_stored;                      /* recoverable energy at the end of the step, J/m2 */
  quoin_out dissipated[QUOIN_DISSIPATED_COUNT]; /* energy dissipated DURING the step by mode, J/m2, >= 0 */
  quoin_out tangent[9]; /* d(sigma, tau_s, tau_t)/d(d_n, d_s, d_t), row by row, consistent with the step, Pa/m */
  quoin_out_u32 flags;
  quoin_out_u32 status;

  /* Summary, always written when the call returns QUOIN_OK */
  uint64_t clamped_count;
  uint64_t failed_count;
  uint32_t worst_status; /* largest per-point status */
  uint32_t any_yielding; /* 0: no internal variable of any point changed, the batch was elastic */

  /* Since 1.1, and only if struct_size includes it. Output, optional: damage of each mode at the end of the step, in
   * [0, 1]. It is the lost share of the drop from the strength to its residual. A mode without a drop has damage 1 once
   * it is complete. */
  quoin_out damage[QUOIN_DAMAGE_COUNT];
} quoin_batch;

/* Size of a batch of version 1.0, in bytes. A law accepts every struct_size from this on. */
#define QUOIN_BATCH_SIZE_1_0 ((uint64_t)(sizeof(quoin_batch) - QUOIN_DAMAGE_COUNT * sizeof(quoin_out)))

#ifdef __cplusplus
}
#endif
#endif
