// A host in the manner of 3DEC: loads the plug-in, makes a model for each contact point and calls it once a step with
// forces and increments; compared with the law called directly. Runs on Linux and, under Wine, on Windows.
// usage: threedec_host PLUGIN LAW_FILE [time]
#include <cmath>
#include <cstring>
#include <memory>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "jointmodel.h"
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
using quoin::tests::DirectLaw;
using quoin::tests::Leg;

namespace {

using quoin::test::mortar::kn, quoin::test::mortar::ks;
constexpr double area = 0.25;  // a power of two: stress and force have the same digits

struct ContactState : jmodels::State {
  ContactState() { area_ = area; }
  double getTimeStep() const override { return 1e-6; }
  bool isThermal() const override { return false; }
  bool isCreep() const override { return false; }
  bool isFluid() const override { return false; }
  bool trackEnergy() const override { return track_energy; }
  void* getTableIndexFromID(const String&) const override { return nullptr; }
  double getYFromX(void*, const double&) const override { return 0.0; }
  double getSlopeFromX(void*, const double&) const override { return 0.0; }

  bool track_energy = false;
};

std::vector<std::string> split(const String& names) {
  std::istringstream stream(std::string(names.begin(), names.end()));
  std::vector<std::string> parts;
  for (std::string part; std::getline(stream, part, ',');) parts.push_back(part);
  return parts;
}

UInt index_of(const JointModel& model, const std::string& property) {
  const std::vector<std::string> names = split(model.getProperties());
  for (std::size_t i = 0; i < names.size(); ++i)
    if (names[i] == property) return static_cast<UInt>(i + 1);
  return 0;
}

using Model = std::unique_ptr<JointModel>;

Model mortar_joint(const JointModel& prototype) {
  Model model(prototype.clone());
  for (const auto& [id, number] : quoin::test::mortar::properties)
    if (const UInt index = index_of(*model, id); index != 0) model->setProperty(index, number);
  return model;
}

// Where s and t of the contact plane point.
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
  // Returns the increments of (d_n, d_s, d_t).
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
    for (UInt i = 1; i <= split(model->getProperties()).size(); ++i)
      equal = equal && same(model->getProperty(i).toDouble(), other.model->getProperty(i).toDouble());
    return equal;
  }
};

void check_description(const JointModel& prototype, const quoin_law& law) {
  CHECK(prototype.getName() == String(law.id, law.id + std::strlen(law.id)));
  std::vector<std::string> expected;
  for (const quoin_property_info* info : quoin::adapters::scalar_properties(law)) expected.push_back(info->id);
  expected.push_back("initial_state");
  for (std::uint64_t k = 0; k < law.state_count; ++k) expected.push_back(law.states[k]->id);
  CHECK(split(prototype.getProperties()) == expected);
  CHECK(split(prototype.getStates()).size() == 5);
  CHECK(split(prototype.getEnergies()).size() == 7 && split(prototype.getEnergies())[3] == "energy-slip");
  const Model model = mortar_joint(prototype);
  CHECK(model->getMaxNormalStiffness() == kn);
  CHECK(model->getMaxShearStiffness() == ks);
  CHECK(model->getProperty(1).toDouble() == kn);
  CHECK(model->getProperty(1000).toDouble() == 0.0);
  if (const UInt residual = index_of(*model, "friction_angle_residual"); residual != 0)
    CHECK(model->getProperty(residual).toDouble() == 35.0);  // default_from friction_angle
}

// Along one axis the digits agree; in an oblique plane the axes of a step round.
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
    CHECK(((contact.state.state_ & 1) != 0) == ((direct.flags[0] & QUOIN_FLAG_SLIPPING) != 0));
  }
  double booked[2] = {0.0, 0.0};  // stored, dissipated
  for (UInt key = 1; key <= 7; ++key)
    booked[contact.model->getEnergyAccumulate(key) ? 1 : 0] += contact.model->getEnergy(key);
  const double scale = direct.stored[0] * area + dissipated;
  CHECK(std::abs(booked[0] - direct.stored[0] * area) <= 1e-9 * scale);
  CHECK(std::abs(booked[1] - dissipated) <= 1e-9 * scale);
  CHECK(exact ? difference == 0.0 : difference <= 1e-9 * largest);
  CHECK(largest > 1e4);
  std::printf("%s, %s%s: %d steps, force up to %.4g N, largest difference %.3g N\n", law.id, name,
              exact ? " along s" : "", quoin::tests::leg_steps, largest, difference);
}

// A contact that is copied, saved or asked to initialize continues as if nothing had happened.
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
        for (UInt p = 1; p <= split(prototype.getProperties()).size(); ++p)
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

void check_first_forces(const JointModel& prototype) {
  Contact contact(mortar_joint(prototype));  // in-situ forces, made by no displacement
  contact.state.normal_force_ = 2e4;
  contact.state.shear_force_ = {3e3, 0, 0};
  contact.move({0, 0, 0});
  CHECK(std::abs(contact.state.normal_force_ - 2e4) <= 1e-11 * 2e4);
  CHECK(std::abs(contact.state.shear_force_.x() - 3e3) <= 1e-11 * 3e3);
  contact.move({-1e-7, 1e-8, 0});
  CHECK(std::abs(contact.state.normal_force_ - (2e4 + area * kn * 1e-7)) <= 1e-11 * 2e4);
  CHECK(std::abs(contact.state.shear_force_.x() - (3e3 - area * ks * 1e-8)) <= 1e-11 * 3e3);
  CHECK(std::abs(contact.state.normal_force_inc_ - area * kn * 1e-7) <= 1e-7);

  Contact opening(mortar_joint(prototype));
  opening.move({-1e-7, 0, 0});
  opening.move({1e-7, 0, 0});  // the second half of this increment is tension
  CHECK(std::abs(opening.state.dnop_ - 1e-7) <= 1e-19);
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

void check_refusals(const JointModel& prototype, const quoin_law& law) {
  ContactState state;
  const Model bad = mortar_joint(prototype);
  bad->setProperty(1, -5.0);
  CHECK(refuses("normal_stiffness", [&] { bad->run(3, &state); }));
  const Model joint = mortar_joint(prototype);
  const UInt initial = index_of(*joint, "initial_state");
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

void print_times(const JointModel& prototype, const quoin_law& law) {
  for (const std::size_t count : {std::size_t{1}, std::size_t{1000}}) {
    std::vector<Contact> contacts;
    for (std::size_t i = 0; i < count; ++i) {
      contacts.emplace_back(mortar_joint(prototype)).move({-1e-7, 1e-9, 0});
      contacts.back().state.normal_disp_inc_ = 0.0;
      contacts.back().state.shear_disp_inc_ = {};
    }
    DirectLaw direct(law, count);
    direct.step(-1e-7, 1e-9, 0.0);
    direct.step(-1e-7, 0.0, 0.0);
    const double adapter = quoin::tests::nanoseconds(count, [&] {
      for (Contact& contact : contacts) contact.model->run(3, &contact.state);
    });
    std::printf("%s, %zu points: %.1f ns a point through run, %.1f ns direct\n", law.id, count, adapter,
                quoin::tests::nanoseconds(count, [&] { direct.evaluate(); }));
  }
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 3) {
    std::printf("usage: %s PLUGIN LAW_FILE [time]\n", argv[0]);
    return 2;
  }
  const quoin_law& law = quoin::adapters::law_in_file(argv[2]);
  void* const create = load_symbol(argv[1], "createInstance");
  if (create == nullptr) {
    std::printf("%s: no createInstance\n", argv[1]);
    return 1;
  }
  const Model prototype(static_cast<JointModel*>(reinterpret_cast<void* (*)()>(create)()));
  if (argc > 3) {
    print_times(*prototype, law);
    return 0;
  }
  check_description(*prototype, law);
  for (const auto& [leg, name] : quoin::tests::legs) {
    check_path(*prototype, law, leg, name, aligned, true);
    check_path(*prototype, law, leg, name, oblique, false);
  }
  check_continuation(*prototype);
  check_interleaved(*prototype);
  check_first_forces(*prototype);
  check_elastic_phase(*prototype);
  check_energy_activation(*prototype);
  if (std::string(law.id) != "elastic") check_dry_joint(*prototype);
  if (std::string(law.id) == "fracture_energy") check_failure_bits(*prototype);
  check_refusals(*prototype, law);
  return quoin::tests::failures == 0 ? 0 : 1;
}
