// Damping: the keys of scenes, and the coefficients that follow from them. damping.cpp has the table of its kinds.
// Kernels and all other code use the coefficients alone.
#pragma once

#include <array>
#include <cmath>
#include <optional>
#include <string>
#include <variant>
#include <vector>

namespace quoin {

// local: eq. 1 at every degree of freedom. block: eq. 1 on the rigid motion of each block and viscous damping of its
// deformation, so that its vibration does not brake its motion. impact: viscous damping of closed contacts alone, in
// proportion to their stiffness, near critical for a block that lands on an edge.
enum class DampingKind { none, local, viscous, block, impact };

// Keys of a scene. Each kind reads those that its row in the table of damping.cpp lists.
struct DampingSettings {
  DampingKind damping = DampingKind::local;
  double local_damping = 0.8;  // local, block: gamma of eq. 1
  // gamma of eq. 1 in stages that run to equilibrium, where vibrations must die out; none: local_damping.
  std::optional<double> settling_damping;
  double deformation_damping = 0.2;  // block: damping ratio at omega_max, less at lower frequencies in proportion
  double mass_damping = 0.0;         // viscous: alpha, 1/s
  double stiffness_damping = 0.0;    // viscous: beta, s
  // impact: share of critical damping of a block landing on an edge. From 0.5 to 1 the restitution is within 0.4 % of
  // that of Housner's rocking block, whose landing edge stays in place.
  double impact_damping = 0.7;
  // impact: damping ratio of vibrations between two frequencies by Maxwell elements parallel to the joints; 0: none.
  double maxwell_damping = 0.0;
  bool implicit_contacts = false;  // impact: implicit mean of a step, on the lattice (step/implicit_contacts.h)
  std::array<double, 2> maxwell_band{0.5, 25.0};
};

// Where eq. 1 acts beside rigid blocks: at gridpoints, or on the rigid motion of units and of their halves.
enum class Eq1 { nothing, gridpoints, rigid_motion };

// Coefficients of viscous damping of closed contacts, in proportion to their stiffness.
struct ImpactTerms {
  double share = 0.0;                    // share of critical damping of a block that lands on an edge
  double maxwell = 0.0;                  // damping ratio within the band
  std::array<double, 2> maxwell_band{};  // Hz
  bool implicit = false;                 // implicit mean of a step in joints
  bool operator==(const ImpactTerms&) const = default;
};

// Coefficients of the damping of a step. Kernels take gamma or alpha, not both.
struct Damping {
  Eq1 eq1 = Eq1::nothing;
  double gamma = 0.0;       // of eq. 1
  double alpha = 0.0;       // proportional to mass, 1/s
  double beta = 0.0;        // proportional to stiffness, of zones and contacts, s
  double zone_ratio = 0.0;  // of zones: damping ratio at omega_max, in proportion to stiffness
  std::optional<ImpactTerms> impacts{};

  bool operator==(const Damping&) const = default;
  bool has_maxwell() const { return impacts && impacts->maxwell > 0.0; }
  bool is_implicit() const { return impacts && impacts->implicit; }
  bool of_contacts() const { return impacts || beta > 0.0; }  // whether contacts have viscous damping
  // Whether the rigid motion of blocks is damped separately from that of their gridpoints.
  bool splits_motion() const { return eq1 == Eq1::rigid_motion; }
};

// Coefficients of settings. settling: in stages that run to equilibrium.
Damping damping_of(const DampingSettings& settings, bool settling = false);

// Stable time step as a share of 2/omega_max, where viscous forces lag by half a step. ratio: damping ratio at
// omega_max.
inline double step_left(double ratio) { return std::sqrt(1.0 + ratio * ratio) - ratio; }

const std::vector<std::string>& damping_names();  // names in scenes, in the order of DampingKind
const std::string& name_of(DampingKind kind);
std::string damping_text(const DampingSettings& settings, bool settling);  // "local 0.8"

// A numeric key of any kind of damping, with its value.
struct DampingNumber {
  std::string key, key_in_summary;
  std::variant<double, bool, std::array<double, 2>> value;
  bool of_kind;  // whether the kind in use reads it
};
std::vector<DampingNumber> damping_numbers(const DampingSettings& settings);

}  // namespace quoin
