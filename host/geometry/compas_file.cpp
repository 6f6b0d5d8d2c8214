#include "geometry/compas_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>

#include "base/error.h"

namespace quoin::geometry {

namespace {

using Json = nlohmann::ordered_json;

constexpr int kDeepest = 64;  // largest depth of nesting in an assembly

// Rows of a rotation matrix with a translation.
using Placement = std::array<std::array<double, 4>, 3>;

class Reader {
 public:
  explicit Reader(const std::string& path) : path_(path) {}

  // Properties of a mesh that it inherits from the objects around it.
  struct Above {
    std::string name, where;
    std::string number;  // COMPAS's number of a block
    bool support = false;
    Placement placement{{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}};
    int depth = 0;
  };

  void visit(const Json& node, Above above) {
    if (++above.depth > kDeepest) refuse(above.where, "is nested too deep for an assembly");
    if (node.is_array()) {
      for (std::size_t i = 0; i < node.size(); ++i) {
        Above own = entry(above, fmt::format("{}", i));
        own.number = above.number;  // number of the object that holds the list
        visit(node[i], own);
      }
      return;
    }
    if (!node.is_object()) return;
    above.support = above.support || flag(node, "is_support");
    if (node.contains("name") && node["name"].is_string()) above.name = node["name"].get<std::string>();
    if (node.contains("attributes") && node["attributes"].is_object()) {
      const Json& attributes = node["attributes"];
      above.support = above.support || flag(attributes, "is_support");
      if (attributes.contains("name") && attributes["name"].is_string())
        above.name = attributes["name"].get<std::string>();
    }
    if (node.contains("transformation")) place(node["transformation"], above);
    // Blocks of an assembly are at the nodes of its graph; what old files have beside the graph belongs to these
    // blocks.
    if (has_blocks(node, "node")) {
      above.support = false;
      return visit_all(node["node"], below(above, "node"), nullptr);
    }
    // Before COMPAS 1, blocks were beside the graph, whose nodes (or vertices) have the supports.
    if (node.contains("blocks") && node["blocks"].is_object()) {
      const Json* graph = node.contains("assembly") && node["assembly"].is_object() ? &node["assembly"] : nullptr;
      return visit_all(node["blocks"], below(above, "blocks"), graph);
    }
    if (node.contains("vertex") && node.contains("face") && node["vertex"].is_object() && node["face"].is_object())
      return add_mesh(node, above);
    // Blocks of a compas_dem model are its elements; its tree and graph only refer to them.
    if (node.contains("elements") && node["elements"].is_array())
      return visit(node["elements"], below(above, "elements"));
    if (node.contains("elements") && node["elements"].is_object())
      return visit_all(node["elements"], below(above, "elements"), nullptr);
    for (const auto& [key, value] : node.items()) {
      const bool is_no_block = key == "edge" || key == "adjacency" || key == "interface" || key == "interfaces" ||
                               key == "modelgeometry" || key == "collision_mesh" || key == "features";
      if (!is_no_block) visit(value, below(above, key));
    }
  }

  std::vector<RawShape> shapes;

 private:
  [[noreturn]] void refuse(const std::string& where, const std::string& what) const {
    throw Error(Exit::bad_input, fmt::format("{}: {}: {}", path_, where.empty() ? "the file" : where, what));
  }

  static bool flag(const Json& node, const char* key) {
    return node.is_object() && node.contains(key) && node[key].is_boolean() && node[key].get<bool>();
  }

  static bool has_blocks(const Json& graph, const char* key) {
    if (!graph.contains(key) || !graph[key].is_object()) return false;
    const auto holds = [](const Json& node) { return node.is_object() && node.contains("block"); };
    return std::any_of(graph[key].begin(), graph[key].end(), holds);
  }

  // Visits entries by COMPAS's numbers; graph: its node (or vertex) of the same number has is_support.
  void visit_all(const Json& entries, const Above& above, const Json* graph) {
    for (const auto& [key, value] : entries.items()) {
      Above own = entry(above, key);
      for (const char* kind : {"node", "vertex"}) {
        if (graph && graph->contains(kind) && (*graph)[kind].is_object() && (*graph)[kind].contains(key))
          own.support = own.support || flag((*graph)[kind][key], "is_support");
      }
      const std::size_t before = shapes.size();
      visit(value, own);
      if (shapes.size() == before && value.is_object() && value.contains("block"))
        refuse(own.where, "its block is no mesh with vertices and faces; remove the node, or give it its mesh");
    }
  }

  // One of several entries: the name of their parent is not its name.
  static Above entry(const Above& above, const std::string& key) {
    Above own = below(above, key);
    own.name.clear();
    own.number = key;
    return own;
  }

  static Above below(Above above, const std::string& key) {
    above.where += (above.where.empty() ? "" : ".") + key;
    return above;
  }

  // Applies transformation: {data: {matrix: 4 x 4}}, also as value of COMPAS 1 or bare; null: none.
  void place(const Json& given, Above& above) const {
    const Json* node = &given;
    for (const char* key : {"data", "value", "matrix"}) {
      if (node->is_object() && node->contains(key)) node = &(*node)[key];
    }
    if (!node->is_array() || node->size() != 4) return;
    Placement own{};
    for (std::size_t r = 0; r < 3; ++r) {
      const Json& row = (*node)[r];
      if (!row.is_array() || row.size() != 4) refuse(above.where, "transformation is no matrix of 4 x 4 numbers");
      for (std::size_t c = 0; c < 4; ++c) {
        if (!row[c].is_number()) refuse(above.where, "transformation is no matrix of 4 x 4 numbers");
        own[r][c] = row[c].get<double>();
      }
    }
    const Placement outer = above.placement;
    for (std::size_t r = 0; r < 3; ++r) {
      for (std::size_t c = 0; c < 4; ++c) {
        above.placement[r][c] = c == 3 ? outer[r][3] : 0.0;
        for (std::size_t k = 0; k < 3; ++k) above.placement[r][c] += outer[r][k] * own[k][c];
      }
    }
  }

  void add_mesh(const Json& mesh, const Above& above) {
    RawShape& shape = shapes.emplace_back();
    shape.name = above.name.empty() ? fmt::format("block_{}", shapes.size() - 1) : above.name;
    shape.number = above.number;
    shape.support = above.support;
    std::map<std::string, int> number;
    for (const auto& [key, vertex] : mesh["vertex"].items()) {
      std::array<double, 3> at{};
      for (std::size_t c = 0; c < 3; ++c) {
        const char* axis = std::array{"x", "y", "z"}[c];
        if (!vertex.is_object() || !vertex.contains(axis) || !vertex[axis].is_number())
          refuse(above.where, fmt::format("vertex {} has no number {}", key, axis));
        at[c] = vertex[axis].get<double>();
      }
      const auto along = [&](std::size_t r) {
        const auto& row = above.placement[r];
        return row[0] * at[0] + row[1] * at[1] + row[2] * at[2] + row[3];
      };
      number[key] = static_cast<int>(shape.vertices.size());
      shape.vertices.push_back({along(0), along(1), along(2)});
    }
    for (const auto& [key, corners] : mesh["face"].items()) {
      auto& face = shape.faces.emplace_back();
      if (!corners.is_array()) refuse(above.where, fmt::format("face {} is no list of vertices", key));
      for (const Json& corner : corners) {
        const std::string of = corner.is_string() ? corner.get<std::string>() : corner.dump();
        const auto found = number.find(of);
        if (found == number.end())
          refuse(above.where, fmt::format("face {} has a vertex {} that is not there", key, of));
        if (face.empty() || face.back() != found->second) face.push_back(found->second);
      }
      if (face.size() > 1 && face.front() == face.back()) face.pop_back();  // COMPAS may repeat the first corner
    }
  }

  std::string path_;
};

}  // namespace

std::vector<RawShape> read_compas(const std::string& path, const std::string& bytes) {
  const Json json = Json::parse(bytes, nullptr, false);
  if (json.is_discarded()) throw Error(Exit::bad_input, path + ": not valid JSON; write it with compas.json_dump");
  Reader reader(path);
  reader.visit(json, {});
  return std::move(reader.shapes);
}

}  // namespace quoin::geometry
