// A strip: bars between its own nodes, each bonded to a face by a contact law. Equations: README.md.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "law/law_library.h"
#include "members/member.h"
#include "members/placing.h"

namespace quoin::members {

class Strip {
 public:
  // A bonded place at the start.
  struct Place {
    int node = 0;          // node on the block
    Vector at;             // m
    Vector normal, along;  // unit vectors: outward normal of the block, direction of the strip
    double area = 0.0;     // m2
  };
  struct Fibres {
    double stiffness = 0.0;  // E A, N
    double strength = 0.0;   // N
    bool compression = false;
  };
  Strip(std::string name, std::vector<Place> places, const Fibres& fibres, std::shared_ptr<const Material> bond,
        const std::string& initial_state);

  const std::string& name() const { return name_; }
  const std::vector<Place>& places() const { return places_; }
  // Adds forces to the blocks' nodes and advances the strip's nodes by a step. Throws Error(numerical) where the
  // law fails.
  void pull(std::vector<Node>& nodes, const Surroundings& step);

  Work work() const { return {stored_, dissipated_, 0.0}; }
  std::vector<double> columns() const { return {largest_force(), debonded_length()}; }
  std::vector<Line> lines(const std::vector<Node>& nodes) const;
  double largest_force() const;    // force of its bars of largest magnitude, N
  double debonded_length() const;  // m
  // Largest force on a block that its bond does not carry in the last step, N: inertia and damping of nodes. 0 at rest.
  double unbalanced() const { return unbalanced_; }
  const std::vector<Vector>& nodes() const { return x_; }
  const std::vector<double>& forces() const { return force_; }  // forces of bars, N

  template <class Visit>
  void each_joint(const Visit& visit) const {
    for (const Place& place : places_) visit(places_.front().node, place.node);
  }
  // Bars act on blocks twice, as nodes of the strip move too.
  template <class Visit>
  void each_spring(const Visit& visit) const {
    for (std::size_t i = 0; i + 1 < places_.size(); ++i)
      visit(places_[i].node, places_[i + 1].node, 2.0 * bar_stiffness(i));
  }
  template <class Visit>
  void each_number(const Visit& visit) const {
    for (const Vector& x : x_) visit(x.x), visit(x.y), visit(x.z);
    for (const auto& column : state_) {
      for (const double value : column) visit(value);
    }
  }
  template <class Archive, class Self>
  static void transfer(Archive& archive, Self& s) {
    archive.array(s.x_), archive.array(s.off_), archive.array(s.speed_), archive.array(s.mass_),
        archive.array(s.force_), archive.array(s.broken_);
    for (auto& column : s.jump_) archive.array(column);
    for (auto& column : s.traction_) archive.array(column);
    for (auto& column : s.state_) archive.array(column);
    archive.array(s.flags_);
    archive.value(s.mass_step_), archive.value(s.stored_), archive.value(s.dissipated_), archive.value(s.braked_later_);
  }

 private:
  double bar_stiffness(std::size_t bar) const { return fibres_.stiffness / length_[bar]; }  // N/m
  void bind();
  void find_masses(double dt);
  void find_jumps();
  void ask_law();
  std::vector<Vector> pull_bars();  // forces on nodes, N
  void advance(const std::vector<Vector>& force, double dt);

  std::string name_;
  std::vector<Place> places_;
  Fibres fibres_;
  std::vector<double> length_;  // lengths of bars at the start, m
  std::shared_ptr<const Material> bond_;

  std::vector<Vector> x_;            // m
  std::vector<Vector> off_, speed_;  // place and velocity (half a step ago) against the face, in its frame; m, m/s
  std::vector<double> mass_;         // kg
  std::vector<double> force_;        // forces of bars, N
  std::vector<uint8_t> broken_;      // by bar
  std::vector<double> jump_[3], slip_[2], traction_[3];
  std::vector<std::vector<double>> state_;
  std::vector<double> energy_[1 + QUOIN_DISSIPATED_COUNT];  // stored, dissipated in the step, J/m2
  std::vector<std::uint32_t> flags_;
  double mass_step_ = 0.0;                  // time step for which masses are computed, s
  double stored_ = 0.0, dissipated_ = 0.0;  // J, at the time of the forces
  double braked_later_ = 0.0;               // work of damping in the half step after that time, J
  double unbalanced_ = 0.0;                 // N
  quoin_batch batch_{};
  std::vector<quoin_in> state_old_;
  std::vector<quoin_out> state_new_;
};

Strip placed(const StripSpec& spec, Placing& placing);
std::vector<std::string> column_names(const StripSpec& spec);

}  // namespace quoin::members
