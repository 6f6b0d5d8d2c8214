#include "geometry/mesh_file.h"

#include <fmt/format.h>

#include <cstdint>
#include <cstring>
#include <fstream>
#include <map>
#include <sstream>

#include "scene/error.h"

namespace quoin::geometry {
namespace {

struct RawShape {
  std::string name;
  std::vector<Vector> vertices;
  std::vector<std::vector<int>> faces;
};

[[noreturn]] void refuse(const std::string& path, size_t line, const std::string& what) {
  throw Error(Exit::bad_input, fmt::format("{}:{}: {}", path, line, what));
}

std::vector<RawShape> read_off(const std::string& path, std::istream& in) {
  RawShape shape;
  shape.name = path;
  std::string text;
  size_t line = 0;
  std::vector<double> numbers;
  auto next = [&] {  // the numbers of the next line that has any; comments are skipped
    numbers.clear();
    while (numbers.empty() && std::getline(in, text)) {
      ++line;
      std::istringstream words(text.substr(0, text.find('#')));
      std::string word;
      while (words >> word) {
        if (line <= 1 && (word == "OFF" || word == "off")) continue;
        char* end = nullptr;
        numbers.push_back(std::strtod(word.c_str(), &end));
        if (*end != 0) refuse(path, line, fmt::format("'{}' is not a number", word));
      }
    }
    if (numbers.empty()) refuse(path, line, "the file ends too early");
  };
  next();
  if (numbers.size() < 2) refuse(path, line, "expected the numbers of vertices and faces");
  const auto vertex_count = size_t(numbers[0]), face_count = size_t(numbers[1]);
  for (size_t i = 0; i < vertex_count; ++i) {
    next();
    if (numbers.size() < 3) refuse(path, line, "a vertex needs three coordinates");
    shape.vertices.push_back({numbers[0], numbers[1], numbers[2]});
  }
  for (size_t i = 0; i < face_count; ++i) {
    next();
    const auto corners = size_t(numbers[0]);
    if (numbers.size() < corners + 1)
      refuse(path, line, fmt::format("a face of {} corners has {} indices", corners, numbers.size() - 1));
    auto& face = shape.faces.emplace_back();
    for (size_t k = 0; k < corners; ++k) face.push_back(int(numbers[k + 1]));
  }
  return {shape};
}

std::vector<RawShape> read_obj(const std::string& path, std::istream& in) {
  std::vector<Vector> all;
  std::vector<RawShape> shapes;
  std::map<int, int> local;  // file-wide vertex number -> number in the current object
  std::string text, key;
  auto current = [&]() -> RawShape& {
    if (shapes.empty()) shapes.push_back({path, {}, {}});
    return shapes.back();
  };
  for (size_t line = 1; std::getline(in, text); ++line) {
    std::istringstream words(text.substr(0, text.find('#')));
    if (!(words >> key)) continue;
    if (key == "v") {
      Vector p;
      if (!(words >> p.x >> p.y >> p.z)) refuse(path, line, "a vertex needs three coordinates");
      all.push_back(p);
    } else if (key == "o" || key == "g") {
      std::string name;
      words >> name;
      if (!shapes.empty() && shapes.back().faces.empty()) {
        shapes.back().name = name;
      } else {
        shapes.push_back({name.empty() ? fmt::format("{}#{}", path, shapes.size()) : name, {}, {}});
      }
      local.clear();
    } else if (key == "f") {
      RawShape& shape = current();
      std::vector<int> face;
      std::string corner;
      while (words >> corner) {
        int i = std::atoi(corner.c_str());  // "7", "7/1", "7//3"; negative counts from the end
        i = i < 0 ? int(all.size()) + i : i - 1;
        if (i < 0 || i >= int(all.size())) refuse(path, line, fmt::format("vertex '{}' does not exist", corner));
        const auto [it, added] = local.try_emplace(i, int(shape.vertices.size()));
        if (added) shape.vertices.push_back(all[i]);
        face.push_back(it->second);
      }
      shape.faces.push_back(face);
    }
  }
  std::erase_if(shapes, [](const RawShape& s) { return s.faces.empty(); });
  return shapes;
}

// STL repeats every corner: equal coordinates are one vertex.
struct Welder {
  RawShape& shape;
  std::map<std::array<double, 3>, int> known;
  int operator()(const Vector& p) {
    const auto [it, added] = known.try_emplace({p.x, p.y, p.z}, int(shape.vertices.size()));
    if (added) shape.vertices.push_back(p);
    return it->second;
  }
};

std::vector<RawShape> read_stl(const std::string& path, const std::string& bytes) {
  std::vector<RawShape> shapes;
  uint32_t count = 0;
  if (bytes.size() >= 84) std::memcpy(&count, bytes.data() + 80, 4);
  if (bytes.size() >= 84 && bytes.size() == 84 + size_t(count) * 50) {
    shapes.push_back({path, {}, {}});
    Welder weld{shapes.back(), {}};
    for (size_t t = 0; t < count; ++t) {
      float xyz[9];
      std::memcpy(xyz, bytes.data() + 84 + t * 50 + 12, sizeof xyz);
      auto& face = shapes.back().faces.emplace_back();
      for (int k = 0; k < 3; ++k) face.push_back(weld({xyz[3 * k], xyz[3 * k + 1], xyz[3 * k + 2]}));
    }
    return shapes;
  }
  std::istringstream in(bytes);
  std::string text, key;
  std::map<std::array<double, 3>, int> known;
  for (size_t line = 1; std::getline(in, text); ++line) {
    std::istringstream words(text);
    if (!(words >> key)) continue;
    if (key == "solid") {
      std::string name;
      words >> name;
      shapes.push_back({name.empty() ? fmt::format("{}#{}", path, shapes.size()) : name, {}, {}});
      known.clear();
    } else if (key == "outer" && !shapes.empty()) {
      shapes.back().faces.emplace_back();
    } else if (key == "vertex") {
      Vector p;
      if (shapes.empty() || shapes.back().faces.empty() || !(words >> p.x >> p.y >> p.z))
        refuse(path, line, "misplaced vertex");
      const auto [it, added] = known.try_emplace({p.x, p.y, p.z}, int(shapes.back().vertices.size()));
      if (added) shapes.back().vertices.push_back(p);
      shapes.back().faces.back().push_back(it->second);
    }
  }
  return shapes;
}

}  // namespace

std::vector<NamedShape> read_mesh_file(const std::string& path, double scale) {
  std::ifstream file(path, std::ios::binary);
  if (!file) throw Error(Exit::bad_input, fmt::format("{}: cannot be opened", path));
  std::string ending = path.substr(std::min(path.size(), path.rfind('.')));
  std::transform(ending.begin(), ending.end(), ending.begin(), [](unsigned char c) { return char(std::tolower(c)); });
  std::vector<RawShape> raw;
  if (ending == ".off") {
    raw = read_off(path, file);
  } else if (ending == ".obj") {
    raw = read_obj(path, file);
  } else if (ending == ".stl") {
    std::ostringstream all;
    all << file.rdbuf();
    raw = read_stl(path, all.str());
  } else {
    throw Error(Exit::bad_input, fmt::format("{}: unknown kind of mesh file; .off, .obj and .stl are read", path));
  }
  if (raw.empty()) throw Error(Exit::bad_input, fmt::format("{}: no block in this file", path));
  std::vector<NamedShape> shapes;
  for (RawShape& r : raw) {
    for (Vector& p : r.vertices) p *= scale;
    shapes.push_back({r.name, from_faces(r.vertices, r.faces, r.name)});
  }
  return shapes;
}

std::string to_obj(const std::vector<NamedShape>& shapes) {
  std::string text;
  size_t base = 1;
  for (const NamedShape& s : shapes) {
    text += fmt::format("o {}\n", s.name);
    for (const Vector& p : s.shape.vertices) text += fmt::format("v {:.17g} {:.17g} {:.17g}\n", p.x, p.y, p.z);
    for (const auto& face : s.shape.faces) {
      text += 'f';
      for (int c : face) text += fmt::format(" {}", base + size_t(c));
      text += '\n';
    }
    base += s.shape.vertices.size();
  }
  return text;
}

}  // namespace quoin::geometry
