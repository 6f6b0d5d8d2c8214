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
  archive.array(m.contacts_.list);
  WorldFields::each(m, [&](const Field&, auto& array) { archive.array(array); });
  archive.value(m.units_.count);
  archive.array(m.start_joints_.kept);

  archive.list(m.actions_.loads, [](auto& a, auto& load) {
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
  archive.list(m.actions_.pressures, [](auto& a, auto& pressure) {
    a.value(pressure.block);
    a.value(pressure.face);
    a.value(pressure.value);
    transfer(a, pressure.factor);
    a.array(pressure.triangles);
    a.value(pressure.arm);
    a.value(pressure.push);
    a.value(pressure.scale);
  });
  archive.array(m.actions_.loaded);
  archive.array(m.actions_.applied);
  archive.value(m.actions_.gravity);
  transfer(archive, m.actions_.gravity_factor);

  archive.value(m.small_);
  archive.value(m.settling_);
  archive.value(m.stepping_.time);
  archive.value(m.stepping_.dt);
  archive.value(m.stepping_.critical_dt);
  archive.array(m.impacts_.beta);
  archive.value(m.impacts_.zone_beta);
  archive.value(m.impacts_.rate);
  archive.value(m.impacts_.share);
  archive.value(m.impacts_.maxwell);
  archive.value(m.stepping_.stiffness_bound);
  archive.value(m.stepping_.count);
  archive.value(m.checks_.next);
  archive.value(m.checks_.calm_steps);
  archive.value(m.checks_.dt);
  archive.value(m.detection_.count);
  archive.value(m.detection_.narrow_calls);
  archive.value(m.step_sums_.unbalanced);
  archive.value(m.step_sums_.net);
  archive.value(m.step_sums_.energies);
  archive.value(m.step_sums_.later);
  archive.value(m.held_by_.work);
  if (m.held_by_.members) members::Members::transfer(archive, *m.held_by_.members);
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
  const std::size_t bodies = bodies_.size(), nodes = nodes_.x.size();
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
      *this, [&](const Field& field, const auto& array) { require_items(field, array.size(), contacts_.list.size()); });
  require(start_joints_.kept.empty() || start_joints_.kept.size() == start_joints_.point.size() * kept_width());
  require(actions_.loaded.size() == blocks_.size() &&
          (actions_.applied.empty() || actions_.applied.size() == blocks_.size()));
  const auto is_block = [&](int i) { return i >= 0 && size_t(i) < blocks_.size(); };
  const auto is_facet = [&](int i, int block) {
    return blocks_[size_t(block)].body >= 0 ? i < 0 : i >= 0 && size_t(i) < contacts_.facets.size();
  };
  for (Family& f : contacts_.families) {
    WorldFields::of_points(
        [&](const Field& field, const auto& column) { require_items(field, column.size(), f.size()); }, f);
    for (const Point& p : f.point)
      require(is_block(p.a) && is_block(p.b) && is_facet(p.facet_a, p.a) && is_facet(p.facet_b, p.b));
  }
  for (const Contact& c : contacts_.list) {
    const bool fits =
        is_block(c.pair.a) && is_block(c.pair.b) && c.family < int(contacts_.families.size()) &&
        (c.family < 0 ? c.count == 0
                      : size_t(c.first) + c.count <= contacts_.families[size_t(c.family)].size() &&
                            c.first_facet + size_t(c.count) * size_t(facets_a_point(c)) <= contacts_.facets.size());
    require(fits);
  }
  for (const PairCheck& check : checks_.pair) require(is_block(check.a) && is_block(check.b));
  for (const SeenMotion& seen : checks_.seen) require(seen.step >= 0 && seen.step <= stepping_.count);
  for (int i = 0; i < block_count(); ++i) {
    const int other = units_.other_half[size_t(i)];
    require(units_.apart[size_t(i)] == (other < 0 ? 0 : units_.apart[size_t(other)]));
  }
  frames_.are_old = false;
  divide_work();
}

}  // namespace quoin::blocks
