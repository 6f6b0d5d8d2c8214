#include "scene/read_tables.h"

namespace quoin {

using namespace reader;

namespace {

void read_joints(Table& t, const Scene& scene, Damage& damage) {
  const std::vector<std::string> names = names_of(scene.joints);
  const std::string allowed = "a name among [joints.*], or a list of them: " + join(names);
  const toml::node* node = t.find("joints", allowed, false);
  if (!node) return;
  const auto add = [&](const toml::node& given) {
    const auto word = given.value<std::string>();
    if (!given.is_string())
      t.wrong_type("joints", allowed);
    else if (!scene.joints.contains(*word))
      t.refuse("joints", allowed + did_you_mean(*word, names));
    else
      damage.joints.push_back(*word);
  };
  const toml::array* list = node->as_array();
  if (!list) return add(*node);
  if (list->empty()) t.refuse("joints", allowed);
  for (const toml::node& element : *list) add(element);
}

void read_crack(Table& t, Damage& damage) {
  t.line("crack", damage.crack, kAny,
         "a list of 2 or more points [along the wall, up], numbers in m, no two in a row the same");
  t.choice("along", damage.crack_along, {{"x", 0}, {"z", 2}});
  t.boolean("through_units", damage.through_units);
  if (t.has("through_units") && !t.has("crack"))
    t.refuse("through_units", "only with a crack; give crack, or remove it");
  if (t.has("along") && !t.has("crack") && !t.has("slip"))
    t.refuse("along", "only with a crack or slip; give one of them, or remove it");
}

void read_state(Table& t, Damage& damage) {
  double xi = 0.0;
  if (t.number("xi", xi, kNotNegative, "(internal variable of softening)")) damage.xi = xi;
  t.within("state", "a table of the law's states, as { w = 1e-4 }", [&](Table& s) {
    for (auto&& [key, node] : s.toml()) {
      const std::string id(key.str());
      s.number(id, damage.state[id], kAny, "in the unit of the law's state");
    }
  });
}

}  // namespace

Damage read_damage(Table& t, const Scene& scene) {
  Damage damage;
  damage.source = {t.where()};
  read_joints(t, scene, damage);
  t.numbers("from", damage.from, kAny, "m (lowest corner of a box)");
  t.numbers("to", damage.to, kAny, "m (highest corner of a box)");
  for (std::size_t k = 0; k < 3; ++k) {
    if (damage.from[k] > damage.to[k]) {
      t.refuse(t.has("to") ? "to" : "from", "not below from");
      break;
    }
  }
  read_crack(t, damage);
  t.text("initial_state", damage.initial_state, "an initial state of the law, as dry");
  read_state(t, damage);
  t.number("slip", damage.slip, kNotNegative, "m");
  t.number("opening", damage.opening, kNotNegative, "m");
  if (!t.has("initial_state") && !t.has("xi") && !t.has("state") && !t.has("slip")) damage.initial_state = "dry";
  return damage;
}

}  // namespace quoin
