#include "scene/read_tests.h"

namespace quoin {

using namespace reader;

namespace {

constexpr const char* kKey = "properties";
constexpr const char* kWord = "from_tests";

const Named<UnitKind> kUnits{{"aerated_concrete", UnitKind::aerated_concrete},
                             {"calcium_silicate", UnitKind::calcium_silicate},
                             {"clay", UnitKind::clay},
                             {"concrete", UnitKind::concrete},
                             {"hollow_clay", UnitKind::hollow_clay},
                             {"stone", UnitKind::stone}};
const Named<JointKind> kBeds{{"dry", JointKind::dry}, {"mortar", JointKind::mortar}, {"thin", JointKind::thin}};
const Named<JointKind> kHeads{{"dry", JointKind::dry},
                              {"mortar", JointKind::mortar},
                              {"thin", JointKind::thin},
                              {"unfilled", JointKind::unfilled}};

// Whether the table requests properties from tests. Removes that key.
bool asks(toml::table& table, const std::string& path, Context& context) {
  const toml::node* node = table.get(kKey);
  if (!node) return false;
  if (node->value<std::string>() != kWord)
    context.fault(fmt::format("{} = {}: allowed: \"{}\", with a table [tests]", context.where(node, path + "." + kKey),
                              text_of(*node), kWord));
  table.erase(kKey);
  return true;
}

void set_missing(toml::table& table, const char* key, double value) {
  if (!table.contains(key)) table.insert(key, value);
}

// Pressure of the first pressure stage, Pa.
double first_pressure(const toml::table& root) {
  const toml::array* stages = root["stage"].as_array();
  for (std::size_t i = 0; stages && i < stages->size(); ++i) {
    const toml::table* stage = stages->get(i)->as_table();
    if (stage && (*stage)["pressure"].is_number()) return (*stage)["pressure"].value_or(0.0);
  }
  return 0.0;
}

}  // namespace

TestedMasonry read_tests(Table t, double block_height, double axial_stress) {
  TestedMasonry tested;
  t.choice("unit", tested.unit, kUnits);
  t.choice("bed_joints", tested.bed, kBeds);
  tested.head = tested.bed;
  t.choice("head_joints", tested.head, kHeads);
  tested.block_height = block_height, tested.axial_stress = axial_stress;
  t.number("block_height", tested.block_height, kPositive, "m");
  t.number("axial_stress", tested.axial_stress, kNotNegative, "Pa");
  t.number("unit_strength", tested.unit_strength, kPositive, "Pa");
  t.number("unit_strength_normalised", tested.unit_strength_normalised, kPositive, "Pa");
  t.number("unit_modulus", tested.unit_modulus, kPositive, "Pa");
  t.number("mortar_strength", tested.mortar_strength, kPositive, "Pa");
  t.number("masonry_strength", tested.masonry_strength, kPositive, "Pa");
  t.number("masonry_modulus", tested.masonry_modulus, kPositive, "Pa");
  t.number("cohesion", tested.cohesion, kNotNegative, "Pa");
  t.number("friction", tested.friction, kPositive, "");
  if (tested.block_height == 0.0)
    t.context().fault(t.where() + ".block_height: missing; give the height of a unit with its joint, m");
  t.finish();
  return tested;
}

std::vector<std::pair<const char*, double>> joint_properties(const MasonryNumbers& numbers, const std::string& part,
                                                             const std::string& law) {
  const JointNumbers& j = part == "inside" ? numbers.inside_units : part == "head" ? numbers.head : numbers.bed;
  std::vector<std::pair<const char*, double>> properties{{"normal_stiffness", j.normal_stiffness},
                                                         {"shear_stiffness", j.shear_stiffness}};
  if (law == "elastic") return properties;
  properties.insert(
      properties.end(),
      {{"friction_angle", j.friction_angle}, {"tensile_strength", j.tensile_strength}, {"cohesion", j.cohesion}});
  if (law == "coulomb_slip") return properties;
  properties.insert(properties.end(),
                    {{"fracture_energy_tension", j.tension_energy}, {"fracture_energy_shear", j.shear_energy}});
  if (j.compressive_strength)
    properties.insert(properties.end(), {{"compressive_strength", *j.compressive_strength},
                                         {"fracture_energy_compression", j.compression_energy}});
  return properties;
}

// Properties from tests. If the tests are at fault, those of an arbitrary masonry, so that the rest of the scene is
// checked too.
MasonryNumbers numbers_of(const TestedMasonry& tested, Context& context) {
  if (!context.has_faults()) {
    try {
      return properties_of(tested);
    } catch (const Error& error) {
      context.fault(error.what());
    }
  }
  TestedMasonry some;
  some.block_height = 0.1, some.unit_strength = 1e7;  // m, Pa
  return properties_of(some);
}

std::vector<Derivation> fill_in_from_tests(toml::table& root, Context& context) {
  const toml::table* given = root["tests"].as_table();
  MasonryNumbers numbers;
  if (given) {
    const double height = root["wall"]["unit"][1].value_or(root["building"]["course_height"].value_or(0.0));
    const TestedMasonry tested = read_tests(Table(context, *given, "tests"), height, first_pressure(root));
    numbers = numbers_of(tested, context);
  }
  bool is_used = false;
  const auto each = [&](const char* kind, const auto& fill) {
    toml::table* all = root[kind].as_table();
    if (!all) return;
    for (auto&& [key, node] : *all) {
      toml::table* table = node.as_table();
      const std::string path = fmt::format("{}.{}", kind, key.str());
      if (!table || !asks(*table, path, context)) continue;
      if (!given)
        context.fault(fmt::format("{}: properties = \"{}\" without a table [tests]; add one, with what tests gave",
                                  context.where(table, path), kWord));
      else
        is_used = true, fill(*table, path);
    }
  };
  each("materials", [&](toml::table& m, const std::string&) {
    set_missing(m, "young_modulus", numbers.young_modulus);
    set_missing(m, "poisson_ratio", numbers.poisson_ratio);
    set_missing(m, "density", numbers.density);
  });
  each("joints", [&](toml::table& j, const std::string& path) {
    const toml::node* word = j.get("part");
    const std::string part = word ? word->value_or(std::string()) : "bed";
    if (part != "bed" && part != "head" && part != "inside")
      context.fault(fmt::format("{} = {}: allowed: \"bed\", \"head\", \"inside\"", context.where(word, path + ".part"),
                                text_of(*word)));
    j.erase("part");
    for (const auto& [id, value] : joint_properties(numbers, part, j["law"].value_or(std::string())))
      set_missing(j, id, value);
  });
  if (given && !is_used)
    context.fault(
        fmt::format("{}: no material and no joint has properties = \"{}\", so that this table does "
                    "nothing; add it to one, or remove [tests]",
                    context.where(given, "tests"), kWord));
  root.erase("tests");
  return numbers.derivation;
}

}  // namespace quoin
