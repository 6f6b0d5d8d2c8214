/* Compile-time checks of the layout of ABI version 1.1 on 64-bit platforms. Include this file in one source file of a
 * host or law: a build with other packing or pointer sizes then fails. An appended field changes the size line of its
 * struct and adds a line. Any other edit is a new major version. */
#ifndef QUOIN_LAYOUT_ASSERTS_H
#define QUOIN_LAYOUT_ASSERTS_H

#include <stddef.h>

#include "quoin/quoin.h"

#if UINTPTR_MAX == UINT64_MAX

#define QUOIN_LAYOUT_JOIN2(a, b) a##b
#define QUOIN_LAYOUT_JOIN(a, b) QUOIN_LAYOUT_JOIN2(a, b)
#define QUOIN_LAYOUT_ASSERT(condition) \
  typedef char QUOIN_LAYOUT_JOIN(quoin_layout_line_, __LINE__)[(condition) ? 1 : -1]
#define QUOIN_LAYOUT_SIZE(type, bytes) QUOIN_LAYOUT_ASSERT(sizeof(type) == (bytes))
#define QUOIN_LAYOUT_OFFSET(type, field, bytes) QUOIN_LAYOUT_ASSERT(offsetof(type, field) == (bytes))

QUOIN_LAYOUT_SIZE(quoin_text, 32);
QUOIN_LAYOUT_OFFSET(quoin_text, struct_size, 0);
QUOIN_LAYOUT_OFFSET(quoin_text, data, 8);
QUOIN_LAYOUT_OFFSET(quoin_text, capacity, 16);
QUOIN_LAYOUT_OFFSET(quoin_text, length, 24);

QUOIN_LAYOUT_SIZE(quoin_in, 16);
QUOIN_LAYOUT_OFFSET(quoin_in, data, 0);
QUOIN_LAYOUT_OFFSET(quoin_in, stride, 8);

QUOIN_LAYOUT_SIZE(quoin_out, 16);
QUOIN_LAYOUT_OFFSET(quoin_out, data, 0);
QUOIN_LAYOUT_OFFSET(quoin_out, stride, 8);

QUOIN_LAYOUT_SIZE(quoin_out_u32, 16);
QUOIN_LAYOUT_OFFSET(quoin_out_u32, data, 0);
QUOIN_LAYOUT_OFFSET(quoin_out_u32, stride, 8);

QUOIN_LAYOUT_SIZE(quoin_property_column, 24);
QUOIN_LAYOUT_OFFSET(quoin_property_column, id, 0);
QUOIN_LAYOUT_OFFSET(quoin_property_column, values, 8);

QUOIN_LAYOUT_SIZE(quoin_batch, 520);
QUOIN_LAYOUT_OFFSET(quoin_batch, struct_size, 0);
QUOIN_LAYOUT_OFFSET(quoin_batch, count, 8);
QUOIN_LAYOUT_OFFSET(quoin_batch, normal_jump, 16);
QUOIN_LAYOUT_OFFSET(quoin_batch, slip_increment, 32);
QUOIN_LAYOUT_OFFSET(quoin_batch, traction_old, 64);
QUOIN_LAYOUT_OFFSET(quoin_batch, state_old, 112);
QUOIN_LAYOUT_OFFSET(quoin_batch, traction_new, 120);
QUOIN_LAYOUT_OFFSET(quoin_batch, state_new, 168);
QUOIN_LAYOUT_OFFSET(quoin_batch, property_column_count, 176);
QUOIN_LAYOUT_OFFSET(quoin_batch, property_columns, 184);
QUOIN_LAYOUT_OFFSET(quoin_batch, energy_stored, 192);
QUOIN_LAYOUT_OFFSET(quoin_batch, dissipated, 208);
QUOIN_LAYOUT_OFFSET(quoin_batch, tangent, 272);
QUOIN_LAYOUT_OFFSET(quoin_batch, flags, 416);
QUOIN_LAYOUT_OFFSET(quoin_batch, status, 432);
QUOIN_LAYOUT_OFFSET(quoin_batch, clamped_count, 448);
QUOIN_LAYOUT_OFFSET(quoin_batch, failed_count, 456);
QUOIN_LAYOUT_OFFSET(quoin_batch, worst_status, 464);
QUOIN_LAYOUT_OFFSET(quoin_batch, any_yielding, 468);
QUOIN_LAYOUT_OFFSET(quoin_batch, damage, 472);
QUOIN_LAYOUT_ASSERT(QUOIN_BATCH_SIZE_1_0 == 472);

QUOIN_LAYOUT_SIZE(quoin_property_info, 104);
QUOIN_LAYOUT_OFFSET(quoin_property_info, struct_size, 0);
QUOIN_LAYOUT_OFFSET(quoin_property_info, id, 8);
QUOIN_LAYOUT_OFFSET(quoin_property_info, symbol, 16);
QUOIN_LAYOUT_OFFSET(quoin_property_info, unit, 24);
QUOIN_LAYOUT_OFFSET(quoin_property_info, description, 32);
QUOIN_LAYOUT_OFFSET(quoin_property_info, kind, 40);
QUOIN_LAYOUT_OFFSET(quoin_property_info, flags, 44);
QUOIN_LAYOUT_OFFSET(quoin_property_info, default_value, 48);
QUOIN_LAYOUT_OFFSET(quoin_property_info, lower, 56);
QUOIN_LAYOUT_OFFSET(quoin_property_info, upper, 64);
QUOIN_LAYOUT_OFFSET(quoin_property_info, default_from, 72);
QUOIN_LAYOUT_OFFSET(quoin_property_info, default_text, 80);
QUOIN_LAYOUT_OFFSET(quoin_property_info, choice_count, 88);
QUOIN_LAYOUT_OFFSET(quoin_property_info, choices, 96);

QUOIN_LAYOUT_SIZE(quoin_state_info, 64);
QUOIN_LAYOUT_OFFSET(quoin_state_info, struct_size, 0);
QUOIN_LAYOUT_OFFSET(quoin_state_info, id, 8);
QUOIN_LAYOUT_OFFSET(quoin_state_info, unit, 16);
QUOIN_LAYOUT_OFFSET(quoin_state_info, description, 24);
QUOIN_LAYOUT_OFFSET(quoin_state_info, role, 32);
QUOIN_LAYOUT_OFFSET(quoin_state_info, kind, 36);
QUOIN_LAYOUT_OFFSET(quoin_state_info, flags, 40);
QUOIN_LAYOUT_OFFSET(quoin_state_info, reserved, 44);
QUOIN_LAYOUT_OFFSET(quoin_state_info, lower, 48);
QUOIN_LAYOUT_OFFSET(quoin_state_info, upper, 56);

QUOIN_LAYOUT_SIZE(quoin_convention, 32);
QUOIN_LAYOUT_OFFSET(quoin_convention, struct_size, 0);
QUOIN_LAYOUT_OFFSET(quoin_convention, tension_sign, 8);
QUOIN_LAYOUT_OFFSET(quoin_convention, opening_sign, 12);
QUOIN_LAYOUT_OFFSET(quoin_convention, force_on_a_sign, 16);
QUOIN_LAYOUT_OFFSET(quoin_convention, normal_is_total, 20);
QUOIN_LAYOUT_OFFSET(quoin_convention, sliding_is_increment, 24);
QUOIN_LAYOUT_OFFSET(quoin_convention, traction_is_stress, 28);

QUOIN_LAYOUT_SIZE(quoin_property_value, 40);
QUOIN_LAYOUT_OFFSET(quoin_property_value, struct_size, 0);
QUOIN_LAYOUT_OFFSET(quoin_property_value, id, 8);
QUOIN_LAYOUT_OFFSET(quoin_property_value, number_count, 16);
QUOIN_LAYOUT_OFFSET(quoin_property_value, numbers, 24);
QUOIN_LAYOUT_OFFSET(quoin_property_value, text, 32);

QUOIN_LAYOUT_SIZE(quoin_stiffness_bounds, 24);
QUOIN_LAYOUT_OFFSET(quoin_stiffness_bounds, struct_size, 0);
QUOIN_LAYOUT_OFFSET(quoin_stiffness_bounds, normal, 8);
QUOIN_LAYOUT_OFFSET(quoin_stiffness_bounds, shear, 16);

QUOIN_LAYOUT_SIZE(quoin_migration, 200);
QUOIN_LAYOUT_OFFSET(quoin_migration, struct_size, 0);
QUOIN_LAYOUT_OFFSET(quoin_migration, count, 8);
QUOIN_LAYOUT_OFFSET(quoin_migration, from_law, 16);
QUOIN_LAYOUT_OFFSET(quoin_migration, from_schema, 24);
QUOIN_LAYOUT_OFFSET(quoin_migration, from_state_count, 32);
QUOIN_LAYOUT_OFFSET(quoin_migration, from_state_ids, 40);
QUOIN_LAYOUT_OFFSET(quoin_migration, from_states, 48);
QUOIN_LAYOUT_OFFSET(quoin_migration, normal_jump, 56);
QUOIN_LAYOUT_OFFSET(quoin_migration, traction, 72);
QUOIN_LAYOUT_OFFSET(quoin_migration, energy_stored, 120);
QUOIN_LAYOUT_OFFSET(quoin_migration, normal_shift, 136);
QUOIN_LAYOUT_OFFSET(quoin_migration, state_new, 152);
QUOIN_LAYOUT_OFFSET(quoin_migration, energy_jump, 160);
QUOIN_LAYOUT_OFFSET(quoin_migration, status, 176);
QUOIN_LAYOUT_OFFSET(quoin_migration, failed_count, 192);

QUOIN_LAYOUT_SIZE(quoin_law, 176);
QUOIN_LAYOUT_OFFSET(quoin_law, struct_size, 0);
QUOIN_LAYOUT_OFFSET(quoin_law, id, 8);
QUOIN_LAYOUT_OFFSET(quoin_law, name, 16);
QUOIN_LAYOUT_OFFSET(quoin_law, version, 24);
QUOIN_LAYOUT_OFFSET(quoin_law, citation, 32);
QUOIN_LAYOUT_OFFSET(quoin_law, description, 40);
QUOIN_LAYOUT_OFFSET(quoin_law, capabilities, 48);
QUOIN_LAYOUT_OFFSET(quoin_law, convention, 56);
QUOIN_LAYOUT_OFFSET(quoin_law, property_count, 64);
QUOIN_LAYOUT_OFFSET(quoin_law, properties, 72);
QUOIN_LAYOUT_OFFSET(quoin_law, state_count, 80);
QUOIN_LAYOUT_OFFSET(quoin_law, states, 88);
QUOIN_LAYOUT_OFFSET(quoin_law, initial_state_count, 96);
QUOIN_LAYOUT_OFFSET(quoin_law, initial_states, 104);
QUOIN_LAYOUT_OFFSET(quoin_law, state_schema, 112);
QUOIN_LAYOUT_OFFSET(quoin_law, create_material, 120);
QUOIN_LAYOUT_OFFSET(quoin_law, destroy_material, 128);
QUOIN_LAYOUT_OFFSET(quoin_law, material_number, 136);
QUOIN_LAYOUT_OFFSET(quoin_law, initial_state, 144);
QUOIN_LAYOUT_OFFSET(quoin_law, stiffness_bounds, 152);
QUOIN_LAYOUT_OFFSET(quoin_law, evaluate, 160);
QUOIN_LAYOUT_OFFSET(quoin_law, migrate_state, 168);

QUOIN_LAYOUT_SIZE(quoin_host_info, 32);
QUOIN_LAYOUT_OFFSET(quoin_host_info, struct_size, 0);
QUOIN_LAYOUT_OFFSET(quoin_host_info, abi_major, 8);
QUOIN_LAYOUT_OFFSET(quoin_host_info, abi_minor, 12);
QUOIN_LAYOUT_OFFSET(quoin_host_info, name, 16);
QUOIN_LAYOUT_OFFSET(quoin_host_info, version, 24);

QUOIN_LAYOUT_SIZE(quoin_library, 56);
QUOIN_LAYOUT_OFFSET(quoin_library, struct_size, 0);
QUOIN_LAYOUT_OFFSET(quoin_library, abi_major, 8);
QUOIN_LAYOUT_OFFSET(quoin_library, abi_minor, 12);
QUOIN_LAYOUT_OFFSET(quoin_library, name, 16);
QUOIN_LAYOUT_OFFSET(quoin_library, version, 24);
QUOIN_LAYOUT_OFFSET(quoin_library, law_count, 32);
QUOIN_LAYOUT_OFFSET(quoin_library, laws, 40);
QUOIN_LAYOUT_OFFSET(quoin_library, extension, 48);

#endif
#endif
