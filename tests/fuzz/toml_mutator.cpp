// Mutations of TOML that are valid TOML: values, keys and tables are changed, removed, repeated and moved, so that
// readers of the contents are tested. Every third input is mutated by bytes.
#include <cmath>
#include <cstring>
#include <limits>
#include <random>
#include <vector>

#include "scene/inline_toml.h"

extern "C" std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t most);

namespace {

using Random = std::mt19937_64;

std::size_t below(Random& random, std::size_t n) { return n == 0 ? 0 : random() % n; }

// Collects `node` and every table and list below it.
void collect(toml::node& node, std::vector<toml::table*>* tables, std::vector<toml::array*>* lists) {
  if (toml::table* table = node.as_table()) {
    tables->push_back(table);
    for (auto&& [key, value] : *table) collect(value, tables, lists);
  } else if (toml::array* list = node.as_array()) {
    lists->push_back(list);
    for (toml::node& value : *list) collect(value, tables, lists);
  }
}

// Calls `put` with an unusual value of a random kind.
template <class Put>
void put_odd(Random& random, const Put& put) {
  static const double kNumbers[] = {
      0.0,         -0.0, 1.0,  -1.0, 0.5,  1e-300, 1e300, 1e9,
      1e-12,       1e20, -1e6, 90.0, 180., 3.0,    1e5,   std::numeric_limits<double>::infinity(),
      std::nan("")};
  static const std::int64_t kCounts[] = {
      0, 1, -1, 2, 3, 7, 100, 1000, 1 << 20, 1l << 40, std::numeric_limits<std::int64_t>::max()};
  static const char* const kWords[] = {
      "",     "x",    "mortar",   "elastic", "fracture_energy", "coulomb_slip", "cyclic_joint", "dry",
      "wall", "free", "top_beam", "1e6",     "../../dev/zero",  "a,b\n\"<&"};
  switch (below(random, 6)) {
    case 0:
    case 1:
      return put(kNumbers[below(random, std::size(kNumbers))]);
    case 2:
      return put(kCounts[below(random, std::size(kCounts))]);
    case 3:
      return put(std::string(kWords[below(random, std::size(kWords))]));
    case 4:
      return put(random() % 2 == 0);
    default: {
      toml::array list;
      for (std::size_t n = below(random, 5); n > 0; --n) list.push_back(kNumbers[below(random, std::size(kNumbers))]);
      return put(std::move(list));
    }
  }
}

// Multiplies a number by a random factor.
bool scale(Random& random, toml::node& node) {
  static const double kFactors[] = {-1.0, 0.0, 0.1, 0.5, 0.9, 1.1, 2.0, 10.0, 1e3, 1e-3, 1e6, 1e-6};
  const double factor = kFactors[below(random, std::size(kFactors))];
  if (auto* decimal = node.as_floating_point()) {
    **decimal *= factor;
    return true;
  }
  if (auto* whole = node.as_integer()) {
    const double scaled = static_cast<double>(**whole) * factor + static_cast<double>(below(random, 3)) - 1.0;
    if (std::abs(scaled) < 1e15) **whole = static_cast<std::int64_t>(scaled);
    return true;
  }
  return false;
}

void change_table(Random& random, toml::table& table, const std::vector<toml::table*>& others) {
  if (table.empty()) return;
  auto at = table.begin();
  std::advance(at, static_cast<std::ptrdiff_t>(below(random, table.size())));
  const std::string key(at->first.str());
  switch (below(random, 8)) {
    case 0:
      table.erase(at);
      break;
    case 1:
      put_odd(random, [&](auto&& value) { table.insert_or_assign(key, std::forward<decltype(value)>(value)); });
      break;
    case 2: {  // a key of another table
      const toml::table& other = *others[below(random, others.size())];
      if (&other == &table || other.empty()) break;
      auto from = other.begin();
      std::advance(from, static_cast<std::ptrdiff_t>(below(random, other.size())));
      toml::table copy(other);  // a table below itself is copied before it is put there
      const std::string name(from->first.str());
      copy.for_each([&](const toml::key& k, auto& value) {
        if (k.str() == name) table.insert_or_assign(random() % 2 ? name : key, value);
      });
      break;
    }
    case 3:
      put_odd(random, [&](auto&& value) { table.insert_or_assign(key + "s", std::forward<decltype(value)>(value)); });
      break;
    default:
      if (!scale(random, at->second))
        put_odd(random, [&](auto&& value) { table.insert_or_assign(key, std::forward<decltype(value)>(value)); });
  }
}

void change_list(Random& random, toml::array& list) {
  const std::size_t at = below(random, list.size());
  const auto place = list.begin() + static_cast<std::ptrdiff_t>(at);
  switch (below(random, 4)) {
    case 0:
      if (!list.empty()) list.erase(place);
      break;
    case 1:
      if (!list.empty()) {
        toml::array copy(list);
        copy[at].visit([&](auto& value) { list.push_back(value); });
      }
      break;
    case 2:
      put_odd(random, [&](auto&& value) { list.push_back(std::forward<decltype(value)>(value)); });
      break;
    default:
      if (list.empty() || !scale(random, list[at]))
        put_odd(random, [&](auto&& value) { list.push_back(std::forward<decltype(value)>(value)); });
  }
}

}  // namespace

extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size, std::size_t most,
                                               unsigned int seed) {
  Random random(seed);
  if (random() % 3 == 0) return LLVMFuzzerMutate(data, size, most);
  toml::table all;
  try {
    all = toml::parse(std::string_view(reinterpret_cast<const char*>(data), size));
  } catch (const toml::parse_error&) {
    return LLVMFuzzerMutate(data, size, most);
  }
  for (std::size_t changes = random() % 2 == 0 ? 1 : 1 + below(random, 4); changes > 0; --changes) {
    std::vector<toml::table*> tables;
    std::vector<toml::array*> lists;
    collect(all, &tables, &lists);
    const std::size_t at = below(random, tables.size() + lists.size());
    if (at < tables.size())
      change_table(random, *tables[at], tables);
    else
      change_list(random, *lists[at - tables.size()]);
  }
  const std::string bytes = quoin::toml_lines(all);
  const std::size_t length = std::min(bytes.size(), most);
  std::memcpy(data, bytes.data(), length);
  return length;
}
