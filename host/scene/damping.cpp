#include "scene/damping.h"

#include <algorithm>

#include "scene/reader.h"

namespace quoin {

using reader::Table;

namespace {

using Settings = DampingSettings;

struct Key {
  const char* name;
  std::variant<double Settings::*, std::optional<double> Settings::*, bool Settings::*,
               std::array<double, 2> Settings::*>
      member;
  reader::Range range;  // of numbers
  const char* unit;
  const char* in_summary;
};

const Key kKeys[] = {
    {"local_damping", &Settings::local_damping, reader::between(0, 0.99), "(gamma of eq. 1)", "local_damping"},
    {"settling_damping", &Settings::settling_damping, reader::between(0, 0.99),
     "(gamma of stages that run to equilibrium)", "settling_damping"},
    {"deformation_damping", &Settings::deformation_damping, reader::between(0, 1), "(damping ratio at omega_max)",
     "deformation_damping"},
    {"mass_damping", &Settings::mass_damping, reader::kNotNegative, "1/s", "mass_damping_per_s"},
    {"stiffness_damping", &Settings::stiffness_damping, reader::kNotNegative, "s", "stiffness_damping_s"},
    {"impact_damping", &Settings::impact_damping, reader::between(0, 2),
     "(of critical, of a block that lands on an edge)", "impact_damping"},
    {"maxwell_damping", &Settings::maxwell_damping, reader::between(0, 0.05), "(damping ratio within maxwell_band)",
     "maxwell_damping"},
    {"implicit_contacts", &Settings::implicit_contacts, {}, "", "implicit_contacts"},
    {"maxwell_band", &Settings::maxwell_band, reader::kPositive, "Hz (lowest and highest frequency)",
     "maxwell_band_Hz"},
};

// One kind of damping. gamma, of eq. 1, is that of the stage.
struct Kind {
  std::string name;
  std::vector<std::string> keys;
  std::string (*text)(const Settings&, double gamma);  // what follows the name in messages
  Damping (*terms)(const Settings&, double gamma);
  void (*check)(Table&, const Settings&) = nullptr;  // checks keys against each other
};

std::string impact_text(const Settings& s, double) {
  std::string text = fmt::format(" {:g} of critical on closed contacts", s.impact_damping);
  if (s.maxwell_damping > 0.0)
    text += fmt::format(", Maxwell {:g} from {:g} to {:g} Hz", s.maxwell_damping, s.maxwell_band[0], s.maxwell_band[1]);
  return text + (s.implicit_contacts ? ", joints implicit while blocks are on the lattice" : "");
}

void check_impact(Table& t, const Settings& s) {
  if (t.has("implicit_contacts") && s.implicit_contacts && s.maxwell_damping > 0.0)
    t.refuse("implicit_contacts", "false with maxwell_damping, or that without this");
  if (!t.has("maxwell_band")) return;
  constexpr double kNarrowest = 10.0, kWidest = 100.0;  // limits between which three elements keep the ratio flat
  const double width = s.maxwell_band[1] / s.maxwell_band[0];
  if (!(width >= kNarrowest && width <= kWidest))
    t.refuse("maxwell_band",
             fmt::format("two frequencies, the second {:g} to {:g} times the first, Hz", kNarrowest, kWidest));
  if (s.maxwell_damping == 0.0) t.refuse("maxwell_band", "only with maxwell_damping; remove it, or give that");
}

// In the order of DampingKind.
const Kind kKinds[] = {
    {"none",
     {},
     [](const Settings&, double) { return std::string(); },
     [](const Settings&, double) { return Damping{}; }},
    {"local",
     {"local_damping", "settling_damping"},
     [](const Settings&, double gamma) { return fmt::format(" {:g}", gamma); },
     [](const Settings&, double gamma) { return Damping{.eq1 = Eq1::gridpoints, .gamma = gamma}; }},
    {"viscous",
     {"mass_damping", "stiffness_damping"},
     [](const Settings& s, double) {
       return fmt::format(", mass {:g} 1/s, stiffness {:g} s", s.mass_damping, s.stiffness_damping);
     },
     [](const Settings& s, double) { return Damping{.alpha = s.mass_damping, .beta = s.stiffness_damping}; }},
    {"block",
     {"local_damping", "settling_damping", "deformation_damping"},
     [](const Settings& s, double gamma) {
       return fmt::format(" {:g}, of deformation {:g}", gamma, s.deformation_damping);
     },
     [](const Settings& s, double gamma) {
       return Damping{.eq1 = Eq1::rigid_motion, .gamma = gamma, .zone_ratio = s.deformation_damping};
     }},
    {"impact",
     {"impact_damping", "maxwell_damping", "implicit_contacts", "maxwell_band"},
     impact_text,
     [](const Settings& s, double) {
       return Damping{.impacts = ImpactTerms{s.impact_damping, s.maxwell_damping, s.maxwell_band, s.implicit_contacts}};
     },
     check_impact},
};

const Kind& kind_of(const Settings& s) { return kKinds[static_cast<std::size_t>(s.damping)]; }

bool reads(const Kind& kind, const char* key) {
  return std::find(kind.keys.begin(), kind.keys.end(), key) != kind.keys.end();
}

double gamma_of(const Settings& s, bool settling) {
  return settling ? s.settling_damping.value_or(s.local_damping) : s.local_damping;
}

// Reads one key. Returns whether it requests damping.
bool read_key(Table& t, const Key& key, Settings& s) {
  if (const auto* number = std::get_if<double Settings::*>(&key.member))
    return t.number(key.name, s.**number, key.range, key.unit);
  if (const auto* number = std::get_if<std::optional<double> Settings::*>(&key.member))
    return t.number(key.name, s.**number, key.range, key.unit);
  if (const auto* flag = std::get_if<bool Settings::*>(&key.member)) return t.boolean(key.name, s.**flag) && s.**flag;
  return t.numbers(key.name, s.*std::get<std::array<double, 2> Settings::*>(key.member), key.range, key.unit);
}

std::string kinds_with(const char* key) {
  std::string text;
  for (const Kind& kind : kKinds) {
    if (reads(kind, key)) text += fmt::format("{}\"{}\"", text.empty() ? "" : " or ", kind.name);
  }
  return text;
}

}  // namespace

Damping damping_of(const Settings& settings, bool settling) {
  return kind_of(settings).terms(settings, gamma_of(settings, settling));
}

const std::vector<std::string>& damping_names() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> all;
    for (const Kind& kind : kKinds) all.push_back(kind.name);
    return all;
  }();
  return names;
}

const std::string& name_of(DampingKind kind) { return damping_names()[static_cast<std::size_t>(kind)]; }

std::string damping_text(const Settings& settings, bool settling) {
  const Kind& kind = kind_of(settings);
  return kind.name + kind.text(settings, gamma_of(settings, settling));
}

std::vector<DampingNumber> damping_numbers(const Settings& settings) {
  std::vector<DampingNumber> numbers;
  for (const Key& key : kKeys) {
    DampingNumber number{key.name, key.in_summary, 0.0, reads(kind_of(settings), key.name)};
    std::visit(
        [&](auto member) {
          if constexpr (std::is_same_v<decltype(member), std::optional<double> Settings::*>)
            number.value = gamma_of(settings, true);
          else
            number.value = settings.*member;
        },
        key.member);
    numbers.push_back(std::move(number));
  }
  return numbers;
}

namespace reader {

void read_damping_kind(Table& t, Settings& s) {
  std::string chosen;
  if (t.choice("damping", chosen, damping_names()))
    s.damping = static_cast<DampingKind>(std::find(damping_names().begin(), damping_names().end(), chosen) -
                                         damping_names().begin());
}

void read_damping(Table& t, Settings& s) {
  const Kind& kind = kind_of(s);
  for (const Key& key : kKeys) {
    if (read_key(t, key, s) && !reads(kind, key.name))
      t.refuse(key.name, fmt::format("only with damping = {}; remove it, or change damping", kinds_with(key.name)));
  }
  if (kind.check) kind.check(t, s);
}

}  // namespace reader

}  // namespace quoin
