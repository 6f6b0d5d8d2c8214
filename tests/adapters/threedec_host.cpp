// A host that works like 3DEC. It loads the plug-in, creates a model for each contact point and calls it in each step
// with forces and increments. Compares with the law called directly. Runs on Linux and, under Wine, on Windows. usage:
// threedec_host PLUGIN LAW_FILE [time | unserved]
#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <memory>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "jointmodel.h"
#include "state.h"
#include "tests/adapters/allocations.h"
#include "tests/adapters/check.h"
#include "tests/adapters/direct_law.h"
#include "tests/adapters/timing.h"
#include "tests/mortar.h"

#if defined(_WIN32)
#include <windows.h>
static void* load_symbol(const char* file, const char* name) {
  const HMODULE module = LoadLibraryA(file);
  return module != nullptr ? reinterpret_cast<void*>(GetProcAddress(module, name)) : nullptr;
}
#else
#include <dlfcn.h>
static void* load_symbol(const char* file, const char* name) {
  void* handle = dlopen(file, RTLD_NOW | RTLD_LOCAL);
  return handle != nullptr ? dlsym(handle, name) : nullptr;
}
#endif

using jmodels::JointModel;
using jmodels::shape::Index;
using jmodels::shape::Text;
using quoin::tests::DirectLaw;
using quoin::tests::Leg;

namespace {

using quoin::test::mortar::kn, quoin::test::mortar::ks;
constexpr double area = 0.25;  // a power of two: stress and force have the same digits

// State of a new contact with the members that 3DEC sets before the first call of the model; others are those of State.
struct ContactState : jmodels::State {
  ContactState() {
    state_ = 0;
    area_ = area;
    normal_force_ = normal_disp_ = normal_disp_inc_ = 0.0;
    shear_force_ = shear_disp_ = shear_disp_inc_ = DVect3(0.0);
  }
  double getTimeStep() const override { return 1e-6; }
  bool isThermal() const override { return false; }
  bool isCreep() const override { return false; }
  bool isFluid() const override { return false; }
  bool trackEnergy() const override { return track_energy; }
  void* getTableIndexFromID(const Text&) const override { return nullptr; }
  double getYFromX(void*, const double&) const override { return 0.0; }
  double getSlopeFromX(void*, const double&) const override { return 0.0; }

  bool track_energy = false;
};

std::vector<std::string> split(const std::string& names, char separator) {
  std::istringstream stream(names);
  std::vector<std::string> parts;
  for (std::string part; std::getline(stream, part, separator);) parts.push_back(part);
  return parts;
}

std::string plain(const Text& text) { return std::string(text.begin(), text.end()); }

std::vector<std::string> split(const Text& names) { return split(plain(names), ','); }

// Returns the index of a property by its name or synonym, as 3DEC's commands do.
Index index_of(const JointModel& model, const std::string& property) {
  const std::vector<std::string> names = split(model.getProperties());
  for (std::size_t i = 0; i < names.size(); ++i)
    for (const std::string& name : split(names[i], ' '))
      if (name == property) return static_cast<Index>(i + 1);
  return 0;
}

// Returns the number in a Variant (3DEC 7) or a Property (3DEC 9).
template <class Value>
double number(const Value& value) {
  if constexpr (requires { value.toDouble(); })
    return value.toDouble();
  else
    return value.template to<double>();
}

using Model = std::unique_ptr<JointModel>;

Model mortar_joint(const JointModel& prototype) {
  Model model(prototype.clone());
  for (const auto& [id, number] : quoin::test::mortar::properties)
    if (const Index index = index_of(*model, id); index != 0) model->setProperty(index, number);
  return model;
}

// Directions of s and t of the contact plane.
struct Plane {
  DVect3 s, t;
};
const Plane aligned{{1, 0, 0}, {0, 1, 0}};
const Plane oblique{{0.48, 0.6, 0.64}, {0.8, 0.0, -0.6}};

struct Contact {
  Model model;
  ContactState state;
  std::array<double, 3> at{};

  explicit Contact(Model joint) : model(std::move(joint)) {}
  // Moves the contact to the displacements `to` and returns the increments of (d_n, d_s, d_t), m.
  std::array<double, 3> move(const std::array<double, 3>& to, const Plane& plane = aligned) {
    const std::array<double, 3> d = {to[0] - at[0], to[1] - at[1], to[2] - at[2]};
    at = to;
    state.normal_disp_inc_ = d[0];
    state.shear_disp_inc_ = plane.s * d[1] + plane.t * d[2];
    model->run(3, &state);
    return d;
  }
  bool same_as(const Contact& other) const {
    const auto same = [](double a, double b) { return std::memcmp(&a, &b, sizeof a) == 0; };
    const DVect3 &f = state.shear_force_, &g = other.state.shear_force_;
    bool equal = same(state.normal_force_, other.state.normal_force_) && same(f.x(), g.x()) && same(f.y(), g.y()) &&
                 same(f.z(), g.z()) && state.state_ == other.state.state_;
    for (Index i = 1; i <= split(model->getProperties()).size(); ++i)
      equal = equal && same(number(model->getProperty(i)), number(other.model->getProperty(i)));
    return equal;
  }
};

void* symbol(const char* plugin, const char* name) {
  void* const address = load_symbol(plugin, name);
  if (address == nullptr) std::printf("%s: no %s\n", plugin, name);
  CHECK(address != nullptr);
  return address;
}

// Returns the file name that 3DEC searches, jmodelNAME###.dll, from getName and the three digits of the version.
std::string exported_name(const char* plugin) {
  const auto name = reinterpret_cast<const char* (*)()>(symbol(plugin, "getName"));
  const auto major = reinterpret_cast<unsigned (*)()>(symbol(plugin, "getMajorVersion"));
  CHECK(major() == QUOIN_3DEC_VERSION);
  CHECK(std::filesystem::path(plugin).stem().string() == std::string(name()) + "00" + std::to_string(major()));
  CHECK(std::string(name()).starts_with("jmodel"));
  return std::string(name()).substr(6);
}

void check_description(const JointModel& prototype, const quoin_law& law, const std::string& name) {
  CHECK(plain(prototype.getName()) == name);
  CHECK(plain(Model(prototype.clone())->getName()) == name);
  std::vector<std::string> expected, first_names, all_names;
  for (const quoin_property_info* info : quoin::adapters::scalar_properties(law)) expected.push_back(info->id);
  expected.push_back("initial_state");
  for (std::uint64_t k = 0; k < law.state_count; ++k) expected.push_back(law.states[k]->id);
  for (const std::string& names : split(prototype.getProperties()))
    for (const std::string& one : split(names, ' ')) all_names.push_back(one);
  for (const std::string& names : split(prototype.getProperties())) first_names.push_back(split(names, ' ')[0]);
  CHECK(first_names == expected);
  std::ranges::sort(all_names);
  CHECK(std::ranges::adjacent_find(all_names) == all_names.end());
  CHECK(plain(prototype.getStates()) == "slip-n,tension-n,slip-p,tension-p,cap-n,cap-p");
  CHECK(split(prototype.getEnergies()).size() == 7 && split(prototype.getEnergies())[3] == "energy-slip");
  const Model model = mortar_joint(prototype);
  CHECK(model->getMaxNormalStiffness() == kn);
  CHECK(model->getMaxShearStiffness() == ks);
  CHECK(number(model->getProperty(1)) == kn);
  CHECK(number(model->getProperty(1000)) == 0.0);
  if (const Index residual = index_of(*model, "friction_angle_residual"); residual != 0)
    CHECK(number(model->getProperty(residual)) == 35.0);  // default_from friction_angle
}

// Names of 3DEC's models are synonyms of the properties.
void check_synonyms(const JointModel& prototype) {
  for (const auto& [id, synonym] :
       {std::pair{"normal_stiffness", "stiffness-normal"}, std::pair{"shear_stiffness", "stiffness-shear"},
        std::pair{"tensile_strength", "tension"}, std::pair{"cohesion_residual", "cohesion-residual"},
        std::pair{"friction_angle", "friction"}, std::pair{"friction_angle_residual", "friction-residual"},
        std::pair{"dilation_angle", "dilation"}, std::pair{"compressive_strength", "compression"},
        std::pair{"fracture_energy_shear", "G_II"}})
    CHECK(index_of(prototype, synonym) == index_of(prototype, id));
  CHECK(index_of(prototype, "stiffness-normal") == 1);
}

// 3DEC requests stiffnesses while it sets the properties one by one: 0 until they make a material.
void check_stiffness_before_properties(const JointModel& prototype) {
  const Model model(prototype.clone());
  CHECK(model->getMaxNormalStiffness() == 0.0);
  CHECK(model->getMaxShearStiffness() == 0.0);
  model->setProperty(1, kn);
  CHECK(model->getMaxNormalStiffness() == 0.0);
  model->setProperty(2, ks);
  CHECK(model->getMaxNormalStiffness() == kn);
  CHECK(model->getMaxShearStiffness() == ks);
}

// 3DEC 7 uses the stiffness for the time step, which needs its upper bound. 3DEC 9 also uses it for damping. For a
// damaged open joint it is then the secant stiffness sigma/d_n of the law; for a closed joint the full one.
void check_stiffness_of_damaged_joint(const JointModel& prototype) {
  Contact contact(mortar_joint(prototype));
  contact.move({-1e-6, 0, 0});
  CHECK(contact.model->getMaxNormalStiffness() == kn);
  contact.move({4e-5, 0, 0});
  const double secant = -contact.state.normal_force_ / area / 4e-5;
  CHECK(secant > 1e-3 * kn && secant < 0.1 * kn);
  const double stiffness = contact.model->getMaxNormalStiffness();
  CHECK(QUOIN_3DEC_VERSION == 9 ? std::abs(stiffness - secant) <= 1e-12 * kn : stiffness == kn);
  CHECK(contact.model->getMaxShearStiffness() == ks);
  contact.move({1e-3, 0, 0});  // beyond the softening
  CHECK(contact.model->getMaxNormalStiffness() == (QUOIN_3DEC_VERSION == 9 ? 0.0 : kn));
  contact.move({-1e-6, 0, 0});
  CHECK(contact.model->getMaxNormalStiffness() == kn);
}

// True if bit slip-n agrees with the law's flag. With a cap a joint may slide by crushing under shear, without slip.
bool slips_as_the_law(Index bits, std::uint32_t flags) {
  return ((bits & 1) != 0) == ((flags & QUOIN_FLAG_SLIPPING) != 0) || (bits & (1 | 16)) == (1 | 16);
}

// Compares a path. exact: bitwise, along one axis. In an oblique plane the axes of a step cause rounding.
void check_path(const JointModel& prototype, const quoin_law& law, Leg leg, const char* name, const Plane& plane,
                bool exact) {
  Contact contact(mortar_joint(prototype));
  contact.state.track_energy = true;
  DirectLaw direct(law);
  direct.want_energies();
  double difference = 0.0, largest = 0.0, dissipated = 0.0, jump = 0.0;
  for (int i = 1; i <= quoin::tests::leg_steps; ++i) {
    std::array<double, 3> to = quoin::tests::displacement(leg, i);
    if (exact) to[2] = 0.0;
    const std::array<double, 3> d = contact.move(to, plane);
    jump += d[0];
    direct.step(jump, d[1], d[2]);
    for (const auto& mode : direct.dissipated) dissipated += mode[0] * area;
    const double force[3] = {-contact.state.normal_force_, -(contact.state.shear_force_ | plane.s),
                             -(contact.state.shear_force_ | plane.t)};
    for (int k = 0; k < 3; ++k) {
      difference = std::max(difference, std::abs(force[k] - direct.traction[k][0] * area));
      largest = std::max(largest, std::abs(force[k]));
    }
    CHECK(slips_as_the_law(contact.state.state_, direct.flags[0]));
  }
  double booked[2] = {0.0, 0.0};  // sums of stored and dissipated energies, J
  for (Index key = 1; key <= 7; ++key)
    booked[contact.model->getEnergyAccumulate(key) ? 1 : 0] += contact.model->getEnergy(key);
  const double scale = direct.stored[0] * area + dissipated;
  CHECK(std::abs(booked[0] - direct.stored[0] * area) <= 1e-9 * scale);
  CHECK(std::abs(booked[1] - dissipated) <= 1e-9 * scale);
  CHECK(exact ? difference == 0.0 : difference <= 1e-9 * largest);
  CHECK(largest > 1e4);
  std::printf("%s, %s%s: %d steps, force up to %.4g N, largest difference %.3g N\n", law.id, name,
              exact ? " along s" : "", quoin::tests::leg_steps, largest, difference);
}

// Returns v rotated by `angle` about the unit vector `axis` (Rodrigues' formula).
DVect3 turned(const DVect3& v, const DVect3& axis, double angle) {
  const DVect3 across(axis.y() * v.z() - axis.z() * v.y(), axis.z() * v.x() - axis.x() * v.z(),
                      axis.x() * v.y() - axis.y() * v.x());
  return v * std::cos(angle) + across * std::sin(angle) + axis * ((axis | v) * (1.0 - std::cos(angle)));
}

// A contact whose plane rotates by a milliradian in each step, about an axis that is neither its normal nor in its
// plane. 3DEC rotates the shear force with it. In its axes the law has the path of a contact without rotation. With
// dilation, so that cyclic_joint slides up its seat, a vector in the plane, and down again.
void check_turning(const JointModel& prototype, const quoin_law& law) {
  const auto joint = [&] {
    Model model = mortar_joint(prototype);
    if (const Index dilation = index_of(*model, "dilation_angle"); dilation != 0) model->setProperty(dilation, 20.0);
    return model;
  };
  std::vector<quoin::adapters::PropertyValue> values = quoin::tests::mortar_of(law);
  if (index_of(prototype, "dilation_angle") != 0) values.push_back({"dilation_angle", {20.0}, {}});
  std::size_t seat = 0;
  while (seat < law.state_count && law.states[seat]->kind == QUOIN_STATE_SCALAR) ++seat;
  for (const double rate : {0.0, 1e-3}) {
    Contact contact(joint());
    DirectLaw direct(law, 1, values);
    Plane plane = oblique;
    const DVect3 axis(0.36, 0.48, 0.8);
    double difference = 0.0, largest = 0.0, farthest = 0.0, jump = 0.0;
    for (int i = 1; i <= quoin::tests::leg_steps; ++i) {
      const double force[2] = {contact.state.shear_force_ | plane.s, contact.state.shear_force_ | plane.t};
      plane = {turned(plane.s, axis, rate), turned(plane.t, axis, rate)};
      contact.state.shear_force_ = plane.s * force[0] + plane.t * force[1];
      std::array<double, 3> to = quoin::tests::displacement(Leg::shear, i);
      to[1] *= std::cos(3e-3 * i);  // in both directions
      const std::array<double, 3> d = contact.move(to, plane);
      jump += d[0];
      direct.step(jump, d[1], d[2]);
      const double now[3] = {-contact.state.normal_force_, -(contact.state.shear_force_ | plane.s),
                             -(contact.state.shear_force_ | plane.t)};
      for (int k = 0; k < 3; ++k) {
        difference = std::max(difference, std::abs(now[k] - direct.traction[k][0] * area));
        largest = std::max(largest, std::abs(now[k]));
      }
      if (seat < law.state_count) farthest = std::max(farthest, std::abs(direct.state[seat + 1][0]));
    }
    CHECK(difference <= 1e-9 * largest);
    CHECK(largest > 1e4);
    if (seat < law.state_count) CHECK(farthest > 1e-4);
    std::printf("%s, turning by %g a step: force up to %.4g N, largest difference %.3g N\n", law.id, rate, largest,
                difference);
  }
}

// A contact that is copied, saved and restored, or initialized again continues without a difference.
void check_continuation(const JointModel& prototype) {
  for (const auto& [leg, name] : quoin::tests::legs) {
    Contact straight(mortar_joint(prototype)), initialized(mortar_joint(prototype));
    std::vector<Contact> copies, restored;
    for (int i = 1; i <= quoin::tests::leg_steps; ++i) {
      const std::array<double, 3> to = quoin::tests::displacement(leg, i);
      if (i % 400 == 0) {
        Contact& copy = copies.emplace_back(Model(prototype.clone()));
        copy.model->copy(straight.model.get());
        Contact& again = restored.emplace_back(Model(prototype.clone()));
        for (Index p = 1; p <= split(prototype.getProperties()).size(); ++p)
          again.model->setProperty(p, straight.model->getProperty(p), 1);
        std::stringstream file;
        straight.model->save(file);
        again.model->restore(file, 1);
        for (Contact* contact : {&copy, &again}) contact->state = straight.state, contact->at = straight.at;
      }
      for (int repeat = 0; repeat < i % 3; ++repeat) initialized.model->initialize(3, &initialized.state);
      straight.move(to);
      initialized.move(to);
      for (std::vector<Contact>* contacts : {&copies, &restored})
        for (Contact& contact : *contacts) contact.move(to);
    }
    CHECK(initialized.same_as(straight));
    for (const Contact& contact : copies) CHECK(contact.same_as(straight));
    for (const Contact& contact : restored) CHECK(contact.same_as(straight));
  }
}

void check_interleaved(const JointModel& prototype) {
  std::vector<Contact> together, alone;
  for (const auto& [leg, name] : quoin::tests::legs) {
    together.emplace_back(mortar_joint(prototype));
    Contact& contact = alone.emplace_back(mortar_joint(prototype));
    for (int i = 1; i <= quoin::tests::leg_steps; ++i) contact.move(quoin::tests::displacement(leg, i));
  }
  for (int i = 1; i <= quoin::tests::leg_steps; ++i)
    for (std::size_t c = 0; c < together.size(); ++c)
      together[c].move(quoin::tests::displacement(quoin::tests::legs[c].first, i));
  for (std::size_t c = 0; c < together.size(); ++c) CHECK(together[c].same_as(alone[c]));
}

// True for laws with total slip as state. Their shear stress depends only on it, not on initial forces or a lost area.
bool keeps_slip(const quoin_law& law) {
  for (std::uint64_t k = 0; k < law.state_count; ++k)
    if (std::strcmp(law.states[k]->id, "slip_s") == 0) return true;
  return false;
}

void check_first_forces(const JointModel& prototype, const quoin_law& law) {
  const double in_situ = keeps_slip(law) ? 0.0 : 3e3;
  Contact contact(mortar_joint(prototype));  // in-situ forces, without displacements
  contact.state.normal_force_ = 2e4;
  contact.state.shear_force_ = {3e3, 0, 0};
  contact.move({0, 0, 0});
  CHECK(std::abs(contact.state.normal_force_ - 2e4) <= 1e-11 * 2e4);
  CHECK(std::abs(contact.state.shear_force_.x() - in_situ) <= 1e-11 * 3e3);
  contact.move({-1e-7, 1e-8, 0});
  CHECK(std::abs(contact.state.normal_force_ - (2e4 + area * kn * 1e-7)) <= 1e-11 * 2e4);
  CHECK(std::abs(contact.state.shear_force_.x() - (in_situ - area * ks * 1e-8)) <= 1e-11 * 3e3);
  CHECK(std::abs(contact.state.normal_force_inc_ - area * kn * 1e-7) <= 1e-7);

  Contact opening(mortar_joint(prototype));
  opening.move({-1e-7, 0, 0});
  opening.move({1e-7, 0, 0});  // the second half of this increment is tension
  CHECK(std::abs(opening.state.dnop_ - 1e-7) <= 1e-19);
}

// Dilation raises the stiffness bounds, but neither the elastic stiffness nor the force of a contact at rest.
void check_dilating_joint(const JointModel& prototype) {
  Model dilating = mortar_joint(prototype);
  const Index dilation = index_of(*dilating, "dilation_angle");
  if (dilation == 0) return;
  dilating->setProperty(dilation, 10.0);
  Contact contact(std::move(dilating));
  contact.state.normal_force_ = 2e4;
  contact.move({0, 0, 0});
  CHECK(std::abs(contact.state.normal_force_ - 2e4) <= 1e-11 * 2e4);
  contact.model->setIfCanFail(false);
  contact.move({-1e-7, 0, 0});
  CHECK(std::abs(contact.state.normal_force_ - (2e4 + area * kn * 1e-7)) <= 1e-11 * 2e4);
  contact.model->setIfCanFail(true);
  contact.move({-1e-7, 0, 0});
  CHECK(std::abs(contact.state.normal_force_ - (2e4 + area * kn * 1e-7)) <= 1e-11 * 2e4);
}

void check_dry_joint(const JointModel& prototype) {
  const Model dry = mortar_joint(prototype);
  dry->setProperty(index_of(*dry, "initial_state"), 1.0);
  Contact contact(Model(prototype.clone()));
  contact.model->copy(dry.get());
  contact.move({1e-7, 0, 0});
  CHECK(contact.state.normal_force_ == 0.0);
  contact.move({-1e-7, 0, 0});
  CHECK(std::abs(contact.state.normal_force_ - area * kn * 1e-7) <= 1e-9 * area * kn * 1e-7);
}

void check_energy_activation(const JointModel& prototype) {
  const Model joint = mortar_joint(prototype);
  Contact idle(Model(prototype.clone())), active(Model(prototype.clone()));
  idle.model->copy(joint.get());
  joint->activateEnergy();
  active.model->copy(joint.get());
  for (Contact* contact : {&idle, &active}) contact->move({-1e-7, 0, 0});
  CHECK(!idle.model->getEnergyActivated() && active.model->getEnergyActivated());
  CHECK(idle.model->getEnergy(JointModel::kwEStrainCompression) == 0.0);
  const double stored = area * kn * 1e-14 / 2;
  CHECK(std::abs(active.model->getEnergy(JointModel::kwEStrainCompression) - stored) <= 1e-9 * stored);
  active.model->setEnergy(JointModel::kwEStrainCompression, 3.0);
  CHECK(active.model->getEnergy(JointModel::kwEStrainCompression) == 3.0);
}

// Random opening, closing and sliding, within and beyond softening. Forces are those of the law. The state bits, which
// the adapter computes from forces, agree with the law's flags and states at every step.
void check_random_path(const JointModel& prototype, const quoin_law& law) {
  Contact contact(mortar_joint(prototype));
  DirectLaw direct(law);
  std::uint32_t random = 1;
  const auto next = [&random] {  // random number in [-1, 1], the same on every machine
    random = random * 1664525u + 1013904223u;
    return static_cast<double>(random >> 8) / (1 << 23) - 1.0;
  };
  std::size_t closure = 0;  // index of the state of crushing
  while (closure < law.state_count && std::strcmp(law.states[closure]->id, "w") != 0) ++closure;
  const auto crushed = [&] { return closure < law.state_count ? direct.state[closure][0] : 0.0; };
  double jump = 0.0, size = 1e-7;
  int open = 0, slips = 0, crushes = 0;
  for (int i = 0; i < 20000; ++i) {
    if (i % 500 == 0) size = size > 2e-3 ? 1e-7 : size * 2.0;
    const bool stands = i % 7 < 3;
    const std::array<double, 3> to = {stands ? contact.at[0] : size * next(),
                                      stands ? contact.at[1] : 2.0 * size * next(), 0.0};
    const std::array<double, 3> d = contact.move(to);
    jump += d[0];
    const double crushed_before = crushed();
    direct.step(jump, d[1], d[2]);
    CHECK(-contact.state.normal_force_ == direct.traction[0][0] * area);
    CHECK(-contact.state.shear_force_.x() == direct.traction[1][0] * area);
    const auto has = [&](std::uint32_t flag) { return (direct.flags[0] & flag) != 0; };
    const auto bit = [&](Index mask) { return (contact.state.state_ & mask) != 0; };
    CHECK(slips_as_the_law(contact.state.state_, direct.flags[0]));
    CHECK(bit(2) == (has(QUOIN_FLAG_OPEN) && has(QUOIN_FLAG_TENSION_DAMAGED)));
    CHECK(bit(16) == (crushed() > crushed_before));
    CHECK(bit(16 | 32) == has(QUOIN_FLAG_CRUSHED));
    CHECK(contact.model->isBonded(contact.state) ==
          !(has(QUOIN_FLAG_TENSION_COMPLETE) || has(QUOIN_FLAG_SHEAR_COMPLETE)));
    open += bit(2), slips += bit(1), crushes += bit(16);
  }
  if (std::string(law.id) == "fracture_energy") CHECK(open > 1000 && slips > 1000 && crushes > 10);
}

// run, which 3DEC calls for every contact and step, does not allocate.
void check_no_allocation(const JointModel& prototype) {
  for (const auto& [leg, name] : quoin::tests::legs) {
    Contact contact(mortar_joint(prototype));
    long before = 0;
    for (int i = 1; i <= quoin::tests::leg_steps; ++i) {
      if (i == quoin::tests::leg_steps / 2) before = quoin::tests::allocations;
      contact.move(quoin::tests::displacement(leg, i));
    }
    CHECK(quoin::tests::allocations == before);
  }
}

template <class Call>
bool refuses(const char* text, const Call& call) {
  try {
    call();
  } catch (const std::runtime_error& error) {
    if (std::strstr(error.what(), text) != nullptr) return true;
    std::printf("another reason: %s\n", error.what());
  }
  return false;
}

// A contact without area has no forces; when it has an area again, its forces are those of its opening.
void check_lost_area(const JointModel& prototype, const quoin_law& law) {
  for (const double lost : {0.0, -0.1}) {
    Contact contact(mortar_joint(prototype));
    contact.move({-1e-6, 1e-6, 0});
    const double normal = contact.state.normal_force_, shear = contact.state.shear_force_.x();
    CHECK(normal > 1e4 && shear < -1e3);
    contact.state.area_ = lost;
    contact.move({-2e-6, 1e-6, 0});
    CHECK(contact.state.normal_force_ == 0.0 && contact.state.shear_force_.mag() == 0.0);
    CHECK(contact.state.normal_force_inc_ == -normal && contact.state.shear_force_inc_.x() == -shear);
    contact.state.area_ = area;
    contact.move({-2e-6, 1e-6, 0});
    CHECK(std::abs(contact.state.normal_force_ - area * kn * 2e-6) <= 1e-9 * normal);
    const double back = keeps_slip(law) ? -shear : 0.0;
    CHECK(std::abs(contact.state.shear_force_.mag() - back) <= 1e-9 * -shear);
  }
}

// A missing or refused law: createInstance does not throw; `initialize` and `run` throw the reason.
void check_unserved(JointModel& model) {
  ContactState state;
  CHECK(split(model.getProperties()).empty());
  CHECK(model.getMaxNormalStiffness() == 0.0 && model.getMaxShearStiffness() == 0.0);
  const Model copy(model.clone());
  copy->copy(&model);
  for (JointModel* const one : {&model, copy.get()}) {
    CHECK(refuses("no law missing; looked for", [&] { one->initialize(3, &state); }));
    CHECK(refuses("no law missing; looked for", [&] { one->run(3, &state); }));
  }
}

void check_elastic_phase(const JointModel& prototype) {
  Contact contact(mortar_joint(prototype));
  contact.model->setIfCanFail(false);
  contact.move({1e-4, 1e-4, -1e-4});  // far beyond every strength
  CHECK(std::abs(contact.state.normal_force_ + area * kn * 1e-4) <= 1e-9 * area * kn * 1e-4);
  CHECK(std::abs(contact.state.shear_force_.x() + area * ks * 1e-4) <= 1e-9 * area * ks * 1e-4);
  CHECK(std::abs(contact.state.shear_force_.y() - area * ks * 1e-4) <= 1e-9 * area * ks * 1e-4);
  CHECK(contact.state.state_ == 0);
}

void check_failure_bits(const JointModel& prototype) {
  Contact contact(mortar_joint(prototype));
  contact.move({-1e-6, 0, 0});
  CHECK(contact.state.state_ == 0 && contact.model->isBonded(contact.state));
  contact.move({1e-3, 0, 0});  // beyond every softening
  CHECK((contact.state.state_ & 2) != 0 && !contact.model->isBonded(contact.state));
  contact.move({-1e-6, 0, 0});
  contact.move({-1e-6, 1e-3, 0});
  CHECK((contact.state.state_ & (1 | 8)) == (1 | 8) && contact.model->isSliding(contact.state));
  contact.move({-1e-6, 1e-3, 0});
  CHECK((contact.state.state_ & (1 | 4)) == 4 && !contact.model->isSliding(contact.state));
  CHECK((contact.state.state_ & (16 | 32)) == 0);

  // cap-n during crushing, cap-p from then on; unloading, reloading and sliding are not crushing.
  constexpr double elastic_limit = quoin::test::mortar::fc / kn;
  Contact cap(mortar_joint(prototype));
  cap.move({-0.9 * elastic_limit, 0, 0});
  CHECK((cap.state.state_ & (16 | 32)) == 0);
  cap.move({-1.1 * elastic_limit, 0, 0});
  CHECK((cap.state.state_ & (16 | 32)) == 16);
  cap.move({-1.2 * elastic_limit, 0, 0});
  CHECK((cap.state.state_ & (16 | 32)) == (16 | 32));
  cap.move({-1.0 * elastic_limit, 0, 0});
  CHECK((cap.state.state_ & (16 | 32)) == 32);
  cap.move({-1.0 * elastic_limit, 1e-3, 0});
  CHECK((cap.state.state_ & (1 | 16 | 32)) == (1 | 32));
  cap.move({1e-3, 1e-3, 0});
  cap.move({-0.5 * elastic_limit, 1e-3, 0});
  CHECK((cap.state.state_ & (16 | 32)) == 32);
}

void check_refusals(const JointModel& prototype, const quoin_law& law) {
  ContactState state;
  const Model bad = mortar_joint(prototype);
  bad->setProperty(1, -5.0);
  CHECK(refuses("normal_stiffness", [&] { bad->run(3, &state); }));
  const Model joint = mortar_joint(prototype);
  const Index initial = index_of(*joint, "initial_state");
  CHECK(refuses("give an index from 0 to 1", [&] { joint->setProperty(initial, 7.0); }));
  if (law.state_count > 0) CHECK(refuses("can be read, not set", [&] { joint->setProperty(initial + 1, 1.0); }));
  CHECK(refuses("another version of the law", [&] {
    std::stringstream file("what another program has written");
    joint->restore(file, 1);
  }));
  CHECK(refuses("not finite", [&] {
    state.normal_disp_inc_ = std::nan("");
    joint->run(3, &state);
  }));
}

// Times of one point under pressure: without motion, and with slip in every step, during softening.
void print_times(const JointModel& prototype, const quoin_law& law) {
  struct Step {
    const char* name;
    double first_slip, slip;
  };
  const Index softening = index_of(prototype, "softening");
  for (const char* const shape : {"linear", "exponential"}) {
    if (softening == 0 && std::strcmp(shape, "exponential") == 0) continue;
    for (const Step& step : {Step{"standing", 1e-9, 0.0}, Step{"sliding", 2e-5, 1e-12}}) {
      const auto contact_time = [&](std::size_t count, bool energies) {
        std::vector<Contact> contacts;
        for (std::size_t i = 0; i < count; ++i) {
          Contact& contact = contacts.emplace_back(mortar_joint(prototype));
          if (softening != 0) contact.model->setProperty(softening, std::strcmp(shape, "exponential") == 0 ? 1.0 : 0.0);
          contact.state.track_energy = energies;
          contact.move({-1e-6, step.first_slip, 0});
          contact.state.normal_disp_inc_ = 0.0;
          contact.state.shear_disp_inc_ = DVect3(step.slip, 0.0, 0.0);
        }
        return quoin::tests::nanoseconds(count, [&] {
          for (Contact& contact : contacts) contact.model->run(3, &contact.state);
        });
      };
      std::vector<quoin::adapters::PropertyValue> values = quoin::tests::mortar_of(law);
      if (softening != 0) values.push_back({"softening", {}, shape});
      const auto direct_time = [&](bool flags) {
        DirectLaw direct(law, 1, values);
        if (!flags) direct.batch.flags = {nullptr, 0};
        direct.step(-1e-6, step.first_slip, 0.0);
        direct.slip[0][0] = step.slip;
        return quoin::tests::nanoseconds(1, [&] { direct.evaluate(); });
      };
      std::printf(
          "%s, %s, %s, ns a point: direct %.1f, with flags %.1f; run: 1 point %.1f, 1000 points %.1f, "
          "1 point with energies %.1f\n",
          law.id, softening != 0 ? shape : "no softening", step.name, direct_time(false), direct_time(true),
          contact_time(1, false), contact_time(1000, false), contact_time(1, true));
    }
  }
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 3) {
    std::printf("usage: %s PLUGIN LAW_FILE [time | unserved]\n", argv[0]);
    return 2;
  }
  const quoin_law& law = quoin::adapters::law_in_file(argv[2]);
  void* const create = symbol(argv[1], "createInstance");
  if (create == nullptr) return 1;
  const auto create_instance = reinterpret_cast<void* (*)()>(create);
  const Model prototype(static_cast<JointModel*>(create_instance()));
  CHECK(prototype != nullptr);
  if (argc > 3 && std::strcmp(argv[3], "unserved") == 0) {
    check_unserved(*prototype);
    return quoin::tests::failures == 0 ? 0 : 1;
  }
  if (argc > 3) {
    print_times(*prototype, law);
    return 0;
  }
  check_description(*prototype, law, exported_name(argv[1]));
  check_synonyms(*prototype);
  check_stiffness_before_properties(*prototype);
  for (const auto& [leg, name] : quoin::tests::legs) {
    check_path(*prototype, law, leg, name, aligned, true);
    check_path(*prototype, law, leg, name, oblique, false);
  }
  check_turning(*prototype, law);
  check_continuation(*prototype);
  check_interleaved(*prototype);
  check_random_path(*prototype, law);
  check_no_allocation(*prototype);
  check_first_forces(*prototype, law);
  check_dilating_joint(*prototype);
  check_lost_area(*prototype, law);
  check_elastic_phase(*prototype);
  check_energy_activation(*prototype);
  if (std::string(law.id) != "elastic") check_dry_joint(*prototype);
  if (std::string(law.id) == "fracture_energy") {
    check_failure_bits(*prototype);
    check_stiffness_of_damaged_joint(*prototype);
  }
  check_refusals(*prototype, law);
  return quoin::tests::failures == 0 ? 0 : 1;
}
