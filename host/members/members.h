// Members of a model: ties between blocks, springs to the ground, strips on faces, floors, beams. They act on nodes;
// the model moves the nodes and applies their forces (model/world_members.cpp).
#pragma once

#include <algorithm>
#include <array>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "members/beam.h"
#include "members/dowel.h"
#include "members/fill.h"
#include "members/floor.h"
#include "members/node.h"
#include "members/spring.h"
#include "members/strip.h"
#include "members/tie.h"
#include "scene/blocks.h"
#include "scene/members.h"

namespace quoin::members {

struct Tie {
  // Nodes of a stop, each with its share of the tie's force.
  using Stop = std::vector<std::pair<int, double>>;
  std::string name;
  std::vector<Stop> stops;  // the first and the last are its ends; it slides through the others
  double length = 0.0;      // length at the start, m
  TieLaw law;
  TieState state;
};

struct Dowel {
  std::string name;
  int first = 0, second = 0;  // nodes, at one place at the start
  Vector along;               // unit, from the first to the second
  double drawn_length = 0.0;  // length in drawings, m
  DowelLaw law;
  DowelState state;
};

// One point of a face under or beside soil.
struct FillPoint {
  int node = 0;
  FillLaw law;
  FillState state;
};
// A [[fill]]: a range of fill points.
struct Fill {
  std::string name;
  std::size_t first = 0, end = 0;
  double area = 0.0;  // m2
};

// One point of a face on springs.
struct SpringPoint {
  int node = 0;
  double area = 0.0;  // m2
  Vector out;         // outward normal of the block at the start, unit
  SpringLaw law;
  SpringState state;
};
// A [[spring]]: a range of spring points.
struct Bed {
  std::string name;
  std::size_t first = 0, end = 0;
  double area = 0.0;  // m2
};

// Tolerance of the distance of a member's end from its block, m.
double allowed_off(const blocks::Assembly& assembly, int block);

// Visits quadrature points of a triangle, exact for quadratics: visit(point, area in m2). They are the midpoints of the
// edges of divisions^2 congruent triangles.
void each_point(const std::array<Vector, 3>& triangle, int divisions,
                const std::function<void(const Vector&, double)>& visit);
// Visits the triangles of a face of a block: visit(triangle).
void each_triangle(const blocks::Assembly& assembly, int block, std::size_t face,
                   const std::function<void(const std::array<Vector, 3>&)>& visit);

inline constexpr int kGround = -1;  // index of the ground, in place of a node

// Kinds of members in drawings.
inline constexpr int kTie = 0, kStrip = 1, kFloor = 2, kBeam = 3, kDowel = 4;

// A stretch of a member in drawings.
struct Line {
  int kind = 0, member = 0;  // index among the members of the kind
  Vector from, to;           // m
  double force = 0.0;        // N, tension positive
  double plastic = 0.0;      // m
  double moment = 0.0;       // larger one of its ends, N m
  bool broken = false;
};

// Energies of members since the start, J.
struct Work {
  double stored = 0.0, dissipated = 0.0;
  double outside = 0.0;  // work of jacks and of the moving ground on members
};

class Members {
 public:
  // Throws Error(bad_input) for an end in no block, with its place and the nearest block.
  Members(const MemberSpecs& specs, const blocks::Assembly& assembly);

  std::vector<Node>& nodes() { return nodes_; }
  const std::vector<Node>& nodes() const { return nodes_; }
  std::span<const int> nodes_of(int block) const;
  const std::vector<Tie>& ties() const { return ties_; }
  const std::vector<Bed>& beds() const { return beds_; }
  const std::vector<Strip>& strips() const { return strips_; }
  double unbalanced_strips() const;  // largest Strip::unbalanced, N
  const std::vector<Floor>& floors() const { return floors_; }
  const std::vector<Beam>& beams() const { return beams_; }
  const std::vector<SpringPoint>& spring_points() const { return points_; }
  const std::vector<Dowel>& dowels() const { return dowels_; }
  const std::vector<Fill>& fills() const { return fills_; }
  const std::vector<FillPoint>& fill_points() const { return fill_points_; }
  Vector force_of(const Bed& bed) const;            // force on its blocks, N
  const Vector& ground() const { return ground_; }  // displacement of the ground below springs since the start, m
  double unbalanced() const;                        // largest force on nodes of beams and floors in the last step, N
  Vector force_of(const Fill& fill) const;          // force on its blocks, N
  Vector start_of(const Tie::Stop& stop) const;     // position at the start, m
  Vector place_of(const Tie::Stop& stop) const;     // current position, m
  // Visits pairs of blocks that members connect: visit(a, b).
  template <class Visit>
  void each_joint(const Visit& visit) const {
    const auto block = [&](int node) { return nodes_[static_cast<std::size_t>(node)].block; };
    for (const Tie& tie : ties_) {
      for (const Tie::Stop& stop : tie.stops) {
        for (const auto& [node, share] : stop) visit(block(tie.stops.front().front().first), block(node));
      }
    }
    for (const Dowel& dowel : dowels_) visit(block(dowel.first), block(dowel.second));
    const auto visit_all = [&](const auto& held) {
      for (const auto& one : held) visit(block(held.front().node), block(one.node));
    };
    for (const Strip& strip : strips_) visit_all(strip.places());
    for (const Floor& floor : floors_) visit_all(floor.connectors());
    for (const Beam& beam : beams_) visit_all(beam.supports());
  }

  // Sets the share of the pretension that jacks apply from the next step on.
  void jack(double share) { jack_ = share; }
  double jacked() const { return jack_; }
  void pull(const Surroundings& step);  // adds forces to nodes, before a step
  // Upper bound of the squared frequency of members' own nodes, 1/s2, for fixed blocks and doubled connections. With
  // each_spring it bounds the frequency of the whole.
  double own_eigenvalue(double mass_scaling) const;
  // Sets the critical time step for which dashpots are reckoned, s.
  void set_step(double dt) { reckoned_step_ = dt; }
  bool has_dashpots() const;
  Work work() const;
  // Visits springs with an upper bound of their stiffness in any direction, N/m, with 2/dt of dashpots: visit(node,
  // other node or kGround, stiffness).
  template <class Visit>
  void each_spring(const Visit& visit) const {
    for (const Tie& tie : ties_) each_spring_of(tie, visit);
    for (const Dowel& dowel : dowels_) visit(dowel.first, dowel.second, std::max(dowel.law.axial, dowel.law.shear));
    for (const FillPoint& p : fill_points_) visit(p.node, kGround, p.law.level * p.law.stiffness);
    // Bars of strips act on blocks twice, as nodes of strips move too.
    for (const Strip& strip : strips_) {
      for (std::size_t i = 0; i + 1 < strip.places().size(); ++i)
        visit(strip.places()[i].node, strip.places()[i + 1].node, 2.0 * strip.bar_stiffness(i));
    }
    for (const Floor& floor : floors_) {
      for (const Floor::Connector& c : floor.connectors()) visit(c.node, kGround, 2.0 * floor.stiffness_of(c));
    }
    for (const Beam& beam : beams_) {
      for (const Beam::Support& s : beam.supports()) visit(s.node, kGround, 2.0 * std::max(s.law.normal, s.law.shear));
    }
    const double rate = reckoned_step_ > 0.0 ? 2.0 / reckoned_step_ : 0.0;
    for (const SpringPoint& p : points_)
      visit(p.node, kGround,
            std::max(p.law.normal + rate * p.law.normal_dashpot, p.law.shear + rate * p.law.shear_dashpot));
  }

  std::vector<double> columns() const;  // values of a row of history.csv, in the order of column_names
  std::vector<Line> lines() const;

  // Visits the numbers for the hash of the state: visit(number).
  template <class Visit>
  void each_number(const Visit& visit) const {
    for (const Tie& tie : ties_) visit(tie.state.force), visit(tie.state.plastic);
    for (const Dowel& dowel : dowels_)
      visit(dowel.state.force), visit(dowel.state.drawn), visit(norm(dowel.state.slid));
    for (const FillPoint& p : fill_points_) visit(p.state.pressure), visit(p.state.slid);
    for (const SpringPoint& p : points_) visit(p.state.slid.x), visit(p.state.slid.y), visit(p.state.slid.z);
    for (const Strip& strip : strips_) strip.each_number(visit);
    for (const Floor& floor : floors_) floor.each_number(visit);
    for (const Beam& beam : beams_) beam.each_number(visit);
  }

  template <class Archive, class Self>
  static void transfer(Archive& archive, Self& m) {
    archive.value(m.jack_), archive.value(m.reckoned_step_);
    for (auto& tie : m.ties_) archive.value(tie.state);
    for (auto& dowel : m.dowels_) archive.value(dowel.state);
    for (auto& point : m.fill_points_) archive.value(point.state);
    archive.value(m.ground_), archive.value(m.ground_work_);
    for (auto& point : m.points_) archive.value(point.state);
    for (auto& strip : m.strips_) Strip::transfer(archive, strip);
    for (auto& floor : m.floors_) Floor::transfer(archive, floor);
    for (auto& beam : m.beams_) Beam::transfer(archive, beam);
  }

 private:
  int node_at(const MemberEnd& end, const blocks::Assembly& assembly);
  void add_tie(const TieSpec& spec, const blocks::Assembly& assembly);
  void add_bed(const SpringSpec& spec, const blocks::Assembly& assembly);
  void add_strip(const StripSpec& spec, const blocks::Assembly& assembly);
  void add_floor(const FloorSpec& spec, const blocks::Assembly& assembly);
  void add_beam(const BeamSpec& spec, const blocks::Assembly& assembly);
  void hold(Beam& beam, int place, int block, const BeamSpec& spec, const std::string& how,
            const blocks::Assembly& assembly);
  void connect(Floor& floor, const blocks::Assembly& assembly);
  void carry_weight(const FloorSpec& spec, Floor& floor) const;
  int block_at(const Vector& point, const blocks::Assembly& assembly, double* off) const;
  Tie::Stop stop_at(const MemberEnd& end, const Vector& along, const TieSpec& spec, const blocks::Assembly& assembly);
  void add_dowel(const DowelSpec& spec, const blocks::Assembly& assembly);
  void add_fill(const FillSpec& spec, const blocks::Assembly& assembly);
  void add_fill_point(const FillSpec& spec, const Vector& at, double area, const Vector& out, int block);
  // A tie's stiffness is k g g', g its direction at each node. It is bounded by k |g_i| sum |g_j| to the ground at each
  // node.
  template <class Visit>
  static void each_spring_of(const Tie& tie, const Visit& visit) {
    const std::size_t last = tie.stops.size() - 1;
    if (last == 1 && tie.stops[0].size() == 1 && tie.stops[1].size() == 1)
      return visit(tie.stops[0][0].first, tie.stops[1][0].first, tie.law.stiffness);
    const auto sum = static_cast<double>(2 * last);
    for (std::size_t i = 0; i <= last; ++i) {
      for (const auto& [node, share] : tie.stops[i])
        visit(node, kGround, tie.law.stiffness * sum * share * (i == 0 || i == last ? 1.0 : 2.0));
    }
  }
  void sort_nodes(std::size_t blocks);
  void pull_beds(const Vector& ground_way, double dt);
  void pull_ties();
  void pull_dowels();
  void pull_fills();

  std::vector<Node> nodes_;
  std::vector<int> by_block_;              // node numbers, block after block
  std::vector<std::size_t> end_of_block_;  // by block
  std::vector<Tie> ties_;
  std::vector<Bed> beds_;
  std::vector<SpringPoint> points_;
  std::vector<Dowel> dowels_;
  std::vector<Fill> fills_;
  std::vector<FillPoint> fill_points_;
  std::vector<Strip> strips_;
  std::vector<Floor> floors_;
  std::vector<Beam> beams_;
  double jack_ = 0.0;
  Vector ground_;             // displacement since the start, m
  double ground_work_ = 0.0;  // J
  double reckoned_step_ = 0.0;
};

// Columns of history.csv for the members of a scene.
std::vector<std::string> column_names(const MemberSpecs& specs);

}  // namespace quoin::members
