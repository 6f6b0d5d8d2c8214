// Assemblies of COMPAS: positions by nested transformations, supports, and refusals.
#include "geometry/compas_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/error.h"

namespace quoin::geometry {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

// A tetrahedron with edges of different length along each axis.
const std::string kMesh =
    R"("vertex": {"0": {"x": 1, "y": 2, "z": 3}, "1": {"x": 4, "y": 2, "z": 3}, "2": {"x": 1, "y": 7, "z": 3},
"3": {"x": 1, "y": 2, "z": 9}}, "face": {"0": [0, 2, 1, 0], "1": ["0", "1", "3"], "2": [0, 3, 2], "3": [1, 2, 2, 3]})";

TEST(Compas, ABareMeshIsWhereItWasWritten) {
  const auto shapes = read_compas("a.json", "{" + kMesh + "}");
  ASSERT_EQ(shapes.size(), 1u);
  EXPECT_EQ(shapes[0].name, "block_0");
  EXPECT_FALSE(shapes[0].support);
  const std::vector<std::array<double, 3>> expected{{1, 2, 3}, {4, 2, 3}, {1, 7, 3}, {1, 2, 9}};
  ASSERT_EQ(shapes[0].vertices.size(), 4u);
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_EQ(shapes[0].vertices[i].x, expected[i][0]);
    EXPECT_EQ(shapes[0].vertices[i].y, expected[i][1]);
    EXPECT_EQ(shapes[0].vertices[i].z, expected[i][2]);
  }
  // A repeated corner, as at the end of a closed cycle, counts once.
  EXPECT_THAT(shapes[0].faces,
              ElementsAre(ElementsAre(0, 2, 1), ElementsAre(0, 1, 3), ElementsAre(0, 3, 2), ElementsAre(1, 2, 3)));
}

// The element's transformation acts first, then that of its parent: outer (own p + t) + T.
TEST(Compas, TransformationsOfWhatHoldsAMeshComeAfterItsOwn) {
  const std::string
      own = R"("transformation": {"data": {"matrix": [[0, -1, 0, 2], [1, 0, 0, 0], [0, 0, 2, 0.5], [0, 0, 0, 1]]}})",
      outer = R"("transformation": [[1, 0, 3, 10], [0, 0, 1, 20], [0, -1, 0, 30], [0, 0, 0, 1]])";
  const auto shapes =
      read_compas("a.json", "{" + outer + R"(, "elements": [{"name": "e", "is_support": true, )" + own +
                                R"(, "geometry": {"attributes": {"name": "cube"}, )" + kMesh + "}}, {" + kMesh + "}]}");
  ASSERT_EQ(shapes.size(), 2u);
  EXPECT_EQ(shapes[0].name, "cube");
  EXPECT_EQ(shapes[1].name, "block_1");
  EXPECT_TRUE(shapes[0].support);
  EXPECT_FALSE(shapes[1].support);
  const double x = 1, y = 2, z = 3;
  const double u = -y + 2, v = x, w = 2 * z + 0.5;
  EXPECT_EQ(shapes[0].vertices[0].x, u + 3 * w + 10);
  EXPECT_EQ(shapes[0].vertices[0].y, w + 20);
  EXPECT_EQ(shapes[0].vertices[0].z, -v + 30);
  EXPECT_EQ(shapes[1].vertices[0].x, x + 3 * z + 10);
  EXPECT_EQ(shapes[1].vertices[0].y, z + 20);
  EXPECT_EQ(shapes[1].vertices[0].z, -y + 30);
}

TEST(Compas, WhatIsNoBlockIsPassedOver) {
  EXPECT_TRUE(read_compas("a.json", R"({"interfaces": [{)" + kMesh + R"(}], "edge": {)" + kMesh + "}}").empty());
  const auto shapes =
      read_compas("a.json", R"({"attributes": {"is_support": true, "name": "base"}, "blocks": [{)" + kMesh + "}]}");
  ASSERT_EQ(shapes.size(), 1u);
  EXPECT_TRUE(shapes[0].support);
  EXPECT_EQ(shapes[0].name, "block_0");
}

// Files before COMPAS 1 have blocks beside the graph, whose nodes, or vertices, define the supports. Every block has
// the name "Block".
TEST(Compas, SupportsOfOldFilesAreInTheGraph) {
  for (const std::string kind : {"node", "vertex"}) {
    const auto shapes = read_compas(
        "a.json", R"({"assembly": {"attributes": {"name": "Assembly"}, "node_attributes": {"is_support": false}, ")" +
                      kind + R"(": {"7": {"x": 1, "is_support": true}, "3": {"x": 1}, "5": {"is_support": false}},
"edge": {}}, "blocks": {"3": {"attributes": {"name": "Block"}, )" +
                      kMesh + R"(}, "7": {"attributes": {"name": "Block"}, )" + kMesh + R"(}, "5": {)" + kMesh + "}}}");
    ASSERT_EQ(shapes.size(), 3u);
    EXPECT_EQ(shapes[0].number + shapes[1].number + shapes[2].number, "375");
    EXPECT_FALSE(shapes[0].support);
    EXPECT_TRUE(shapes[1].support);
    EXPECT_FALSE(shapes[2].support);
    EXPECT_EQ(shapes[1].name, "Block");
    EXPECT_EQ(shapes[2].name, "block_2");
  }
}

// Files of COMPAS 0.18 have the attributes of the last block beside the graph, also a mesh and a support.
TEST(Compas, BlocksOfAGraphAreAllThatItHas) {
  const auto shapes = read_compas(
      "a.json", R"({"attributes": {"name": "Graph"}, "is_support": true, )" + kMesh +
                    R"(, "node": {"0": {"is_support": false, "block": {"value": {)" + kMesh +
                    R"(}}}, "4": {"is_support": true, "block": {"value": {"attributes": {"name": "key"}, )" + kMesh +
                    "}}}}}");
  ASSERT_EQ(shapes.size(), 2u);
  EXPECT_EQ(shapes[0].name, "block_0");  // not the name of the graph
  EXPECT_FALSE(shapes[0].support);
  EXPECT_EQ(shapes[1].name, "key");
  EXPECT_TRUE(shapes[1].support);
}

// A node whose block is null was left out in silence.
TEST(Compas, BlocksWithoutAMeshAreRefused) {
  const std::string node = R"({"node": {"0": {"block": {"value": {)" + kMesh + R"(}}}, "7": {"block": null}}})";
  try {
    read_compas("a.json", node);
    ADD_FAILURE() << "read";
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), HasSubstr("a.json: node.7: its block is no mesh"));
  }
}

TEST(Compas, FaultsNameTheirPlace) {
  const auto refused = [](const std::string& text, const std::string& why) {
    try {
      read_compas("a.json", text);
      ADD_FAILURE() << "read: " << text;
    } catch (const Error& error) {
      EXPECT_EQ(error.exit_code, Exit::bad_input);
      EXPECT_THAT(error.what(), HasSubstr(why));
    }
  };
  refused("{", "a.json: not valid JSON");
  refused(R"({"a": [{}, {"vertex": {"7": {"x": 1, "y": 2}}, "face": {}}]})", "a.json: a.1: vertex 7 has no number z");
  refused(R"({"vertex": {}, "face": {"2": [5]}})", "the file: face 2 has a vertex 5 that is not there");
  refused(R"({"vertex": {}, "face": {"2": 5}})", "face 2 is no list of vertices");
  refused(R"({"transformation": [[1, 0, 0], [0], [0], [0]]})", "no matrix of 4 x 4 numbers");
  refused(R"({"transformation": [["a", 0, 0, 0], [0], [0], [0]]})", "no matrix of 4 x 4 numbers");
  std::string deep = "1";
  for (int i = 0; i < 200; ++i) deep = "[" + deep + "]";
  refused(deep, "nested too deep");
}

}  // namespace
}  // namespace quoin::geometry
