// Time per step and phase under shear. First, the paper's solid wall (11,520 zones, 3,447 contact points) and its
// 576-block wall. Arguments: courses, half units in a course, threads, displacement before the measurement in um (0: no
// cracks). Second, walls of rigid cubes while cracks grow. Arguments: size, threads, 1 for the kernels of blocks of any
// shape in place of those of the lattice.
#include <benchmark/benchmark.h>

#include "hot_arrays.h"
#include "machine_limits.h"
#include "scene/generate.h"
#include "scene/quality.h"
#include "scene/read_scene.h"
#include "step/findings.h"
#include "step/kernels.h"
#include "step/large_motion.h"
#include "step/simulation.h"

namespace quoin {
namespace {

JointFamily family(const std::string& name, double kn, double ks, double ft, double c, double fc, double g1, double g2,
                   double gc) {
  JointFamily result;
  result.name = name;
  result.law = "fracture_energy";
  const auto add = [&](const char* id, double value) { result.properties.push_back({id, {value}, "", {}}); };
  add("normal_stiffness", kn);
  add("shear_stiffness", ks);
  add("tensile_strength", ft);
  add("cohesion", c);
  add("friction_angle", 35.0);
  add("compressive_strength", fc);
  add("fracture_energy_tension", g1);
  add("fracture_energy_shear", g2);
  add("fracture_energy_compression", gc);
  return result;
}

// Returns a wall with the properties of Table 1 of the paper, as changed in the shipped scenes.
Scene wall(int courses, double units) {
  Scene scene;
  scene.solver = quality_named("standard").solver;
  scene.materials["brick"] = {"brick", 16.7e9, 0.15, 1900.0};
  scene.joints["mortar"] = family("mortar", 82e9, 36e9, 0.2e6, 0.3e6, 5e6, 15, 125, 8000);
  scene.joints["unit"] = family("unit", 1000e9, 1000e9, 2e6, 3e6, 12e6, 80, 550, 19000);
  WallSpec spec;
  spec.courses = courses;
  spec.units_per_course = units;
  spec.unit = {0.22, 0.0625, 0.1};
  spec.unit_material = "brick";
  spec.bed_joint = spec.head_joint = spec.beam_joint = "mortar";
  spec.unit_joint = "unit";
  scene.wall = spec;
  Stage shear;
  BodyControl bottom, top;
  bottom.body = "bottom_beam";
  top.body = "top_beam";
  top.velocity = {0.02, 0.0, 0.0};
  shear.controls = {bottom, top};
  shear.ramp_time = 0.005;
  shear.duration = 1e9;
  shear.monitor = "top_beam";
  scene.stages = {shear};
  return scene;
}

void measure_steps(Simulation& simulation, benchmark::State& state) {
  // The shortest of many windows, since other programs only add time.
  constexpr int kWindow = 10;  // steps; shorter than a time slice of the operating system
  double contacts = 1e9, blocks = 1e9;
  for (auto _ : state) {
    time_phases(simulation);
    simulation.advance(kWindow, false);
    const PhaseTimes times = phase_times(simulation);
    const double of_contacts = times[Phase::jumps] + times[Phase::law] + times[Phase::contact_forces];
    const double of_blocks = times[Phase::internal_forces] + times[Phase::motion];
    if (of_contacts + of_blocks < contacts + blocks) {
      contacts = of_contacts;
      blocks = of_blocks;
    }
  }
  double block_count = 0.0, body_count = 0.0, bytes[3] = {0.0, 0.0, 0.0};
  for (const Model::BlockPlace& place : simulation.model().place) ++(place.body < 0 ? block_count : body_count);
  const double counts[3] = {block_count, body_count, static_cast<double>(simulation.model().point_count)};
  const blocks::Model* const large_motion = simulation.large_motion();
  const double points = large_motion ? static_cast<double>(large_motion->point_count()) : counts[2];
  for (const HotArray& array : hot_arrays(simulation))
    bytes[static_cast<int>(array.of)] += static_cast<double>(array.bytes);
  state.counters["contacts_us"] = contacts * 1e6 / kWindow;
  state.counters["blocks_us"] = blocks * 1e6 / kWindow;
  state.counters["step_us"] = (contacts + blocks) * 1e6 / kWindow;
  state.counters["ns_a_block"] = (contacts + blocks) * 1e9 / kWindow / static_cast<double>(simulation.block_count());
  state.counters["ns_a_point"] = (contacts + blocks) * 1e9 / kWindow / points;
  const char* const names[3] = {"bytes_a_block", "bytes_a_body", "bytes_a_point"};
  for (int i = 0; i < 3; ++i) {
    if (counts[i] > 0.0) state.counters[names[i]] = bytes[i] / counts[i];
  }
  state.SetLabel(kernel_instruction_set());
}

void step(benchmark::State& state) {
  const Scene scene = wall(static_cast<int>(state.range(0)), 0.5 * static_cast<double>(state.range(1)));
  Simulation simulation(scene, assemble(scene), static_cast<int>(state.range(2)));
  do {
    simulation.advance(200);
  } while (simulation.measure().displacement < 1e-6 * static_cast<double>(state.range(3)));
  measure_steps(simulation, state);
}

void cubes(benchmark::State& state) {
  const std::string file = QUOIN_SCENES "/cube_wall_" + std::to_string(state.range(0)) + ".toml";
  const char* const kernels = state.range(2) == 0 ? "lattice" : "general";
  Simulation simulation(read_scene(file, {std::string("solver.kernels=") + kernels}), static_cast<int>(state.range(1)));
  simulation.advance(2000);
  measure_steps(simulation, state);
}
BENCHMARK(cubes)
    ->ArgsProduct({{10, 20}, {1, 2}, {0, 1}})
    ->Iterations(3000)
    ->Unit(benchmark::kMicrosecond)
    ->UseRealTime();

// Measures the product with the stiffness matrices over all blocks of the 576-block wall, on one thread. The result is
// compared with the machine's limits, which are measured just before.
void internal_forces(benchmark::State& state) {
  const benchmarks::Limits limits = benchmarks::measure_limits();
  const Scene scene = wall(32, 9.0);
  const Model model(assemble(scene), make_materials(assemble(scene)));
  LaneVector<double> u(static_cast<std::size_t>(model.line_count) * kLine, 1e-6), force(1 << 16);
  const std::vector<const double*> none(model.groups.size(), nullptr);
  StepData data;
  data.displacement = u.data();
  data.velocity = u.data();
  data.dt_over_mass = u.data();
  data.shared_dt_over_mass = none.data();
  data.load = none.data();
  for (auto _ : state) {
    for (const UnitGroup& unit : model.unit_groups) internal_force(model, unit, data, force.data());
    benchmark::DoNotOptimize(force.data());
  }
  double flops = 0.0, bytes = 0.0;
  for (const BlockGroup& group : model.groups) {
    const BrickTemplate& shape = model.templates[static_cast<std::size_t>(group.brick_template)];
    flops += 2.0 * kLanes * static_cast<double>(shape.stiffness.coefficient.size());
    bytes += 2.0 * sizeof(double) * kLine * shape.node_count;  // u loaded, force stored; K is in the cache
  }
  const auto rate = [](double x) { return benchmark::Counter(x, benchmark::Counter::kIsIterationInvariantRate); };
  state.counters["flop/s"] = rate(flops);
  state.counters["of_peak"] = rate(flops / limits.flops);
  state.counters["flop/byte"] = flops / bytes;
  state.SetLabel(benchmarks::describe(limits));
}
BENCHMARK(internal_forces)->Unit(benchmark::kMicrosecond)->MinTime(1.0);

// Undamaged walls of 60 to 100 thousand blocks; the setup of the largest takes minutes.
void size(benchmark::State& state) { step(state); }

BENCHMARK(step)
    ->Args({16, 9, 1, 0})
    ->Args({16, 9, 2, 0})
    ->Args({16, 9, 1, 500})
    ->Args({32, 18, 1, 0})
    ->Args({32, 18, 2, 0})
    ->Unit(benchmark::kMicrosecond)
    ->UseRealTime();
BENCHMARK(size)
    ->ArgsProduct({{10}, {6}, {1, 2}, {0}})
    ->ArgsProduct({{32}, {32}, {1, 2}, {0}})
    ->ArgsProduct({{100}, {100}, {1, 2}, {0}})
    ->ArgsProduct({{316}, {316}, {1, 2}, {0}})
    ->Iterations(20)
    ->Unit(benchmark::kMicrosecond)
    ->UseRealTime();

}  // namespace
}  // namespace quoin
