// Springs and dashpots of joints on the lattice, with forces by the mean of a step: zones alone limit the time step.
//
// Central differences take forces F at the displacements u, and dashpots C at the velocities of half a step before:
//     M a = F - C v,    a = (v' - v)/dt.
// These are unstable beyond dt^2 K + 2 dt C = 4 M.
// Here the joints' stiffness K acts on u + dt^2 a/4 and C on (v + v')/2:
//     (M + G) a = F - C v,    G = dt^2 K/4 + dt C/2.
// In the condition 4 (M + G) - dt^2 K - 2 dt C > 0 the terms of joints then cancel, whatever their stiffness. The
// scheme is of second order and conserves momentum. It changes frequencies of joints by the factor 1 + omega^2 dt^2/8
// at most. (Belytschko and Hughes 1983, implicit and explicit elements; beta = 1/4, gamma = 1/2.)
//
// Contact points of the lattice lie on gridpoints. G therefore couples only gridpoints at the same place, a cluster.
// Clusters have two gridpoints within faces, four along edges of bricks in a wall, eight where walls cross. Each
// cluster is solved exactly. K and C are current values: for points that are open, slide or soften, the secants of the
// last step.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "model/model.h"
#include "step/kernels.h"

namespace quoin {

class ImplicitContacts {
 public:
  ImplicitContacts() = default;  // no implicit contacts
  // node_mass: lane layout, kg. This process must hold all of the model, and rigid bodies must have prescribed
  // velocities.
  ImplicitContacts(const Model& model, const LaneVector<double>& node_mass);

  bool in_use() const { return !batches_.empty(); }
  int pieces() const { return (static_cast<int>(batches_.size()) + kBatches - 1) / kBatches; }

  // Columns of a chunk, beginning at its first point. viscosity: over stiffness, normal to the joint and along it, s.
  struct Chunk {
    const double *traction[3], *old_traction[3], *viscous[3];  // Pa; viscous: null without damping
    const double *way[3], *area;                               // opening and slip increments of the last step, m; m2
    double normal_stiffness, shear_stiffness;                  // Pa/m
    std::array<double, 2> viscosity;
  };
  // Computes G of the chunk's points, and G times their velocities of half a step before.
  void weigh(const ContactChunk& chunk, const Chunk& columns, double time_step);

  // A contact point in a cluster: places of the gridpoints that it joins, and the axis of its normal.
  struct Point {
    int a, b, axis;
    auto operator<=>(const Point&) const = default;
  };
  // A batch of up to eight congruent clusters, one a lane.
  struct Lanes {
    int lanes;
    bool any_held;  // some gridpoint is held along some axes alone: masses differ by component
    int nodes, points;
    const Point* point_of_kind;
    const std::int32_t *node, *point;            // lines of kLanes indices
    const std::uint8_t *nodes_row, *points_row;  // by line: 1 where its indices are consecutive
    const double* mass;                          // three lines a gridpoint
    const double *weight[2], *momentum[3];       // G by contact point, kg; G times the old velocity, kg m/s
    double *velocity, *displacement;
    double time_step;
  };

  // Turns velocities and displacements after a step of M a = F - C v into those of (M + G) a = F - C v. Pieces are
  // independent.
  void settle(int piece, const StepData& step) const;

 private:
  static constexpr int kBatches = 8;  // batches in a piece
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
    std::vector<int> nodes, points;  // gridpoints and contact points, ascending
  };
  std::size_t kind_of(const Cluster& cluster, const Model& model);
  void fill(int kind, std::vector<Cluster> clusters, const Model& model, const LaneVector<double>& node_mass);
  void add(int kind, std::span<const Cluster* const> clusters, const Model& model, const LaneVector<double>& node_mass);

  std::vector<Kind> kinds_;
  std::vector<Batch> batches_;
  LaneVector<std::int32_t> node_, point_;             // [batch][gridpoint], [batch][point]; lanes
  std::vector<std::uint8_t> nodes_row_, points_row_;  // by line of node_, point_
  LaneVector<double> mass_;                           // [batch][gridpoint][component], kg
  LaneVector<double> weight_[2], momentum_[3];  // G by point, normal and along, kg; G times the old velocity, kg m/s
};

}  // namespace quoin
