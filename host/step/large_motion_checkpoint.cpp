// Everything of a model that changes while it runs, as bytes; what follows from the scene alone is built, not stored.
#include "base/archive.h"
#include "base/error.h"
#include "step/large_motion.h"

namespace quoin::blocks {

namespace {

constexpr const char* kOther = "checkpoint: of another model";

template <class Archive, class Series>
void transfer(Archive& archive, Series& series) {
  archive.array(series.time);
  archive.array(series.value);
}

}  // namespace

template <class Archive, class Self>
void Model::transfer_state(Archive& archive, Self& m) {
  archive.value(m.solver_);  // damping is a stage's
  archive.array(m.broad_);
  archive.array(m.bodies_);
  archive.array(m.node_x_);
  archive.array(m.node_v_);
  archive.array(m.node_held_);
  archive.array(m.node_held_v_);
  archive.array(m.apart_);
  archive.value(m.unit_count_);
  archive.array(m.by_zone_);
  for (auto& f : m.families_) {
    archive.array(f.point);
    for (auto& column : f.slid) archive.array(column);
    archive.array(f.normal_jump);
    for (auto& column : f.slip) archive.array(column);
    for (auto& column : f.traction) archive.array(column);
    archive.list(f.state, [](auto& a, auto& column) { a.array(column); });
    for (auto& column : f.columns) archive.array(column.values);
    for (auto& column : f.old_traction) archive.array(column);
    archive.array(f.old_jump);
    archive.array(f.stored);
    for (auto& column : f.dissipated) archive.array(column);
    for (auto& column : f.viscous) archive.array(column);
  }
  archive.array(m.facets_);
  archive.array(m.contacts_);
  archive.array(m.pair_place_);
  archive.array(m.pair_look_);
  archive.array(m.block_look_);
  archive.array(m.seen_);
  archive.array(m.block_contact_force_);

  archive.list(m.loads_, [](auto& a, auto& load) {
    a.value(load.block);
    a.value(load.point);
    a.value(load.force);
    transfer(a, load.factor);
    a.list(load.share, [](auto& inner, auto& share) {
      inner.value(share.first);
      inner.value(share.second);
    });
    a.value(load.arm);
    a.value(load.scale);
  });
  archive.list(m.pressures_, [](auto& a, auto& pressure) {
    a.value(pressure.block);
    a.value(pressure.face);
    a.value(pressure.value);
    transfer(a, pressure.factor);
    a.array(pressure.triangles);
    a.value(pressure.arm);
    a.value(pressure.push);
    a.value(pressure.scale);
  });
  archive.list(m.motions_, [](auto& a, auto& motion) {
    a.array(motion.blocks);
    a.value(motion.direction);
    transfer(a, motion.acceleration);
  });
  archive.array(m.loaded_);
  archive.array(m.applied_);
  archive.value(m.gravity_);
  transfer(archive, m.gravity_factor_);

  archive.value(m.small_);
  archive.value(m.settling_);
  archive.value(m.time_);
  archive.value(m.dt_);
  archive.value(m.critical_dt_);
  archive.value(m.stiffness_bound_);
  archive.value(m.step_count_);
  archive.value(m.next_check_);
  archive.value(m.calm_steps_);
  archive.value(m.look_dt_);
  archive.value(m.detections_);
  archive.value(m.narrow_calls_);
  archive.value(m.unbalanced_);
  archive.value(m.net_);
  archive.value(m.energies_);
  archive.value(m.later_);
}

namespace {

struct GivingWriter {
  ArchiveWriter& to;
  const Model::GiveArray& give;
  template <class T>
  void value(const T& x) {
    to.value(x);
  }
  template <class Array>
  void array(const Array& x) {
    to.array(x);
  }
  template <class T>
  void array(const LaneVector<T>& x) {
    if (!give) return to.array(x);
    to.value(std::uint64_t{x.size()});
    give(to, x.data(), x.size() * sizeof(T));
  }
  template <class Element, class Fields>
  void list(const std::vector<Element>& x, Fields&& of_element) {
    value(std::uint64_t{x.size()});
    for (const Element& element : x) of_element(*this, element);
  }
};

}  // namespace

void Model::save(ArchiveWriter& writer, const GiveArray& give) {
  take_back_facets();
  GivingWriter giving{writer, give};
  transfer_state(giving, *this);
}

void Model::restore(ArchiveReader& reader) {
  const std::size_t bodies = bodies_.size(), nodes = node_x_.size();
  transfer_state(reader, *this);
  if (bodies_.size() != bodies || node_x_.size() != nodes || node_v_.size() != nodes || node_held_.size() != nodes ||
      node_held_v_.size() != nodes || block_contact_force_.size() != blocks_.size() ||
      loaded_.size() != blocks_.size() || apart_.size() != blocks_.size() || by_zone_.size() != blocks_.size() ||
      (!applied_.empty() && applied_.size() != blocks_.size()) || pair_look_.size() != contacts_.size() ||
      pair_place_.size() != contacts_.size() || broad_.size() != blocks_.size() ||
      (!block_look_.empty() && block_look_.size() != blocks_.size()) || (!seen_.empty() && seen_.size() != bodies))
    throw Error(Exit::bad_input, kOther);
  const auto is_block = [&](int i) { return i >= 0 && size_t(i) < blocks_.size(); };
  const auto is_facet = [&](int i, int block) {
    return blocks_[size_t(block)].body >= 0 ? i < 0 : i >= 0 && size_t(i) < facets_.size();
  };
  for (const Family& f : families_) {
    const size_t n = f.size();
    bool fits = f.normal_jump.size() == n && f.state.size() == f.material->api().state_count;
    for (const auto& column : f.slid) fits = fits && column.size() == n;
    for (const auto& column : f.slip) fits = fits && column.size() == n;
    for (const auto& column : f.traction) fits = fits && column.size() == n;
    for (const auto& column : f.state) fits = fits && column.size() == n;
    for (const auto& column : f.columns) fits = fits && column.values.size() == n;
    for (const auto& column : f.old_traction) fits = fits && (column.size() == n || !viscous_contacts());
    fits = fits && (f.old_jump.size() == n || !viscous_contacts()) && (f.stored.size() == n || !energy_);
    for (const auto& column : f.dissipated) fits = fits && (column.size() == n || !energy_);
    for (const auto& column : f.viscous) fits = fits && (column.size() == n || !viscous_contacts());
    for (const Point& p : f.point)
      fits = fits && is_block(p.a) && is_block(p.b) && is_facet(p.facet_a, p.a) && is_facet(p.facet_b, p.b);
    if (!fits) throw Error(Exit::bad_input, kOther);
  }
  for (const Contact& c : contacts_) {
    const bool fits =
        is_block(c.pair.a) && is_block(c.pair.b) && c.family < int(families_.size()) &&
        (c.family < 0 ? c.count == 0
                      : size_t(c.first) + c.count <= families_[size_t(c.family)].size() &&
                            c.first_facet + size_t(c.count) * size_t(facets_a_point(c)) <= facets_.size());
    if (!fits) throw Error(Exit::bad_input, kOther);
  }
  for (const PairLook& look : pair_look_) {
    if (!is_block(look.a) || !is_block(look.b)) throw Error(Exit::bad_input, kOther);
  }
  for (const SeenMotion& seen : seen_) {
    if (seen.step < 0 || seen.step > step_count_) throw Error(Exit::bad_input, kOther);
  }
  for (int i = 0; i < block_count(); ++i) {
    const int other = other_half_[size_t(i)];
    if (apart_[size_t(i)] != (other < 0 ? 0 : apart_[size_t(other)])) throw Error(Exit::bad_input, kOther);
  }
  divide_work();
}

}  // namespace quoin::blocks
