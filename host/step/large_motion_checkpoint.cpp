// Everything of a model that changes while it runs, as bytes; what follows from the scene alone is built, not stored.
#include "base/archive.h"
#include "base/error.h"
#include "members/members.h"
#include "model/fields.h"
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
  archive.array(m.contacts_);
  WorldFields::each(m, [&](const Field&, auto& array) { archive.array(array); });
  archive.value(m.unit_count_);
  archive.array(m.kept_);

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
  archive.array(m.loaded_);
  archive.array(m.applied_);
  archive.value(m.gravity_);
  transfer(archive, m.gravity_factor_);

  archive.value(m.small_);
  archive.value(m.settling_);
  archive.value(m.time_);
  archive.value(m.dt_);
  archive.value(m.critical_dt_);
  archive.array(m.impact_beta_);
  archive.value(m.impact_zone_beta_);
  archive.value(m.impact_rate_);
  archive.value(m.impact_share_);
  archive.value(m.maxwell_);
  archive.value(m.stiffness_bound_);
  archive.value(m.step_count_);
  archive.value(m.next_check_);
  archive.value(m.check_dt_);
  archive.value(m.detections_);
  archive.value(m.narrow_calls_);
  archive.value(m.unbalanced_);
  archive.value(m.net_);
  archive.value(m.energies_);
  archive.value(m.later_);
  archive.value(m.members_work_);
  if (m.members_) members::Members::transfer(archive, *m.members_);
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
  const auto require = [](bool fits) {
    if (!fits) throw Error(Exit::bad_input, kOther);
  };
  const auto require_items = [&](const Field& field, size_t count, size_t items) {
    const bool wanted =
        field.when == When::always || (field.when == When::with_stiffness_damping && viscous_contacts()) ||
        (field.when == When::with_maxwell && has_maxwell()) || (field.when == When::with_energies && energy_);
    require(count == items || (!wanted && count == 0));
  };
  WorldFields::of_blocks(*this, [&](const Field& field, const auto& array) {
    require_items(field, array.size(),
                  field.owner == Owner::gridpoint ? nodes : (field.owner == Owner::body ? bodies : blocks_.size()));
  });
  WorldFields::of_pairs(
      *this, [&](const Field& field, const auto& array) { require_items(field, array.size(), contacts_.size()); });
  require(kept_.empty() || kept_.size() == start_point_.size() * kept_width());
  require(loaded_.size() == blocks_.size() && (applied_.empty() || applied_.size() == blocks_.size()));
  const auto is_block = [&](int i) { return i >= 0 && size_t(i) < blocks_.size(); };
  const auto is_facet = [&](int i, int block) {
    return blocks_[size_t(block)].body >= 0 ? i < 0 : i >= 0 && size_t(i) < facets_.size();
  };
  for (Family& f : families_) {
    WorldFields::of_points(
        [&](const Field& field, const auto& column) { require_items(field, column.size(), f.size()); }, f);
    for (const Point& p : f.point)
      require(is_block(p.a) && is_block(p.b) && is_facet(p.facet_a, p.a) && is_facet(p.facet_b, p.b));
  }
  for (const Contact& c : contacts_) {
    const bool fits =
        is_block(c.pair.a) && is_block(c.pair.b) && c.family < int(families_.size()) &&
        (c.family < 0 ? c.count == 0
                      : size_t(c.first) + c.count <= families_[size_t(c.family)].size() &&
                            c.first_facet + size_t(c.count) * size_t(facets_a_point(c)) <= facets_.size());
    require(fits);
  }
  for (const PairCheck& check : pair_check_) require(is_block(check.a) && is_block(check.b));
  for (const SeenMotion& seen : seen_) require(seen.step >= 0 && seen.step <= step_count_);
  for (int i = 0; i < block_count(); ++i) {
    const int other = other_half_[size_t(i)];
    require(apart_[size_t(i)] == (other < 0 ? 0 : apart_[size_t(other)]));
  }
  frames_are_old_ = false;
  divide_work();
}

}  // namespace quoin::blocks
