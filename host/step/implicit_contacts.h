// Springs and dashpots of joints on the lattice by the mean of a step, so that the step is that of the zones.
//
// Central differences have forces F of the displacements u, and dashpots C of the velocities of half a step ago:
//     M a = F - C v,    a = (v' - v)/dt.
// They are unstable past dt^2 K + 2 dt C = 4 M. Here the joints' stiffness K acts on u + dt^2 a/4 and C on (v + v')/2:
//     (M + G) a = F - C v,    G = dt^2 K/4 + dt C/2.
// Joints then take no part in 4 (M + G) - dt^2 K - 2 dt C, whatever their stiffness. The scheme has second order, keeps
// momentum, and differs from the other by the factor 1 + omega^2 dt^2/8 at most in frequencies of joints. (Belytschko
// and Hughes 1983, implicit and explicit elements; beta = 1/4, gamma = 1/2.)
//
// Contact points of the lattice lie on gridpoints. G therefore joins only gridpoints that meet at one place. Clusters
// have two of them within faces, four along edges in a wall, eight where walls cross. It is solved for each of them
// exactly. K and C are those of now: of a point that is open, slides or softens they are its secants of the last step.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "model/model.h"
#include "step/kernels.h"

namespace quoin {

class ImplicitContacts {
 public:
  ImplicitContacts() = default;  // none
  // node_mass: lane layout, kg. All of the model must be laid out, and its rigid bodies move as prescribed.
  ImplicitContacts(const Model& model, const LaneVector<double>& node_mass);

  bool in_use() const { return !batches_.empty(); }
  int pieces() const { return (static_cast<int>(batches_.size()) + kBatches - 1) / kBatches; }

  // Columns of a chunk, from its first point on; viscosity over stiffness normal to the joint and along it, s.
  struct Chunk {
    const double *traction[3], *old_traction[3], *viscous[3];  // Pa; viscous: null where nothing is damped
    const double *way[3], *area;                               // m in the last step, m2
    double normal_stiffness, shear_stiffness;                  // Pa/m
    std::array<double, 2> viscosity;
  };
  // G of its points, and what G takes of the velocities of half a step ago.
  void weigh(const ContactChunk& chunk, const Chunk& columns, double time_step);

  // Congruent clusters: which of their gridpoints each contact point joins, and along which axis it lies.
  struct Point {
    int a, b, axis;
    auto operator<=>(const Point&) const = default;
  };
  // Up to eight of a kind, one a lane.
  struct Lanes {
    int lanes;
    bool any_held;  // along some component alone: masses differ by component
    int nodes, points;
    const Point* point_of_kind;
    const std::int32_t *node, *point;            // lines of lanes
    const std::uint8_t *nodes_row, *points_row;  // by line: 1 where its places follow each other
    const double* mass;                          // three lines a gridpoint
    const double *weight[2], *momentum[3];       // by contact point
    double *velocity, *displacement;
    double time_step;
  };

  // Velocities and displacements after a step of M a = F - C v, into those of (M + G) a = F - C v. Any order.
  void settle(int piece, const StepData& step) const;

 private:
  static constexpr int kBatches = 8;  // batches of a piece
  struct Kind {
    int nodes = 0;
    std::vector<Point> points;
    auto operator<=>(const Kind&) const = default;
  };
  struct Batch {
    int kind, lanes;
    bool any_held;
    std::size_t first_node, first_point;  // first lines of lanes
  };
  struct Cluster {
    std::vector<int> nodes, points;  // offsets of gridpoints, contact points; both in order
  };
  std::size_t kind_of(const Cluster& cluster, const Model& model);
  void fill(int kind, std::vector<Cluster> clusters, const Model& model, const LaneVector<double>& node_mass);
  void add(int kind, std::span<const Cluster* const> clusters, const Model& model, const LaneVector<double>& node_mass);

  std::vector<Kind> kinds_;
  std::vector<Batch> batches_;
  LaneVector<std::int32_t> node_, point_;             // [batch][gridpoint], [batch][point]; lanes
  std::vector<std::uint8_t> nodes_row_, points_row_;  // by line of these
  LaneVector<double> mass_;                           // [batch][gridpoint][component], kg
  LaneVector<double> weight_[2], momentum_[3];  // G by point, normal and along, kg; G times the old velocity, kg m/s
};

}  // namespace quoin
