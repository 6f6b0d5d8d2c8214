// Checkpoint of a simulation: all data that change during a run, as bytes.
#include <string>

#include "model/contact_frames.h"
#include "step/gather.h"
#include "step/saved_state.h"

namespace quoin {

namespace {

// Law swaps by stage, those of the scene and of a controller: joint family, law.
void write_law_swaps(ArchiveWriter& writer, const std::vector<Stage>& stages) {
  writer.value(std::uint64_t{stages.size()});
  for (const Stage& stage : stages) {
    writer.value(std::uint64_t{stage.law_swaps.size()});
    for (const auto& [family, law] : stage.law_swaps) writer.array(family), writer.array(law);
  }
}

template <class Writer>
void write_state(Writer& writer, const Simulation::Impl& s) {
  writer.value(kCheckpointMark);
  writer.value(s.progress.stage);
  write_law_swaps(writer, s.scene.stages);
  const std::optional<Promotion>& promotion = s.outcome.promotion;
  writer.value(promotion.has_value());
  if (promotion) transfer_promotion(writer, *promotion);
  for (const ContactFamily& family : s.model.families) {
    writer.array(std::string(family.material->api().id));
    writer.value(family.material->api().state_schema);
  }
  // The time step of blocks in large motion follows their contacts, and is saved with these.
  writer.value(s.large_motion ? 0.0 : s.data.time_step);
  transfer_state(writer, s);
  if (!s.large_motion) return;
  take_back_facets(*s.large_motion);
  copy_velocities(*s.large_motion);
  blocks::transfer_blocks(writer, *s.large_motion);
}

// Counts the bytes of arrays by gridpoint and contact point without writing them.
struct CountingWriter : ArchiveWriter {
  std::size_t& more;
  using ArchiveWriter::array;
  template <class T>
  void array(const LaneVector<T>& x) {
    value(std::uint64_t{x.size()});
    give(x.data(), x.size() * sizeof(T));
  }
  void give(const void*, std::size_t size) { more += size; }
};

// Passes bytes to `take` as they come. Arrays by gridpoint and contact point are collected from all ranks.
struct PartsWriter : ArchiveWriter {
  Simulation::Impl& s;
  const Simulation::TakeBytes& take;
  using ArchiveWriter::array;
  template <class T>
  void array(const LaneVector<T>& x) {
    value(std::uint64_t{x.size()});
    give(x.data(), x.size() * sizeof(T));
  }
  void give(const void* first, std::size_t size) {
    hand_on();
    give_array(s, first, size, take);
  }
  void hand_on() {
    if (s.ranks->rank() == 0) take(bytes);
    bytes.clear();
  }
};

}  // namespace

std::vector<std::uint8_t> Simulation::save() const {
  std::vector<std::uint8_t> bytes;
  ArchiveWriter writer{bytes};
  write_state(writer, *impl_);
  return bytes;
}

std::size_t Simulation::saved_bytes() const {
  std::vector<std::uint8_t> bytes;
  std::size_t more = 0;
  CountingWriter writer{{bytes}, more};
  write_state(writer, *impl_);
  return bytes.size() + more;
}

void Simulation::save(const TakeBytes& take) const {
  Impl& s = *impl_;
  if (!s.parts.divided) {
    if (!s.ranks || s.ranks->rank() == 0) take(save());
    return;
  }
  gather(s, Part::row);
  std::vector<std::uint8_t> bytes;
  PartsWriter writer{{bytes}, s, take};
  write_state(writer, s);
  writer.hand_on();
}

}  // namespace quoin
