// A beam or cable: co-rotational Timoshenko pieces between nodes of its own, with plastic hinges at their ends.
// Equations: README.md.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "members/member.h"
#include "members/spring.h"

namespace quoin::members {

struct Section {
  double axial = 0.0;                                            // E A, N
  double torsion = 0.0;                                          // G J, N m2
  std::array<double, 2> bending{};                               // E I, N m2: of deflection towards `up`, and sideways
  std::array<double, 2> shear_area{};                            // G As, N; infinity: none
  double mass = 0.0;                                             // kg/m
  double polar = 0.0;                                            // rotary inertia per metre, kg m
  double yield_force = std::numeric_limits<double>::infinity();  // N
  std::array<double, 2> yield_moment{};                          // N m
  bool compression = true;
};

class Beam {
 public:
  // One spring between a block and the end of an arm that turns with a node of the beam.
  struct Support {
    int place = 0, node = 0;
    Vector arm;               // m, at the start
    std::uint64_t rests = 0;  // 1: no tension
    Vector out;               // normal of the block's face, unit, where the node rests
    SpringLaw law;
    SpringState state;
    Vector moved;  // motion of the block relative to the arm's end in the last step, m
  };
  // Distance of a support from an edge of its face, along the outward normal of the edge in the face, m.
  struct ToEdge {
    Vector out;
    double distance = 0.0;
  };
  struct Seat {
    std::size_t support = 0;
    std::vector<ToEdge> edges;
  };
  // points: positions of its nodes at the start, m. up: any vector that is not along the line.
  Beam(std::string name, std::vector<Vector> points, const Vector& up, const Section& section);

  const std::string& name() const { return name_; }
  const std::vector<Vector>& nodes() const { return x_; }
  std::vector<Support>& supports() { return supports_; }
  const std::vector<Support>& supports() const { return supports_; }
  std::vector<Seat>& seats() { return seats_; }  // of supports on which it rests
  // A support that still carries, though what its node stands for has slid past the edge of the face; null: none.
  const Support* slid_off() const;
  double piece_at(int place) const;  // shortest piece at the node, m
  const Section& section() const { return section_; }
  double length() const;  // length at the start, m

  void pull(std::vector<Node>& nodes, const Surroundings& step);
  double own_eigenvalue(double mass_scaling) const;  // as Floor::own_eigenvalue

  struct Piece {
    double length = 0.0;                            // length at the start, m
    geometry::Matrix frame;                         // frame at the start: columns along, up, side
    double plastic = 0.0;                           // plastic elongation, m
    std::array<std::array<double, 2>, 2> hinge{};   // plastic rotation towards up and sideways, at both ends, rad
    double force = 0.0, torque = 0.0;               // N, N m
    std::array<std::array<double, 2>, 2> moment{};  // N m, in the order of `hinge`
  };
  const std::vector<Piece>& pieces() const { return pieces_; }
  Work work() const { return {stored_, dissipated_, outside_}; }
  std::vector<double> columns() const { return {largest_force(), largest_moment(), largest_hinge()}; }
  std::vector<Line> lines(const std::vector<Node>& nodes) const;
  double unbalanced() const { return unbalanced_; }  // largest force on a node in the last step, N
  double largest_force() const;                      // largest magnitude, N
  double largest_moment() const;                     // N m
  double largest_hinge() const;                      // rad
  // Sine of the largest rotation of an end of a piece from its chord, at any time since the start or resume.
  double largest_turn() const { return largest_turn_; }

  template <class Visit>
  void each_joint(const Visit& visit) const {
    for (const Support& s : supports_) visit(supports_.front().node, s.node);
  }
  template <class Visit>
  void each_spring(const Visit& visit) const {
    for (const Support& s : supports_) visit(s.node, kGround, 2.0 * std::max(s.law.normal, s.law.shear));
  }
  template <class Visit>
  void each_number(const Visit& visit) const {
    for (const Vector& x : x_) visit(x.x), visit(x.y), visit(x.z);
    for (const Piece& p : pieces_) visit(p.plastic), visit(p.force);
  }
  template <class Archive, class Self>
  static void transfer(Archive& archive, Self& s) {
    archive.array(s.x_), archive.array(s.v_), archive.array(s.frame_), archive.array(s.turn_), archive.array(s.spin_);
    for (auto& piece : s.pieces_) archive.value(piece);
    for (auto& support : s.supports_) archive.value(support);
    archive.value(s.stored_), archive.value(s.dissipated_), archive.value(s.outside_);
  }

 private:
  // A node that is built into one block. Its rotation is that against the block, and its moment acts on the block.
  struct Clamp {
    std::size_t place = 0;
    std::vector<std::size_t> supports;
    std::vector<Vector> off;   // places on the block from their mean, m, at the start
    geometry::Matrix couples;  // inverse of the sum of |off|^2 - off off^T, 1/m2
  };
  void find_clamps(const std::vector<Node>& nodes);
  void turn_frame(const Clamp& clamp, const std::vector<Node>& nodes);
  void find_inertia();
  void pull_piece(std::size_t i);
  void bend(Piece& piece, int plane, const std::array<double, 2>& rotation);
  void pull_support(Support& support, std::vector<Node>& nodes, double dt);
  void advance(const Surroundings& step);

  std::string name_;
  Section section_;
  std::vector<Vector> start_;
  std::vector<Piece> pieces_;
  std::vector<Support> supports_;
  std::vector<Seat> seats_;
  std::vector<Vector> x_, v_;  // m; m/s half a step ago
  std::vector<Clamp> clamps_;
  std::vector<geometry::Matrix> frame_;  // rotation of the places of a clamp since the start; else none
  std::vector<geometry::Matrix> turn_;   // rotations since the start, in these frames
  std::vector<Vector> spin_;             // in these frames, rad/s half a step ago
  std::vector<double> mass_, inertia_;   // kg, kg m2
  std::vector<double> row_;              // row sums of the stiffness at each node, N/m
  std::vector<Vector> force_, moment_;
  double stored_ = 0.0, dissipated_ = 0.0, outside_ = 0.0;
  double unbalanced_ = 0.0;  // N
  double largest_turn_ = 0.0;
};

Beam placed(const BeamSpec& spec, Placing& placing);
std::vector<std::string> column_names(const BeamSpec& spec);

}  // namespace quoin::members
