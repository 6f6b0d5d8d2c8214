// Members of a model: ties between blocks, springs to the ground, strips on faces, floors, beams, dowels, soil. They
// act on nodes; the model moves the nodes and applies their forces (model/world_members.cpp).
#pragma once

#include <span>
#include <string>
#include <tuple>
#include <vector>

#include "members/beam.h"
#include "members/dowel.h"
#include "members/fill.h"
#include "members/floor.h"
#include "members/spring.h"
#include "members/strip.h"
#include "members/tie.h"

namespace quoin::members {

// A kind of member and where scenes have it.
template <Member M, class Spec>
struct Kind {
  std::vector<Spec> MemberSpecs::*specs;
};

// All kinds, in the order of their columns in history.csv.
inline constexpr std::tuple kKinds{
    Kind<Tie, TieSpec>{&MemberSpecs::ties},       Kind<Bed, SpringSpec>{&MemberSpecs::springs},
    Kind<Strip, StripSpec>{&MemberSpecs::strips}, Kind<Floor, FloorSpec>{&MemberSpecs::floors},
    Kind<Beam, BeamSpec>{&MemberSpecs::beams},    Kind<Dowel, DowelSpec>{&MemberSpecs::dowels},
    Kind<Fill, FillSpec>{&MemberSpecs::fills}};

class Members {
 public:
  // Throws Error(bad_input) for an end in no block, with its place and the nearest block.
  Members(const MemberSpecs& specs, const blocks::Assembly& assembly);

  std::vector<Node>& nodes() { return nodes_; }
  const std::vector<Node>& nodes() const { return nodes_; }
  std::span<const int> nodes_of(int block) const;
  const std::vector<Tie>& ties() const { return all<Tie>(); }
  const std::vector<Bed>& beds() const { return all<Bed>(); }
  const std::vector<Strip>& strips() const { return all<Strip>(); }
  const std::vector<Floor>& floors() const { return all<Floor>(); }
  const std::vector<Beam>& beams() const { return all<Beam>(); }
  const std::vector<Dowel>& dowels() const { return all<Dowel>(); }
  const std::vector<Fill>& fills() const { return all<Fill>(); }
  double unbalanced_strips() const;                 // largest Strip::unbalanced, N
  double unbalanced() const;                        // largest force on nodes of beams and floors in the last step, N
  const Vector& ground() const { return ground_; }  // displacement of the ground below springs since the start, m

  // Sets the share of pretensions and of the weight of soil that acts from the next step on.
  void jack(double share) { jack_ = share; }
  double jacked() const { return jack_; }
  void pull(const Surroundings& step);  // adds forces to nodes, before a step
  // Upper bound of the squared frequency of members' own nodes, 1/s2, for fixed blocks and doubled connections. With
  // each_spring it bounds the frequency of the whole.
  double own_eigenvalue(double mass_scaling) const;
  // Sets the critical time step for which dashpots are reckoned, s.
  void set_step(double dt);
  bool has_dashpots() const;
  Work work() const;
  std::vector<double> columns() const;  // values of a row of history.csv, in the order of column_names
  std::vector<Line> lines() const;

  // Visits pairs of blocks that members connect: visit(a, b).
  template <class Visit>
  void each_joint(const Visit& visit) const {
    const auto block = [&](int node) { return nodes_[static_cast<std::size_t>(node)].block; };
    each([&](const auto& member) {
      if constexpr (requires { member.each_joint(block); })
        member.each_joint([&](int a, int b) { visit(block(a), block(b)); });
    });
  }
  // Visits springs with an upper bound of their stiffness in any direction, N/m, with 2/dt of dashpots: visit(node,
  // other node or kGround, stiffness).
  template <class Visit>
  void each_spring(const Visit& visit) const {
    each([&](const auto& member) { member.each_spring(visit); });
  }
  // Visits the numbers for the hash of the state: visit(number).
  template <class Visit>
  void each_number(const Visit& visit) const {
    each([&](const auto& member) { member.each_number(visit); });
  }
  template <class Archive, class Self>
  static void transfer(Archive& archive, Self& m) {
    archive.value(m.jack_), archive.value(m.ground_);
    m.each([&](auto& member) { std::remove_cvref_t<decltype(member)>::transfer(archive, member); });
  }

 private:
  // By kind, in the order of kKinds.
  template <class... M, class... Spec>
  static auto lists_of(const std::tuple<Kind<M, Spec>...>&) -> std::tuple<std::vector<M>...>;
  using Lists = decltype(lists_of(kKinds));

  template <class M>
  const std::vector<M>& all() const {
    return std::get<std::vector<M>>(lists_);
  }
  // Visits all members, kind after kind.
  template <class Visit>
  void each(const Visit& visit) const {
    std::apply([&](const auto&... list) { (std::for_each(list.begin(), list.end(), visit), ...); }, lists_);
  }
  template <class Visit>
  void each(const Visit& visit) {
    std::apply([&](auto&... list) { (std::for_each(list.begin(), list.end(), visit), ...); }, lists_);
  }
  void sort_nodes(std::size_t blocks);

  std::vector<Node> nodes_;
  std::vector<int> by_block_;              // node numbers, block after block
  std::vector<std::size_t> end_of_block_;  // by block
  Lists lists_;
  double jack_ = 0.0;
  Vector ground_;  // displacement since the start, m
};

// Columns of history.csv for the members of a scene.
std::vector<std::string> column_names(const MemberSpecs& specs);

}  // namespace quoin::members
