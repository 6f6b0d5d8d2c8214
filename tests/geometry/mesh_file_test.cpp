// Faulty mesh files: each is refused with file and line, and none crashes the reader.
#include "geometry/mesh_file.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <array>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <random>
#include <sstream>

#include "base/error.h"

namespace quoin::geometry {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

const char* const kOff = "OFF\n4 4 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 1 2 3\n3 0 3 2\n";
const char* const kObj = "o wedge\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2/1 3/2 4//3\nf -4 -1 -2\n";

std::string ascii_stl() {
  std::string text = "solid wedge#1\n";
  for (const char* facet : {"0 0 0/0 1 0/1 0 0", "0 0 0/1 0 0/0 0 1", "1 0 0/0 1 0/0 0 1", "0 0 0/0 0 1/0 1 0"}) {
    text += "facet normal 0 0 0\nouter loop\nvertex ";
    for (const char* c = facet; *c; ++c) text += *c == '/' ? "\nvertex " : std::string(1, *c);
    text += "\nendloop\nendfacet\n";
  }
  return text + "endsolid\n";
}

std::string binary_stl() {
  const int corners[4][3] = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}};
  std::string bytes(80, ' ');
  const uint32_t count = 4;
  bytes.append(reinterpret_cast<const char*>(&count), 4);
  for (const auto& triangle : corners) {
    float record[12] = {};
    for (int k = 0; k < 3; ++k) {
      if (triangle[k] > 0) record[3 + 3 * k + triangle[k] - 1] = 1.0f;
    }
    bytes.append(reinterpret_cast<const char*>(record), 48).append(2, '\0');
  }
  return bytes;
}

class BadMeshFile : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::temp_directory_path() /
              (std::string("quoin_mesh_") + ::testing::UnitTest::GetInstance()->current_test_info()->name() + "_" +
               std::to_string(getpid()));
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  std::vector<NamedShape> read(const std::string& ending, const std::string& bytes) {
    const std::string file = (folder_ / ("m." + ending)).string();
    std::ofstream(file, std::ios::binary) << bytes;
    return read_mesh_file(file);
  }
  std::string refusal(const std::string& ending, const std::string& bytes) {
    try {
      read(ending, bytes);
    } catch (const Error& error) {
      EXPECT_EQ(error.exit_code, Exit::bad_input);
      return error.what();
    }
    return "accepted";
  }
  // Returns the message for a valid file in which `from` is replaced by `to`.
  std::string refusal(const std::string& ending, std::string text, const std::string& from, const std::string& to) {
    const size_t at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    return refusal(ending, text.replace(at, from.size(), to));
  }

  std::filesystem::path folder_;
};

TEST_F(BadMeshFile, TheGoodOnesAreGood) {
  for (const auto& [ending, bytes] :
       std::vector<std::pair<std::string, std::string>>{{"off", kOff},
                                                        {"off", "OFF 4 4 0\n" + std::string(kOff).substr(10)},
                                                        {"off", std::string(kOff).substr(4)},
                                                        {"obj", kObj},
                                                        {"obj", "\xEF\xBB\xBF" + std::string(kObj)},
                                                        {"stl", ascii_stl()},
                                                        {"stl", binary_stl()}}) {
    const auto shapes = read(ending, bytes);
    ASSERT_EQ(shapes.size(), 1u);
    EXPECT_DOUBLE_EQ(mass_properties(shapes[0].shape).volume, 1.0 / 6);
  }
  EXPECT_EQ(read("stl", ascii_stl())[0].name, "wedge#1");
}

// An object without a name has the name of the file and its index in it, from 0.
TEST_F(BadMeshFile, ObjectsAreCalledAsTheFileSaysOrByTheirPlace) {
  const auto names = [&](const std::string& ending, const std::string& bytes) {
    std::vector<std::string> list;
    for (const NamedShape& shape : read(ending, bytes)) list.push_back(shape.name);
    return list;
  };
  const std::string body = std::string(kObj).substr(8);
  const std::string faces = "f -4 -2 -3\nf -4 -3 -1\nf -3 -2 -1\nf -4 -1 -2\n";
  const std::string next = "v 5 0 0\nv 6 0 0\nv 5 1 0\nv 5 0 1\n" + faces;
  EXPECT_THAT(names("obj", "o\n" + body + "g post\n" + next + "o\n" + next), ElementsAre("m#0", "post", "m#2"));
  EXPECT_THAT(names("obj", body), ElementsAre("m"));
  // Names may have blanks. Equal names get an index, and several bodies of one object get a number.
  EXPECT_THAT(names("obj", "o left post\n" + body + "o lintel\n" + next + "o lintel\n" + next),
              ElementsAre("left post", "lintel#1", "lintel#2"));
  EXPECT_THAT(names("obj", "o posts\n" + body + next), ElementsAre("posts/0", "posts/1"));
  // Mirrored in its face z = 0: two bodies that touch.
  const std::string below = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 -1\n" + faces;
  EXPECT_THAT(names("obj", "o pair\n" + body + below), ElementsAre("pair/0", "pair/1"));
  // Two opposite triangles with nearly equal corners: a closed surface, which is degenerate.
  EXPECT_THAT(refusal("obj", "v 0 0 0\nv 1e-9 0 0\nv 0 1 0\nf 1 2 3\nf 3 2 1\n"),
              HasSubstr("block '': has no face with an area"));
  EXPECT_THAT(refusal("obj", "o flat\nv 0 0 0\nv 1 0 0\nf 1 2 1\n"),
              HasSubstr("block 'flat': has no face with an area"));
  const std::string named = ascii_stl();
  const std::string nameless = "solid" + named.substr(named.find('\n'));
  EXPECT_THAT(names("stl", nameless + named + nameless), ElementsAre("m#0", "wedge#1", "m#2"));
  EXPECT_THAT(names("off", kOff), ElementsAre("m"));
}

// Returns a unit cube as OBJ, whose corner (1, 1, 1) is raised: its top is warped.
std::string cube(double raised, const std::string& name = "cube", double x = 0.0) {
  std::string text = "o " + name + "\n";
  for (int i = 0; i < 8; ++i)
    text += fmt::format("v {} {} {}\n", x + (i & 1), (i >> 1 & 1) * (i == 7 ? 1 + raised : 1), i >> 2);
  for (const auto& f : {"1 5 7 3", "2 4 8 6", "1 2 6 5", "3 7 8 4", "1 3 4 2", "5 6 8 7"}) {
    text += "f";
    std::istringstream corners(f);
    for (int c; corners >> c;) text += fmt::format(" {}", c - 9);
    text += "\n";
  }
  return text;
}

// The plane with Newell's normal through (0, 1, 0), (1, 1, 0), (0, 1, 1), (1, 1 + h, 1) has a distance of h/4 from
// each, above two and below two; vertical faces stay planes. Corners move along vertical edges by h/4, and the volume
// is that of the mean height, 1 + h/4.
TEST_F(BadMeshFile, WarpedFacesBecomePlanesThroughTheMiddle) {
  for (const double h : {1e-5, 1e-4, 1e-3, 1e-2}) {
    const NamedShape block = read("obj", cube(h)).at(0);
    EXPECT_EQ(block.shape.faces.size(), 6u);
    EXPECT_EQ(block.shape.vertices.size(), 8u);
    EXPECT_NEAR(block.warp, h / 4, 1e-3 * h);
    EXPECT_NEAR(mass_properties(block.shape).volume, 1 + h / 4, 1e-6 * h + 1e-12);
    EXPECT_EQ(fault_of_faces(block.shape.vertices, block.shape.faces), "");
    for (const Vector& p : block.shape.vertices) {
      const bool up = p.y > 0.5;
      const double drawn = up && p.x > 0.5 && p.z > 0.5 ? 1 + h : (up ? 1.0 : 0.0);
      EXPECT_NEAR(std::abs(p.y - drawn), up ? h / 4 : 0.0, 1e-3 * h);
    }
  }
  EXPECT_EQ(read("obj", cube(0)).at(0).warp, 0.0);
  for (const double h : {0.05, -0.05})
    EXPECT_THAT(refusal("obj", cube(h)),
                AllOf(HasSubstr("m.obj: block cube: a face is not planar: its corner"),
                      HasSubstr("lies 0.0125 m off the plane (allowed: 0.005"), HasSubstr("triangles")));
}

// Two blocks with common corners of a warped face have one plane there, without a gap.
TEST_F(BadMeshFile, NeighboursShareThePlaneOfAWarpedFace) {
  const double h = 1e-3;
  std::string upper = "o upper\n";
  for (int i = 0; i < 8; ++i)
    upper += fmt::format("v {} {} {}\n", i & 1, i >> 1 & 1 ? 2.0 : ((i & 5) == 5 ? 1 + h : 1.0), i >> 2);
  for (const auto& f : {"9 13 15 11", "10 12 16 14", "9 10 14 13", "11 15 16 12", "9 11 12 10", "13 14 16 15"})
    upper += fmt::format("f {}\n", f);
  const auto blocks = read("obj", cube(h) + upper);
  ASSERT_EQ(blocks.size(), 2u);
  int shared = 0;
  for (const Vector& p : blocks[0].shape.vertices) {
    for (const Vector& q : blocks[1].shape.vertices) shared += norm(p - q) < 1e-6 * h;
  }
  EXPECT_EQ(shared, 4);
}

// Rhino writes some blocks inside out, some with every face twice, some with separate corners for every face.
TEST_F(BadMeshFile, FacesMayRunEitherWayRoundAndComeTwice) {
  std::string twice = cube(0), inside_out, own_corners = "o cube\n";
  for (const auto& f : {"-4 -2 -6 -8", "-7 -5 -1 -3"}) twice += fmt::format("f {}\n", f);
  std::istringstream lines(cube(0));
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with("f")) {
      std::istringstream words(line.substr(1));
      std::array<std::string, 4> c;
      for (auto& word : c) words >> word;
      line = "f " + c[3] + " " + c[2] + " " + c[1] + " " + c[0];
    }
    inside_out += line + "\n";
  }
  const ConvexPolyhedron body = read("obj", cube(0)).at(0).shape;
  for (const auto& face : body.faces) {
    for (int i : face) {
      const Vector& p = body.vertices[size_t(i)];
      own_corners += fmt::format("v {} {} {}\n", p.x, p.y, p.z);
    }
    own_corners += "f -4 -3 -2 -1\n";
  }
  for (const std::string& text : {twice, inside_out, own_corners})
    EXPECT_DOUBLE_EQ(mass_properties(read("obj", text).at(0).shape).volume, 1.0);
}

TEST_F(BadMeshFile, AllThatIsRefusedIsNamed) {
  const std::string l_shape = [] {  // a prism over an L
    std::string text = "o L\n";
    for (int z : {0, 1}) {
      for (const char* p : {"0 0", "2 0", "2 1", "1 1", "1 2", "0 2"}) text += fmt::format("v {} {}\n", p, z);
    }
    text += "f 6 5 4 3 2 1\nf 7 8 9 10 11 12\n";
    for (int i = 0; i < 6; ++i) text += fmt::format("f {} {} {} {}\n", i + 1, (i + 1) % 6 + 1, (i + 1) % 6 + 7, i + 7);
    return text;
  }();
  EXPECT_THAT(refusal("obj", l_shape), AllOf(HasSubstr("m.obj: block L: is not convex: near"), HasSubstr("`unit`"),
                                             HasSubstr("convex parts"), HasSubstr("inside_units")));
  EXPECT_THAT(refusal("obj", l_shape + cube(0) + cube(0.2, "post")),
              HasSubstr("2 of the file's 3 blocks are refused: L, post"));
}

// A support drawn as a flat face becomes a plate, a tenth of its extent thick, on the side away from the blocks.
TEST_F(BadMeshFile, SupportsDrawnAsOneFaceArePlates) {
  const std::string floor = "o floor\nv -1 0 -1\nv 3 0 -1\nv 3 0 1\nv -1 0 1\n", face = "f -4 -3 -2 -1\n";
  for (const std::string& way_round : {face, std::string("f -1 -2 -3 -4\n")}) {
    const auto fixed = [](const std::string& name) { return name == "floor"; };
    std::ofstream(folder_ / "m.obj") << cube(0) << floor << way_round;
    const auto blocks = read_mesh_file((folder_ / "m.obj").string(), 1.0, fixed);
    ASSERT_EQ(blocks.size(), 2u);
    EXPECT_FALSE(blocks[0].plate || blocks[0].support);
    EXPECT_TRUE(blocks[1].plate && blocks[1].support);
    const MassProperties plate = mass_properties(blocks[1].shape);
    EXPECT_DOUBLE_EQ(plate.volume, 4 * 2 * 0.4);
    EXPECT_DOUBLE_EQ(plate.centroid.y, -0.2);
  }
  EXPECT_THAT(refusal("obj", cube(0) + floor + face),
              AllOf(HasSubstr("block floor: is drawn as a flat face"), HasSubstr("is_support"), HasSubstr("`fixed`")));
}

// A closed volume is a block whatever its thickness, free or fixed. Tolerance: rounding of sums of squares.
TEST_F(BadMeshFile, ThinClosedBlocksAreNoPlates) {
  for (const double thickness : {1e-4, 4e-3, 8e-3, 2e-2}) {
    std::string text = "o tile\n";
    for (const double y : {0.0, thickness})
      for (const char* corner : {"0 {} 0", "1 {} 0", "1 {} 0.1", "0 {} 0.1"})
        text += "v " + fmt::format(fmt::runtime(corner), y) + "\n";
    text += "f 1 2 3 4\nf 8 7 6 5\nf 1 5 6 2\nf 2 6 7 3\nf 3 7 8 4\nf 4 8 5 1\n";
    std::ofstream(folder_ / "m.obj") << text;
    for (const bool fixed : {true, false}) {
      const auto blocks = read_mesh_file((folder_ / "m.obj").string(), 1.0, [&](const std::string&) { return fixed; });
      ASSERT_EQ(blocks.size(), 1u);
      EXPECT_FALSE(blocks[0].plate);
      EXPECT_NEAR(mass_properties(blocks[0].shape).volume, 0.1 * thickness, 1e-12);
    }
  }
}

TEST_F(BadMeshFile, NumbersOfCornersAreWholeAndInRange) {
  for (const char* wrong : {"-1", "0", "2", "1.7", "4294967299", "9223372036854775807", "1e1", "nan", "three"}) {
    EXPECT_THAT(
        refusal("off", kOff, "3 1 2 3", std::string(wrong) + " 1 2 3"),
        AllOf(HasSubstr("m.off:9: number of corners '" + std::string(wrong) + "'"), HasSubstr("an integer, 3 to")));
  }
  EXPECT_THAT(refusal("off", kOff, "3 1 2 3", "4 1 2 3"), HasSubstr("m.off:9: a face of 4 corners has 3 indices"));
}

TEST_F(BadMeshFile, VertexNumbersAreWholeAndInRange) {
  for (const char* wrong : {"-1", "4", "1.7", "1.0", "4294967297", "18446744073709551617", "nan", "x"}) {
    EXPECT_THAT(
        refusal("off", kOff, "3 1 2 3", "3 1 " + std::string(wrong) + " 3"),
        AllOf(HasSubstr("m.off:9: vertex number '" + std::string(wrong) + "'"), HasSubstr("an integer, 0 to 3")));
  }
  for (const char* wrong : {"0", "5", "1.7", "4294967297", "x", "/1"}) {
    EXPECT_THAT(refusal("obj", kObj, "f 1 3 2", "f 1 " + std::string(wrong) + " 2"),
                AllOf(HasSubstr("m.obj:6: vertex number"), HasSubstr("an integer, 1 to 4")))
        << wrong;
  }
  for (const char* wrong : {"-5", "-4294967297", "-1.7", "-x"}) {
    EXPECT_THAT(refusal("obj", kObj, "f 1 3 2", "f 1 " + std::string(wrong) + " 2"),
                AllOf(HasSubstr("m.obj:6: vertex number '" + std::string(wrong) + "'"), HasSubstr("-4 to -1")));
  }
  EXPECT_THAT(refusal("obj", "f 1 2 3\n"), HasSubstr("no vertices yet"));
  EXPECT_THAT(refusal("obj", kObj, "f 1 3 2", "f 1 3"), HasSubstr("m.obj:6: a face of 2 corners"));
}

TEST_F(BadMeshFile, CountsAreNotBelieved) {
  for (const char* wrong : {"-4", "1.5", "4294967300", "1e3", "nan"}) {
    EXPECT_THAT(refusal("off", kOff, "4 4 0", std::string(wrong) + " 4 0"),
                HasSubstr("m.off:2: number of vertices '" + std::string(wrong) + "'"));
    EXPECT_THAT(refusal("off", kOff, "4 4 0", "4 " + std::string(wrong) + " 0"),
                HasSubstr("m.off:2: number of faces '" + std::string(wrong) + "'"));
  }
  EXPECT_THAT(refusal("off", kOff, "4 4 0", "4 9999999 0"), HasSubstr("m.off:10: the file ends too early"));
  EXPECT_THAT(refusal("off", kOff, "4 4 0", "4 3 0"), HasSubstr("m.off:10: '3' after the last of 3 faces"));
  EXPECT_THAT(refusal("off", ""), HasSubstr("the file ends too early"));
  std::string many = binary_stl();
  std::memset(many.data() + 80, 0xff, 4);
  EXPECT_THAT(refusal("stl", many), HasSubstr("284 bytes, but a binary STL file of the 4294967295 triangles"));
  EXPECT_THAT(refusal("stl", binary_stl().substr(0, 200)),
              HasSubstr("200 bytes, but a binary STL file of the 4 triangles that it announces has 284"));
}

TEST_F(BadMeshFile, CoordinatesAreFinite) {
  for (const char* wrong : {"nan", "inf", "1e999", "0x1", "1,5", "one"}) {
    EXPECT_THAT(refusal("off", kOff, "1 0 0", std::string(wrong) + " 0 0"),
                HasSubstr("m.off:4: '" + std::string(wrong)));
    EXPECT_THAT(refusal("obj", kObj, "1 0 0", std::string(wrong) + " 0 0"),
                HasSubstr("m.obj:3: '" + std::string(wrong)));
    EXPECT_THAT(refusal("stl", ascii_stl(), "1 0 0", std::string(wrong) + " 0 0"),
                HasSubstr("m.stl:6: '" + std::string(wrong)));
  }
  EXPECT_THAT(refusal("off", kOff, "1 0 0", "1 0"), HasSubstr("m.off:4: a vertex needs three coordinates"));
  std::string bytes = binary_stl();
  const float not_a_number = NAN;
  std::memcpy(bytes.data() + 84 + 50 + 12 + 24, &not_a_number, 4);
  EXPECT_THAT(refusal("stl", bytes), HasSubstr("triangle 1, corner 2: a coordinate is not finite"));
}

TEST_F(BadMeshFile, FacetsOfStlHaveThreeVertices) {
  EXPECT_THAT(refusal("stl", ascii_stl(), "vertex 1 0 0\n", ""), HasSubstr("m.stl:6: a facet needs three vertices"));
  EXPECT_THAT(refusal("stl", ascii_stl(), "outer loop\n", ""), HasSubstr("m.stl:3: misplaced vertex"));
  EXPECT_THAT(refusal("stl", ascii_stl(), "endloop", "solid other"), HasSubstr("m.stl:7: misplaced 'solid'"));
  const std::string text = ascii_stl();
  EXPECT_THAT(refusal("stl", text.substr(0, text.rfind("endloop"))), HasSubstr("ends within a facet"));
}

// Mutated files are read or refused as bad input. With sanitizers this test finds accesses beyond arrays and
// conversions that overflow an integer.
TEST_F(BadMeshFile, MutatedFilesAreReadOrRefused) {
  const std::vector<std::pair<std::string, std::string>> seeds = {
      {"off", kOff}, {"obj", kObj}, {"stl", ascii_stl()}, {"stl", binary_stl()}};
  const std::vector<std::string> words = {"-1",     "4294967297", "1.7",     "nan", "inf", "9223372036854775808",
                                          "99999",  "0",          "solid",   "o",   "f",   "v",
                                          "vertex", "outer",      "endloop", "#",   "\n",  "1e308"};
  std::mt19937 random(20261122);
  const auto below = [&](size_t n) { return random() % n; };
  for (int round = 0; round < 3000; ++round) {
    auto [ending, bytes] = seeds[below(seeds.size())];
    for (size_t changes = 1 + below(3); changes > 0 && !bytes.empty(); --changes) {
      const size_t at = below(bytes.size());
      switch (below(6)) {
        case 0:
          bytes[at] = static_cast<char>(random());
          break;
        case 1:
          bytes.erase(at, below(20));
          break;
        case 2:
          bytes.insert(at, words[below(words.size())]);
          break;
        case 3:
          bytes.resize(at);
          break;
        case 4: {  // replaces a word by another
          const size_t begin = bytes.find_last_of(" \n", at) + 1,
                       end = std::min(bytes.find_first_of(" \n", at), bytes.size());
          if (begin < end) bytes.replace(begin, end - begin, words[below(words.size())]);
          break;
        }
        default:
          bytes.insert(at, bytes.substr(below(bytes.size()), below(60)));
      }
    }
    try {
      read(ending, bytes);
    } catch (const Error& error) {
      ASSERT_EQ(error.exit_code, Exit::bad_input) << error.what();
    } catch (const std::exception& error) {
      FAIL() << "round " << round << ": " << error.what();
    }
  }
}

}  // namespace
}  // namespace quoin::geometry
