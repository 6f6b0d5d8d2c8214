// Blocks in large motion from a checkpoint.
#include "base/error.h"
#include "model/contact_frames.h"
#include "step/saved_blocks.h"

namespace quoin::blocks {

using namespace geometry;

namespace {

constexpr const char* kOther = "checkpoint: of another model";

}  // namespace

void Model::restore(ArchiveReader& reader) {
  const std::size_t body_count = bodies.size(), node_count = nodes.x.size();
  transfer_blocks(reader, *this);
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
  require(impacts.landing.size() == (damping.impacts ? contacts.families.size() * blocks.size() : 0));
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
