#include "results/history.h"

#include <fmt/format.h>

#include <cmath>

#include "files/csv_text.h"
#include "files/file.h"

namespace quoin {

Response response(const HistoryRow& row, const Stage& stage) {
  // A stage monitored along y still has a horizontal response: the one along the wall.
  const size_t axis = stage.direction == 1 ? 0 : static_cast<size_t>(stage.direction);
  const double force = stage.direction == 1 ? -row.joint_force[0] : row.resistance;
  return {row.monitor_displacement[axis], force, row.vertical_force};
}

History::History(const std::filesystem::path& path, const Scene& scene, const std::vector<HistoryRow>& before)
    : path_(path), scene_(scene), stream_(begin_file(path), std::ios::trunc) {
  stream_ << "stage,stage_name,step,time_s,displacement_m,vertical_displacement_m,horizontal_force_N,vertical_force_N,"
             "unbalanced_ratio,kinetic_energy_J";
  if (scene.output.energy)
    stream_ << ",strain_energy_J,contact_energy_J,dissipated_tension_J,dissipated_cohesion_J,dissipated_friction_J,"
               "dissipated_crushing_J,external_work_J,damping_work_J,energy_balance_error_J";
  if (scene.blocks) {
    stream_ << ",multiplier,monitor_dx_m,monitor_dy_m,monitor_dz_m,monitor_fx_N,monitor_fy_N,monitor_fz_N,"
               "largest_displacement_m";
    if (scene.output.energy) stream_ << ",kinetic_J,strain_J,contact_stored_J,damping_J,external_J,detection_J";
  }
  stream_ << '\n';
  for (const HistoryRow& row : before) add(row);
}

// Numbers in the shortest decimals that read back to the same double.
void History::add(const HistoryRow& row) {
  const Stage& stage = scene_.stages[static_cast<size_t>(row.stage)];
  const Response r = response(row, stage);
  std::string line = fmt::format("{},{},{},{},{},{},{},{},{},{}", row.stage + 1, csv_text(stage.name), row.step,
                                 row.time, r.displacement, row.monitor_displacement[1], r.horizontal_force,
                                 r.vertical_force, csv_number(row.unbalanced_ratio), row.kinetic_energy);
  if (scene_.output.energy) {
    const Energies e = row.energies.value_or(Energies{});
    line += fmt::format(",{},{},{},{},{},{},{},{},{}", e.strain, e.contact_stored, e.dissipated[0], e.dissipated[1],
                        e.dissipated[2], e.dissipated[3], e.external, e.damping, e.balance_error());
  }
  if (scene_.blocks) {
    line += fmt::format(",{}", row.multiplier);
    for (const Vec3& v : {row.monitor_displacement, row.joint_force})
      line += fmt::format(",{},{},{}", v[0], v[1], v[2]);
    line += fmt::format(",{}", row.largest_displacement);
    if (scene_.output.energy) {
      const Energies e = row.energies.value_or(Energies{});
      line +=
          fmt::format(",{},{},{},{},{},{}", e.kinetic, e.strain, e.contact_stored, e.damping, e.external, e.detection);
    }
  }
  stream_ << line << '\n';
  if (!stream_) refuse();  // now, and not after hours
  rows_.push_back(row);
}

void History::finish() {
  stream_.close();
  if (!stream_) refuse();
  finish_file(path_);
}

void History::refuse() {
  stream_.close();
  std::error_code ignored;
  std::filesystem::remove(part_name(path_), ignored);
  throw Error(Exit::bad_input, path_.string() +
                                   ": cannot be written; free space and go on with --resume, or choose another folder "
                                   "with --out");
}

}  // namespace quoin
