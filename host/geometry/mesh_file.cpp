#include "geometry/mesh_file.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <map>
#include <set>
#include <sstream>

#include "base/error.h"
#include "base/input_file.h"
#include "base/number_text.h"
#include "base/text.h"
#include "geometry/compas_file.h"
#include "geometry/drawn_shape.h"

namespace quoin::geometry {
namespace {

// Largest number of corners of a block; a larger one is an error, or another kind of file.
constexpr int64_t most_corners = 10'000'000;

// Lines of a file as words, and errors with the line number.
class Lines {
 public:
  // comment: first character of comments; 0: the format has none.
  Lines(const std::string& path, const std::string& bytes, char comment) : path_(path), in_(bytes), comment_(comment) {}

  // Goes to the next line that has words; false at the end of the file.
  bool next() {
    std::string text;
    while (std::getline(in_, text)) {
      ++line_;
      std::istringstream stream(comment_ ? text.substr(0, text.find(comment_)) : text);
      words_.clear();
      for (std::string word; stream >> word;) words_.push_back(word);
      if (!words_.empty()) return true;
    }
    return false;
  }
  const std::vector<std::string>& words() const { return words_; }
  // Text after the first word: a name, which may have blanks.
  std::string rest() const { return fmt::format("{}", fmt::join(words_.begin() + 1, words_.end(), " ")); }

  [[noreturn]] void refuse(const std::string& what) const {
    throw Error(Exit::bad_input, fmt::format("{}:{}: {}", path_, line_, what));
  }
  double number(size_t word) const {
    double value = 0.0;
    if (!parse_number(words_[word], value)) refuse(fmt::format("'{}' is not a number", words_[word]));
    if (!std::isfinite(value)) refuse(fmt::format("'{}' is not finite", words_[word]));
    return value;
  }
  // A whole number from lower to upper. what: its meaning, for the message.
  int64_t integer(const std::string& word, int64_t lower, int64_t upper, const char* what) const {
    int64_t value = 0;
    if (!parse_number(word, value) || value < lower || value > upper) {
      refuse(fmt::format(
          "{} '{}'; allowed: {}", what, word,
          lower > upper ? "none, as there are no vertices yet" : fmt::format("an integer, {} to {}", lower, upper)));
    }
    return value;
  }
  Vector point(size_t first) const {
    if (words_.size() < first + 3) refuse("a vertex needs three coordinates");
    return {number(first), number(first + 1), number(first + 2)};
  }

 private:
  std::string path_;
  std::istringstream in_;
  char comment_;
  std::vector<std::string> words_;
  size_t line_ = 0;
};

std::vector<RawShape> read_off(const std::string& path, const std::string& bytes) {
  RawShape shape;
  Lines lines(path, bytes, '#');
  const auto next = [&](const std::string& expected) {
    if (!lines.next()) lines.refuse(fmt::format("the file ends too early: expected {}", expected));
  };
  const std::string counts = "the numbers of vertices and faces";
  next(counts);
  size_t word = 0;  // "OFF" may precede the counts, on their line or on its own
  if (lines.words()[0] == "OFF" || lines.words()[0] == "off") word = 1;
  if (word == lines.words().size()) next(counts), word = 0;
  if (lines.words().size() < word + 2) lines.refuse("expected " + counts);
  const int64_t vertex_count = lines.integer(lines.words()[word], 0, most_corners, "number of vertices");
  const int64_t face_count = lines.integer(lines.words()[word + 1], 0, most_corners, "number of faces");
  // No memory is reserved by a count, as a file may be shorter than that.
  for (int64_t i = 0; i < vertex_count; ++i) {
    next(fmt::format("vertex {} of {}", i, vertex_count));
    shape.vertices.push_back(lines.point(0));
  }
  for (int64_t i = 0; i < face_count; ++i) {
    next(fmt::format("face {} of {}", i, face_count));
    const auto& words = lines.words();
    const auto corners = size_t(lines.integer(words[0], 3, most_corners, "number of corners"));
    if (words.size() < corners + 1)
      lines.refuse(fmt::format("a face of {} corners has {} indices", corners, words.size() - 1));
    auto& face = shape.faces.emplace_back();
    for (size_t k = 1; k <= corners; ++k)
      face.push_back(int(lines.integer(words[k], 0, vertex_count - 1, "vertex number")));
  }
  if (lines.next()) lines.refuse(fmt::format("'{}' after the last of {} faces", lines.words()[0], face_count));
  return {shape};
}

std::vector<RawShape> read_obj(const std::string& path, const std::string& bytes) {
  std::vector<Vector> all;
  std::vector<RawShape> shapes;
  std::map<int64_t, int> local;  // file-wide vertex number -> number in the current object
  auto current = [&]() -> RawShape& {
    if (shapes.empty()) shapes.emplace_back();
    return shapes.back();
  };
  Lines lines(path, bytes, '#');
  while (lines.next()) {
    const auto& words = lines.words();
    if (words[0] == "v") {
      all.push_back(lines.point(1));
    } else if (words[0] == "o" || words[0] == "g") {
      if (shapes.empty() || !shapes.back().faces.empty()) shapes.emplace_back();
      shapes.back().name = lines.rest();
      local.clear();
    } else if (words[0] == "f") {
      RawShape& shape = current();
      if (words.size() < 4) lines.refuse(fmt::format("a face of {} corners; it needs at least 3", words.size() - 1));
      const auto count = int64_t(all.size());
      std::vector<int> face;
      for (size_t k = 1; k < words.size(); ++k) {
        // "7", "7/1", "7//3"; negative numbers count back from the last vertex
        const std::string number = words[k].substr(0, words[k].find('/'));
        const bool backwards = number.starts_with('-');
        const int64_t given = backwards ? lines.integer(number, -count, -1, "vertex number")
                                        : lines.integer(number, 1, count, "vertex number");
        const int64_t i = backwards ? count + given : given - 1;
        const auto [it, added] = local.try_emplace(i, int(shape.vertices.size()));
        if (added) shape.vertices.push_back(all[size_t(i)]);
        face.push_back(it->second);
      }
      shape.faces.push_back(face);
    }
  }
  std::erase_if(shapes, [](const RawShape& s) { return s.faces.empty(); });
  return shapes;
}

// STL repeats every corner: corners with equal coordinates are one vertex.
struct Welder {
  std::map<std::array<double, 3>, int> known;
  int operator()(const Vector& p, RawShape& shape) {
    const auto [it, added] = known.try_emplace({p.x, p.y, p.z}, int(shape.vertices.size()));
    if (added) shape.vertices.push_back(p);
    return it->second;
  }
};

std::vector<RawShape> read_binary_stl(const std::string& path, const std::string& bytes, size_t count) {
  RawShape shape;
  Welder weld;
  for (size_t t = 0; t < count; ++t) {
    float xyz[9];
    std::memcpy(xyz, bytes.data() + 84 + t * 50 + 12, sizeof xyz);
    auto& face = shape.faces.emplace_back();
    for (int k = 0; k < 3; ++k) {
      const Vector p{xyz[3 * k], xyz[3 * k + 1], xyz[3 * k + 2]};
      // A coordinate that is not a number would break the order of the map.
      if (!std::isfinite(p.x + p.y + p.z))
        throw Error(Exit::bad_input, fmt::format("{}: triangle {}, corner {}: a coordinate is not finite", path, t, k));
      face.push_back(weld(p, shape));
    }
  }
  return {shape};
}

std::vector<RawShape> read_ascii_stl(const std::string& path, const std::string& bytes) {
  std::vector<RawShape> shapes;
  Welder weld;
  Lines lines(path, bytes, 0);
  bool in_loop = false;
  while (lines.next()) {
    const auto& words = lines.words();
    if (words[0] == "solid") {
      if (in_loop) lines.refuse("misplaced 'solid'");
      shapes.emplace_back().name = lines.rest();
      weld.known.clear();
    } else if (words[0] == "outer") {
      if (shapes.empty() || in_loop) lines.refuse("misplaced 'outer loop'");
      shapes.back().faces.emplace_back();
      in_loop = true;
    } else if (words[0] == "vertex") {
      if (!in_loop) lines.refuse("misplaced vertex");
      shapes.back().faces.back().push_back(weld(lines.point(1), shapes.back()));
    } else if (words[0] == "endloop") {
      if (!in_loop || shapes.back().faces.back().size() != 3) lines.refuse("a facet needs three vertices");
      in_loop = false;
    }
  }
  if (in_loop) lines.refuse("the file ends within a facet");
  return shapes;
}

std::vector<RawShape> read_stl(const std::string& path, const std::string& bytes) {
  uint32_t count = 0;
  if (bytes.size() >= 84) std::memcpy(&count, bytes.data() + 80, 4);
  if (bytes.size() >= 84 && bytes.size() == 84 + size_t(count) * 50) return read_binary_stl(path, bytes, count);
  if (bytes.find('\0') != std::string::npos) {
    throw Error(Exit::bad_input,
                fmt::format("{}: {} bytes, but a binary STL file of the {} triangles that it announces has {}", path,
                            bytes.size(), count, 84 + uint64_t{count} * 50));
  }
  return read_ascii_stl(path, bytes);
}

// Each body as a shape, in m, welded and oriented. Bodies of one object are numbered.
std::vector<RawShape> bodies(const std::string& path, std::vector<RawShape> raw, double scale) {
  std::vector<RawShape> all;
  for (RawShape& r : raw) {
    for (Vector& p : r.vertices) {
      p *= scale;
      if (!std::isfinite(p.x + p.y + p.z))
        throw Error(Exit::bad_input, fmt::format("{}: block '{}': a coordinate is not finite", path, r.name));
    }
    // Bodies that touch have corners at the same places, so closed surfaces are split first. Open surfaces are
    // connected only by welding.
    std::vector<RawShape> parts = split(r);
    if (std::all_of(parts.begin(), parts.end(), is_closed)) {
      for (RawShape& part : parts) weld(part);
    } else {
      weld(r);
      parts = split(r);
    }
    if (parts.empty() || std::any_of(parts.begin(), parts.end(), [](const RawShape& p) { return p.faces.empty(); }))
      throw Error(Exit::bad_input, fmt::format("{}: block '{}': has no face with an area", path, r.name));
    for (size_t i = 0; i < parts.size(); ++i) {
      RawShape& part = parts[i];
      orient(part);
      if (parts.size() > 1 && !part.name.empty()) part.name += fmt::format("/{}", i);
      all.push_back(std::move(part));
    }
  }
  return all;
}

// Names of the file. A block without a name gets the file's name and its place; blocks with the same name get their
// numbers.
void name_all(const std::string& path, std::vector<RawShape>& raw) {
  const std::string file = std::filesystem::path(path).stem().string();
  std::map<std::string, std::vector<size_t>> called;
  for (size_t i = 0; i < raw.size(); ++i) {
    if (raw[i].name.empty()) raw[i].name = raw.size() == 1 ? file : fmt::format("{}#{}", file, i);
    called[raw[i].name].push_back(i);
  }
  for (const auto& [name, places] : called) {
    if (places.size() == 1) continue;
    std::set<std::string> numbers;
    for (size_t i : places) numbers.insert(raw[i].number);
    const bool by_number = numbers.size() == places.size() && !numbers.contains("");
    for (size_t i : places) raw[i].name += fmt::format("#{}", by_number ? raw[i].number : std::to_string(i));
  }
}

NamedShape block_of(const RawShape& shape, const std::vector<RawShape>& all) {
  if (!is_flat(shape)) {
    DrawnShape drawn = from_drawn(shape);
    return {shape.name, std::move(drawn.shape), shape.support, drawn.warp, false};
  }
  if (!shape.support) {
    throw Error(
        Exit::bad_input,
        fmt::format("block {}: is drawn as a flat face, which only a support can be; mark it as one (is_support "
                    "in COMPAS, or its name in `fixed` here), or draw it as a closed block",
                    shape.name));
  }
  Vector middle;
  double corners = 0.0;
  for (const RawShape& other : all) {
    if (&other == &shape) continue;
    for (const Vector& p : other.vertices) middle += p;
    corners += double(other.vertices.size());
  }
  const Vector behind = shape.vertices[0] - plane_of(shape.vertices, shape.faces[0]).normal;
  return {shape.name, plate(shape, corners > 0 ? middle / corners : behind), true, 0.0, true};
}

}  // namespace

std::vector<NamedShape> read_mesh_file(const std::string& path, double scale,
                                       const std::function<bool(const std::string& name)>& fixed) {
  const std::string ending = lower(path.substr(std::min(path.size(), path.rfind('.'))));
  std::vector<RawShape> (*read)(const std::string&, const std::string&) = nullptr;
  if (ending == ".off") {
    read = read_off;
  } else if (ending == ".obj") {
    read = read_obj;
  } else if (ending == ".stl") {
    read = read_stl;
  } else if (ending == ".json") {
    read = read_compas;
  } else {
    throw Error(Exit::bad_input,
                fmt::format("{}: unknown kind of mesh file; .off, .obj, .stl and .json (COMPAS) are read", path));
  }
  std::vector<RawShape> raw = read(path, read_text_file(path));
  if (raw.empty()) throw Error(Exit::bad_input, fmt::format("{}: no block in this file", path));
  raw = bodies(path, std::move(raw), scale);
  name_all(path, raw);
  std::vector<NamedShape> shapes;
  std::vector<std::string> refused;
  std::string why;
  for (RawShape& r : raw) {
    r.support = r.support || (fixed && fixed(r.name));
    try {
      shapes.push_back(block_of(r, raw));
    } catch (const Error& error) {
      if (refused.empty()) why = error.what();
      refused.push_back(r.name);
    }
  }
  if (refused.empty()) return shapes;
  if (refused.size() > 1) {
    constexpr size_t kNamed = 10;
    why += fmt::format("; {} of the file's {} blocks are refused: {}", refused.size(), raw.size(),
                       fmt::join(refused.begin(), refused.begin() + long(std::min(kNamed, refused.size())), ", "));
    if (refused.size() > kNamed) why += " ...";
  }
  throw Error(Exit::bad_input, fmt::format("{}: {}", path, why));
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
