// Data that an MGIS-based host passes to a behaviour, declared here from the public headers of MGIS. The layout is
// version 1 of MFront's generic behaviour interface (TFEL 3.4.1 and later, 4.x; MGIS 1.2.1 and later, 2.x). The host
// owns all memory.
#pragma once

#include <cstddef>

namespace quoin::mgis {

constexpr unsigned short api_version = 1;
constexpr std::size_t error_message_size = 512;  // bytes that the host provides at least

// State at the start of the step, from the host.
struct InitialState {
  const double* gradients;
  const double* thermodynamic_forces;
  const double* mass_density;
  const double* material_properties;
  const double* internal_state_variables;
  const double* stored_energy;
  const double* dissipated_energy;
  const double* external_state_variables;
};

// State at the end of the step: gradients and properties from the host, all else from the behaviour.
struct State {
  const double* gradients;
  double* thermodynamic_forces;
  const double* mass_density;
  const double* material_properties;
  double* internal_state_variables;
  double* stored_energy;      // may be null
  double* dissipated_energy;  // may be null
  const double* external_state_variables;
};

struct BehaviourData {
  char* error_message;  // may be null
  double dt;
  double* K;  // in: K[0] is the request (see request.h); out: the tangent operator
  double* rdt;
  double* speed_of_sound;
  InitialState s0;
  State s1;
};

static_assert(sizeof(void*) != 8 || (sizeof(InitialState) == 64 && sizeof(State) == 64));
static_assert(sizeof(void*) != 8 || offsetof(InitialState, material_properties) == 24);
static_assert(sizeof(void*) != 8 || offsetof(State, thermodynamic_forces) == 8);
static_assert(sizeof(void*) != 8 || offsetof(State, material_properties) == 24);
static_assert(sizeof(void*) != 8 || offsetof(State, internal_state_variables) == 32);
static_assert(sizeof(void*) != 8 || offsetof(State, stored_energy) == 40);
static_assert(sizeof(void*) != 8 || offsetof(State, dissipated_energy) == 48);
static_assert(sizeof(void*) != 8 || offsetof(BehaviourData, dt) == 8);
static_assert(sizeof(void*) != 8 || offsetof(BehaviourData, K) == 16);
static_assert(sizeof(void*) != 8 || offsetof(BehaviourData, rdt) == 24);
static_assert(sizeof(void*) != 8 || offsetof(BehaviourData, speed_of_sound) == 32);
static_assert(sizeof(void*) != 8 || offsetof(BehaviourData, s0) == 40);
static_assert(sizeof(void*) != 8 || offsetof(BehaviourData, s1) == 104);
static_assert(sizeof(void*) != 8 || sizeof(BehaviourData) == 168);

// Return values of a behaviour.
constexpr int integration_failed = -1;
constexpr int results_unreliable = 0;
constexpr int results_reliable = 1;

}  // namespace quoin::mgis
