#include "python/document.h"

#include <fmt/format.h>

#include <sstream>

#include "base/printable.h"

namespace quoin::python {

namespace py = pybind11;

namespace {

[[noreturn]] void refuse(const std::string& key, const py::handle& value, const char* why) {
  throw py::type_error(
      fmt::format("{}: {} of type {}; allowed: a number, a word, true or false, a list or a dictionary", key, why,
                  py::str(py::type::of(value).attr("__name__")).cast<std::string>()));
}

// Appends the value to a list.
void convert(const py::handle& value, const std::string& key, toml::array& list) {
  if (py::isinstance<py::bool_>(value)) {
    list.push_back(value.cast<bool>());
  } else if (py::isinstance<py::int_>(value)) {
    int overflow = 0;
    const long long whole = PyLong_AsLongLongAndOverflow(value.ptr(), &overflow);
    if (overflow != 0) throw py::value_error(key + ": an integer beyond 64 bits; write a number with a point");
    list.push_back(static_cast<std::int64_t>(whole));
  } else if (py::isinstance<py::float_>(value)) {
    list.push_back(value.cast<double>());
  } else if (py::isinstance<py::str>(value)) {
    const auto text = value.cast<std::string>();
    std::string shown = text;
    std::erase(shown, '\r');  // which files of scenes may hold
    if (!is_printable(shown)) throw py::value_error(key + ": the text holds a control character; remove it");
    list.push_back(text);
  } else if (py::isinstance<py::dict>(value)) {
    toml::table table;
    for (const auto& [name, element] : py::reinterpret_borrow<py::dict>(value)) {
      if (!py::isinstance<py::str>(name)) refuse(key, name, "a name");
      const auto text = name.cast<std::string>();
      toml::array one;
      convert(element, key.empty() ? text : fmt::format("{}.{}", key, text), one);
      one[0].visit([&](auto& v) { table.insert_or_assign(text, std::move(v)); });
    }
    list.push_back(std::move(table));
  } else if (py::isinstance<py::list>(value)) {
    toml::array array;
    for (const py::handle element : py::reinterpret_borrow<py::list>(value))
      convert(element, fmt::format("{}.{}", key, array.size() + 1), array);
    list.push_back(std::move(array));
  } else {
    refuse(key, value, "a value");
  }
}

py::object object_of(const toml::node& node) {
  if (const auto* table = node.as_table()) return document_of(*table);
  if (const auto* array = node.as_array()) {
    py::list list;
    for (const toml::node& element : *array) list.append(object_of(element));
    return list;
  }
  if (const auto* whole = node.as_integer()) return py::int_(whole->get());
  if (const auto* number = node.as_floating_point()) return py::float_(number->get());
  if (const auto* flag = node.as_boolean()) return py::bool_(flag->get());
  if (const auto* text = node.as_string()) return py::str(text->get());
  std::ostringstream date;  // not allowed for any key: the reader of scenes reports it
  node.visit([&](const auto& value) { date << value; });
  return py::str(date.str());
}

}  // namespace

toml::table table_of(const py::dict& document) {
  toml::array list;
  convert(document, "", list);
  return std::move(*list[0].as_table());
}

py::dict document_of(const toml::table& table) {
  py::dict document;
  for (auto&& [key, node] : table) document[py::str(std::string(key.str()))] = object_of(node);
  return document;
}

std::string text_of(const toml::table& table) {
  std::ostringstream text;
  text << toml::toml_formatter(table) << '\n';
  return text.str();
}

}  // namespace quoin::python
