#include "step/state_hash.h"

#include <bit>
#include <span>

#include "base/fnv_hash.h"
#include "model/world_parts.h"
#include "step/borders.h"
#include "step/gather.h"
#include "step/lattice_fields.h"
#include "step/points_at_rest.h"
#include "step/state.h"

namespace quoin {

namespace {

template <class Values>
void add_to_hash(const Values& values, FnvHash* hash) {
  for (const double value : values) hash->add(std::bit_cast<std::uint64_t>(value));
}

void add_to_hash(const std::vector<BodyLanes>& bodies, FnvHash* hash) {
  for (const BodyLanes& lanes : bodies) {
    for (const auto* quantity : {&lanes.displacement, &lanes.rotation, &lanes.velocity, &lanes.spin}) {
      for (const auto& component : *quantity) add_to_hash(component, hash);
    }
  }
}

// at_rest: all arrays but states of laws are zero.
std::uint64_t hash_by_parts(Simulation::Impl& s, bool at_rest) {
  const auto give = [&](const void* first, std::size_t bytes, const Simulation::TakeBytes& take) {
    give_array(s, first, bytes, take);
  };
  if (s.large_motion) return s.large_motion->hash(give);
  FnvHash hash;
  each_lattice_field(s.lattice, [&](const Field& field, const auto& array, int family) {
    if (field.hashed == 0) return;
    if (field.known_to_all || (at_rest && family < 0)) return add_to_hash(array, &hash);
    give(array.data(), array.size() * sizeof array[0], [&](std::span<const std::uint8_t> bytes) {
      add_to_hash(std::span(reinterpret_cast<const double*>(bytes.data()), bytes.size() / sizeof(double)), &hash);
    });
  });
  return hash.value();
}

}  // namespace

// Gathers the results that rank 0 writes afterwards, or all of the state where it is not held in parts.
void end_run(Simulation::Impl& s) {
  if (!s.parts.divided) return gather(s, Part::all);
  if (s.large_motion)
    exchange_parted_blocks(*s.large_motion);
  else
    receive_whole_borders(s);
  s.agreed.end_conditions = conditions_of_all(s);
  gather(s, Part::row);
  s.agreed.end_hash = hash_by_parts(s, false);
}

void note_start(Simulation::Impl& s) {
  s.agreed.start_hash.reset();
  if (!s.parts.divided || (s.scene.damage.empty() && !s.large_motion)) return;
  prepare_row(s);
  s.agreed.start_hash = hash_by_parts(s, true);
}

std::uint64_t Simulation::hash() const {
  if (impl_->agreed.end_conditions && !has_all(*impl_)) return impl_->agreed.end_hash;
  if (impl_->agreed.start_hash && impl_->progress.step == 0 && !has_all(*impl_)) return *impl_->agreed.start_hash;
  if (impl_->large_motion) {
    copy_velocities(*impl_->large_motion);
    return impl_->large_motion->hash();
  }
  FnvHash hash;
  each_lattice_field(impl_->lattice, [&](const Field& field, const auto& array, int f) {
    if (field.hashed == 0) return;
    if (f < 0 || impl_->parts.holds_all) return add_to_hash(array, &hash);
    // Before the first step: initial states of all points, as this rank holds those of its own points alone.
    const ContactFamily& family = impl_->model.families[at(f)];
    for (const double value : family.material->initial_state(impl_->model.assembly.families[at(f)].initial_state))
      add_to_hash(std::vector<double>(at(family.point_count), value), &hash);
  });
  return hash.value();
}

}  // namespace quoin
