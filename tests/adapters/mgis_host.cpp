// A host in the manner of MGIS: reads the symbols of a behaviour library with dlsym, walks the paths and compares with
// the law called directly. usage: mgis_host BEHAVIOUR_FILE LAW_FILE [time]
#include <dlfcn.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <string>
#include <vector>

#include "mgis/behaviour_data.h"
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

// One integration point: memory of the host, filled by name as MGIS does.
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

void check_description(const Library& library, const quoin_law& law) {
  CHECK(library.text("mfront_ept") == law.id);
  CHECK(library.text("mfront_interface") == "Generic");
  CHECK(library.text("unit_system") == "SI");
  CHECK(library.flag("api_version") == 1);
  CHECK(library.flag("mfront_mkt") == 1);
  CHECK(library.flag("BehaviourType") == 3);
  CHECK(library.flag("BehaviourKinematic") == 2);
  CHECK(library.flag("SymmetryType") == 0);
  CHECK(library.flag("ElasticSymmetryType") == 0);
  CHECK(library.flag("requiresStiffnessTensor") == 0);
  CHECK(library.flag("requiresThermalExpansionCoefficientTensor") == 0);
  CHECK(library.flag("TemperatureRemovedFromExternalStateVariables") == 0);
  CHECK(library.names("ModellingHypotheses") == std::vector<std::string>{"Tridimensional"});
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

// Traction, state, energies and tangent, bit for bit.
void check_path(const Library& library, Integrate integrate, const quoin_law& law, Leg leg, const char* name) {
  Point point(library);
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
    CHECK(point.stored1 == direct.stored[0]);
    CHECK(std::abs(point.dissipated1 - dissipated) <= 1e-12 * dissipated);
    if (i % 3 != 0)
      for (int k = 0; k < 9; ++k) CHECK(point.K[k] == direct.tangent[k][0]);
    point.accept();
  }
  CHECK(difference == 0.0);
  CHECK(largest > 1e5);
  std::printf("%s, %s: %d steps, force up to %.4g Pa, largest difference %g Pa\n", law.id, name,
              quoin::tests::leg_steps, largest, difference);
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
    if (!point.isv1.empty()) CHECK((point.isv1[0] > 0.0) == (std::string(state) == "dry"));
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

void print_times(const Library& library, Integrate integrate, const quoin_law& law) {
  for (const std::size_t count : {std::size_t{1}, std::size_t{1000}}) {
    std::vector<Point> points;
    points.reserve(count);
    for (std::size_t i = 0; i < count; ++i) {
      points.emplace_back(library).gradients1[0] = -1e-7;
      Point& point = points.back();
      point.data.s0.gradients = point.data.s1.gradients = point.gradients1;
      point.data.s1.stored_energy = point.data.s1.dissipated_energy = nullptr;
      point.K[0] = 0.0;
    }
    DirectLaw direct(law, count);
    direct.step(-1e-7, 0.0, 0.0);
    const double adapter = quoin::tests::nanoseconds(count, [&] {
      for (Point& point : points) integrate(&point.data);
    });
    std::printf("%s, %zu points: %.1f ns a point through MGIS's call, %.1f ns direct\n", law.id, count, adapter,
                quoin::tests::nanoseconds(count, [&] { direct.evaluate(); }));
  }
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 3) {
    std::printf("usage: %s BEHAVIOUR_FILE LAW_FILE [time]\n", argv[0]);
    return 2;
  }
  const quoin_law& law = quoin::adapters::law_in_file(argv[2]);
  const Library library(argv[1], law.id);
  const auto integrate = library ? reinterpret_cast<Integrate>(library.symbol("Tridimensional")) : nullptr;
  if (integrate == nullptr) return 1;
  if (argc > 3) {
    print_times(library, integrate, law);
    return 0;
  }
  check_description(library, law);
  for (const auto& [leg, name] : quoin::tests::legs) check_path(library, integrate, law, leg, name);
  check_operators(library, integrate);
  check_initial_states(library);
  check_refusals(library, integrate);
  return quoin::tests::failures == 0 ? 0 : 1;
}
