// Materials of blocks and families of joints.
#include <cmath>

#include "scene/read_scatter.h"
#include "scene/reader.h"

namespace quoin::reader {

BlockMaterial read_material(const std::string& name, Table& t, bool rigid) {
  BlockMaterial m;
  m.name = name;
  t.number("young_modulus", m.young_modulus, kPositive, "Pa", !rigid);
  t.number("poisson_ratio", m.poisson_ratio, between(0, 0.49), "", !rigid);
  t.number("density", m.density, kDensity, "kg/m3", true);
  return m;
}

// Every key that is not the host's own is a property of the law. The law alone checks its value.
JointFamily read_joint(const std::string& name, Table& t) {
  JointFamily family;
  family.name = name;
  family.source = {t.where()};
  t.text("law", family.law, "the name of a law (see `quoin models`) or the path of a library", true);
  t.text("initial_state", family.initial_state, "an initial state of the law, as bonded or dry");
  family.initial_state_source = {t.has("initial_state") ? t.where("initial_state") : t.where() + ".initial_state"};
  t.number("missing_mortar", family.missing_mortar, between(0, 1), "(share of the joints)");
  for (auto&& [key, node] : t.toml()) {
    PropertySetting p;
    p.id = std::string(key.str());
    if (p.id == "law" || p.id == "initial_state" || p.id == "missing_mortar" || p.id == "correlation") continue;
    t.accept(p.id);
    p.source = {t.where(p.id)};
    const char* allowed = "a number (not nan), a list of numbers, a word, or a distribution";
    // Allowed values depend on the law; nan is never allowed.
    const auto add = [&](const toml::node& number) {
      const std::optional<double> value = number_of(number);
      if (!value)
        t.wrong_type(p.id, allowed);
      else if (std::isnan(*value))
        t.refuse(p.id, allowed);
      else
        p.numbers.push_back(*value);
    };
    if (node.is_number()) {
      add(node);
    } else if (const auto word = node.template value<std::string>()) {
      p.text = *word;
    } else if (const toml::table* table = node.as_table()) {
      p.scatter = read_scatter(Table(t.context(), *table, t.path(p.id)));
      if (p.scatter->distribution.fault().empty()) p.numbers = {random::Sampler(p.scatter->distribution).mean()};
    } else if (const toml::array* list = node.as_array()) {
      for (const toml::node& element : *list) {
        // Pairs may be written flat, [0, 1, 1, 0], or nested, [[0, 1], [1, 0]].
        const toml::array* pair = element.as_array();
        if (!pair) {
          add(element);
        } else if (pair->size() == 2) {
          for (const toml::node& number : *pair) add(number);
        } else {
          t.wrong_type(p.id, "a list of pairs, as [[0, 1], [0.3, 0.5], [1, 0]]");
        }
      }
    } else {
      t.wrong_type(p.id, allowed);
    }
    family.properties.push_back(std::move(p));
  }
  read_correlation(t, family);
  return family;
}

}  // namespace quoin::reader
