#include "subject.h"

#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstring>
#include <numeric>

#include "report.h"

namespace check {

std::string shortest(double value) {
  char text[64];
  const auto end = std::to_chars(text, text + sizeof text, value);
  return std::string(text, end.ptr);
}

double uniform(std::mt19937_64& random, double low, double high) {
  return low + (high - low) * static_cast<double>(random() >> 11) * 0x1p-53;
}

Text::Text() : bytes(1 << 16), text{sizeof(quoin_text), bytes.data(), bytes.size(), 0} {}

std::vector<const quoin_property_info*> numbers_of(const quoin_law& law) {
  std::vector<const quoin_property_info*> numbers;
  for (const quoin_property_info* property : properties_of(law)) {
    if (property->kind == QUOIN_PROPERTY_NUMBER) numbers.push_back(property);
  }
  return numbers;
}

const quoin_property_info* find_property(const quoin_law& law, const std::string& id) {
  for (const quoin_property_info* property : properties_of(law)) {
    if (property != nullptr && property->id != nullptr && id == property->id) return property;
  }
  return nullptr;
}

bool inside(const quoin_property_info& number, double value) {
  const bool above = number.flags & QUOIN_PROPERTY_LOWER_OPEN ? value > number.lower : value >= number.lower;
  const bool below = number.flags & QUOIN_PROPERTY_UPPER_OPEN ? value < number.upper : value <= number.upper;
  return above && below;
}

std::vector<double> values_outside(const quoin_property_info& number) {
  constexpr double kBeyond = 7;
  std::vector<double> values;
  if (std::isfinite(number.lower)) values.push_back(number.lower - kBeyond);
  if (number.flags & QUOIN_PROPERTY_LOWER_OPEN) values.push_back(number.lower);
  if (std::isfinite(number.upper)) values.push_back(number.upper + kBeyond);
  if (number.flags & QUOIN_PROPERTY_UPPER_OPEN) values.push_back(number.upper);
  return values;
}

Values::Values(const quoin_law& law, const Settings& settings) {
  for (const auto& [id, text] : settings) {
    const quoin_property_info* property = find_property(law, id);
    ids.push_back(id);
    texts.push_back(text);
    std::vector<double> list;
    if (property == nullptr || property->kind != QUOIN_PROPERTY_CHOICE) {
      for (const char* c = text.c_str(); *c != 0;) {
        char* end = nullptr;
        list.push_back(std::strtod(c, &end));
        if (end == c) break;
        c = *end == 0 ? end : end + 1;
      }
    }
    numbers.push_back(list);
  }
  for (size_t i = 0; i < ids.size(); ++i) {
    const bool numeric = !numbers[i].empty();
    values.push_back({sizeof(quoin_property_value), ids[i].c_str(), numbers[i].size(),
                      numeric ? numbers[i].data() : nullptr, numeric ? nullptr : texts[i].c_str()});
  }
  for (const quoin_property_value& value : values) pointers.push_back(&value);
}

Material::Material(const quoin_law& law, const Settings& from) : settings(from), law_(law) {
  const Values values(law, from);
  Text text;
  status = law.create_material(&law, values.pointers.size(), values.pointers.data(), &handle, &text.text);
  message = text.str();
}

Material::~Material() {
  if (handle != nullptr) law_.destroy_material(handle);
}

Material::Material(Material&& other) noexcept
    : handle(other.handle), status(other.status), message(other.message), settings(other.settings), law_(other.law_) {
  other.handle = nullptr;
}

double Material::number(const char* id) const {
  double value = std::numeric_limits<double>::quiet_NaN();
  law_.material_number(handle, id, &value);
  return value;
}

Settings base_settings(const quoin_law& law, const Settings& given) {
  Settings settings = given;
  for (const quoin_property_info* number : numbers_of(law)) {
    const quoin_property_info& property = *number;
    if (!(property.flags & QUOIN_PROPERTY_REQUIRED) || given.count(property.id)) continue;
    static const std::map<std::string, double> usual = {{"Pa/m", 4e10}, {"Pa", 3e5}, {"deg", 30},
                                                        {"J/m2", 100},  {"-", 0.5},  {"m", 1e-3}};
    const auto found = usual.find(property.unit);
    double value = found == usual.end() ? 1.0 : found->second;
    if (!(value >= property.lower && value <= property.upper)) {
      value = std::isinf(property.lower)   ? property.upper - 1
              : std::isinf(property.upper) ? property.lower + 1
                                           : (property.lower + property.upper) / 2;
    }
    settings[property.id] = shortest(value);
  }
  return settings;
}

std::vector<Settings> varied_settings(const quoin_law& law, const Settings& base) {
  std::vector<Settings> all = {base};
  std::mt19937_64 random(7);
  const bool warned = !Material(law, base).message.empty();
  for (int attempt = 0; attempt < 40 && all.size() < 3; ++attempt) {
    Settings varied = base;
    for (const quoin_property_info* property : numbers_of(law)) {
      const auto set = varied.find(property->id);
      if (set == varied.end()) continue;  // the property has its default
      const double value = std::strtod(set->second.c_str(), nullptr);
      const double other = value * std::exp(uniform(random, -0.3, 0.3));
      if (std::isfinite(other) && other > property->lower && other < property->upper) set->second = shortest(other);
    }
    const Material material(law, varied);
    if (varied != base && material.handle != nullptr && (warned || material.message.empty())) all.push_back(varied);
  }
  return all;
}

Points Points::take(const std::vector<size_t>& indices) const {
  const auto pick = [&](const std::vector<double>& from) {
    std::vector<double> to;
    for (const size_t i : indices) to.push_back(from[i]);
    return to;
  };
  Points out;
  out.normal_jump = pick(normal_jump);
  for (size_t k = 0; k < 2; ++k) out.slip[k] = pick(slip[k]);
  for (size_t k = 0; k < 3; ++k) out.traction[k] = pick(traction[k]);
  for (const auto& column : state) out.state.push_back(pick(column));
  return out;
}

Result Result::take(const std::vector<size_t>& indices) const {
  const auto pick = [&](const auto& from) {
    std::remove_cvref_t<decltype(from)> to;
    if (from.empty()) return to;
    for (const size_t i : indices) to.push_back(from[i]);
    return to;
  };
  Result out;
  for (size_t k = 0; k < 3; ++k) out.traction[k] = pick(traction[k]);
  for (const auto& column : state) out.state.push_back(pick(column));
  out.stored = pick(stored);
  for (size_t k = 0; k < dissipated.size(); ++k) out.dissipated[k] = pick(dissipated[k]);
  for (size_t k = 0; k < 9; ++k) out.tangent[k] = pick(tangent[k]);
  for (size_t k = 0; k < damage.size(); ++k) out.damage[k] = pick(damage[k]);
  out.flags = pick(flags);
  out.point_status = pick(point_status);
  return out;
}

double Result::dissipation(size_t i) const {
  double sum = 0;
  for (const auto& mode : dissipated) sum += mode.empty() ? 0.0 : mode[i];
  return sum;
}

Points points_at(const quoin_law& law, const Material& material, size_t count, const char* initial_state) {
  std::vector<double> values(law.state_count + 1);
  law.initial_state(material.handle, initial_state != nullptr ? initial_state : law.initial_states[0], values.data());
  Points points;
  points.normal_jump.assign(count, 0.0);
  for (auto& column : points.slip) column.assign(count, 0.0);
  for (auto& column : points.traction) column.assign(count, 0.0);
  for (uint64_t s = 0; s < law.state_count; ++s) points.state.emplace_back(count, values[s]);
  return points;
}

Result unwritten(const quoin_law& law, size_t count, double value) {
  Result result;
  for (auto& column : result.traction) column.assign(count, value);
  result.state.assign(law.state_count, std::vector<double>(count, value));
  return result;
}

Columns::Columns(const quoin_law& law) : state_old(law.state_count), state_new(law.state_count) {
  batch.struct_size = sizeof batch;
  batch.state_old = state_old.data();
  batch.state_new = state_new.data();
}

Columns::Columns(const quoin_law& law, const Points& points, Result& result) : Columns(law) {
  read(points);
  write(result.traction, result.state);
}

void Columns::read(const Points& points) {
  batch.count = points.size();
  batch.normal_jump = {points.normal_jump.data(), 1};
  for (size_t k = 0; k < 2; ++k) batch.slip_increment[k] = {points.slip[k].data(), 1};
  for (size_t k = 0; k < 3; ++k) batch.traction_old[k] = {points.traction[k].data(), 1};
  for (size_t s = 0; s < state_old.size(); ++s) state_old[s] = {points.state[s].data(), 1};
}

void Columns::write(std::array<std::vector<double>, 3>& traction, std::vector<std::vector<double>>& state) {
  for (size_t k = 0; k < 3; ++k) batch.traction_new[k] = {traction[k].data(), 1};
  for (size_t s = 0; s < state_new.size(); ++s) state_new[s] = {state[s].data(), 1};
}

Result evaluate(const quoin_law& law, const Material& material, const Points& points, unsigned wanted) {
  const size_t n = points.size();
  Result result = unwritten(law, n);
  Columns columns(law, points, result);
  quoin_batch& batch = columns.batch;
  const auto column = [&](std::vector<double>& data) {
    data.assign(n, std::numeric_limits<double>::quiet_NaN());
    return quoin_out{data.data(), 1};
  };
  if ((wanted & kEnergy) && (law.capabilities & QUOIN_CAN_ENERGY)) {
    batch.energy_stored = column(result.stored);
    for (size_t k = 0; k < result.dissipated.size(); ++k) batch.dissipated[k] = column(result.dissipated[k]);
  }
  if ((wanted & kTangent) && (law.capabilities & QUOIN_CAN_TANGENT)) {
    for (size_t k = 0; k < 9; ++k) batch.tangent[k] = column(result.tangent[k]);
  }
  if ((wanted & kDamage) && (law.capabilities & QUOIN_CAN_DAMAGE)) {
    for (size_t k = 0; k < result.damage.size(); ++k) batch.damage[k] = column(result.damage[k]);
  }
  if ((wanted & kFlags) && (law.capabilities & QUOIN_CAN_FLAGS)) {
    result.flags.assign(n, 0xdeadbeefu);
    batch.flags = {result.flags.data(), 1};
  }
  if (wanted & kStatus) {
    result.point_status.assign(n, 0xdeadbeefu);
    batch.status = {result.point_status.data(), 1};
  }
  batch.clamped_count = batch.failed_count = 77;
  batch.worst_status = batch.any_yielding = 77;
  alarm(law_seconds);
  result.status = law.evaluate(material.handle, &batch);
  result.clamped = batch.clamped_count;
  result.failed = batch.failed_count;
  result.worst = batch.worst_status;
  result.any_yielding = batch.any_yielding;
  return result;
}

namespace {

template <class T>
std::string compare(const std::string& name, const std::vector<T>& a, const std::vector<T>& b) {
  if (a.empty() || b.empty()) return "";
  for (size_t i = 0; i < std::min(a.size(), b.size()); ++i) {
    if (std::memcmp(&a[i], &b[i], sizeof(T)) != 0) {
      return name + " of point " + std::to_string(i) + ": " + shortest(static_cast<double>(a[i])) + " against " +
             shortest(static_cast<double>(b[i]));
    }
  }
  return "";
}

}  // namespace

std::string difference(const quoin_law& law, const Result& a, const Result& b) {
  if (a.status != b.status) return "return values differ";
  static const char* const tractions[3] = {"sigma", "tau_s", "tau_t"};
  std::string text;
  for (size_t k = 0; k < 3 && text.empty(); ++k) text = compare(tractions[k], a.traction[k], b.traction[k]);
  for (size_t s = 0; s < a.state.size() && text.empty(); ++s) {
    text = compare(law.states[s]->id, a.state[s], b.state[s]);
  }
  if (text.empty()) text = compare("energy_stored", a.stored, b.stored);
  for (size_t k = 0; k < a.dissipated.size() && text.empty(); ++k) {
    text = compare("dissipated[" + std::to_string(k) + "]", a.dissipated[k], b.dissipated[k]);
  }
  for (size_t k = 0; k < 9 && text.empty(); ++k) {
    text = compare("tangent[" + std::to_string(k) + "]", a.tangent[k], b.tangent[k]);
  }
  for (size_t k = 0; k < a.damage.size() && text.empty(); ++k) {
    text = compare("damage[" + std::to_string(k) + "]", a.damage[k], b.damage[k]);
  }
  if (text.empty()) text = compare("flags", a.flags, b.flags);
  if (text.empty()) text = compare("status", a.point_status, b.point_status);
  return text;
}

Scales::Scales(const quoin_law& law, const Material& material) {
  quoin_stiffness_bounds bounds = {sizeof bounds, 0, 0};
  law.stiffness_bounds(material.handle, &bounds);
  normal_stiffness = bounds.normal > 0 && std::isfinite(bounds.normal) ? bounds.normal : 1e10;
  shear_stiffness = bounds.shear > 0 && std::isfinite(bounds.shear) ? bounds.shear : 1e10;
  for (const quoin_property_info* property : numbers_of(law)) {
    const double value = material.number(property->id);
    if (!(value > 0) || !std::isfinite(value)) continue;
    if (std::strcmp(property->unit, "Pa") == 0) strengths.push_back(value);
    if (std::strcmp(property->unit, "J/m2") == 0) energies.push_back(value);
  }
  if (strengths.empty()) strengths.push_back(1e5);
  traction = *std::max_element(strengths.begin(), strengths.end());
  if (!energies.empty()) short_slip = std::max(1e-6, *std::min_element(energies.begin(), energies.end()) / traction);
  // A smaller energy than any strength stores is that of a mode without strength. Its legs would be as short as
  // rounding.
  const double least_strength = *std::min_element(strengths.begin(), strengths.end());
  const double least_stored = least_strength * least_strength / (2 * std::max(normal_stiffness, shear_stiffness));
  std::erase_if(energies, [&](double energy) { return energy < least_stored; });
}

namespace {

double pick(std::mt19937_64& random, const std::vector<double>& from) { return from[random() % from.size()]; }

}  // namespace

double Scales::opening(std::mt19937_64& random) const {
  if (energies.empty() || uniform(random) < 0.4)
    return uniform(random, 0, 3) * pick(random, strengths) / normal_stiffness;
  return uniform(random, 0, 1.5) * pick(random, energies) / pick(random, strengths);
}

double Scales::closing(std::mt19937_64& random) const {
  if (energies.empty() || uniform(random) < 0.8)
    return -uniform(random, 0, 3) * pick(random, strengths) / normal_stiffness;
  return -uniform(random, 0, 1) * pick(random, energies) / traction;
}

double Scales::sliding(std::mt19937_64& random) const {
  if (energies.empty() || uniform(random) < 0.4)
    return uniform(random, 0, 4) * pick(random, strengths) / shear_stiffness;
  return uniform(random, 0, 1.5) * pick(random, energies) / pick(random, strengths);
}

Walk::Walk(const quoin_law& law, const Material& material, size_t count, uint64_t seed, int steps_per_leg,
           const char* initial_state, Reach reach)
    : points(points_at(law, material, count, initial_state)),
      normal_before(count, 0.0),
      scales_(law, material),
      reach_(reach),
      steps_per_leg_(steps_per_leg),
      random_(seed),
      drawn_(count),
      numbers_(count),
      increment_(count) {
  std::iota(numbers_.begin(), numbers_.end(), size_t{0});
}

void Walk::keep(const std::vector<size_t>& which) {
  points = points.take(which);
  numbers_ = which;
  normal_before.resize(which.size());
  increment_.resize(which.size());
}

Walk::Leg Walk::draw_leg() {
  // Lengths of every magnitude up to this one.
  const auto up_to = [&](double most) { return most * std::pow(10.0, uniform(random_, -4, 0)); };
  const bool far = reach_ == Reach::far, opens = uniform(random_) < 0.5;
  const double target = opens ? far ? up_to(kFarOpening) : scales_.opening(random_)
                        : far ? -up_to(kFarPressure / scales_.normal_stiffness)
                              : scales_.closing(random_);
  const double length = far ? up_to(kFarSlip) : scales_.sliding(random_);
  const double angle = uniform(random_, 0, 6.283185307179586);
  const double kind = uniform(random_);  // a fifth of the legs only open or close, a fifth only slide
  return {kind < 0.2 ? std::numeric_limits<double>::quiet_NaN() : target,
          {kind > 0.8 ? 0.0 : length * std::cos(angle), kind > 0.8 ? 0.0 : length * std::sin(angle)}};
}

void Walk::begin_legs() {
  for (size_t number = 0, i = 0; number < drawn_; ++number) {
    const Leg leg = draw_leg();
    if (i == numbers_.size() || number != numbers_[i]) continue;
    const double change = std::isnan(leg.target) ? 0.0 : leg.target - points.normal_jump[i];
    increment_[i++] = {change / steps_per_leg_, leg.slip[0] / steps_per_leg_, leg.slip[1] / steps_per_leg_};
  }
}

void Walk::aim() {
  if (step_ % steps_per_leg_ == 0) begin_legs();
  for (size_t i = 0; i < points.size(); ++i) {
    normal_before[i] = points.normal_jump[i];
    points.normal_jump[i] += increment_[i][0];
    points.slip[0][i] = increment_[i][1];
    points.slip[1][i] = increment_[i][2];
  }
  ++step_;
}

void Walk::advance(const Result& result) {
  points.traction = result.traction;
  points.state = result.state;
}

Points scattered_points(const quoin_law& law, const Material& material, size_t count, uint64_t seed) {
  Walk walk(law, material, count, seed, 5);
  Points points = walk.points;
  for (int step = 0; step < 30; ++step) {
    walk.aim();
    // Each point gets the inputs of one step of its path.
    for (size_t i = 0; i < count; ++i) {
      if (static_cast<int>(i * 7 % 30) != step) continue;
      points.normal_jump[i] = walk.points.normal_jump[i];
      for (size_t k = 0; k < 2; ++k) points.slip[k][i] = walk.points.slip[k][i];
      for (size_t k = 0; k < 3; ++k) points.traction[k][i] = walk.points.traction[k][i];
      for (size_t s = 0; s < points.state.size(); ++s) points.state[s][i] = walk.points.state[s][i];
    }
    walk.advance(evaluate(law, material, walk.points));
  }
  return points;
}

}  // namespace check
