// Unknowns of a simulation, numbered: components of gridpoints, and translations and spins of rigid blocks. Their
// stiffness, assembled from contact points and zones.
#pragma once

#include <array>
#include <functional>
#include <utility>
#include <vector>

#include "sparse/sparse_cholesky.h"
#include "sparse/stiffness_entries.h"
#include "step/state.h"

namespace quoin {

// A zone of a deformable block, in either model.
struct StressedZone {
  std::array<int, 4> node;                   // gridpoints, numbered within the block
  std::array<geometry::Vector, 4> gradient;  // gradients of the shape functions, which turn with the block, 1/m
  double volume, lambda, mu;                 // m3, Pa
  geometry::Matrix stress;                   // current, Pa
};
void each_stressed_zone(const Simulation::Impl& s, int block, const std::function<void(const StressedZone&)>& visit);

geometry::Vector force_of(const ContactPoint& point);  // on its block a, N
// Stiffness bounds of the law at a contact point, Pa/m.
quoin_stiffness_bounds stiffness_bounds_at(const Simulation::Impl& s, const ContactPoint& point);

class Unknowns {
 public:
  struct OfBlock {
    std::vector<std::array<int, 3>> gridpoint;        // -1: held
    std::array<int, 6> body{-1, -1, -1, -1, -1, -1};  // translations, spins about the axes; -1: held
    geometry::Vector centre;                          // centre of a rigid block
    bool rigid = false;
  };

  // Components that the controls of the current stage hold are left out. The simulation must outlive this.
  explicit Unknowns(const Simulation::Impl& s);

  int count() const { return count_; }
  std::vector<OfBlock>& blocks() { return blocks_; }
  const std::vector<OfBlock>& blocks() const { return blocks_; }
  const UnknownGroups& groups() const { return groups_; }
  int block_of_group(std::size_t group) const { return block_of_group_[group]; }

  void shares_of(const ContactPoint& point, std::vector<UnknownShare>* shares) const;
  void add_point(const ContactPoint& point, double normal, double shear, StiffnessEntries* entries) const;  // N/m
  void add_zones(StiffnessEntries* entries) const;
  // Adds the geometric stiffness of current forces: stresses of zones, and contact forces on the arms of rigid blocks.
  void add_stresses(const std::vector<ContactPoint>& points, StiffnessEntries* entries) const;
  // Adds that of a force of fixed direction, N, on an arm from the centre of a rigid block, m; nothing for others.
  void add_force(int block, const geometry::Vector& force, const geometry::Vector& arm,
                 StiffnessEntries* entries) const;

 private:
  void number_lattice(int block, unsigned held);
  void number_large_motion(int block, unsigned held);
  int next(bool held) { return held ? -1 : count_++; }
  void close_group(int block, const geometry::Vector& place);
  void add_side(const ContactPoint& point, int block, double sign, std::vector<UnknownShare>* shares) const;
  std::pair<std::array<int, 3>, std::array<double, 3>> on_surface(int block, const geometry::Vector& place) const;
  int gridpoint_at(int block, const geometry::Vector& place) const;

  const Simulation::Impl& s_;
  std::vector<OfBlock> blocks_;
  UnknownGroups groups_;
  std::vector<int> block_of_group_;
  int count_ = 0;
};

// Adds the symmetric part of the stiffness v x u of forces, for motions u: half of it, and half of its transpose.
void add_turning(const std::array<int, 3>& forces, const std::array<int, 3>& motions, const geometry::Vector& v,
                 StiffnessEntries* entries);

}  // namespace quoin
