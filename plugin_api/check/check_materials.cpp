// C4: materials.
#include <malloc.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstring>
#include <iterator>

#include "checks.h"

namespace check {
namespace {

quoin_status create(const quoin_law& law, const Values& values, quoin_material** material, quoin_text* text) {
  return law.create_material(&law, values.pointers.size(), values.pointers.data(), material, text);
}

Settings with(Settings settings, const std::string& id, const std::string& value) {
  settings[id] = value;
  return settings;
}

void expect_refused(Report& report, const quoin_law& law, const Settings& settings, const std::string& what) {
  const Values values(law, settings);
  Text text;
  quoin_material* material = reinterpret_cast<quoin_material*>(&text);
  const quoin_status status = create(law, values, &material, &text.text);
  report.expect(status == QUOIN_ERROR_PROPERTY, "%s: returns %d, not QUOIN_ERROR_PROPERTY", what.c_str(), status);
  if (report.expect(material == nullptr || status == QUOIN_OK, "%s: *material is not null after an error",
                    what.c_str()) &&
      status == QUOIN_OK) {
    law.destroy_material(material);
  }
  report.expect(status == QUOIN_OK || !text.str().empty(), "%s: refused without a message", what.c_str());
}

// Finite values outside the bounds of a number.
std::vector<std::string> wrong_values(const quoin_property_info& number) {
  std::vector<std::string> texts;
  for (const double value : values_outside(number)) {
    if (std::isfinite(value)) texts.push_back(shortest(value));
  }
  return texts;
}

void check_accepted(Report& report, const Subject& subject) {
  report.clause("C4.1");
  for (const Settings& settings : subject.varied) {
    const Material material(subject.law, settings);
    report.expect(material.handle != nullptr && material.status == QUOIN_OK, "refused: %s", material.message.c_str());
    if (!material.message.empty()) report.note("warning of the law: %s", material.message.c_str());
  }
  if (subject.varied.size() < 2) report.note("no variation of the properties was accepted: one material is used");
}

void check_out_of_bounds(Report& report, const Subject& subject) {
  for (const quoin_property_info* number : numbers_of(subject.law)) {
    report.clause("C4.2");
    const std::string id = number->id;
    for (const std::string& value : wrong_values(*number)) {
      expect_refused(report, subject.law, with(subject.base, id, value), id + " = " + value);
    }
  }
}

// C4.3, and C2 on its long message.
void check_all_faults(Report& report, const Subject& subject) {
  const quoin_law& law = subject.law;
  report.clause("C4.3");
  Settings all_wrong = subject.base;
  std::vector<std::string> wrong_ids;
  for (const quoin_property_info* number : numbers_of(law)) {
    const std::vector<std::string> wrong = wrong_values(*number);
    if (wrong.empty()) continue;
    all_wrong[number->id] = wrong.front();
    wrong_ids.push_back(number->id);
  }
  if (wrong_ids.empty()) {
    report.skip("no property has a finite bound");
    return;
  }
  const Material refused(law, all_wrong);
  const std::string& message = refused.message;
  for (const std::string& id : wrong_ids) {
    report.expect(message.find(id) != std::string::npos, "%zu values are out of bounds, %s is not named in: %s",
                  wrong_ids.size(), id.c_str(), message.c_str());
    report.expect(message.find(all_wrong[id]) != std::string::npos, "the value %s of %s is not named in: %s",
                  all_wrong[id].c_str(), id.c_str(), message.c_str());
  }
  const Values values(law, all_wrong);
  check_text(report, "create_material", [&](quoin_text* text) {
    quoin_material* material = nullptr;
    return create(law, values, &material, text) == QUOIN_ERROR_PROPERTY;
  });
}

void check_wrong_numbers(Report& report, const Subject& subject) {
  const quoin_law& law = subject.law;
  for (const quoin_property_info* number : numbers_of(law)) {
    report.clause("C4.4");
    const std::string id = number->id;
    expect_refused(report, law, with(subject.base, id, "nan"), id + " = nan");
    if (!std::isinf(number->lower)) expect_refused(report, law, with(subject.base, id, "-inf"), id + " = -inf");
    if (number->flags & QUOIN_PROPERTY_REQUIRED) {
      Settings settings = subject.base;
      settings.erase(id);
      expect_refused(report, law, settings, id + " missing");
    }
  }
}

// C4.4 of everything but numbers: properties that are unknown, given twice or of another kind, and choices.
void check_wrong_properties(Report& report, const Subject& subject) {
  const quoin_law& law = subject.law;
  report.clause("C4.4");
  const Settings unknown = with(subject.base, "no_such_property", "1");
  expect_refused(report, law, unknown, "no_such_property");
  report.expect(Material(law, unknown).message.find("no_such_property") != std::string::npos,
                "the unknown property is not named");
  for (const quoin_property_info* property : properties_of(law)) {
    if (property->kind != QUOIN_PROPERTY_CHOICE) continue;
    const std::string id = property->id;
    expect_refused(report, law, with(subject.base, id, "no_such_choice"), id + " = no_such_choice");
  }
  if (subject.base.empty()) return;
  Values twice(law, subject.base);
  twice.pointers.push_back(twice.pointers.front());
  quoin_material* material = nullptr;
  report.expect(create(law, twice, &material, nullptr) == QUOIN_ERROR_PROPERTY, "%s given twice is accepted",
                twice.ids.front().c_str());
  Values words(law, subject.base);
  for (quoin_property_value& value : words.values) {
    const quoin_property_info* property = find_property(law, value.id);
    if (property == nullptr || property->kind != QUOIN_PROPERTY_NUMBER) continue;
    value.number_count = 0;
    value.numbers = nullptr;
    value.text = "word";
    material = nullptr;
    report.expect(create(law, words, &material, nullptr) == QUOIN_ERROR_PROPERTY, "%s as text is accepted", value.id);
    break;
  }
}

void check_arguments(Report& report, const Subject& subject, const Material& base) {
  const quoin_law& law = subject.law;
  report.clause("C4.5");
  const Values values(law, subject.base);
  quoin_material* material = nullptr;
  report.expect(create(law, values, nullptr, nullptr) == QUOIN_OK, "validating without a material fails");
  if (!values.pointers.empty()) {
    report.expect(
        law.create_material(&law, values.pointers.size(), nullptr, &material, nullptr) == QUOIN_ERROR_ARGUMENT,
        "null values are accepted");
    Values cut(law, subject.base);
    cut.values.front().struct_size = 16;
    report.expect(create(law, cut, &material, nullptr) != QUOIN_OK, "a property value of 16 bytes is accepted");
    report.expect(material == nullptr, "*material is not null after an error");
  }
  double number = 0;
  std::vector<double> state(law.state_count + 1);
  quoin_stiffness_bounds bounds = {sizeof bounds, 0, 0};
  quoin_stiffness_bounds cut_bounds = {8, -1, -1};
  const char* some_property = law.property_count > 0 ? law.properties[0]->id : "normal_stiffness";
  report.expect(law.material_number(nullptr, some_property, &number) == QUOIN_ERROR_ARGUMENT &&
                    law.material_number(base.handle, nullptr, &number) == QUOIN_ERROR_ARGUMENT,
                "material_number with a null argument");
  report.expect(law.initial_state(nullptr, law.initial_states[0], state.data()) == QUOIN_ERROR_ARGUMENT &&
                    law.initial_state(base.handle, nullptr, state.data()) == QUOIN_ERROR_ARGUMENT,
                "initial_state with a null argument");
  report.expect(law.stiffness_bounds(nullptr, &bounds) == QUOIN_ERROR_ARGUMENT &&
                    law.stiffness_bounds(base.handle, nullptr) == QUOIN_ERROR_ARGUMENT,
                "stiffness_bounds with a null argument");
  report.expect(law.stiffness_bounds(base.handle, &cut_bounds) == QUOIN_ERROR_ARGUMENT && cut_bounds.normal == -1,
                "quoin_stiffness_bounds of 8 bytes");
}

void check_values_in_force(Report& report, const Subject& subject, const Material& base) {
  report.clause("C4.6");
  double number = 0;
  report.expect(subject.law.material_number(base.handle, "no_such_property", &number) == QUOIN_ERROR_ARGUMENT,
                "material_number of an unknown property");
  for (const quoin_property_info* property : numbers_of(subject.law)) {
    const auto set = subject.base.find(property->id);
    const double seen = base.number(property->id);
    if (set != subject.base.end()) {
      const double given = std::strtod(set->second.c_str(), nullptr);
      report.expect(seen == given, "%s: %s was given, %s is in force", property->id, set->second.c_str(),
                    shortest(seen).c_str());
    } else if (property->default_from != nullptr) {
      report.expect(seen == base.number(property->default_from), "%s: %s is in force, not the value of %s",
                    property->id, shortest(seen).c_str(), property->default_from);
    } else {
      report.expect(seen == property->default_value, "%s: default %s, %s is in force", property->id,
                    shortest(property->default_value).c_str(), shortest(seen).c_str());
    }
  }
}

void check_order_and_pointers(Report& report, const Subject& subject, const Material& base) {
  const quoin_law& law = subject.law;
  report.clause("C4.7");
  const Points points = scattered_points(law, base, 50, 11);
  const Result expected = evaluate(law, base, points);
  Settings all = subject.base;  // defaults too, so that there is an order
  for (const quoin_property_info* number : numbers_of(law)) {
    if (const double value = base.number(number->id); std::isfinite(value)) all.emplace(number->id, shortest(value));
  }
  Values reversed(law, all);
  std::reverse(reversed.pointers.begin(), reversed.pointers.end());
  quoin_material* other = nullptr;
  report.expect(create(law, reversed, &other, nullptr) == QUOIN_OK, "refused in another order");
  for (auto& list : reversed.numbers) std::fill(list.begin(), list.end(), -1e300);  // the law keeps no pointers
  for (auto& text : reversed.texts) std::fill(text.begin(), text.end(), '#');
  for (auto& id : reversed.ids) std::fill(id.begin(), id.end(), '#');
  for (auto& value : reversed.values) value = {};
  if (other == nullptr) return;
  Material kept(law, subject.base);
  std::swap(kept.handle, other);
  expect_same(report, law, expected, evaluate(law, kept, points), "after the caller reused its memory");
  law.destroy_material(other);
}

void check_freed(Report& report, const Subject& subject) {
  const quoin_law& law = subject.law;
  report.clause("C4.8");
  law.destroy_material(nullptr);
  const Values values(law, subject.base);
  const auto churn = [&] {
    for (int i = 0; i < 2000; ++i) {
      quoin_material* one = nullptr;
      create(law, values, &one, nullptr);
      law.destroy_material(one);
    }
  };
  churn();
  const size_t before = mallinfo2().uordblks;
  churn();
  const size_t after = mallinfo2().uordblks;
  report.expect(after < before + 8000, "%zu bytes are left behind by 2000 materials", after - before);
}

// Strengths that the bounds allow to be zero.
std::vector<std::string> optional_strengths(const quoin_law& law) {
  std::vector<std::string> ids;
  for (const quoin_property_info* number : numbers_of(law)) {
    const bool open = number->flags & QUOIN_PROPERTY_LOWER_OPEN;
    if (std::strcmp(number->unit, "Pa") == 0 && number->lower <= 0 && number->upper >= 0 &&
        !(number->lower == 0 && open)) {
      ids.push_back(number->id);
    }
  }
  return ids;
}

}  // namespace

void check_materials(Report& report, const Subject& subject) {
  check_accepted(report, subject);
  check_out_of_bounds(report, subject);
  check_wrong_numbers(report, subject);
  check_all_faults(report, subject);
  check_wrong_properties(report, subject);
  const Material base(subject.law, subject.base);
  check_arguments(report, subject, base);
  check_values_in_force(report, subject, base);
  check_order_and_pointers(report, subject, base);
  check_freed(report, subject);
}

namespace {

// Whether a text has the id of a property as a whole word.
bool names(const std::string& text, const std::string& id) {
  const auto of_word = [&](size_t at) { return at < text.size() && (std::isalnum(text[at]) || text[at] == '_'); };
  for (size_t at = text.find(id); at != std::string::npos; at = text.find(id, at + 1)) {
    if (!of_word(at - 1) && !of_word(at + id.size())) return true;
  }
  return false;
}

// A set with strengths of zero.
struct ZeroCase {
  Settings settings;
  std::vector<std::string> zero;  // ids
};
ZeroCase with_zeros(Settings settings, const std::vector<std::string>& zero) {
  for (const std::string& id : zero) settings[id] = "0";
  return {settings, zero};
}

// Whether the law refuses the combination (C4.1), not the zero. Then the text names a property that is not zero, and
// the law accepts the zeros beside the defaults of the other properties.
bool refuses_the_combination(const quoin_law& law, const Material& refused, const ZeroCase& tried,
                             const Settings& alone) {
  const bool names_another = std::ranges::any_of(properties_of(law), [&](const quoin_property_info* property) {
    return std::ranges::count(tried.zero, property->id) == 0 && names(refused.message, property->id);
  });
  return refused.status == QUOIN_ERROR_PROPERTY && names_another && Material(law, alone).handle != nullptr;
}

void walk_without_strength(Report& report, const quoin_law& law, const Material& material, const std::string& what) {
  Walk walk(law, material, 50, 21, 20);
  for (int step = 0; step < 160; ++step) {
    walk.aim();
    const Result result = evaluate(law, material, walk.points);
    for (size_t i = 0; i < walk.points.size(); ++i) {
      bool finite = std::isfinite(result.dissipation(i)) && result.point_status[i] != QUOIN_POINT_FAILED;
      for (const auto& column : result.traction) finite = finite && std::isfinite(column[i]);
      for (const auto& column : result.state) finite = finite && std::isfinite(column[i]);
      report.expect(finite, "%sfails or is not finite at d_n = %g", what.c_str(), walk.points.normal_jump[i]);
    }
    walk.advance(result);
  }
}

}  // namespace

void check_zero_strengths(Report& report, const Subject& subject) {
  const quoin_law& law = subject.law;
  const std::vector<std::string> strengths = optional_strengths(law);
  report.clause("C4.9");
  if (strengths.empty()) {
    report.skip("no strength may be zero");
    return;
  }
  std::vector<ZeroCase> cases;
  for (const std::string& id : strengths) {
    std::vector<std::string> zero;
    std::ranges::copy_if(strengths, std::back_inserter(zero),
                         [&](const std::string& other) { return other.starts_with(id); });  // with its residual value
    cases.push_back(with_zeros(subject.base, zero));
  }
  cases.push_back(with_zeros(subject.base, strengths));
  for (const ZeroCase& tried : cases) {
    std::string what;
    for (const std::string& id : tried.zero) what += id + "=0 ";
    const Material whole(law, tried.settings);
    const Settings alone = with_zeros(base_settings(law, {}), tried.zero).settings;
    const bool combination = whole.handle == nullptr && refuses_the_combination(law, whole, tried, alone);
    if (combination)
      report.note("%srefused with the other values, and checked alone: %s", what.c_str(), whole.message.c_str());
    if (report.expect(whole.handle != nullptr || combination, "%srefused: %s", what.c_str(), whole.message.c_str())) {
      walk_without_strength(report, law, combination ? Material(law, alone) : Material(law, tried.settings), what);
    }
  }
}

}  // namespace check
