// Damage of all joints, where frames follow it.
#include "step/columns/columns.h"
#include "step/state.h"

namespace quoin {

namespace {

std::vector<std::string> damage_names(const Scene& scene) {
  return scene.output.frames_at_damage > 0.0 ? std::vector<std::string>{"joint_damage"} : std::vector<std::string>{};
}

std::vector<double> damage_values(const Simulation::Impl& run) {
  return run.damage.sound_at_start < 0.0 ? std::vector<double>{} : std::vector<double>{run.damage.now};
}

}  // namespace

extern const ColumnGroup kDamageColumns{damage_names, damage_values};

}  // namespace quoin
