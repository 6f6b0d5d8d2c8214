#include "members/floor.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace quoin::members {

namespace {

InPlane operator+(const InPlane& a, const InPlane& b) { return {a.along + b.along, a.across + b.across}; }
InPlane operator-(const InPlane& a, const InPlane& b) { return {a.along - b.along, a.across - b.across}; }
InPlane operator*(double f, const InPlane& a) { return {f * a.along, f * a.across}; }
double dot(const InPlane& a, const InPlane& b) { return a.along * b.along + a.across * b.across; }
// Rotates a vector by an angle with cosine c and sine s.
InPlane turned(const InPlane& a, double c, double s) {
  return {c * a.along - s * a.across, s * a.along + c * a.across};
}

}  // namespace

Floor::Floor(std::string name, const Grid& grid, const Membrane& membrane, const ConnectorLaw& law)
    : name_(std::move(name)), grid_(grid), membrane_(membrane), law_(law) {
  const auto& [n, m] = grid.pieces;
  for (int j = 0; j <= m; ++j) {
    for (int i = 0; i <= n; ++i) {
      start_.push_back(
          {grid.size[0] * (static_cast<double>(i) / n - 0.5), grid.size[1] * (static_cast<double>(j) / m - 0.5)});
    }
  }
  moved_.resize(start_.size()), velocity_.resize(start_.size());
  local_.resize(start_.size()), force_.resize(start_.size());
  const auto panels = static_cast<std::size_t>(n) * static_cast<std::size_t>(m);
  sheared_.resize(panels), shear_flow_.resize(panels);
}

Vector Floor::start_of(int place) const {
  const InPlane& at = start_[static_cast<std::size_t>(place)];
  return grid_.origin + (at.along + 0.5 * grid_.size[0]) * grid_.along +
         (at.across + 0.5 * grid_.size[1]) * grid_.across;
}

Vector Floor::place_now(int place) const {
  const InPlane& u = moved_[static_cast<std::size_t>(place)];
  return start_of(place) + u.along * grid_.along + u.across * grid_.across;
}

double Floor::share_of(int place) const {
  const auto& [n, m] = grid_.pieces;
  const int i = place % (n + 1), j = place / (n + 1);
  return area() / (n * m) * (i == 0 || i == n ? 0.5 : 1.0) * (j == 0 || j == m ? 0.5 : 1.0);
}

// Rotation with the least displacements in its frame.
void Floor::turn_along() {
  double with = 0.0, across = 0.0;
  for (std::size_t k = 0; k < start_.size(); ++k) {
    const InPlane x = start_[k] + moved_[k];
    with += dot(start_[k], x), across += start_[k].along * x.across - start_[k].across * x.along;
  }
  const double length = std::hypot(with, across);
  cosine_ = with / length, sine_ = across / length;
}

void Floor::find_local() {
  for (std::size_t k = 0; k < start_.size(); ++k)
    local_[k] = turned(start_[k] + moved_[k], cosine_, -sine_) - start_[k];
}

// Rectangles of four nodes. Axial strains are linear over each and integrated exactly. Shear strain is that of the
// middle, so that panels can bend without shear.
void Floor::pull_membrane() {
  const auto& [n, m] = grid_.pieces;
  const double a = grid_.size[0] / n, b = grid_.size[1] / m;
  for (int j = 0; j < m; ++j) {
    for (int i = 0; i < n; ++i) {
      const auto panel = static_cast<std::size_t>(j * n + i);
      const std::size_t k[4] = {static_cast<std::size_t>(place_at(i, j)), static_cast<std::size_t>(place_at(i + 1, j)),
                                static_cast<std::size_t>(place_at(i + 1, j + 1)),
                                static_cast<std::size_t>(place_at(i, j + 1))};
      const InPlane* u[4] = {&local_[k[0]], &local_[k[1]], &local_[k[2]], &local_[k[3]]};
      const double low = (u[1]->along - u[0]->along) / a, high = (u[2]->along - u[3]->along) / a;
      const double left = (u[3]->across - u[0]->across) / b, right = (u[2]->across - u[1]->across) / b;
      const double strain = 0.5 * ((u[3]->along + u[2]->along - u[0]->along - u[1]->along) / b +
                                   (u[1]->across + u[2]->across - u[0]->across - u[3]->across) / a);
      const double trial = membrane_.shear * (strain - sheared_[panel]);
      const double beyond = std::max(std::abs(trial) - membrane_.shear_yield, 0.0);
      const double flow = std::copysign(beyond, trial) / membrane_.shear;
      const double shear = trial - membrane_.shear * flow;
      if (flow != 0.0) {
        sheared_[panel] += flow;
        dissipated_ += a * b * membrane_.shear_yield * std::abs(flow);
      }
      shear_flow_[panel] = shear;
      // Forces on the two halves of the panel, N.
      const double at_low = membrane_.along * b * (2 * low + high) / 6,
                   at_high = membrane_.along * b * (low + 2 * high) / 6;
      const double at_left = membrane_.across * a * (2 * left + right) / 6,
                   at_right = membrane_.across * a * (left + 2 * right) / 6;
      const double by_along = 0.5 * shear * a, by_across = 0.5 * shear * b;
      force_[k[0]] = force_[k[0]] + InPlane{at_low + by_along, at_left + by_across};
      force_[k[1]] = force_[k[1]] + InPlane{-at_low + by_along, at_right - by_across};
      force_[k[2]] = force_[k[2]] + InPlane{-at_high - by_along, -at_right - by_across};
      force_[k[3]] = force_[k[3]] + InPlane{at_high - by_along, -at_left + by_across};
      stored_ += 0.5 * (a * (at_low * low + at_high * high) + b * (at_left * left + at_right * right));
      if (shear != 0.0) stored_ += 0.5 * a * b * shear * shear / membrane_.shear;
    }
  }
}

// Anchors open plastically where wall and floor separate; in compression the floor bears on the wall. Work that is not
// stored is dissipated.
void Floor::pull_connector(Connector& c, std::vector<Node>& nodes) {
  Node& node = nodes[static_cast<std::size_t>(c.node)];
  const auto place = static_cast<std::size_t>(c.place);
  const Vector way = node.x - node.start;
  const InPlane space{geometry::dot(way, grid_.along), geometry::dot(way, grid_.across)};
  const InPlane apart = turned(space - moved_[place], cosine_, -sine_), edge{-c.out.across, c.out.along};
  const Connector before = c;
  c.open = dot(apart, c.out), c.slip = dot(apart, edge);
  const double k = law_.axial * c.length, ks = law_.shear * c.length;
  c.is_out = c.is_out || c.open > law_.pull_out;
  const double trial = std::max(k * (c.open - c.drawn), 0.0);
  c.anchor = c.is_out ? 0.0 : std::min(trial, law_.axial_strength * c.length);
  if (!c.is_out) c.drawn += (trial - c.anchor) / k;
  c.axial = c.anchor;
  c.stored = 0.5 * c.anchor * c.anchor / k;
  if (law_.bearing && c.open < 0.0) c.axial += k * c.open, c.stored += 0.5 * k * c.open * c.open;
  if (ks > 0.0) {
    const double limit =
        law_.friction * std::abs(weight_) * c.carried + (c.is_out ? 0.0 : law_.shear_strength * c.length);
    c.shear = std::clamp(ks * (c.slip - c.slid), -limit, limit);
    c.slid = c.slip - c.shear / ks;
    c.stored += 0.5 * c.shear * c.shear / ks;
  }
  dissipated_ +=
      0.5 * ((before.axial + c.axial) * (c.open - before.open) + (before.shear + c.shear) * (c.slip - before.slip)) -
      (c.stored - before.stored);
  stored_ += c.stored;
  const InPlane on_floor = c.axial * c.out + c.shear * edge;
  force_[place] = force_[place] + on_floor;
  const InPlane on_block = turned(-1.0 * on_floor, cosine_, sine_);
  node.force += on_block.along * grid_.along + on_block.across * grid_.across;
}

std::string Floor::uneven_weight() const {
  constexpr double kRounding = 1e-6;  // of the sides
  Vector weight, middle;              // first moments of area, m3
  for (const Connector& c : connectors_) weight += c.carried * start_of(c.place);
  for (std::size_t k = 0; k < start_.size(); ++k) {
    const int place = static_cast<int>(k);
    middle += share_of(place) * start_of(place);
  }
  const double off = norm(weight - middle) / area();
  if (off <= kRounding * (grid_.size[0] + grid_.size[1])) return "";
  return fmt::format(
      "floor '{}': some lines along its span meet a wall at one end alone, which takes their whole weight: the weight "
      "of the floor acts {:.3g} m beside its middle, and its moment is wrong by as much; put both ends of each line "
      "into "
      "blocks, or change span",
      name_, off);
}

// Weight along the normal acts on the walls directly: a membrane has no bending.
void Floor::load_blocks(std::vector<Node>& nodes, const Surroundings& step) {
  const Vector normal = cross(grid_.along, grid_.across);
  lift_then_.resize(connectors_.size());
  for (std::size_t i = 0; i < connectors_.size(); ++i) {
    Node& node = nodes[static_cast<std::size_t>(connectors_[i].node)];
    const double lift = geometry::dot(node.x - node.start, normal);
    if (begun_) outside_ += weight_ * connectors_[i].carried * (lift - lift_then_[i]);
    lift_then_[i] = lift;
  }
  begun_ = 1;
  weight_ = membrane_.mass * geometry::dot(step.gravity, normal) +
            membrane_.load / kGravityOfLoads * geometry::dot(step.gravity - step.of_collapse, normal);
  for (const Connector& c : connectors_) nodes[static_cast<std::size_t>(c.node)].force += weight_ * c.carried * normal;
}

void Floor::advance(const Surroundings& step) {
  const auto in_plane = [&](const Vector& g) {
    return InPlane{geometry::dot(g, grid_.along), geometry::dot(g, grid_.across)};
  };
  // A load has no inertia, so the body force of a collapse stage does not push it.
  const InPlane gravity = in_plane(step.gravity), of_load = in_plane(step.gravity - step.of_collapse);
  const InPlane ground{geometry::dot(step.ground_velocity, grid_.along),
                       geometry::dot(step.ground_velocity, grid_.across)};
  const double dt = step.dt;
  unbalanced_ = 0.0;
  for (std::size_t k = 0; k < start_.size(); ++k) {
    const double mass = membrane_.mass * share_of(static_cast<int>(k)), inertia = step.mass_scaling * mass;
    const double loaded = membrane_.load / kGravityOfLoads * share_of(static_cast<int>(k));
    const InPlane inner = turned(force_[k], cosine_, sine_);
    const auto go = [&](double InPlane::*c) {
      double& v = velocity_[k].*c;
      const double weight = mass * gravity.*c + loaded * of_load.*c, before = v, force = inner.*c + weight;
      unbalanced_ = std::max(unbalanced_, std::abs(force));
      const double motion = brake(step, inertia, force, ground.*c, v);
      dissipated_ += motion;
      outside_ += weight * 0.5 * (before + v) * dt;
      stored_ += 0.125 * inertia * (before + v) * (before + v);
      moved_[k].*c += dt * v;
    };
    go(&InPlane::along), go(&InPlane::across);
  }
}

void Floor::pull(std::vector<Node>& nodes, const Surroundings& step) {
  stored_ = 0.0;
  std::fill(force_.begin(), force_.end(), InPlane{});
  turn_along();
  find_local();
  pull_membrane();
  load_blocks(nodes, step);
  for (Connector& c : connectors_) pull_connector(c, nodes);
  advance(step);
}

double Floor::stiffness_of(const Connector& c) const { return c.length * std::max(law_.axial, law_.shear); }

// Upper bound of eigenvalues: the sum of magnitudes in a row of the stiffness, over the inertia.
double Floor::own_eigenvalue(double mass_scaling) const {
  const auto& [n, m] = grid_.pieces;
  const double a = grid_.size[0] / n, b = grid_.size[1] / m;
  const double panel = std::max(membrane_.along * b / a + membrane_.shear * (a / b + 1.0),
                                membrane_.across * a / b + membrane_.shear * (b / a + 1.0));
  std::vector<double> row(start_.size());
  for (std::size_t k = 0; k < row.size(); ++k) row[k] = panel * 4.0 * share_of(static_cast<int>(k)) / (a * b);
  for (const Connector& c : connectors_) row[static_cast<std::size_t>(c.place)] += 2.0 * stiffness_of(c);
  double largest = 0.0;
  for (std::size_t k = 0; k < row.size(); ++k)
    largest = std::max(largest, row[k] / (mass_scaling * membrane_.mass * share_of(static_cast<int>(k))));
  return largest;
}

double Floor::largest_shear() const {
  double largest = 0.0;
  for (const double s : shear_flow_) largest = std::max(largest, std::abs(s));
  return largest;
}

double Floor::plastic_shear() const {
  double largest = 0.0;
  for (const double s : sheared_) largest = std::max(largest, std::abs(s));
  return largest;
}

double Floor::largest_anchor() const {
  double largest = 0.0;
  for (const Connector& c : connectors_) largest = std::max(largest, c.anchor / c.length);
  return largest;
}

double Floor::largest_drawn() const {
  double largest = 0.0;
  for (const Connector& c : connectors_) largest = std::max(largest, c.drawn);
  return largest;
}

double Floor::largest_slid() const {
  double largest = 0.0;
  for (const Connector& c : connectors_) largest = std::max(largest, std::abs(c.slid));
  return largest;
}

double Floor::pulled_out_length() const {
  double sum = 0.0;
  for (const Connector& c : connectors_) sum += c.is_out ? c.length : 0.0;
  return sum;
}

std::vector<Floor::Panel> Floor::panels() const {
  std::vector<Panel> all;
  const auto& [n, m] = grid_.pieces;
  for (int j = 0; j < m; ++j) {
    for (int i = 0; i < n; ++i) {
      const auto panel = static_cast<std::size_t>(j * n + i);
      all.push_back({{place_now(place_at(i, j)), place_now(place_at(i + 1, j)), place_now(place_at(i + 1, j + 1)),
                      place_now(place_at(i, j + 1))},
                     shear_flow_[panel],
                     sheared_[panel]});
    }
  }
  return all;
}

}  // namespace quoin::members
