// A floor: a membrane with inertia between walls, connected to them along its edges. Equations: README.md.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "members/member.h"
#include "members/placing.h"

namespace quoin::members {

// Vector in the plane of a floor: components along and across.
struct InPlane {
  double along = 0.0, across = 0.0;
};

inline constexpr double kGravityOfLoads = 9.81;  // gravity for which `load` of a floor is given, m/s2

struct Membrane {
  double along = 0.0, across = 0.0;                              // axial stiffness, N/m
  double shear = 0.0;                                            // N/m
  double shear_yield = std::numeric_limits<double>::infinity();  // N/m
  double mass = 0.0;                                             // kg/m2
  double load = 0.0;                                             // load without inertia, Pa
};

// Law of a connector, per metre of edge.
struct ConnectorLaw {
  double axial = 0.0, shear = 0.0;                                  // N/m2
  double axial_strength = 0.0;                                      // N/m, of anchors in tension
  double shear_strength = std::numeric_limits<double>::infinity();  // N/m
  double friction = 0.0;  // friction coefficient, for the weight that a connector carries
  double pull_out = std::numeric_limits<double>::infinity();  // opening at which anchors are pulled out, m
  bool bearing = true;                                        // whether the floor bears on the wall in compression
};

class Floor {
 public:
  struct Connector {
    int place = 0;         // node of the floor
    int node = 0;          // node on the block
    InPlane out;           // outward direction in the floor, unit
    double length = 0.0;   // length of edge, m
    double carried = 0.0;  // area of the floor whose weight it carries, m2
    // State after the last step, in the frame that turns with the floor:
    double open = 0.0, slip = 0.0;                  // motion of the block outwards and along the edge, m
    double axial = 0.0, anchor = 0.0, shear = 0.0;  // N; axial: anchors and bearing
    double slid = 0.0, drawn = 0.0;                 // plastic: slip along the edge, opening of anchors, m
    double stored = 0.0;                            // J
    std::uint64_t is_out = 0;                       // 1: its anchors are pulled out
  };
  struct Grid {
    Vector origin, along, across;  // m; unit; unit
    std::array<double, 2> size{};  // m
    std::array<int, 2> pieces{};
  };
  Floor(std::string name, const Grid& grid, const Membrane& membrane, const ConnectorLaw& law);

  const std::string& name() const { return name_; }
  const std::vector<Connector>& connectors() const { return connectors_; }
  std::vector<Connector>& connectors() { return connectors_; }
  int place_at(int i, int j) const { return j * (grid_.pieces[0] + 1) + i; }
  Vector start_of(int place) const;  // m
  double share_of(int place) const;  // area of the floor at this node, m2
  const Grid& grid() const { return grid_; }
  const Membrane& membrane() const { return membrane_; }
  const ConnectorLaw& law() const { return law_; }
  double area() const { return grid_.size[0] * grid_.size[1]; }
  // Warning of weight that lines with a wall at one end alone carry beside its place; empty: none.
  std::string uneven_weight() const;

  // Adds forces to the blocks' nodes and advances the floor by a step.
  void pull(std::vector<Node>& nodes, const Surroundings& step);

  // Upper bounds: stiffness of a connector, N/m; squared frequency of the floor's own nodes for fixed blocks and
  // doubled connectors, 1/s2.
  double stiffness_of(const Connector& c) const;
  double own_eigenvalue(double mass_scaling) const;

  Work work() const { return {stored_, dissipated_, outside_}; }  // stored in panels, connectors and motion of nodes
  std::vector<double> columns() const { return {largest_shear(), largest_anchor(), pulled_out_length()}; }
  double unbalanced() const { return unbalanced_; }  // largest force on a node in the last step, N
  double largest_shear() const;                      // N/m
  double largest_anchor() const;                     // N/m
  double pulled_out_length() const;                  // length of edge with pulled-out anchors, m
  double plastic_shear() const;                      // largest plastic shear strain
  double largest_drawn() const;                      // largest plastic opening of its anchors, m
  double largest_slid() const;                       // largest slip of its connectors along their edges, m

  // A panel between four nodes, for drawings.
  struct Panel {
    std::array<Vector, 4> corner;  // m
    double shear = 0.0;            // N/m
    double plastic = 0.0;
  };
  std::vector<Panel> panels() const;
  Vector place_now(int place) const;  // m

  template <class Visit>
  void each_joint(const Visit& visit) const {
    for (const Connector& c : connectors_) visit(connectors_.front().node, c.node);
  }
  template <class Visit>
  void each_spring(const Visit& visit) const {
    for (const Connector& c : connectors_) visit(c.node, kGround, 2.0 * stiffness_of(c));
  }
  template <class Visit>
  void each_number(const Visit& visit) const {
    for (const InPlane& u : moved_) visit(u.along), visit(u.across);
    for (const double p : sheared_) visit(p);
    for (const Connector& c : connectors_) visit(c.slid), visit(c.drawn);
  }
  template <class Archive, class Self>
  static void transfer(Archive& archive, Self& s) {
    archive.array(s.moved_), archive.array(s.velocity_), archive.array(s.sheared_), archive.array(s.shear_flow_);
    archive.array(s.lift_then_);
    for (auto& c : s.connectors_) archive.value(c);
    archive.value(s.stored_), archive.value(s.dissipated_), archive.value(s.outside_), archive.value(s.begun_),
        archive.value(s.weight_);
  }

 private:
  void turn_along();
  void find_local();
  void pull_membrane();
  void pull_connector(Connector& c, std::vector<Node>& nodes);
  void load_blocks(std::vector<Node>& nodes, const Surroundings& step);
  void advance(const Surroundings& step);

  std::string name_;
  Grid grid_;
  Membrane membrane_;
  ConnectorLaw law_;
  std::vector<Connector> connectors_;
  std::vector<InPlane> start_;             // position from the middle at the start, m
  std::vector<InPlane> moved_, velocity_;  // m; m/s half a step ago
  std::vector<double> sheared_;            // plastic shear strain by panel
  std::vector<double> shear_flow_;         // shear flow by panel, N/m
  std::vector<double> lift_then_;          // displacement of blocks along the normal at connectors, a step ago, m
  double stored_ = 0.0, dissipated_ = 0.0, outside_ = 0.0;
  double unbalanced_ = 0.0;  // N
  double weight_ = 0.0;      // current weight along the normal, N/m2
  std::uint8_t begun_ = 0;
  // Temporary numbers of a step: rotation of the floor in its plane; displacements and forces in the frame that turns
  // with it.
  double cosine_ = 1.0, sine_ = 0.0;
  std::vector<InPlane> local_, force_;
};

Floor placed(const FloorSpec& spec, Placing& placing);
std::vector<std::string> column_names(const FloorSpec& spec);

}  // namespace quoin::members
