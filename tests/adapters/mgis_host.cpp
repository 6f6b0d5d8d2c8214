// A host that works like MGIS. It reads the symbols of a behaviour library with dlsym, computes paths and compares them
// with the law called directly. usage: mgis_host BEHAVIOUR_FILE LAW_FILE [time]
#include <dlfcn.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "mgis/behaviour_data.h"
#include "tests/adapters/allocations.h"
#include "tests/adapters/check.h"
#include "tests/adapters/direct_law.h"
#include "tests/adapters/timing.h"
#include "tests/mortar.h"

using quoin::mgis::BehaviourData;
using quoin::tests::DirectLaw;
using quoin::tests::Leg;

namespace {

using Integrate = int (*)(BehaviourData*);
using Initialize = int (*)(BehaviourData*, const double*);

class Library {
 public:
  Library(const char* file, std::string behaviour) : handle_(dlopen(file, RTLD_NOW)), behaviour_(std::move(behaviour)) {
    if (handle_ == nullptr) std::printf("%s\n", dlerror());
  }
  explicit operator bool() const { return handle_ != nullptr; }

  void* symbol(const std::string& name) const {
    void* address = dlsym(handle_, (behaviour_ + "_" + name).c_str());
    if (address == nullptr) std::printf("no symbol %s_%s\n", behaviour_.c_str(), name.c_str());
    return address;
  }
  unsigned short flag(const std::string& name) const {
    const void* address = symbol(name);
    return address != nullptr ? *static_cast<const unsigned short*>(address) : 65535;
  }
  std::string text(const std::string& name) const {
    const void* address = symbol(name);
    return address != nullptr ? *static_cast<const char* const*>(address) : "";
  }
  std::vector<std::string> names(const std::string& list) const {
    const auto* first = static_cast<const char* const*>(symbol(list));
    return first != nullptr ? std::vector<std::string>(first, first + flag("n" + list)) : std::vector<std::string>{};
  }
  std::vector<int> types(const std::string& list) const {
    const auto* first = static_cast<const int*>(symbol(list + "Types"));
    return first != nullptr ? std::vector<int>(first, first + flag("n" + list)) : std::vector<int>{};
  }

 private:
  void* handle_;
  std::string behaviour_;
};

bool any_positive(const std::vector<double>& numbers) {
  return std::ranges::any_of(numbers, [](double number) { return number > 0.0; });
}

// One integration point: memory of the host, filled in by names as in MGIS. It has memory for energies also if the
// behaviour does not compute them, as in a MaterialDataManager of MGIS 2.
struct Point {
  std::vector<double> properties, isv0, isv1;
  double gradients0[3] = {}, gradients1[3] = {}, force0[3] = {}, force1[3] = {}, K[9] = {};
  double stored0 = 0, stored1 = 0, dissipated0 = 0, dissipated1 = 0, rdt = 1, sound = 0;
  char message[quoin::mgis::error_message_size] = {};
  BehaviourData data{};

  explicit Point(const Library& library) {
    for (const std::string& name : library.names("MaterialProperties")) {
      properties.push_back(std::numeric_limits<double>::quiet_NaN());  // the law's default
      for (const auto& [id, number] : quoin::test::mortar::properties)
        if (name == id) properties.back() = number;
    }
    isv0.resize(library.flag("nInternalStateVariables"));
    isv1 = isv0;
    tie();
  }
  // Sets the pointers to members; needed again after the object has been moved in memory.
  void tie() {
    data = {message,
            0.1,
            K,
            &rdt,
            &sound,
            {gradients0, force0, nullptr, properties.data(), isv0.data(), &stored0, &dissipated0, nullptr},
            {gradients1, force1, nullptr, properties.data(), isv1.data(), &stored1, &dissipated1, nullptr}};
  }
  int integrate(Integrate function, const std::array<double, 3>& opening, double request) {
    std::copy(opening.begin(), opening.end(), gradients1);
    K[0] = request;
    return function(&data);
  }
  void accept() {
    std::memcpy(gradients0, gradients1, sizeof gradients0);
    std::memcpy(force0, force1, sizeof force0);
    isv0.assign(isv1.begin(), isv1.end());
    stored0 = stored1;
    dissipated0 = dissipated1;
  }
};

void check_description(const Library& library, const quoin_law& law, bool energies) {
  CHECK(library.text("mfront_ept") == std::string(law.id) + (energies ? "_with_energies" : ""));
  CHECK(library.text("mfront_interface") == "Generic");
  CHECK(library.text("unit_system") == "SI");
  CHECK(library.flag("api_version") == 1);
  CHECK(library.flag("mfront_mkt") == 1);
  CHECK(library.flag("BehaviourType") == 3);
  CHECK(library.flag("BehaviourKinematic") == 2);
  CHECK(library.flag("SymmetryType") == 0);
  CHECK(library.flag("ElasticSymmetryType") == 0);
  CHECK(library.flag("ComputesInternalEnergy") == energies && library.flag("ComputesDissipatedEnergy") == energies);
  CHECK(library.flag("requiresStiffnessTensor") == 0);
  CHECK(library.flag("requiresThermalExpansionCoefficientTensor") == 0);
  CHECK(library.flag("TemperatureRemovedFromExternalStateVariables") == 0);
  CHECK(library.names("ModellingHypotheses") == std::vector<std::string>{"PlaneStrain", "Tridimensional"});
  CHECK(library.names("Gradients") == std::vector<std::string>{"OpeningDisplacement"});
  CHECK(library.types("Gradients") == std::vector<int>{2});
  CHECK(library.names("ThermodynamicForces") == std::vector<std::string>{"CohesiveForce"});
  CHECK(library.types("ThermodynamicForces") == std::vector<int>{2});
  CHECK(library.names("TangentOperatorBlocks") == std::vector<std::string>{"CohesiveForce", "OpeningDisplacement"});
  CHECK(library.names("ExternalStateVariables").empty());
  CHECK(library.names("Parameters").empty() && library.types("Parameters").empty());
  std::vector<std::string> states;
  for (std::uint64_t k = 0; k < law.state_count; ++k) states.push_back(law.states[k]->id);
  CHECK(library.names("InternalStateVariables") == states);
  CHECK(library.types("InternalStateVariables") == std::vector<int>(states.size(), 0));
  CHECK(library.names("MaterialProperties")[0] == "normal_stiffness");
  CHECK(*static_cast<const long double*>(library.symbol("normal_stiffness_LowerPhysicalBound")) == 0.0L);
  CHECK(library.names("InitializeFunctions") == std::vector<std::string>{"bonded", "dry"});
}

// Compares traction, state and tangent bit by bit; also energies for the behaviour that computes them. The other
// behaviour neither writes energies nor requests them from the law.
void check_path(const Library& library, Integrate integrate, const quoin_law& law, Leg leg, const char* name) {
  const bool energies = library.flag("ComputesInternalEnergy") != 0;
  constexpr double untouched = 7e77;
  Point point(library);
  if (!energies) point.stored1 = point.dissipated1 = untouched;
  DirectLaw direct(law);
  direct.want_energies();
  direct.want_tangent();
  double difference = 0.0, largest = 0.0, dissipated = 0.0;
  for (int i = 1; i <= quoin::tests::leg_steps; ++i) {
    const std::array<double, 3> opening = quoin::tests::displacement(leg, i);
    const int result = point.integrate(integrate, opening, i % 3 == 0 ? 0.0 : 4.0);
    direct.step(opening[0], opening[1] - point.gradients0[1], opening[2] - point.gradients0[2]);
    CHECK(result == quoin::mgis::results_reliable);
    if (result == quoin::mgis::integration_failed) {
      std::printf("%s\n", point.message);
      return;
    }
    for (int k = 0; k < 3; ++k) {
      difference = std::max(difference, std::abs(point.force1[k] - direct.traction[k][0]));
      largest = std::max(largest, std::abs(point.force1[k]));
    }
    for (std::size_t k = 0; k < law.state_count; ++k) CHECK(point.isv1[k] == direct.state[k][0]);
    for (const auto& mode : direct.dissipated) dissipated += mode[0];
    CHECK(point.stored1 == (energies ? direct.stored[0] : untouched));
    CHECK(energies ? std::abs(point.dissipated1 - dissipated) <= 1e-12 * dissipated : point.dissipated1 == untouched);
    if (i % 3 != 0)
      for (int k = 0; k < 9; ++k) CHECK(point.K[k] == direct.tangent[k][0]);
    point.accept();
  }
  CHECK(difference == 0.0);
  CHECK(largest > 1e5);
  std::printf("%s, %s: %d steps, force up to %.4g Pa, largest difference %g Pa\n", law.id, name,
              quoin::tests::leg_steps, largest, difference);
}

// Opening and sliding along one axis with two components are equal to the step with three components. Memory behind the
// two components is not written.
void check_plane_strain(const Library& library, Integrate integrate, const quoin_law& law, Leg leg) {
  const auto plane = reinterpret_cast<Integrate>(library.symbol("PlaneStrain"));
  constexpr double untouched = 7e77;
  Point flat(library), solid(library);
  flat.gradients0[2] = flat.gradients1[2] = flat.force1[2] = untouched;
  double largest = 0.0;
  for (int i = 1; i <= quoin::tests::leg_steps; ++i) {
    std::array<double, 3> opening = quoin::tests::displacement(leg, i);
    opening[2] = 0.0;
    const double request = i % 3 == 0 ? -2.0 : i % 3 == 1 ? 1.0 : 4.0;
    for (double& number : flat.K) number = untouched;
    CHECK(solid.integrate(integrate, opening, request) == quoin::mgis::results_reliable);
    CHECK(flat.integrate(plane, {opening[0], opening[1], untouched}, request) == quoin::mgis::results_reliable);
    for (int row = 0; row < 2; ++row)
      for (int column = 0; column < 2; ++column) CHECK(flat.K[2 * row + column] == solid.K[3 * row + column]);
    for (int k = 4; k < 9; ++k) CHECK(flat.K[k] == untouched);
    if (request < 0.0) continue;
    for (int k = 0; k < 2; ++k) CHECK(flat.force1[k] == solid.force1[k]);
    CHECK(flat.force1[2] == untouched && solid.force1[2] == 0.0);
    CHECK(flat.isv1 == solid.isv1 && flat.stored1 == solid.stored1 && flat.dissipated1 == solid.dissipated1);
    largest = std::max(largest, std::abs(flat.force1[1]));
    flat.accept(), solid.accept();
  }
  if (leg == Leg::shear) CHECK(largest > 1e5);
  Point point(library);
  for (const char* state : {"bonded", "dry"}) {
    const auto initialize =
        reinterpret_cast<Initialize>(library.symbol(std::string("PlaneStrain_InitializeFunction_") + state));
    CHECK(initialize(&point.data, nullptr) == quoin::mgis::results_reliable);
    if (law.state_count > 0) CHECK(any_positive(point.isv1) == (std::string(state) == "dry"));
  }
}

// Returns a property of the mortar joint increased by a share that depends on the point.
double varied(double number, std::size_t point) { return number * (1.0 + 1e-5 * static_cast<double>(point)); }

Point varied_point(const Library& library, std::size_t number) {
  Point point(library);
  for (double& property : point.properties) property = varied(property, number);
  return point;
}

// A field in which every point has its own values, with more points than separate materials. The results are bitwise
// identical to the law with these values, in any order. Refused or not finite values have a message.
void check_varied_field(const Library& library, Integrate integrate, const quoin_law& law) {
  constexpr std::size_t count = 1500;  // PropertySets::kept is 1024
  const Leg leg = Leg::shear;
  long before = 0;
  std::vector<Point> points;
  std::vector<std::unique_ptr<DirectLaw>> direct;
  points.reserve(count);  // they have pointers to their own members
  for (std::size_t i = 0; i < count; ++i) {
    points.push_back(varied_point(library, i));
    points.back().tie();
    std::vector<quoin::adapters::PropertyValue> values = quoin::tests::mortar_of(law);
    for (quoin::adapters::PropertyValue& value : values) value.numbers[0] = varied(value.numbers[0], i);
    direct.push_back(std::make_unique<DirectLaw>(law, 1, values));
  }
  for (int i = 200; i <= quoin::tests::leg_steps; i += 200) {
    const std::array<double, 3> opening = quoin::tests::displacement(leg, i);
    const double request = i % 400 == 0 ? 1.0 : 0.0;
    for (std::size_t p = 0; p < count; ++p) {
      Point& point = points[p];
      before = quoin::tests::allocations;
      CHECK(point.integrate(integrate, opening, request) == quoin::mgis::results_reliable);
      // All values have been used before. Only an elastic operator of a point without a separate material allocates.
      if (i > 400 && request == 0.0) CHECK(quoin::tests::allocations == before);
      direct[p]->step(opening[0], opening[1] - point.gradients0[1], opening[2] - point.gradients0[2]);
      for (int k = 0; k < 3; ++k) CHECK(point.force1[k] == direct[p]->traction[k][0]);
      for (std::size_t k = 0; k < law.state_count; ++k) CHECK(point.isv1[k] == direct[p]->state[k][0]);
      if (i % 400 == 0) CHECK(point.K[0] == direct[p]->material.stiffness().normal);
      point.accept();
    }
  }
  Point bad = varied_point(library, count);
  bad.tie();
  bad.properties[0] = -5.0;
  CHECK(bad.integrate(integrate, {0.0, 0.0, 0.0}, 0.0) == quoin::mgis::integration_failed);
  CHECK(std::strstr(bad.message, "normal_stiffness") != nullptr && std::strstr(bad.message, "-5") != nullptr);
  bad.properties[0] = std::numeric_limits<double>::quiet_NaN();
  CHECK(bad.integrate(integrate, {0.0, 0.0, 0.0}, 0.0) == quoin::mgis::integration_failed);
  CHECK(std::strstr(bad.message, "normal_stiffness") != nullptr);
  bad.properties[0] = 1e10;
  CHECK(bad.integrate(integrate, {std::nan(""), 0.0, 0.0}, 0.0) == quoin::mgis::integration_failed);
  CHECK(std::strstr(bad.message, "opening (nan, 0, 0) m") != nullptr);
}

// The law is searched once: a later file of its name, which is not a law, has no effect.
void check_law_is_kept(const Library& library, Integrate integrate, const quoin_law& law) {
  const std::filesystem::path folder =
      std::filesystem::temp_directory_path() / ("quoin_mgis_" + std::to_string(getpid()));
  std::filesystem::create_directory(folder);
  std::ofstream(folder / (std::string(law.id) + ".so")) << "no law";
  setenv("QUOIN_LAW_PATH", folder.c_str(), 1);
  Point point(library);
  point.properties[0] *= 1.25;  // values that were not used before
  CHECK(point.integrate(integrate, {-1e-7, 0.0, 0.0}, 0.0) == quoin::mgis::results_reliable);
  std::printf("%s", point.message);
  std::filesystem::remove_all(folder);
}

void check_operators(const Library& library, Integrate integrate) {
  using quoin::test::mortar::kn, quoin::test::mortar::ks;
  Point point(library);
  for (const double request : {-1.0, -3.0, 1.0, 4.0}) {  // closed and unbroken: all are the elastic operator
    CHECK(point.integrate(integrate, {-1e-7, 1e-8, 0.0}, request) == quoin::mgis::results_reliable);
    const bool integrated = point.force1[0] != 0.0;
    CHECK(integrated == (request > 0.0));
    for (int k = 0; k < 9; ++k) CHECK(point.K[k] == (k == 0 ? kn : k % 4 == 0 ? ks : 0.0));
  }
  point.K[4] = 7.0;
  CHECK(point.integrate(integrate, {-1e-7, 1e-8, 0.0}, 0.0) == quoin::mgis::results_reliable);
  CHECK(point.K[4] == 7.0);
  CHECK(std::abs(point.force1[0] + kn * 1e-7) <= 1e-12 * kn * 1e-7);
  CHECK(std::abs(point.force1[1] - ks * 1e-8) <= 1e-12 * ks * 1e-8);
}

void check_initial_states(const Library& library) {
  for (const char* state : {"bonded", "dry"}) {
    const auto initialize =
        reinterpret_cast<Initialize>(library.symbol(std::string("Tridimensional_InitializeFunction_") + state));
    Point point(library);
    for (double& value : point.isv1) value = -1.0;
    CHECK(initialize(&point.data, nullptr) == quoin::mgis::results_reliable);
    for (const double value : point.isv1) CHECK(value >= 0.0);
    if (!point.isv1.empty()) CHECK(any_positive(point.isv1) == (std::string(state) == "dry"));
  }
}

void check_refusals(const Library& library, Integrate integrate) {
  const auto says = [](const Point& point, const char* text) { return std::strstr(point.message, text) != nullptr; };
  Point point(library);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  CHECK(point.integrate(integrate, {nan, 0.0, 0.0}, 0.0) == quoin::mgis::integration_failed);
  CHECK(says(point, "opening (nan, 0, 0) m"));
  CHECK(point.integrate(integrate, {0.0, 0.0, 0.0}, 104.0) == quoin::mgis::integration_failed);
  CHECK(says(point, "speed of sound"));
  point.properties[0] = -5.0;
  CHECK(point.integrate(integrate, {0.0, 0.0, 0.0}, 0.0) == quoin::mgis::integration_failed);
  CHECK(says(point, "normal_stiffness") && says(point, "-5"));
  CHECK(std::memchr(point.message, 0, sizeof point.message) != nullptr);
  point.data.error_message = nullptr;  // allowed
  CHECK(point.integrate(integrate, {0.0, 0.0, 0.0}, 0.0) == quoin::mgis::integration_failed);
}

// Times of steps without operator at closed points: with one material, and with different values for each point.
void print_times(const Library& library, Integrate integrate, const quoin_law& law) {
  const auto time = [&](std::size_t count, bool field) {
    std::vector<Point> points;
    points.reserve(count);
    for (std::size_t i = 0; i < count; ++i) {
      points.push_back(varied_point(library, field ? i : 0));
      Point& point = points.back();
      point.tie();
      point.gradients1[0] = -1e-7;
      point.data.s0.gradients = point.data.s1.gradients = point.gradients1;
      point.K[0] = 0.0;
    }
    return quoin::tests::nanoseconds(count, [&] {
      for (Point& point : points) integrate(&point.data);
    });
  };
  DirectLaw direct(law);
  direct.batch.flags = {nullptr, 0};
  direct.step(-1e-7, 0.0, 0.0);
  std::printf("%s, ns a point: direct %.1f; through MGIS's call 1 point %.1f, 1000 points of one material %.1f,\n",
              library.text("mfront_ept").c_str(), quoin::tests::nanoseconds(1, [&] { direct.evaluate(); }),
              time(1, false), time(1000, false));
  std::printf("  fields of different values: 10 points %.1f, 1000 points %.1f, 4000 points %.1f\n", time(10, true),
              time(1000, true), time(4000, true));
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 3) {
    std::printf("usage: %s BEHAVIOUR_FILE LAW_FILE [time]\n", argv[0]);
    return 2;
  }
  const quoin_law& law = quoin::adapters::law_in_file(argv[2]);
  for (const bool energies : {false, true}) {
    const Library library(argv[1], std::string(law.id) + (energies ? "_with_energies" : ""));
    const auto integrate = library ? reinterpret_cast<Integrate>(library.symbol("Tridimensional")) : nullptr;
    if (integrate == nullptr) return 1;
    if (argc > 3) {
      print_times(library, integrate, law);
      continue;
    }
    check_description(library, law, energies);
    for (const auto& [leg, name] : quoin::tests::legs) check_path(library, integrate, law, leg, name);
    if (quoin::tests::failures > 0) return 1;
    for (const auto& [leg, name] : quoin::tests::legs) check_plane_strain(library, integrate, law, leg);
    check_operators(library, integrate);
    check_initial_states(library);
    check_refusals(library, integrate);
    check_varied_field(library, integrate, law);
    check_law_is_kept(library, integrate, law);
  }
  return quoin::tests::failures == 0 ? 0 : 1;
}
