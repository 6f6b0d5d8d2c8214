// Settings of --set, applied to the tables of a scene.
#include <algorithm>

#include "base/toml_text.h"
#include "scene/reader.h"

namespace quoin::reader {

namespace {

// Name of an element of a list: its `name`. A stage without one has that of its kind, others that of their list.
std::string called(const toml::node& element, const std::string& list) {
  const toml::table* table = element.as_table();
  if (!table) return "";
  if (const auto name = (*table)["name"].value<std::string>()) return *name;
  if (list == "stage") return (*table)["kind"].value_or(std::string("stage"));
  return list == "dry_wall" ? "wall" : list == "arch" ? "arch" : "";
}

bool is_called(const toml::node& element, const std::string& list, const std::string& name) {
  return called(element, list) == name;
}

// What to do about an element that a list does not have.
std::string elements_of(const toml::array& elements, const std::string& list) {
  std::string names;
  for (const toml::node& element : elements) {
    if (const std::string name = called(element, list); !name.empty())
      names += fmt::format("{}'{}'", names.empty() ? " (" : ", ", name);
  }
  return fmt::format("{}{}", elements.size(),
                     names.empty() ? "; count from 1" : names + "); count from 1 or use its name");
}

// Whether tables of this one have names that a scene chooses.
bool has_named_tables(const std::string& table) { return table == "materials" || table == "joints"; }

// Passes the value to `set`, with its type in TOML.
template <class Set>
void set_value(const std::string& value, const std::string& key, const Set& set) {
  try {
    refuse_unfit_toml(value, key);
    toml::table parsed = toml::parse("value = " + value);
    if (parsed.size() != 1) throw Error(Exit::bad_input, "");
    parsed.get("value")->visit([&](auto& v) { set(std::move(v)); });
  } catch (const std::exception&) {
    set(value);  // not TOML: a text without quotes
  }
}

// Parts of a dotted key. A name with a dot is in quotes, as in TOML. Returns the place of the equals sign; npos: there
// is none, or a quote is not closed.
size_t read_key(const std::string& setting, std::vector<std::string>* parts) {
  size_t at = 0;
  do {
    const char quote = at < setting.size() ? setting[at] : '\0';
    const bool quoted = quote == '"' || quote == '\'';
    const size_t first = at + (quoted ? 1 : 0);
    const size_t end =
        quoted ? setting.find(quote, first) : std::min(setting.find_first_of(".=", first), setting.size());
    if (end == std::string::npos) return end;
    parts->push_back(setting.substr(first, end - first));
    at = end + (quoted ? 1 : 0);
  } while (at < setting.size() && setting[at++] == '.');
  return at > 0 && at <= setting.size() && setting[at - 1] == '=' ? at - 1 : std::string::npos;
}

}  // namespace

void apply_override(toml::table& root, const std::string& setting, Context& context) {
  std::vector<std::string> keys;
  const size_t equals = read_key(setting, &keys);
  auto fail = [&](const std::string& why) {
    throw Error(Exit::bad_input, fmt::format("--set {}: {}; write --set dotted.key=value", setting, why));
  };
  if (equals == std::string::npos || equals == 0) fail("no key or no value");
  if (keys.size() > static_cast<size_t>(kMostKeyParts))
    fail(fmt::format("the key has more than {} parts", kMostKeyParts));
  const std::string value = setting.substr(equals + 1);
  toml::node* node = &root;
  std::string resolved, read_by_key;  // the second: without the numbers in a list that readers take as one value
  for (size_t i = 0; i < keys.size(); ++i) {
    const bool last = i + 1 == keys.size();
    if (keys[i].empty()) fail("an empty key");
    if (toml::array* list = node->as_array()) {
      size_t index = list->size();
      for (size_t j = 0; j < list->size(); ++j) {
        const bool named = is_called(*list->get(j), keys[i - 1], keys[i]);
        if (std::to_string(j + 1) != keys[i] && !named) continue;
        if (index < list->size())
          fail(fmt::format("'{}' fits elements {} and {} of the list {}; use the number", keys[i], index + 1, j + 1,
                           resolved));
        index = j;
      }
      if (index == list->size())
        fail(fmt::format("'{}' is no element of the list {}, which has {}", keys[i], resolved,
                         elements_of(*list, keys[i - 1])));
      resolved += "." + std::to_string(index + 1);
      if (last)
        set_value(value, keys[i], [&](auto&& v) {
          list->replace(list->begin() + static_cast<std::ptrdiff_t>(index), std::forward<decltype(v)>(v));
        });
      node = list->get(index);
      if (node->is_table()) read_by_key = resolved;
      continue;
    }
    toml::table* table = node->as_table();
    if (!table) fail(fmt::format("{} is not a table", resolved));
    resolved += (resolved.empty() ? "" : ".") + keys[i];
    read_by_key = resolved;
    if (!last) {
      node = table->get(keys[i]);
      if (!node && i == 1 && has_named_tables(keys[0])) {
        std::vector<std::string> names;
        for (auto&& [name, value_of] : *table) names.emplace_back(name.str());
        // A name like one that is there is a typing error, another one a new table.
        if (const std::string hint = did_you_mean(keys[i], names); !hint.empty())
          fail(fmt::format("[{}] has no '{}'{}", keys[0], keys[i], hint));
      }
      if (!node) node = &table->insert(keys[i], toml::table{}).first->second;
      continue;
    }
    set_value(value, keys[i], [&](auto&& v) { table->insert_or_assign(keys[i], std::forward<decltype(v)>(v)); });
  }
  context.overridden.insert(read_by_key);
}

}  // namespace quoin::reader
