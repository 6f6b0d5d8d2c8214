// Checkpoint of blocks in large motion: all data that change in a run. Data that follow from the scene are built again.
#include "base/archive.h"
#include "base/error.h"
#include "members/members.h"
#include "model/contact_frames.h"
#include "model/fields.h"
#include "step/large_motion.h"

namespace quoin::blocks {

using namespace geometry;

namespace {

constexpr const char* kOther = "checkpoint: of another model";

template <class Archive, class Self>
void transfer_state(Archive& archive, Self& m) {
  archive.array(m.contacts.list);
  WorldFields::each(m, [&](const Field&, auto& array) { archive.array(array); });
  archive.value(m.units.count);
  archive.array(m.start_joints.kept);

  archive.list(m.actions.loads, [](auto& a, auto& load) {
    a.value(load.block);
    a.value(load.point);
    a.value(load.force);
    a.list(load.share, [](auto& inner, auto& share) {
      inner.value(share.first);
      inner.value(share.second);
    });
    a.value(load.arm);
    a.value(load.scale);
  });
  archive.list(m.actions.pressures, [](auto& a, auto& pressure) {
    a.value(pressure.block);
    a.value(pressure.face);
    a.value(pressure.value);
    a.array(pressure.triangles);
    a.value(pressure.arm);
    a.value(pressure.push);
    a.value(pressure.scale);
  });
  archive.array(m.actions.loaded);
  archive.array(m.actions.applied);
  archive.value(m.actions.gravity);
  archive.value(m.actions.of_collapse);

  archive.value(m.is_small);
  archive.value(m.is_settling);
  archive.value(m.stepping.time);
  archive.value(m.stepping.dt);
  archive.value(m.stepping.critical_dt);
  archive.value(m.stepping.springs);
  archive.array(m.impacts.beta);
  archive.value(m.impacts.zone_beta);
  archive.value(m.impacts.rate);
  archive.value(m.impacts.share);
  archive.value(m.impacts.maxwell);
  archive.value(m.stepping.stiffness_bound);
  archive.value(m.stepping.count);
  archive.value(m.checks.next);
  archive.value(m.checks.dt);
  archive.value(m.detection.count);
  archive.value(m.detection.narrow_calls);
  archive.value(m.step_sums.unbalanced);
  archive.value(m.step_sums.net);
  archive.value(m.step_sums.energies);
  archive.value(m.step_sums.later);
  archive.value(m.held_by.work);
  if (m.held_by.members) members::Members::transfer(archive, *m.held_by.members);
}

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
  take_back_facets(*this);
  copy_velocities(*this);
  GivingWriter giving{writer, give};
  transfer_state(giving, *this);
}

void Model::restore(ArchiveReader& reader) {
  const std::size_t body_count = bodies.size(), node_count = nodes.x.size();
  transfer_state(reader, *this);
  settle(is_settling);
  const auto require = [](bool fits) {
    if (!fits) throw Error(Exit::bad_input, kOther);
  };
  const auto require_items = [&](const Field& field, size_t count, size_t items) {
    const bool wanted = field.when == When::always ||
                        (field.when == When::with_stiffness_damping && damping.of_contacts()) ||
                        (field.when == When::with_maxwell && damping.has_maxwell()) ||
                        (field.when == When::with_energies && books_energy);
    require(count == items || (!wanted && count == 0));
  };
  WorldFields::of_blocks(*this, [&](const Field& field, const auto& array) {
    require_items(
        field, array.size(),
        field.owner == Owner::gridpoint ? node_count : (field.owner == Owner::body ? body_count : blocks.size()));
  });
  WorldFields::of_pairs(
      *this, [&](const Field& field, const auto& array) { require_items(field, array.size(), contacts.list.size()); });
  require(start_joints.kept.empty() || start_joints.kept.size() == start_joints.point.size() * kept_width(*this));
  require(actions.loaded.size() == blocks.size() &&
          (actions.applied.empty() || actions.applied.size() == blocks.size()));
  const auto is_block = [&](int i) { return i >= 0 && size_t(i) < blocks.size(); };
  const auto is_facet = [&](int i, int block) {
    return blocks[size_t(block)].body >= 0 ? i < 0 : i >= 0 && size_t(i) < contacts.facets.size();
  };
  for (Family& f : contacts.families) {
    WorldFields::of_points(
        [&](const Field& field, const auto& column) { require_items(field, column.size(), f.size()); }, f);
    for (const Point& p : f.point)
      require(is_block(p.a) && is_block(p.b) && is_facet(p.facet_a, p.a) && is_facet(p.facet_b, p.b));
  }
  for (const Contact& c : contacts.list) {
    const bool fits = is_block(c.pair.a) && is_block(c.pair.b) && c.family < int(contacts.families.size()) &&
                      (c.family < 0 ? c.count == 0
                                    : size_t(c.first) + c.count <= contacts.families[size_t(c.family)].size() &&
                                          c.first_facet + size_t(c.count) * size_t(facets_a_point(*this, c)) <=
                                              contacts.facets.size());
    require(fits);
  }
  for (const PairCheck& check : checks.pair) require(is_block(check.a) && is_block(check.b));
  for (const AssumedMotion& motion : checks.assumed) require(motion.step >= 0 && motion.step <= stepping.count);
  for (int i = 0; i < block_count(); ++i) {
    const int other = units.other_half[size_t(i)];
    require(units.apart[size_t(i)] == (other < 0 ? 0 : units.apart[size_t(other)]));
  }
  frames.are_old = pieces.velocities_lag = false;
  pieces.are_old = pieces.motion_is_old = true;
  divide_work(*this);
}

}  // namespace quoin::blocks
