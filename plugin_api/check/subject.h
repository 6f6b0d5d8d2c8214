// Materials of the law under test, and arrays of points for its evaluation.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <map>
#include <memory>
#include <random>
#include <span>
#include <string>
#include <vector>

#include "quoin/quoin.h"

namespace check {

// Property values by id, as text with the syntax of the command line: a number, a word, or a table x:y,x:y.
using Settings = std::map<std::string, std::string>;

std::string shortest(double value);  // shortest text that converts back to the same bits

// A quoin_text with a buffer large enough for any message.
struct Text {
  Text();
  std::string str() const { return std::string(bytes.data()); }
  std::vector<char> bytes;
  quoin_text text;
};

// Settings as arrays of the ABI, valid as long as this object.
struct Values {
  Values(const quoin_law& law, const Settings& settings);
  std::vector<std::string> ids, texts;
  std::vector<std::vector<double>> numbers;
  std::vector<quoin_property_value> values;
  std::vector<const quoin_property_value*> pointers;
};

class Material {
 public:
  Material(const quoin_law& law, const Settings& settings);  // handle is null if the law refuses the settings
  ~Material();
  Material(Material&& other) noexcept;
  Material(const Material&) = delete;
  Material& operator=(const Material&) = delete;
  quoin_material* handle = nullptr;
  quoin_status status = QUOIN_OK;
  std::string message;
  Settings settings;
  double number(const char* id) const;

 private:
  const quoin_law& law_;
};

inline std::span<const quoin_property_info* const> properties_of(const quoin_law& law) {
  return {law.properties, law.property_count};
}
inline std::span<const quoin_state_info* const> states_of(const quoin_law& law) {
  return {law.states, law.state_count};
}
std::vector<const quoin_property_info*> numbers_of(const quoin_law& law);  // properties that are numbers
const quoin_property_info* find_property(const quoin_law& law, const std::string& id);
bool inside(const quoin_property_info& number, double value);           // within the bounds that the law states
std::vector<double> values_outside(const quoin_property_info& number);  // beyond each bound, and a bound that is open

// Returns values for all properties: given, default, or for a required property a usual value of its unit.
Settings base_settings(const quoin_law& law, const Settings& given);
// Returns the base and up to two variations of it that the law accepts, without a warning if it has none for the base.
std::vector<Settings> varied_settings(const quoin_law& law, const Settings& base);

// N points, structure of arrays.
struct Points {
  std::vector<double> normal_jump;
  std::array<std::vector<double>, 2> slip;
  std::array<std::vector<double>, 3> traction;
  std::vector<std::vector<double>> state;
  size_t size() const { return normal_jump.size(); }
  Points take(const std::vector<size_t>& indices) const;
};
Points points_at(const quoin_law& law, const Material& material, size_t count, const char* initial_state);

struct Result {
  quoin_status status = QUOIN_OK;
  std::array<std::vector<double>, 3> traction;
  std::vector<std::vector<double>> state;
  std::vector<double> stored;
  std::array<std::vector<double>, QUOIN_DISSIPATED_COUNT> dissipated;
  std::array<std::vector<double>, 9> tangent;
  std::array<std::vector<double>, QUOIN_DAMAGE_COUNT> damage;
  std::vector<uint32_t> flags, point_status;
  uint64_t clamped = 0, failed = 0;
  uint32_t worst = 0, any_yielding = 0;
  double dissipation(size_t i) const;
  Result take(const std::vector<size_t>& indices) const;
};

// Returns a result whose tractions and states have this value.
Result unwritten(const quoin_law& law, size_t count, double value = std::numeric_limits<double>::quiet_NaN());

// A batch of contiguous columns, without optional outputs. A test may change every column.
struct Columns {
  explicit Columns(const quoin_law& law);
  Columns(const quoin_law& law, const Points& points, Result& result);
  Columns(const Columns&) = delete;
  void read(const Points& points);
  void write(std::array<std::vector<double>, 3>& traction, std::vector<std::vector<double>>& state);
  quoin_batch batch = {};
  std::vector<quoin_in> state_old;
  std::vector<quoin_out> state_new;
};

constexpr unsigned kEnergy = 1, kTangent = 2, kFlags = 4, kStatus = 8, kDamage = 16, kAll = 31;

Result evaluate(const quoin_law& law, const Material& material, const Points& points, unsigned wanted = kAll);

// Returns the first difference of two results, as text; empty if they are bitwise identical. Outputs that only one of
// them has are not compared.
std::string difference(const quoin_law& law, const Result& a, const Result& b);

// Lengths and tractions at which a material yields, estimated from its properties and stiffness bounds.
struct Scales {
  Scales(const quoin_law& law, const Material& material);
  double normal_stiffness, shear_stiffness;
  std::vector<double> strengths;                                // Pa
  std::vector<double> energies;                                 // J/m2
  double traction;                                              // largest strength
  double short_slip = std::numeric_limits<double>::infinity();  // longest slip of a step for which C8.5 holds, m
  double opening(std::mt19937_64& random) const;
  double closing(std::mt19937_64& random) const;
  double sliding(std::mt19937_64& random) const;
};

// Ends of the legs of far walks, beyond all strengths: what a joint may meet in a collapse.
inline constexpr double kFarPressure = 3e7;                   // Pa, of an elastic joint
inline constexpr double kFarOpening = 5e-3, kFarSlip = 1e-2;  // m

// Points on random paths of straight legs, which open, close, crush, slide and reverse: near the strengths, or far.
class Walk {
 public:
  enum class Reach { near, far };
  Walk(const quoin_law& law, const Material& material, size_t count, uint64_t seed, int steps_per_leg,
       const char* initial_state = nullptr, Reach reach = Reach::near);
  void keep(const std::vector<size_t>& which);  // before the first step: leaves only these points, on the same paths
  void aim();                                   // sets the inputs of the next step in points
  void advance(const Result&);                  // copies the outputs to the old traction and state in points
  Points points;
  std::vector<double> normal_before;  // d_n at the start of the step

 private:
  struct Leg {
    double target;  // d_n at its end, m; NaN: d_n does not change
    double slip[2];
  };
  Leg draw_leg();
  void begin_legs();
  Scales scales_;
  Reach reach_;
  int steps_per_leg_;
  int step_ = 0;
  std::mt19937_64 random_;
  size_t drawn_;                 // points before keep: each draws its legs
  std::vector<size_t> numbers_;  // of points, among those drawn; ascending
  std::vector<std::array<double, 3>> increment_;
};

// Returns typical inputs: each point at another step of its random path.
Points scattered_points(const quoin_law& law, const Material& material, size_t count, uint64_t seed);

double uniform(std::mt19937_64& random, double low = 0, double high = 1);

}  // namespace check
