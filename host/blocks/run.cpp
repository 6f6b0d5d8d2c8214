#include "blocks/run.h"

#include <fmt/format.h>

#include "blocks/generate.h"
#include "scene/error.h"

namespace quoin::blocks {

using namespace geometry;

Run::Run(BlockScene scene) : scene_(std::move(scene)) {
  model_ = std::make_unique<Model>(assemble(scene_), scene_.solver);
  for (int i = 0; i < model_->block_count(); ++i) start_.push_back(model_->position(i));
  const Assembly& a = model_->assembly();
  if (!scene_.monitor.empty()) monitor_ = find_block(a, scene_.monitor, scene_.file + ": output.monitor");
  for (const Contact& c : model_->contacts()) {
    if (c.count == 0 || std::abs(c.separation.normal.y) < 0.7) continue;
    if (a.blocks[c.pair.a].fixed) on_base_.push_back(c.pair.b);
    if (a.blocks[c.pair.b].fixed) on_base_.push_back(c.pair.a);
  }
  // every name of every stage is looked up before anything runs
  for (const BlockStage& s : scene_.stages) {
    for (const auto& v : s.velocities) find_block(a, v.block, s.source.text);
    for (const auto& f : s.forces) find_block(a, f.block, s.source.text);
    for (const auto& p : s.pressures) find_block(a, p.block, s.source.text);
  }
  model_->track_energy(scene_.energy);
}

double Run::largest_displacement() const {
  double largest = 0.0;
  for (int i = 0; i < model_->block_count(); ++i) {
    if (model_->assembly().blocks[i].fixed) continue;
    const double moved = norm(model_->position(i) - start_[i]);
    if (!std::isfinite(moved)) return moved;  // std::max would lose it
    largest = std::max(largest, moved);
  }
  return largest;
}

namespace {

// What a history may hold: a run whose rows are no numbers has failed, whatever comes after.
void require_finite(const Row& r, const std::string& stage) {
  const Energies& e = r.energies;
  const std::pair<const char*, double> values[] = {
      {"displacement of the monitor", norm(r.displacement)},
      {"force on the monitor", norm(r.force)},
      {"largest displacement", r.largest_displacement},
      {"unbalanced ratio", r.unbalanced_ratio},
      {"energy balance", e.balance_error(0.0)},
  };
  for (const auto& [name, value] : values) {
    if (std::isfinite(value)) continue;
    throw Error(Exit::numerical,
                fmt::format("stage '{}', step {}, time {:.6g} s: the {} is {}, no finite number; check "
                            "the velocities and forces of the stage, or reduce time_step_fraction",
                            stage, r.step, r.time, name, value));
  }
}

}  // namespace

Row Run::measure(int stage) const {
  Row r;
  r.stage = stage, r.step = model_->steps(), r.time = model_->time(), r.multiplier = multiplier_;
  if (monitor_ >= 0) {
    r.displacement = model_->position(monitor_) - start_[monitor_];
    r.force = model_->contact_force(monitor_);
  }
  r.largest_displacement = largest_displacement();
  r.unbalanced_ratio = model_->unbalanced_ratio();
  r.energies = model_->energies();
  require_finite(r, scene_.stages[size_t(stage)].name);
  return r;
}

void Run::begin(const BlockStage& stage, const BlockStage* previous) {
  Model& m = *model_;
  const Assembly& a = m.assembly();
  stage_start_ = m.time();
  multiplier_ = 0.0;
  if (stage.solver) m.set_damping(*stage.solver);
  // Loads of before fade while those of this stage grow.
  const double t0 = m.time(), t1 = t0 + std::max(stage.ramp_time, m.time_step());
  const TimeSeries up{{t0, t1}, {0, 1}}, down{{t0, t1}, {1, 0}};
  m.clear_loads();
  const auto add_loads = [&](const BlockStage& s, const TimeSeries& factor) {
    for (const auto& f : s.forces) {
      Load l{};
      l.block = find_block(a, f.block, s.source.text), l.force = vector(f.force), l.factor = factor;
      // the point moves with its block
      l.point = m.position(l.block) + m.orientation(l.block) * (vector(f.point) - start_[l.block]);
      m.add(l);
    }
    for (const auto& p : s.pressures) {
      Pressure load{};
      load.block = find_block(a, p.block, s.source.text), load.value = p.pressure, load.factor = factor;
      const ConvexPolyhedron& shape = a.shapes[a.blocks[load.block].shape];
      const Matrix turned = matrix(a.blocks[load.block].orientation);
      for (size_t f = 1; f < shape.faces.size(); ++f) {
        if (dot(turned * shape.normals[f], vector(p.normal)) > dot(turned * shape.normals[load.face], vector(p.normal)))
          load.face = int(f);
      }
      m.add(load);
    }
  };
  if (previous) add_loads(*previous, down);
  add_loads(stage, up);
  if (previous) {
    for (const auto& v : previous->velocities) {
      const int block = find_block(a, v.block, previous->source.text);
      if (a.blocks[block].fixed)
        m.prescribe(block, {});
      else
        m.release(block);
    }
  }
  if (stage.ground) {
    GroundMotion g;
    for (size_t i = 0; i < a.blocks.size(); ++i) {
      if (a.blocks[i].fixed) g.blocks.push_back(int(i));
    }
    g.direction = vector(stage.ground->direction);
    g.acceleration = {stage.ground->acceleration.time, stage.ground->acceleration.value};
    for (double& t : g.acceleration.time) t += t0;
    m.add(g);
  } else if (previous && previous->ground) {
    for (size_t i = 0; i < a.blocks.size(); ++i) {
      if (a.blocks[i].fixed) m.prescribe(int(i), {});
    }
  }
}

void Run::watch_uplift() {
  if (outcome_.base_slip_at_uplift) return;
  double opened = 0.0;
  for (const Contact& c : model_->contacts()) {
    if (c.count == 0 || std::abs(c.separation.normal.y) < 0.7) continue;
    for (uint32_t i = c.first; i < c.first + c.count; ++i)
      opened = std::max(opened, model_->families()[c.family].normal_jump[i]);
  }
  if (opened < 1e-4) return;
  double slip = 0.0;
  for (int b : on_base_) {
    const Vector d = model_->position(b) - start_[b];
    slip = std::max(slip, std::hypot(d.x, d.z));
  }
  outcome_.base_slip_at_uplift = slip;
}

void Run::run_stage(int index, const std::function<void(const Row&)>& row, const std::function<void(int)>& frame) {
  const BlockStage& stage = scene_.stages[size_t(index)];
  const BlockStage* previous = index > 0 ? &scene_.stages[size_t(index) - 1] : nullptr;
  begin(stage, previous);
  Model& m = *model_;
  const Vector from = previous ? vector(previous->gravity) : Vector{}, to = vector(stage.gravity);
  const bool last = index + 1 == int(scene_.stages.size());
  double expected = stage.duration.value_or(
      stage.collapse ? (stage.collapse->limit - stage.collapse->start) / stage.collapse->rate : 1.0);
  const double interval = scene_.record_interval > 0 ? scene_.record_interval : expected / 500;
  double next_row = m.time() + interval, next_frame = m.time();
  const double frame_interval = scene_.frames > 0 ? expected / scene_.frames : 1e300;
  int frames = 0, calm = 0;
  for (long steps = 0;; ++steps) {
    if (stop_.load(std::memory_order_relaxed)) throw Error(Exit::interrupted, "interrupted");
    const double t = m.time() - stage_start_;
    const double x = stage.ramp_time > 0 ? std::min(1.0, t / stage.ramp_time) : 1.0, smooth = x * x * (3 - 2 * x);
    Vector g = from + smooth * (to - from);
    if (stage.collapse) {
      multiplier_ = stage.collapse->start * smooth + stage.collapse->rate * std::max(0.0, t - stage.ramp_time);
      g += multiplier_ * norm(to) * normalized(vector(stage.collapse->direction));
    }
    m.set_gravity(g);
    for (const auto& v : stage.velocities) {
      uint8_t held = v.rotation_held ? 0x38 : 0;
      for (int k = 0; k < 3; ++k) held |= uint8_t(v.held[size_t(k)] << k);
      m.prescribe(find_block(m.assembly(), v.block, stage.source.text), smooth * vector(v.velocity),
                  smooth * vector(v.omega), held);
    }
    // a few steps at a time while controls change slowly
    const long chunk = 10;
    m.run_steps(chunk);
    steps += chunk - 1;
    if (m.time() >= next_row) row(measure(index)), next_row += interval;
    if (last && frame && m.time() >= next_frame && frames < scene_.frames)
      frame(frames++), next_frame += frame_interval;
    if (stage.collapse) {
      watch_uplift();
      if (largest_displacement() > stage.collapse->displacement) {
        outcome_.collapse_multiplier = multiplier_;
        break;
      }
      if (multiplier_ > stage.collapse->limit) break;
    }
    if (stage.duration && m.time() - stage_start_ >= *stage.duration - 0.5 * m.time_step()) break;
    if (stage.equilibrium_ratio) {
      calm = m.unbalanced_ratio() <= *stage.equilibrium_ratio && t > stage.ramp_time ? calm + 1 : 0;
      if (calm >= 10) break;
    }
    if (steps > stage.max_steps) {
      throw Error(Exit::numerical, fmt::format("stage '{}': no end after {} steps (unbalanced ratio {:.2e}); raise "
                                               "max_steps, the damping or equilibrium_ratio",
                                               stage.name, steps, m.unbalanced_ratio()));
    }
  }
  row(measure(index));
  if (last && frame && scene_.frames > 0) frame(frames);
}

Outcome Run::run(const std::function<void(const Row&)>& row, const std::function<void(int)>& frame) {
  for (size_t i = 0; i < scene_.stages.size(); ++i) run_stage(int(i), row, frame);
  return outcome_;
}

}  // namespace quoin::blocks
