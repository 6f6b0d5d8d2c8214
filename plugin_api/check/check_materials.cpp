// C4: materials; C2 for the messages of materials.
#include <malloc.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "checks.h"

namespace check {
namespace {

constexpr char kGuard = 0x5a;

bool is_number(const quoin_property_info& property) { return property.kind == QUOIN_PROPERTY_NUMBER; }

quoin_status create(const quoin_law& law, const Values& values, quoin_material** material, quoin_text* text) {
  return law.create_material(&law, values.pointers.size(), values.pointers.data(), material, text);
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

void check_messages(Report& report, const quoin_law& law, const Settings& wrong) {
  const Values values(law, wrong);
  Text whole;
  quoin_material* material = nullptr;
  create(law, values, &material, &whole.text);
  const std::string message = whole.str();
  report.clause("C2.1");
  report.expect(create(law, values, &material, nullptr) == QUOIN_ERROR_PROPERTY, "refusal with null text");
  for (const size_t capacity : {0u, 1u, 2u, 7u, 40u, 100u}) {
    std::vector<char> bytes(capacity + 16384, kGuard);
    quoin_text text = {sizeof text, bytes.data() + 8192, capacity, 12345};
    create(law, values, &material, &text);
    report.clause("C2.2");
    const auto guarded = [](char c) { return c == kGuard; };
    report.expect(std::all_of(bytes.begin(), bytes.begin() + 8192, guarded) &&
                      std::all_of(bytes.begin() + 8192 + static_cast<long>(capacity), bytes.end(), guarded),
                  "create_material: bytes outside a buffer of %zu were written", capacity);
    report.expect(capacity == 0 || std::memchr(text.data, 0, capacity) != nullptr,
                  "create_material: no final zero in a buffer of %zu", capacity);
    report.clause("C2.3");
    report.expect(text.length == message.size(), "create_material: length %llu with capacity %zu, the message has %zu",
                  static_cast<unsigned long long>(text.length), capacity, message.size());
  }
  report.clause("C2.4");
  char small[64];
  std::memset(small, kGuard, sizeof small);
  quoin_text cut = {24, small, sizeof small, 12345};
  create(law, values, &material, &cut);
  report.expect(cut.length == 12345 && small[0] == kGuard, "create_material: a quoin_text of 24 bytes was written to");
}

}  // namespace

void check_materials(Report& report, const Subject& subject) {
  const quoin_law& law = subject.law;
  report.clause("C4.1");
  for (const Settings& settings : subject.varied) {
    const Material material(law, settings);
    report.expect(material.handle != nullptr && material.status == QUOIN_OK, "refused: %s", material.message.c_str());
    if (!material.message.empty()) report.note("warning of the law: %s", material.message.c_str());
  }
  if (subject.varied.size() < 2) report.note("no variation of the properties was accepted: one material is used");

  // Values outside their bounds, one property at a time and all at once.
  Settings all_wrong = subject.base;
  std::vector<std::string> wrong_ids;
  for (uint64_t p = 0; p < law.property_count; ++p) {
    const quoin_property_info& property = *law.properties[p];
    if (!is_number(property)) continue;
    report.clause("C4.2");
    std::vector<double> bad;
    if (std::isfinite(property.lower)) {
      bad.push_back(property.lower - 7);
      if (property.flags & QUOIN_PROPERTY_LOWER_OPEN) bad.push_back(property.lower);
    }
    if (std::isfinite(property.upper)) {
      bad.push_back(property.upper + 7);
      if (property.flags & QUOIN_PROPERTY_UPPER_OPEN) bad.push_back(property.upper);
    }
    for (const double value : bad) {
      Settings settings = subject.base;
      settings[property.id] = shortest(value);
      expect_refused(report, law, settings, std::string(property.id) + " = " + shortest(value));
    }
    if (!bad.empty()) {
      all_wrong[property.id] = shortest(bad.front());
      wrong_ids.push_back(property.id);
    }
    report.clause("C4.4");
    for (const char* value : {"nan", "-inf"}) {
      if (value[0] == '-' && std::isinf(property.lower)) continue;
      Settings settings = subject.base;
      settings[property.id] = value;
      expect_refused(report, law, settings, std::string(property.id) + " = " + value);
    }
    if (property.flags & QUOIN_PROPERTY_REQUIRED) {
      Settings settings = subject.base;
      settings.erase(property.id);
      expect_refused(report, law, settings, std::string(property.id) + " missing");
    }
  }
  report.clause("C4.3");
  if (wrong_ids.empty()) {
    report.skip("no property has a finite bound");
  } else {
    const Material refused(law, all_wrong);
    for (const std::string& id : wrong_ids) {
      const size_t where = refused.message.find(id);
      report.expect(where != std::string::npos, "%zu values are out of bounds, %s is not named in: %s",
                    wrong_ids.size(), id.c_str(), refused.message.c_str());
      report.expect(refused.message.find(all_wrong[id]) != std::string::npos, "the value %s of %s is not named in: %s",
                    all_wrong[id].c_str(), id.c_str(), refused.message.c_str());
    }
    check_messages(report, law, all_wrong);
  }

  report.clause("C4.4");
  Settings unknown = subject.base;
  unknown["no_such_property"] = std::string(1, '1');
  expect_refused(report, law, unknown, "no_such_property");
  report.expect(Material(law, unknown).message.find("no_such_property") != std::string::npos,
                "the unknown property is not named");
  for (uint64_t p = 0; p < law.property_count; ++p) {
    const quoin_property_info& property = *law.properties[p];
    if (property.kind != QUOIN_PROPERTY_CHOICE) continue;
    Settings settings = subject.base;
    settings[property.id] = "no_such_choice";
    expect_refused(report, law, settings, std::string(property.id) + " = no_such_choice");
  }
  if (!subject.base.empty()) {
    Values twice(law, subject.base);
    twice.pointers.push_back(twice.pointers.front());
    quoin_material* material = nullptr;
    report.expect(create(law, twice, &material, nullptr) == QUOIN_ERROR_PROPERTY, "%s given twice is accepted",
                  twice.ids.front().c_str());
    Values words(law, subject.base);
    for (quoin_property_value& value : words.values) {
      const quoin_property_info* property = find_property(law, value.id);
      if (property == nullptr || !is_number(*property)) continue;
      value.number_count = 0;
      value.numbers = nullptr;
      value.text = "word";
      material = nullptr;
      report.expect(create(law, words, &material, nullptr) == QUOIN_ERROR_PROPERTY, "%s as text is accepted", value.id);
      break;
    }
  }

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
  const Material base(law, subject.base);
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

  report.clause("C4.6");
  report.expect(law.material_number(base.handle, "no_such_property", &number) == QUOIN_ERROR_ARGUMENT,
                "material_number of an unknown property");
  for (uint64_t p = 0; p < law.property_count; ++p) {
    const quoin_property_info& property = *law.properties[p];
    if (!is_number(property)) continue;
    const auto set = subject.base.find(property.id);
    const double seen = base.number(property.id);
    if (set != subject.base.end()) {
      const double given = std::strtod(set->second.c_str(), nullptr);
      report.expect(seen == given, "%s: %s was given, %s is in force", property.id, set->second.c_str(),
                    shortest(seen).c_str());
    } else if (property.default_from != nullptr) {
      report.expect(seen == base.number(property.default_from), "%s: %s is in force, not the value of %s", property.id,
                    shortest(seen).c_str(), property.default_from);
    } else {
      report.expect(seen == property.default_value, "%s: default %s, %s is in force", property.id,
                    shortest(property.default_value).c_str(), shortest(seen).c_str());
    }
  }

  report.clause("C4.7");
  const Points points = scattered_points(law, base, 50, 11);
  const Result expected = evaluate(law, base, points);
  {
    Settings all = subject.base;  // defaults too, so that there is an order
    for (uint64_t p = 0; p < law.property_count; ++p) {
      const quoin_property_info& property = *law.properties[p];
      if (property.kind != QUOIN_PROPERTY_NUMBER) continue;
      if (const double value = base.number(property.id); std::isfinite(value))
        all.emplace(property.id, shortest(value));
    }
    auto reversed = std::make_unique<Values>(law, all);
    std::reverse(reversed->pointers.begin(), reversed->pointers.end());
    quoin_material* other = nullptr;
    report.expect(create(law, *reversed, &other, nullptr) == QUOIN_OK, "refused in another order");
    for (auto& list : reversed->numbers) std::fill(list.begin(), list.end(), -1e300);  // the law keeps no pointers
    for (auto& text : reversed->texts) std::fill(text.begin(), text.end(), '#');
    for (auto& id : reversed->ids) std::fill(id.begin(), id.end(), '#');
    for (auto& value : reversed->values) value = {};
    if (other != nullptr) {
      Material kept(law, subject.base);
      std::swap(kept.handle, other);
      const std::string what = difference(law, expected, evaluate(law, kept, points));
      report.expect(what.empty(), "after the caller reused its memory: %s", what.c_str());
      law.destroy_material(other);
    }
  }

  report.clause("C4.8");
  law.destroy_material(nullptr);
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

void check_zero_strengths(Report& report, const Subject& subject) {
  const quoin_law& law = subject.law;
  std::vector<std::string> strengths;
  for (uint64_t p = 0; p < law.property_count; ++p) {
    const quoin_property_info& property = *law.properties[p];
    if (is_number(property) && std::strcmp(property.unit, "Pa") == 0 && property.lower <= 0 && property.upper >= 0 &&
        !(property.lower == 0 && (property.flags & QUOIN_PROPERTY_LOWER_OPEN))) {
      strengths.push_back(property.id);
    }
  }
  report.clause("C4.9");
  if (strengths.empty()) {
    report.skip("no strength may be zero");
    return;
  }
  const std::string zero(1, '0');
  std::vector<Settings> cases;
  Settings none = subject.base;
  for (const std::string& id : strengths) {
    Settings settings = subject.base;
    for (const std::string& other : strengths) {
      if (other.compare(0, id.size(), id) == 0) settings[other] = zero;  // with its residual value
    }
    cases.push_back(settings);
    none[id] = zero;
  }
  cases.push_back(none);
  for (const Settings& settings : cases) {
    std::string what;
    for (const auto& [id, value] : settings) what += value == "0" ? id + "=0 " : "";
    report.clause("C4.9");
    const Material material(law, settings);
    if (!report.expect(material.handle != nullptr, "%srefused: %s", what.c_str(), material.message.c_str())) continue;
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
}

}  // namespace check
