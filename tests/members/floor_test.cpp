// Floors as diaphragms between walls, against closed forms.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <vector>

#include "base/error.h"
#include "scenes.h"

namespace quoin {
namespace {

using members_cases::box;
using members_cases::head;
using ::testing::AllOf;
using ::testing::HasSubstr;

constexpr double kLength = 6.0, kBreadth = 4.0, kMass = 100.0;  // m, m, kg/m2

struct Floor {
  double axial = 1e9, shear = 1e6;  // N/m
  std::string keys;
  std::string connector = "axial_stiffness = 1e9, shear_stiffness = 1e9";
  double spacing = 0.5, damping = 40.0;
};

// Returns a floor between two walls at its ends, which are fixed unless `right` has other keys.
std::string floor_between(const Floor& f, const std::string& right = "fixed = true") {
  return head(30.0, 1e9, f.damping) + box("left", "[-1, 0, -1]", "[1, 1, 6]", "fixed = true") +
         box("right", fmt::format("[{}, 0, -1]", kLength), "[1, 1, 6]", right) +
         fmt::format(
             "[[floor]]\nname = \"f\"\ncorner = [0, 0.5, 0]\nalong = [{}, 0, 0]\nacross = [0, 0, {}]\n"
             "spacing = {}\naxial_stiffness = [{}, {}]\nshear_stiffness = {}\nmass = {}\nspan = \"along\"\n"
             "connector = {{ {} }}\n{}\n",
             kLength, kBreadth, f.spacing, f.axial, f.axial, f.shear, kMass, f.connector, f.keys);
}

std::string pushed(double across, double ramp, double duration) {
  return fmt::format("[[stage]]\ngravity = [0, 0, {}]\nramp_time = {}\nduration = {}\n", across, ramp, duration);
}

// Returns the largest displacement of the floor across its span, m.
double sag(const Simulation& simulation) {
  const members::Floor& floor = simulation.large_motion()->held_by.members.get()->floors().front();
  double largest = 0.0;
  for (int i = 0; i <= floor.grid().pieces[0]; ++i) {
    for (int j = 0; j <= floor.grid().pieces[1]; ++j)
      largest =
          std::max(largest, std::abs(floor.place_now(floor.place_at(i, j)).z - floor.start_of(floor.place_at(i, j)).z));
  }
  return largest;
}

double rested(const std::string& scene, Simulation** kept = nullptr) {
  static std::unique_ptr<Simulation> simulation;
  simulation = std::make_unique<Simulation>(read_scene_text(scene, "floor.toml"), 1);
  Observer nobody;
  simulation->run(nobody);
  if (kept) *kept = simulation.get();
  return sag(*simulation);
}

// A connector of 0.5 m that carries 1 m2 of 10 kg/m2, by hand. Anchors have 50 N/m up to 1.5 N. Shear has 25 N/m up to
// 0.5 N and half of the weight of 98.1 N. Its block moves by -x away from the floor.
TEST(Floors, AConnectorAnchorsBearsSlidesAndIsPulledOut) {
  members::Floor floor("f", {{}, {1, 0, 0}, {0, 0, 1}, {2.0, 1.0}, {1, 1}}, {300.0, 600.0, 90.0, 1e9, 10.0, 0.0},
                       {100.0, 50.0, 3.0, 1.0, 0.5, 0.5, true});
  members::Floor::Connector connector;
  connector.out = {-1, 0}, connector.length = 0.5, connector.carried = 1.0;
  floor.connectors() = {connector};
  members::Surroundings step{};
  step.gravity = {0, -9.81, 0};
  std::vector<members::Node> nodes(1);
  const auto pull = [&](const geometry::Vector& moved) {
    nodes[0].x = moved, nodes[0].force = {};
    floor.pull(nodes, step);
    return nodes[0].force;
  };
  const auto near = [](const geometry::Vector& a, const geometry::Vector& b) {
    EXPECT_NEAR(norm(a - b), 0.0, 1e-9) << a.x << " " << a.y << " " << a.z;
  };
  near(pull({-0.02, 0, 0.3}), {1.0, -98.1, -7.5});
  EXPECT_NEAR(floor.work().stored, 0.5 * 1.0 * 0.02 + 0.5 * 7.5 * 0.3, 1e-12);
  EXPECT_NEAR(floor.work().dissipated, 0.0, 1e-12);
  EXPECT_NEAR(floor.largest_anchor(), 2.0, 1e-12) << "N/m";
  near(pull({-0.05, -0.01, 0.3}), {1.5, -98.1, -7.5});  // anchors draw by 0.02 m; the weight sinks by 0.01 m
  EXPECT_NEAR(floor.largest_drawn(), 0.02, 1e-12);
  EXPECT_NEAR(floor.work().stored, 0.5 * 1.5 * 0.03 + 0.5 * 7.5 * 0.3, 1e-12);
  EXPECT_NEAR(floor.work().dissipated, 1.25 * 0.03 - (0.0225 - 0.01), 1e-12);
  EXPECT_NEAR(floor.work().outside, 98.1 * 0.01, 1e-12);
  near(pull({0.01, -0.01, 0.3}), {-0.5, -98.1, -7.5});  // bears
  EXPECT_EQ(floor.largest_anchor(), 0.0);
  near(pull({0.01, -0.01, 3.0}), {-0.5, -98.1, -49.55});
  EXPECT_NEAR(floor.largest_slid(), 3.0 - 49.55 / 25.0, 1e-9);
  near(pull({-0.6, -0.01, 3.0}), {0.0, -98.1, -49.05});  // friction is left
  EXPECT_EQ(floor.pulled_out_length(), 0.5);
  near(pull({-0.04, -0.01, 0.1}), {0.0, -98.1, 25.0 * 2.9 - 49.05});
}

// Shear beam under its inertia force: q L^2/(8 G B) at midspan, plus the deformation of connectors along the walls,
// q L/(2 ks B). Tolerance 1 %, for remaining motion and for bending, a share of 1e-3.
TEST(Floors, DiaphragmIsAShearBeam) {
  const double q = kMass * kBreadth * 1.0;
  const double shear = q * kLength * kLength / (8 * 1e6 * kBreadth);
  for (const double ks : {1e9, 1e6}) {
    Floor f;
    f.connector = fmt::format("axial_stiffness = 1e9, shear_stiffness = {:g}", ks);
    const double expected = shear + q * kLength / (2 * ks * kBreadth);
    const double measured = rested(floor_between(f) + pushed(1.0, 0.2, 1.0));
    std::printf("  | shear beam: %.5g m, closed form %.5g m\n", measured, expected);
    EXPECT_NEAR(measured / expected, 1.0, 0.01);
  }
}

// A membrane whose axial stiffness is near its shear stiffness bends as a beam with fixed ends. That adds q L^4/(384 E
// I), E I = Ka B^3/12. Its shear flow is parabolic: 6/5 of the deflection. Tolerance 3 %: its ends do not warp.
TEST(Floors, DiaphragmBendsInItsPlane) {
  Floor f;
  f.axial = 2e6, f.spacing = 0.25;
  f.connector = "axial_stiffness = 1e9, shear_stiffness = 1e9";
  const double q = kMass * kBreadth, inertia = kBreadth * kBreadth * kBreadth / 12;
  const double expected =
      1.2 * q * std::pow(kLength, 2) / (8 * f.shear * kBreadth) + q * std::pow(kLength, 4) / (384 * f.axial * inertia);
  const double measured = rested(floor_between(f) + pushed(1.0, 0.2, 1.2));
  std::printf("  | beam with shear: %.5g m, closed form %.5g m\n", measured, expected);
  EXPECT_NEAR(measured / expected, 1.0, 0.03);
}

// Both ends yield at q L/2 = ty B: the floor is stable just below this load and moves without limit just above.
// Energies balance.
TEST(Floors, DiaphragmYieldsInShear) {
  Floor f;
  f.damping = 4.0;
  const double limit = kMass * kLength / 2;  // yield shear flow ty for 1 m/s2, N/m
  f.keys = fmt::format("shear_yield = {}\n", limit);
  Simulation* simulation = nullptr;
  // A panel has the mean shear flow of its length: the first one that of its middle, 0.25 m from the wall.
  const double first = 1.0 / (1.0 - 0.25 / (kLength / 2));
  const double below = rested(floor_between(f) + pushed(0.97 * first, 0.5, 2.5), &simulation);
  EXPECT_EQ(simulation->large_motion()->held_by.members.get()->floors().front().plastic_shear(), 0.0);
  const double above = rested(floor_between(f) + pushed(1.03 * first, 0.5, 2.5), &simulation);
  const members::Floor& floor = simulation->large_motion()->held_by.members.get()->floors().front();
  EXPECT_GT(floor.plastic_shear(), 0.01);
  EXPECT_LE(floor.largest_shear(), limit * (1 + 1e-12));
  EXPECT_GT(above, 5 * below);
  const Energies& e = simulation->large_motion()->step_sums.energies;
  EXPECT_GT(e.members_dissipated, 0.0);
  EXPECT_LT(std::abs(e.balance_error()), 1e-3 * e.external);
}

// A wall that moves away: anchors carry up to their strength per metre of edge, and nothing after they have pulled out.
TEST(Floors, AnchorsYieldAndPullOut) {
  Floor f;
  f.connector = "axial_stiffness = 1e8, shear_stiffness = 1e8, axial_strength = 5e3, pull_out = 0.01";
  const auto drawn = [&](double way) {
    return read_scene_text(
        floor_between(f, "") + fmt::format("[[stage]]\nduration = {}\nramp_time = 0.1\n[[stage.velocity]]\nblock = "
                                           "\"right\"\nvelocity = [0.02, 0, 0]\n",
                                           0.05 + way / 0.02),
        "floor.toml");
  };
  Observer nobody;
  Simulation held(drawn(0.008), 1), out(drawn(0.03), 1);
  held.run(nobody), out.run(nobody);
  const members::Floor &yields = held.large_motion()->held_by.members.get()->floors().front(),
                       &is_out = out.large_motion()->held_by.members.get()->floors().front();
  EXPECT_NEAR(yields.largest_anchor(), 5e3, 1e-6);
  EXPECT_EQ(yields.pulled_out_length(), 0.0);
  EXPECT_GE(is_out.pulled_out_length(), kBreadth - 1e-9);  // one edge or both
  const Energies& e = out.large_motion()->step_sums.energies;
  // Both edges yield before one pulls out: strength times displacement of each, less the elastic part.
  EXPECT_GT(e.members_dissipated, 5e3 * kBreadth * 0.009);
  EXPECT_LT(std::abs(e.balance_error()), 0.01 * e.external);
}

// Each of the two walls at the ends of the joists carries half of a floor's weight.
TEST(Floors, WeightGoesToTheWallsThatJoistsEndOn) {
  Floor f;
  f.keys = "load = 981.0\n";
  Simulation simulation(read_scene_text(floor_between(f) + pushed(0.0, 0.1, 0.2), "floor.toml"), 1);
  const members::Floor& floor = simulation.large_motion()->held_by.members.get()->floors().front();
  double left = 0.0, right = 0.0;
  for (const members::Floor::Connector& c : floor.connectors()) {
    const Vec3 at = geometry::array(floor.start_of(c.place));
    (at[0] < kLength / 2 ? left : right) += c.carried;
  }
  EXPECT_NEAR(left, kLength * kBreadth / 2, 1e-9);
  EXPECT_NEAR(right, kLength * kBreadth / 2, 1e-9);
  Simulation heavy(
      read_scene_text(floor_between(f) + "[[stage]]\ngravity = [0, -9.81, 0]\nramp_time = 0.1\nduration = 0.2\n",
                      "floor.toml"),
      1);
  Observer nobody;
  heavy.run(nobody);
  geometry::Vector sum;
  for (const members::Node& node : heavy.large_motion()->held_by.members.get()->nodes()) sum += node.force;
  EXPECT_NEAR(sum.y, -(kMass * 9.81 + 981.0) * kLength * kBreadth, 1e-6 * 47e3);
  EXPECT_NEAR(sum.x, 0.0, 1e-6);
}

// The right wall ends at z = 2, so that lines from 2.25 to 4 have one wall: 1.75 of 4 m, whose weight moves from x = 3
// to 0. Nothing was said of it.
TEST(Floors, WeightOfLinesWithOneWallIsWarnedOf) {
  const auto warning = [](const std::string& size) {
    std::string scene = floor_between({}) + pushed(0.0, 0.01, 0.02);
    scene.replace(scene.rfind("[1, 1, 6]"), 9, size);
    Simulation simulation(read_scene_text(scene, "floor.toml"), 1);
    Observer nobody;
    simulation.run(nobody);
    for (const Warning& w : simulation.outcome().warnings)
      if (w.about == "floor") return w.text;
    return std::string();
  };
  EXPECT_EQ(warning("[1, 1, 6]"), "");
  EXPECT_THAT(warning("[1, 1, 3]"), AllOf(HasSubstr("floor 'f'"), HasSubstr("1.31 m beside its middle")));
}

// A floor between walls of one block each: w and e at its ends, s and n along its sides.
std::string floor_in_box(const std::vector<std::string>& order, const std::string& floor,
                         const std::map<std::string, std::pair<const char*, const char*>>& walls) {
  std::string text = head(30.0, 1e9, 40.0) + "[[joint_rule]]\nfamily = \"none\"\nnormal = \"horizontal\"\n";
  for (const std::string& name : order)
    text += box(name, walls.at(name).first, walls.at(name).second, name == "n" ? "" : "fixed = true");
  return text + "[[floor]]\nname = \"f\"\naxial_stiffness = [20e6, 30e6]\nshear_stiffness = 1e6\nmass = 100\n" + floor;
}

const std::vector<std::vector<std::string>> kOrders{{"w", "e", "s", "n"}, {"s", "n", "w", "e"}, {"n", "w", "s", "e"}};

// Area of the floor whose weight a block carries, by its name, m2.
std::map<std::string, double> carried_by(const Simulation& simulation) {
  std::map<std::string, double> area;
  const blocks::Model& model = *simulation.large_motion();
  for (const auto& connector : model.held_by.members->floors().front().connectors()) {
    const int block = model.held_by.members->nodes()[static_cast<std::size_t>(connector.node)].block;
    area[model.assembly.blocks[static_cast<std::size_t>(block)].name] += connector.carried;
  }
  return area;
}

// Each of a corner's two connectors joins the wall of its own edge, so that n is held by L/(2/ka + B/K2). Both joined
// the first block of the scene: with one panel n was held by nothing, and w and e carried all of the weight. 1e-4: the
// motion that is left after 0.5 s.
TEST(Floors, CornersJoinTheWallsOfTheirEdgesInAnyOrderOfBlocks) {
  const double length = 5.0, breadth = 3.0, ka = 20e6;
  const std::string floor =
      "corner = [0, 2.5, 0]\nalong = [5, 0, 0]\nacross = [0, 0, 3]\nspan = \"across\"\n"
      "connector = { axial_stiffness = 20e6, shear_stiffness = 0.0, axial_strength = 1e6 }\n";
  for (const double spacing : {5.0, 0.5}) {
    for (const std::vector<std::string>& order : kOrders) {
      const std::string scene = floor_in_box(order, floor + fmt::format("spacing = {}\n", spacing),
                                             {{"w", {"[-0.3, 0, 0]", "[0.3, 3, 3]"}},
                                              {"e", {"[5, 0, 0]", "[0.3, 3, 3]"}},
                                              {"s", {"[0, 0, -0.3]", "[5, 3, 0.3]"}},
                                              {"n", {"[0, 0, 3]", "[5, 3, 0.3]"}}}) +
                                R"([[stage]]
duration = 0.1
[[stage.velocity]]
block = "n"
velocity = [0, 0, 0.01]
[[stage]]
duration = 0.5
[[stage.velocity]]
block = "n"
velocity = [0, 0, 0]
)";
      Simulation simulation(read_scene_text(scene, "floor.toml"), 1);
      std::map<std::string, double> area = carried_by(simulation);
      const std::string what = fmt::format("spacing {}, first block {}", spacing, order.front());
      for (const char* wall : {"s", "n"}) EXPECT_NEAR(area[wall], length * breadth / 2, 1e-9) << what << wall;
      for (const char* wall : {"w", "e"}) EXPECT_EQ(area[wall], 0.0) << what << wall;
      Observer nobody;
      simulation.run(nobody);
      double pull = 0.0, way = 0.0;
      for (const members::Node& node : simulation.large_motion()->held_by.members->nodes()) {
        if (simulation.large_motion()->assembly.blocks[static_cast<std::size_t>(node.block)].name == "n")
          pull -= node.force.z, way = node.x.z - node.start.z;
      }
      const double expected = way * length / (2.0 / ka + breadth / 30e6);
      EXPECT_NEAR(pull, expected, 1e-4 * expected) << what;
    }
  }
}

// Edges in the middle of walls: their corners lie in s and n, which go on past the ends of w and e. One panel's
// connectors along w and e stand for 1.65 m, of which 0.15 m lies in s or n.
TEST(Floors, CornersInACrossWallJoinTheWallOfTheirEdge) {
  for (const std::vector<std::string>& order : kOrders) {
    const Simulation simulation(
        read_scene_text(
            floor_in_box(order,
                         "corner = [-0.15, 2.5, -0.15]\nalong = [5.3, 0, 0]\nacross = [0, 0, 3.3]\nspacing = 6\n"
                         "span = \"along\"\nconnector = { axial_stiffness = 20e6, shear_stiffness = 20e6 }\n",
                         {{"w", {"[-0.3, 0, 0]", "[0.3, 3, 3]"}},
                          {"e", {"[5, 0, 0]", "[0.3, 3, 3]"}},
                          {"s", {"[-0.3, 0, -0.3]", "[5.6, 3, 0.3]"}},
                          {"n", {"[-0.3, 0, 3]", "[5.6, 3, 0.3]"}}}) +
                pushed(0.0, 0.1, 0.2),
            "floor.toml"),
        1);
    std::map<std::string, double> area = carried_by(simulation);
    EXPECT_NEAR(area["w"], 5.3 * 3.3 / 2, 1e-9) << order.front();
    EXPECT_NEAR(area["e"], 5.3 * 3.3 / 2, 1e-9) << order.front();
    EXPECT_EQ(area["s"] + area["n"], 0.0) << order.front();
  }
}

// Nodes that blocks touch equally. At s, along which the edge runs, a wall m below the floor ends. On the bed joint of
// n lies a block; the lower one carries the floor.
TEST(Floors, BlocksThatTouchANodeEquallyAreTakenInAnyOrder) {
  for (const auto& order :
       std::vector<std::vector<std::string>>{{"m", "top", "w", "e", "s", "n"}, {"n", "s", "e", "w", "top", "m"}}) {
    const Simulation simulation(
        read_scene_text(floor_in_box(order,
                                     "corner = [0, 2.5, 0]\nalong = [5, 0, 0]\nacross = [0, 0, 3]\nspacing = 0.5\n"
                                     "span = \"across\"\n"
                                     "connector = { axial_stiffness = 20e6, shear_stiffness = 20e6 }\n",
                                     {{"w", {"[-0.3, 0, 0]", "[0.3, 3, 3]"}},
                                      {"e", {"[5, 0, 0]", "[0.3, 3, 3]"}},
                                      {"s", {"[0, 0, -0.3]", "[5, 3, 0.3]"}},
                                      {"n", {"[0, 0, 3]", "[5, 2.5, 0.3]"}},
                                      {"top", {"[0, 2.5, 3]", "[5, 0.5, 0.3]"}},
                                      {"m", {"[2.4, 0, 0]", "[0.2, 2.5, 2]"}}}) +
                            pushed(0.0, 0.1, 0.2),
                        "floor.toml"),
        1);
    std::map<std::string, double> area = carried_by(simulation);
    for (const char* wall : {"s", "n"}) EXPECT_NEAR(area[wall], 7.5, 1e-9) << order.front() << wall;
    for (const char* wall : {"w", "e", "m", "top"}) EXPECT_EQ(area[wall], 0.0) << order.front() << wall;
  }
}

// A load is a weight at any pitch. Of a sloping floor the part along its normal alone acted, and pushed sideways: 12 %
// of the vertical load was gone here. Tolerance: 0.1 %, for motion that remains.
TEST(Floors, LoadsOfSlopingFloorsAreVertical) {
  const double load = 1000.0, mass = 200.0;
  for (const auto& [along, across, area] :
       {std::tuple("[4, 3, 0]", "[0, 0, 3]", 15.0), std::tuple("[4, 0, 0]", "[0, 3, 0]", 12.0)}) {
    Simulation simulation(
        read_scene_text(
            head(30.0, 1e9, 40.0) + box("low", "[0, 0, 0]", "[0.4, 4, 3]", "fixed = true") +
                box("high", "[4, 0, 0]", "[0.4, 5, 3]", "fixed = true") +
                fmt::format(
                    "[[floor]]\nname = \"f\"\ncorner = [0.2, 1, 0]\nalong = {}\nacross = {}\nspacing = 0.5\n"
                    "axial_stiffness = [2e7, 2e7]\nshear_stiffness = 1e6\nmass = {}\nload = {}\nspan = \"along\"\n"
                    "connector = {{ axial_stiffness = 2e7, shear_stiffness = 2e7 }}\n[[stage]]\n"
                    "gravity = [0, -9.81, 0]\nramp_time = 0.2\nduration = 0.8\n",
                    along, across, mass, load),
            "floor.toml"),
        1);
    Observer nobody;
    simulation.run(nobody);
    geometry::Vector sum;
    for (const members::Node& node : simulation.large_motion()->held_by.members->nodes()) sum += node.force;
    const double weight = area * (9.81 * mass + load);
    EXPECT_NEAR(sum.y, -weight, 1e-3 * weight) << along;
    EXPECT_NEAR(sum.x, 0.0, 1e-3 * weight) << along;
  }
}

// The body force of a collapse stage is 0.2 of the weight of the mass, not of the load, and fades in the next stage.
// There the load was pushed too, at once and as much as the mass. Tolerance: vibrations of the ramp.
TEST(Floors, CollapseMultipliesTheMassAlone) {
  for (const char* along : {"[4, 0, 0]", "[4, 3, 0]"}) {
    const double area = 3.0 * (along[4] == '0' ? 4.0 : 5.0), pull = 0.2 * 9.81 * 200.0 * area;
    Simulation simulation(
        read_scene_text(
            head(30.0, 1e9, 40.0) + box("low", "[0, 0, 0]", "[0.4, 4, 3]", "fixed = true") +
                box("high", "[4, 0, 0]", "[0.4, 5, 3]", "fixed = true") + box("top", "[0, 4, 0]", "[0.4, 0.4, 3]") +
                fmt::format("[[floor]]\nname = \"f\"\ncorner = [0.2, 1, 0]\nalong = {}\nacross = [0, 0, 3]\n"
                            "spacing = 0.5\naxial_stiffness = [2e7, 2e7]\nshear_stiffness = 1e6\nmass = 200\n"
                            "load = 2000\nspan = \"along\"\nconnector = {{ axial_stiffness = 2e7, "
                            "shear_stiffness = 2e7 }}\n[[stage]]\ngravity = [0, -9.81, 0]\nramp_time = 0.2\n"
                            "duration = 0.6\n[[stage]]\nramp_time = 0.2\nduration = 0.6\ncollapse = {{ direction = "
                            "[1, 0, 0], start = 0.2, rate = 1e-6, displacement = 1.0 }}\n[[stage]]\n"
                            "ramp_time = 0.4\nduration = 0.6\n",
                            along),
            "floor.toml"),
        1);
    const auto push = [&] {
      geometry::Vector sum;
      for (const members::Node& node : simulation.large_motion()->held_by.members->nodes()) sum += node.force;
      return sum.x;
    };
    struct Watch : Observer {
      std::vector<std::pair<int, double>> pushes;  // stage, N
      std::function<double()> push;
      void on_row(const HistoryRow& row) override { pushes.emplace_back(row.stage, push()); }
    } watch;
    watch.push = push;
    simulation.run(watch);
    double at_end = 0.0, after = 0.0;
    for (const auto& [stage, x] : watch.pushes) {
      if (stage == 1) at_end = x;
      if (stage == 2) after = std::max(after, x);
    }
    EXPECT_NEAR(at_end, pull, 0.01 * pull) << along;
    EXPECT_LT(after, 1.02 * pull) << along;
    EXPECT_NEAR(push(), 0.0, 0.01 * pull) << along;
  }
}

TEST(Floors, GoOnFromACheckpointBitForBit) {
  Floor f;
  f.keys = "shear_yield = 250.0\n";
  f.connector = "axial_stiffness = 1e8, shear_stiffness = 1e7, axial_strength = 200.0, shear_strength = 100.0";
  const Scene scene = read_scene_text(
      floor_between(f, "") + "[[stage]]\ngravity = [1.0, -9.81, 2.0]\nramp_time = 0.05\nduration = 1.0\n",
      "floor.toml");
  Simulation whole(scene, 1), before(scene, 1), after(scene, 1);
  whole.advance(3000), before.advance(3000);
  const std::vector<std::uint8_t> bytes = before.save();
  after.advance(37);
  after.restore(bytes);
  whole.advance(2000), after.advance(2000);
  EXPECT_EQ(whole.hash(), after.hash());
  EXPECT_GT(whole.large_motion()->step_sums.energies.members_dissipated, 0.0);
  EXPECT_EQ(whole.large_motion()->step_sums.energies.members_dissipated,
            after.large_motion()->step_sums.energies.members_dissipated);
  EXPECT_EQ(whole.large_motion()->step_sums.energies.external, after.large_motion()->step_sums.energies.external);
}

// A floor between two walls has connectors along these alone, also where one panel is as long as the span. Its open
// edges, which end at walls, had half a connector at each corner.
TEST(Floors, OpenEdgesOfOnePanelHaveNoConnectors) {
  for (const double spacing : {4.0, 6.0, 7.0}) {
    Floor f;
    f.spacing = spacing;
    Simulation* simulation = nullptr;
    rested(floor_between(f) + pushed(0.0, 0.01, 0.02), &simulation);
    double length = 0.0;
    for (const auto& connector : simulation->large_motion()->held_by.members.get()->floors().front().connectors()) {
      EXPECT_EQ(connector.out.across, 0.0) << spacing;
      length += connector.length;
    }
    EXPECT_NEAR(length, 2 * kBreadth, 1e-12) << spacing;
  }
}

TEST(Floors, BadOnesAreRefusedWithTheirPlaces) {
  const auto refusal = [](std::string scene, const std::string& from, const std::string& to) {
    scene.replace(scene.find(from), from.size(), to);
    try {
      Simulation simulation(read_scene_text(scene, "floor.toml"), 1);
    } catch (const Error& error) {
      return std::string(error.what());
    }
    return std::string("accepted");
  };
  const std::string scene = floor_between({}) + pushed(0.0, 0.1, 0.2);
  EXPECT_THAT(refusal(scene, "corner = [0, 0.5, 0]", "corner = [0, 2.5, 0]"),
              AllOf(HasSubstr("floor 'f' meets no wall"), HasSubstr("(0, 2.5, 0) m (1.5 m off the nearest block)")));
  EXPECT_THAT(refusal(scene, "span = \"along\"", "span = \"across\""),
              AllOf(HasSubstr("has no wall for the weight of its line from"), HasSubstr("change span")));
  EXPECT_THAT(refusal(scene, "across = [0, 0, 4]", "across = [1, 0, 4]"), HasSubstr("square to along"));
  EXPECT_THAT(refusal(scene, "mass = 100", "mass = 0"), HasSubstr("mass = 0"));
  EXPECT_THAT(refusal(scene, "spacing = 0.5", "spacing = 0.001"), HasSubstr("at least 0.03 m"));
}

}  // namespace
}  // namespace quoin
