#include "step/implicit_contacts.h"

#include <fmt/core.h>

#include <algorithm>
#include <map>
#include <set>

#include "base/error.h"
#include "base/index.h"
#include "base/joined_items.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "step/implicit_contacts.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "model/vectors-inl.h"

HWY_BEFORE_NAMESPACE();
namespace quoin {
namespace HWY_NAMESPACE {

constexpr int kMostNodes = 16;  // most gridpoints of a cluster
// Changes of the traction by less than this share of it are rounding, and give no stiffness.
constexpr double kStill = 1e-9;

// Secant stiffness of a point in the last step, Pa/m, between 0 and that of an undamaged joint.
template <class Tag, class Vec>
HWY_INLINE Vec secant(Tag d, Vec power, Vec way2, Vec traction2, double stiffness) {
  const auto k = hn::Set(d, stiffness), zero = hn::Zero(d);
  const auto still = hn::Le(hn::Mul(hn::Mul(k, k), way2), hn::Mul(hn::Set(d, kStill * kStill), traction2));
  const auto shown = hn::Max(zero, hn::Min(k, hn::Div(power, way2)));
  return hn::IfThenElse(still, hn::IfThenElseZero(hn::Gt(traction2, zero), k), shown);
}

// Secant viscosity over the time step, Pa/m: traction of damping over motion, between 0 and `most`.
template <class Tag, class Vec>
HWY_INLINE Vec dashpot(Tag d, Vec power, Vec way2, Vec most) {
  const auto zero = hn::Zero(d);
  return hn::IfThenElseZero(hn::Gt(way2, zero), hn::Max(zero, hn::Min(most, hn::Div(power, way2))));
}

template <class Tag>
HWY_INLINE void weigh_points(Tag d, const ImplicitContacts::Chunk& c, double dt, int i, double* const (&weight)[2],
                             double* const (&momentum)[3]) {
  using Vec = hn::Vec<Tag>;
  const auto zero = hn::Zero(d), area = hn::LoadU(d, c.area + i);
  const auto known_way = hn::LoadU(d, c.way[0] + i);
  const auto known = hn::Eq(known_way, known_way);  // NaN in the first step: no rate is known
  Vec way[3], change[3], viscous[3], traction[3];
  for (int k = 0; k < 3; ++k) {
    way[k] = hn::IfThenElseZero(known, hn::LoadU(d, c.way[k] + i));
    traction[k] = hn::LoadU(d, c.traction[k] + i);
    change[k] = hn::Sub(traction[k], hn::LoadU(d, c.old_traction[k] + i));
    viscous[k] = c.viscous[k] ? hn::LoadU(d, c.viscous[k] + i) : zero;
  }
  const auto quarter = hn::Set(d, 0.25 * dt * dt), half = hn::Set(d, 0.5 * dt), rate = hn::Set(d, 1.0 / dt);
  const auto mass = [&](Vec k, Vec damping_power, Vec way2, double viscosity) HWY_ATTR {
    const auto most = hn::Mul(hn::Set(d, viscosity / dt), k);
    const auto damped = dashpot(d, damping_power, way2, most);
    return hn::IfThenElseZero(known,
                              hn::Mul(area, hn::MulAdd(quarter, k, hn::Mul(hn::Mul(half, hn::Set(d, dt)), damped))));
  };
  const auto way2 = hn::Mul(way[0], way[0]);
  const auto normal =
      secant(d, hn::Mul(change[0], way[0]), way2, hn::Mul(traction[0], traction[0]), c.normal_stiffness);
  const auto across = mass(normal, hn::Mul(viscous[0], way[0]), way2, c.viscosity[0]);
  const auto both = [&](const Vec(&x)[3], const Vec(&y)[3])
                        HWY_ATTR { return hn::MulAdd(x[1], y[1], hn::Mul(x[2], y[2])); };
  const auto slip2 = both(way, way);
  const auto shear = secant(d, both(change, way), slip2, both(traction, traction), c.shear_stiffness);
  const auto along = mass(shear, both(viscous, way), slip2, c.viscosity[1]);
  hn::StoreU(across, d, weight[0] + i);
  hn::StoreU(along, d, weight[1] + i);
  for (int k = 0; k < 3; ++k) hn::StoreU(hn::Mul(hn::Mul(k == 0 ? across : along, way[k]), rate), d, momentum[k] + i);
}

void WeighPoints(const ImplicitContacts::Chunk& c, int count, double dt, double* const (&weight)[2],
                 double* const (&momentum)[3]) {
  int i = 0;
  for (; i + kWidth <= count; i += kWidth) weigh_points(D(), c, dt, i, weight, momentum);
  for (; i < count; ++i) weigh_points(hn::CappedTag<double, 1>(), c, dt, i, weight, momentum);
}

using Lanes = ImplicitContacts::Lanes;

// Values of the lanes in use; others are 0.
HWY_INLINE V from_line(const Lanes& c, const double* field, const std::int32_t* place, bool row, int p) {
  const D d;
  place += p * kWidth;
  if (!row) return gather(d, field, place);
  const int used = std::clamp(c.lanes - p * kWidth, 0, kWidth);
  if (used == kWidth) return hn::LoadU(d, field + *place);
  return hn::MaskedLoad(hn::FirstN(d, static_cast<std::size_t>(used)), d, field + *place);
}

HWY_INLINE V at_nodes(const Lanes& c, const double* field, int n, int component, int p) {
  return from_line(c, field + component * kLanes, c.node + n * kLanes, c.nodes_row[n] != 0, p);
}

HWY_INLINE void add_at_nodes(const Lanes& c, int n, int component, int p, V velocity, V change) {
  const D d;
  const int used = std::clamp(c.lanes - p * kWidth, 0, kWidth);
  const std::int32_t* node = c.node + n * kLanes + p * kWidth;
  double* const v = c.velocity + component * kLanes;
  double* const u = c.displacement + component * kLanes;
  const V after = hn::Add(velocity, change), dt = hn::Set(d, c.time_step);
  if (c.nodes_row[n] != 0 && used == kWidth) {
    hn::StoreU(after, d, v + *node);
    hn::StoreU(hn::MulAdd(change, dt, hn::LoadU(d, u + *node)), d, u + *node);
    return;
  }
  alignas(64) double afters[kWidth], moved[kWidth];
  hn::Store(after, d, afters);
  hn::Store(hn::MulAdd(change, dt, at_nodes(c, c.displacement, n, component, p)), d, moved);
  for (int lane = 0; lane < used; ++lane) v[node[lane]] = afters[lane], u[node[lane]] = moved[lane];
}

// G of a point for one component, and its pull G (r - b v). r is the point's velocity of half a step before, b v the
// current one.
struct Pull {
  V weight, pull;
};
HWY_INLINE Pull pull_of(const Lanes& c, int point, int component, int p, V jump) {
  const int of = (component - c.point_of_kind[point].axis + 3) % 3;
  const std::int32_t* index = c.point + point * kLanes;
  const bool row = c.points_row[point] != 0;
  const V weight = from_line(c, c.weight[of > 0 ? 1 : 0], index, row, p);
  return {weight, hn::NegMulAdd(weight, jump, from_line(c, c.momentum[of], index, row, p))};
}

HWY_INLINE V mass_of(const Lanes& c, int n, int component, int p) {
  return hn::Load(D(), c.mass + (n * 3 + (c.any_held ? component : 0)) * kLanes + p * kWidth);
}

// Solves clusters of two gridpoints and one point between them.
void SettlePairs(const Lanes& c) {
  for (int p = 0; p < kParts; ++p) {
    for (int k = 0; k < 3; ++k) {
      const int a = c.point_of_kind[0].a, b = c.point_of_kind[0].b;
      const V va = at_nodes(c, c.velocity, a, k, p), vb = at_nodes(c, c.velocity, b, k, p);
      const Pull point = pull_of(c, 0, k, p, hn::Sub(vb, va));
      const V ma = mass_of(c, a, k, p), mb = mass_of(c, b, k, p);
      const V share = hn::Div(point.pull, hn::MulAdd(ma, mb, hn::Mul(point.weight, hn::Add(ma, mb))));
      add_at_nodes(c, a, k, p, va, hn::Neg(hn::Mul(share, mb)));
      add_at_nodes(c, b, k, p, vb, hn::Mul(share, ma));
    }
  }
}

// Solves (M + G) d = sum b (G r - G b v) by elimination: M is diagonal and positive, so no pivot is needed.
template <int kNodes>
void SettleNodes(const Lanes& c) {
  const int nodes = kNodes > 0 ? kNodes : c.nodes;
  constexpr int kRoom = kNodes > 0 ? kNodes : kMostNodes;
  for (int p = 0; p < kParts; ++p) {
    for (int k = 0; k < 3; ++k) {
      V matrix[kRoom][kRoom], right[kRoom], before[kRoom], over[kRoom];
      for (int i = 0; i < nodes; ++i) {
        before[i] = at_nodes(c, c.velocity, i, k, p);
        right[i] = hn::Zero(D());
        for (int j = 0; j < i; ++j) matrix[i][j] = hn::Zero(D());
        matrix[i][i] = mass_of(c, i, k, p);
      }
      for (int q = 0; q < c.points; ++q) {
        const int a = c.point_of_kind[q].a, b = c.point_of_kind[q].b;
        const Pull point = pull_of(c, q, k, p, hn::Sub(before[b], before[a]));
        matrix[a][a] = hn::Add(matrix[a][a], point.weight);
        matrix[b][b] = hn::Add(matrix[b][b], point.weight);
        V& beside = matrix[std::max(a, b)][std::min(a, b)];
        beside = hn::Sub(beside, point.weight);
        right[a] = hn::Sub(right[a], point.pull);
        right[b] = hn::Add(right[b], point.pull);
      }
      for (int i = 0; i < nodes; ++i) {
        over[i] = hn::Div(hn::Set(D(), 1.0), matrix[i][i]);
        for (int j = i + 1; j < nodes; ++j) {
          const V factor = hn::Mul(matrix[j][i], over[i]);
          for (int l = j; l < nodes; ++l) matrix[l][j] = hn::NegMulAdd(factor, matrix[l][i], matrix[l][j]);
          right[j] = hn::NegMulAdd(factor, right[i], right[j]);
        }
      }
      for (int i = nodes - 1; i >= 0; --i) {
        for (int j = i + 1; j < nodes; ++j) right[i] = hn::NegMulAdd(matrix[j][i], right[j], right[i]);
        right[i] = hn::Mul(right[i], over[i]);
      }
      for (int i = 0; i < nodes; ++i) add_at_nodes(c, i, k, p, before[i], right[i]);
    }
  }
}

void SettleCluster(const Lanes& c) {
  if (c.nodes == 2 && c.points == 1) return SettlePairs(c);
  if (c.nodes == 3) return SettleNodes<3>(c);
  if (c.nodes == 4) return SettleNodes<4>(c);
  SettleNodes<0>(c);
}

}  // namespace HWY_NAMESPACE
}  // namespace quoin
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace quoin {

HWY_EXPORT(WeighPoints);
HWY_EXPORT(SettleCluster);

namespace {
constexpr double kHeld = 1e30;  // kg; inertia of held components and of prescribed bodies
}  // namespace

ImplicitContacts::ImplicitContacts(const Model& model, const LaneVector<double>& node_mass) {
  JoinedItems joined(node_mass.size());
  std::set<int> nodes;
  for (std::int32_t i = 0; i < model.point_count; ++i) {
    joined.join(model.node_a[at(i)], model.node_b[at(i)]);
    nodes.insert({model.node_a[at(i)], model.node_b[at(i)]});
  }
  std::map<int, Cluster> clusters;
  for (const int node : nodes) clusters[joined.first_of(node)].nodes.push_back(node);
  for (std::int32_t i = 0; i < model.point_count; ++i)
    clusters[joined.first_of(model.node_a[at(i)])].points.push_back(i);
  std::vector<std::vector<Cluster>> of_kind;
  for (auto& [node, cluster] : clusters) {
    const std::size_t kind = kind_of(cluster, model);
    of_kind.resize(kinds_.size());
    of_kind[kind].push_back(std::move(cluster));
  }
  for (std::size_t k = 0; k < of_kind.size(); ++k) fill(static_cast<int>(k), std::move(of_kind[k]), model, node_mass);
  for (auto& column : weight_) column.assign(at(model.point_count), 0.0);
  for (auto& column : momentum_) column.assign(at(model.point_count), 0.0);
}

std::size_t ImplicitContacts::kind_of(const Cluster& cluster, const Model& model) {
  const std::vector<int>& nodes = cluster.nodes;
  const std::vector<int>& points = cluster.points;
  if (nodes.size() > at(HWY_NAMESPACE::kMostNodes))
    throw Error(Exit::bad_input,
                fmt::format("solver.implicit_contacts takes {} gridpoints that meet at one place at most, and {} do; "
                            "remove it",
                            HWY_NAMESPACE::kMostNodes, nodes.size()));
  Kind kind{static_cast<int>(nodes.size()), {}};
  const auto place = [&](int node) {
    return static_cast<int>(std::lower_bound(nodes.begin(), nodes.end(), node) - nodes.begin());
  };
  for (const int i : points)
    kind.points.push_back({place(model.node_a[at(i)]), place(model.node_b[at(i)]), model.point_axis[at(i)]});
  const auto known = std::find(kinds_.begin(), kinds_.end(), kind);
  if (known != kinds_.end()) return static_cast<std::size_t>(known - kinds_.begin());
  kinds_.push_back(std::move(kind));
  return kinds_.size() - 1;
}

// Consecutive indices need no gather instructions. Where those of the contact points of at least kRow clusters are
// consecutive, so are those of gridpoints, on one side at least. Such clusters have a batch of their own.
void ImplicitContacts::fill(int kind, std::vector<Cluster> clusters, const Model& model,
                            const LaneVector<double>& node_mass) {
  constexpr std::size_t kRow = 6;
  std::sort(clusters.begin(), clusters.end(), [](const auto& x, const auto& y) { return x.points < y.points; });
  std::vector<const Cluster*> rest;
  for (std::size_t i = 0; i < clusters.size();) {
    std::vector<const Cluster*> row{&clusters[i]};
    for (++i; i < clusters.size() && row.size() < kLanes; ++i) {
      if (clusters[i].points.front() != row.back()->points.front() + 1) break;
      row.push_back(&clusters[i]);
    }
    if (row.size() >= kRow)
      add(kind, row, model, node_mass);
    else
      rest.insert(rest.end(), row.begin(), row.end());
  }
  for (std::size_t i = 0; i < rest.size(); i += kLanes)
    add(kind, std::span(rest).subspan(i, std::min<std::size_t>(kLanes, rest.size() - i)), model, node_mass);
}

void ImplicitContacts::add(int kind, std::span<const Cluster* const> clusters, const Model& model,
                           const LaneVector<double>& node_mass) {
  const auto nodes = at(kinds_[at(kind)].nodes), points = kinds_[at(kind)].points.size();
  Batch batch{kind, static_cast<int>(clusters.size()), false, node_.size() / kLanes, point_.size() / kLanes};
  node_.resize(node_.size() + nodes * kLanes, 0);
  point_.resize(point_.size() + points * kLanes, 0);
  mass_.resize(mass_.size() + 3 * nodes * kLanes, kHeld);
  for (std::size_t lane = 0; lane < clusters.size(); ++lane) {
    const Cluster& cluster = *clusters[lane];
    for (std::size_t q = 0; q < points; ++q) point_[(batch.first_point + q) * kLanes + lane] = cluster.points[q];
    for (std::size_t n = 0; n < nodes; ++n) {
      node_[(batch.first_node + n) * kLanes + lane] = cluster.nodes[n];
      for (std::size_t c = 0; c < 3; ++c) {
        const std::size_t i = at(cluster.nodes[n]) + c * kLanes;
        if (model.node_free[i] != 0.0 && node_mass[i] > 0.0)
          mass_[((batch.first_node + n) * 3 + c) * kLanes + lane] = node_mass[i];
      }
      const double* const mass = &mass_[(batch.first_node + n) * 3 * kLanes + lane];
      batch.any_held = batch.any_held || mass[0] != mass[kLanes] || mass[0] != mass[2 * kLanes];
    }
  }
  const auto follow = [&](const LaneVector<std::int32_t>& places, std::size_t line) {
    bool row = true;
    for (std::size_t lane = 1; lane < clusters.size(); ++lane)
      row = row && places[line * kLanes + lane] == places[line * kLanes + lane - 1] + 1;
    return row ? std::uint8_t{1} : std::uint8_t{0};
  };
  for (std::size_t n = 0; n < nodes; ++n) nodes_row_.push_back(follow(node_, batch.first_node + n));
  for (std::size_t q = 0; q < points; ++q) points_row_.push_back(follow(point_, batch.first_point + q));
  batches_.push_back(batch);
}

void ImplicitContacts::weigh(const ContactChunk& chunk, const Chunk& columns, double time_step) {
  const auto first = chunk.first_point;
  double* const weight[2] = {weight_[0].data() + first, weight_[1].data() + first};
  double* const momentum[3] = {momentum_[0].data() + first, momentum_[1].data() + first, momentum_[2].data() + first};
  HWY_DYNAMIC_DISPATCH(WeighPoints)(columns, chunk.point_count, time_step, weight, momentum);
}

void ImplicitContacts::settle(int piece, const StepData& step) const {
  const std::size_t end = std::min(batches_.size(), at((piece + 1) * kBatches));
  for (std::size_t i = at(piece * kBatches); i < end; ++i) {
    const Batch& batch = batches_[i];
    const Kind& kind = kinds_[at(batch.kind)];
    const Lanes lanes{batch.lanes,
                      batch.any_held,
                      kind.nodes,
                      static_cast<int>(kind.points.size()),
                      kind.points.data(),
                      node_.data() + batch.first_node * kLanes,
                      point_.data() + batch.first_point * kLanes,
                      nodes_row_.data() + batch.first_node,
                      points_row_.data() + batch.first_point,
                      mass_.data() + 3 * batch.first_node * kLanes,
                      {weight_[0].data(), weight_[1].data()},
                      {momentum_[0].data(), momentum_[1].data(), momentum_[2].data()},
                      step.velocity,
                      step.displacement,
                      step.time_step};
    HWY_DYNAMIC_DISPATCH(SettleCluster)(lanes);
  }
}

}  // namespace quoin
#endif
