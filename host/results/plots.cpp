#include "results/plots.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <optional>
#include <string_view>

#include "base/attempt.h"
#include "files/file.h"
#include "files/gnuplot.h"
#include "results/colours.h"
#include "results/history.h"
#include "results/picture_text.h"
#include "scene/generate.h"
#include "step/collect.h"
#include "step/results.h"

namespace quoin {

namespace {

// Largest of 1, 2 or 5 times a power of ten that is not above x.
double round_down(double x) {
  const double power = std::pow(10.0, std::floor(std::log10(x)));
  for (const double digit : {5.0, 2.0}) {
    if (x >= digit * power) return digit * power;
  }
  return power;
}

std::string moved_part(const Scene& scene) {
  return scene.stages.empty() ? "wall" : moved_part(scene, scene.stages.back());
}

}  // namespace

std::string moved_part(const Scene& scene, const Stage& stage) {
  if (!stage.roof.empty()) return "roof";
  std::string name = stage.monitor.empty() ? scene.output.monitor : stage.monitor;
  std::replace(name.begin(), name.end(), '_', ' ');
  return name.empty() ? "wall" : name;
}

bool same_curve(const Scene& scene, const Stage& a, const Stage& b) {
  return &a == &b || (moved_part(scene, a) == moved_part(scene, b) && axis_name(a) == axis_name(b));
}

const Stage& stage_of_curve(const Scene& scene) {
  for (const bool at_rest : {false, true}) {
    for (auto stage = scene.stages.rbegin(); stage != scene.stages.rend(); ++stage) {
      const bool rests = std::string_view(curve_kind(*stage)) == "rest";
      if (rests == at_rest && !watches_nothing(scene, *stage)) return *stage;
    }
  }
  return scene.stages.back();
}

bool watches_part_of_curve(const Scene& scene, const Stage& stage) {
  return !watches_nothing(scene, stage) && moved_part(scene, stage) == moved_part(scene, stage_of_curve(scene));
}

std::vector<bool> stages_on_curve(const Scene& scene) {
  const Stage& of_curve = stage_of_curve(scene);
  std::vector<bool> on_curve;
  for (const Stage& stage : scene.stages)
    on_curve.push_back(!watches_nothing(scene, stage) && same_curve(scene, stage, of_curve));
  return on_curve;
}

bool watches_several(const Scene& scene) {
  return std::ranges::any_of(scene.stages, [&](const Stage& stage) {
    return !watches_nothing(scene, stage) && !watches_part_of_curve(scene, stage);
  });
}

Peak find_peak(const std::vector<HistoryRow>& rows, const Scene& scene) {
  Peak peak;
  const std::vector<bool> on_curve = stages_on_curve(scene);
  for (size_t i = 0; i < rows.size(); ++i) {
    if (!on_curve[static_cast<size_t>(rows[i].stage)]) continue;
    const Shown r = shown(rows[i], scene);
    if (peak.row >= 0 && std::abs(r.force) <= peak.force) continue;
    peak = {static_cast<int>(i), std::abs(r.force), std::abs(r.displacement), rows[i].vertical_force};
  }
  return peak;
}

namespace {

// Whether the half cycle at `time` goes farther to a side than those before. Others repeat an amplitude, after which
// the force is smaller although the envelope of the cycles has not fallen.
bool goes_farther(const CyclicMotion& motion, double time, double side) {
  double farthest = 0.0;
  const int now = motion.half_cycle(time);
  for (int half_cycle = 0; half_cycle < now; ++half_cycle)
    farthest = std::max(farthest, side * motion.target(half_cycle));
  return side * motion.target(now) > farthest;
}

}  // namespace

std::optional<double> displacement_at_loss(const std::vector<HistoryRow>& rows, const Scene& scene, const Peak& peak,
                                           double kept) {
  if (!(peak.force > 0.0)) return std::nullopt;
  const auto at_peak = static_cast<size_t>(peak.row);
  const std::vector<bool> on_curve = stages_on_curve(scene);
  const double side = std::copysign(1.0, shown(rows[at_peak], scene).force);
  std::optional<CyclicMotion> cycles;  // of the stage
  std::optional<double> lost;
  double begin = 0.0, farthest = 0.0, largest = -HUGE_VAL;
  for (size_t i = 0; i < rows.size(); ++i) {
    const HistoryRow& row = rows[i];
    if (i == 0 || row.stage != rows[i - 1].stage) {
      const Stage& stage = scene.stages[static_cast<size_t>(row.stage)];
      begin = row.time;
      cycles = stage.cycles ? std::optional<CyclicMotion>(*stage.cycles) : std::nullopt;
    }
    if (!on_curve[static_cast<size_t>(row.stage)]) continue;
    const Shown now = shown(row, scene);
    const double displacement = side * now.displacement, force = side * now.force;
    const bool is_farther = displacement > farthest && (!cycles || goes_farther(*cycles, row.time - begin, side));
    farthest = std::max(farthest, displacement);
    if (is_farther) {
      // The force rises when the wall is loaded again, so that a loss counts from its largest value on.
      if (force > largest) largest = force, lost.reset();
      if (!lost && i > at_peak && force <= kept * peak.force) lost = displacement;
    } else if (lost) {
      break;
    } else {
      largest = -HUGE_VAL;
    }
  }
  return lost;
}

namespace {

using Run = ResultRun;

constexpr long kMostBricks =
    100'000;  // largest number: gnuplot takes 10 kB for each, and more would be too small to see

// Magnified displacements of the wall: the largest one is at most 7.5 % of its height.
struct Magnified {
  Vec3 low{HUGE_VAL, HUGE_VAL, HUGE_VAL}, high{-HUGE_VAL, -HUGE_VAL, -HUGE_VAL};  // box around all blocks, m
  double largest = 0.0;                                                           // largest displacement, m
  double factor = 1.0;

  // Magnified place as a line of a gnuplot file, mm.
  std::string moved(const Vec3& x, const Vec3& u) const {
    return fmt::format("{:.6g} {:.6g}\n", (x[0] + factor * u[0]) * 1e3, (x[1] + factor * u[1]) * 1e3);
  }
};

Magnified magnified(const Simulation& simulation) {
  Magnified view;
  for (const Run& run : runs_of_blocks(simulation)) {
    for (int b = run.first; brings(simulation, run) && b < run.end; ++b) {
      for (const Vec3& u : block_displacement(simulation, b))
        view.largest = std::max(view.largest, std::hypot(u[0], u[1]));
    }
  }
  view.largest = largest_brought(simulation, view.largest);
  for (const Brick& brick : simulation.assembly().bricks) {
    for (size_t axis = 0; axis < 3; ++axis) {
      view.low[axis] = std::min(view.low[axis], brick.origin[axis]);
      view.high[axis] = std::max(view.high[axis], brick.origin[axis] + brick.size[axis]);
    }
  }
  if (view.largest > 1e-12) view.factor = round_down(0.075 * (view.high[1] - view.low[1]) / view.largest);
  return view;
}

// Data files of the picture.
enum : size_t { kBricks, kBeams, kJointsInUnits, kFirstCrack };
constexpr size_t kDataFiles = kFirstCrack + kCrackCount;
using Data = std::array<std::string, kDataFiles>;

std::string name_of_data(size_t file) {
  if (file >= kFirstCrack) return fmt::format("joints_{}.dat", file - kFirstCrack);
  return file == kBricks ? "bricks.dat" : file == kBeams ? "beams.dat" : "joints_unit.dat";
}

// Adds the outline of a brick's front face, counter-clockwise, along the gridpoints of its edges.
void add_outline(const Simulation& simulation, const Magnified& view, int block, Data& data) {
  const Brick& brick = simulation.assembly().bricks[static_cast<size_t>(block)];
  const auto mesh = block_mesh(simulation, block);
  const auto displacement = block_displacement(simulation, block);
  const double x0 = brick.origin[0], y0 = brick.origin[1], x1 = x0 + brick.size[0], y1 = y0 + brick.size[1];
  const double tolerance = 1e-6 * (brick.size[0] + brick.size[1]), front = brick.origin[2] + brick.size[2];
  std::vector<std::pair<double, size_t>> outline;  // place along the edge, gridpoint
  for (size_t i = 0; i < mesh.gridpoint.size(); ++i) {
    const Vec3& p = mesh.gridpoint[i];
    if (std::abs(p[2] - front) > tolerance) continue;
    const double fx = (p[0] - x0) / brick.size[0], fy = (p[1] - y0) / brick.size[1];
    if (std::abs(p[1] - y0) < tolerance)
      outline.emplace_back(fx, i);
    else if (std::abs(p[0] - x1) < tolerance)
      outline.emplace_back(1 + fy, i);
    else if (std::abs(p[1] - y1) < tolerance)
      outline.emplace_back(3 - fx, i);
    else if (std::abs(p[0] - x0) < tolerance)
      outline.emplace_back(4 - fy, i);
  }
  std::sort(outline.begin(), outline.end());
  if (!outline.empty()) outline.push_back(outline[0]);
  std::string& text = data[brick.beam ? kBeams : kBricks];
  for (const auto& [place, i] : outline) text += view.moved(mesh.gridpoint[i], displacement[i]);
  text += "\n";
}

// Joints of this rank as quads of the picture.
class JointQuads {
 public:
  JointQuads(const Simulation& simulation, const Surfaces& surfaces, const Magnified& view)
      : simulation_(simulation),
        model_(simulation.model()),
        view_(view),
        order_(points_by_joint(simulation)),
        crack_(static_cast<size_t>(simulation.point_count())) {
    for (const Run& run : runs_of_points(simulation)) {
      for (const JointPoint& p : surfaces.joint_points(simulation, {run.first, run.end}, ranks_collect(simulation)))
        crack_[static_cast<size_t>(p.contact.index)] = p.crack;
    }
  }

  // Adds joints as seen from the front. Of points behind each other the most damaged one counts. Each point colours the
  // line half-way to its neighbours.
  void add(const Run& joints, Data& data) const {
    const auto joint_of = [&](std::int32_t point) { return model_.point_joint[static_cast<size_t>(point)]; };
    auto p = std::partition_point(order_.begin(), order_.end(),
                                  [&](std::int32_t point) { return joint_of(point) < joints.first; });
    while (p != order_.end() && joint_of(*p) < joints.end) {
      std::map<long long, Seen> places;  // along the joint
      for (const int joint = joint_of(*p); p != order_.end() && joint_of(*p) == joint; ++p) {
        const int axis = model_.point_axis[static_cast<size_t>(*p)];
        if (axis == 2) continue;  // horizontal in the picture plane: not visible from the front
        const size_t along = axis == 0 ? 1 : 0;
        auto [place, fresh] = places.try_emplace(std::llround(position(*p)[along] * 1e6), Seen{*p, *p});
        if (crack(*p) > crack(place->second.worst)) place->second.worst = *p;
        if (position(*p)[2] > position(place->second.front)[2]) place->second.front = *p;
      }
      for (auto it = places.begin(); it != places.end() && std::next(it) != places.end(); ++it) {
        const Seen &a = it->second, &b = std::next(it)->second;
        add_half(a.worst, a.front, b.front, 0.0, 0.5, data);
        add_half(b.worst, a.front, b.front, 0.5, 1.0, data);
      }
    }
  }

 private:
  struct Seen {
    std::int32_t worst, front;
  };

  Crack crack(std::int32_t point) const { return crack_[static_cast<size_t>(point)]; }
  const Vec3& position(std::int32_t point) const { return model_.point_position[static_cast<size_t>(point)]; }

  // Adds a half segment as the quad between its two sides: an open crack is a coloured gap, a closed one a line. Intact
  // joints inside a unit have their own colour, so that the unit looks like one brick.
  void add_half(std::int32_t worst, std::int32_t a, std::int32_t b, double from, double to, Data& data) const {
    const auto at_a = displacement_of_sides(simulation_, a), at_b = displacement_of_sides(simulation_, b);
    const auto corner = [&](double t, Vec3 std::pair<Vec3, Vec3>::*side) {
      Vec3 x{}, u{};
      for (size_t axis = 0; axis < 2; ++axis) {
        x[axis] = position(a)[axis] + t * (position(b)[axis] - position(a)[axis]);
        u[axis] = (at_a.*side)[axis] + t * ((at_b.*side)[axis] - (at_a.*side)[axis]);
      }
      return view_.moved(x, u);
    };
    const Model::Sides sides = model_.sides_of(worst);
    const auto& bricks = model_.assembly.bricks;
    const int unit = bricks[static_cast<size_t>(sides.a)].unit;
    const bool inside = unit >= 0 && unit == bricks[static_cast<size_t>(sides.b)].unit;
    const bool intact = crack(worst) == Crack::intact;
    std::string& text = data[inside && intact ? kJointsInUnits : kFirstCrack + static_cast<size_t>(crack(worst))];
    using Pair = std::pair<Vec3, Vec3>;
    text += corner(from, &Pair::first) + corner(to, &Pair::first) + corner(to, &Pair::second) +
            corner(from, &Pair::second) + corner(from, &Pair::first) + "\n";
  }

  const Simulation& simulation_;
  const Model& model_;
  const Magnified& view_;
  std::vector<std::int32_t> order_;  // points by joint
  std::vector<Crack> crack_;         // by point
};

// Collects the data of all ranks on rank 0, piece by piece: take(Data).
template <class Take>
Magnified collect_data(const Simulation& simulation, const Surfaces& surfaces, const Take& take) {
  const Magnified view = magnified(simulation);
  const JointQuads joints(simulation, surfaces, view);
  const auto collect = [&](const std::vector<Run>& runs, const auto& add) {
    collect_at_first(
        simulation, runs,
        [&](const Run& run) {
          Data data;
          add(run, data);
          std::string packed;
          for (const std::string& text : data) packed += text + '\0';
          return packed;
        },
        [&](const std::string& packed) {
          Data data;
          size_t begin = 0;
          for (std::string& text : data) {
            text = packed.substr(begin, packed.find('\0', begin) - begin);
            begin += text.size() + 1;
          }
          take(data);
        });
  };
  collect(runs_of_blocks(simulation), [&](const Run& run, Data& data) {
    for (int b = run.first; b < run.end; ++b) add_outline(simulation, view, b, data);
  });
  collect(runs_of_joints(simulation), [&](const Run& run, Data& data) { joints.add(run, data); });
  return view;
}

// Data files that grow. An empty one has a point NaN, as gnuplot fails on an empty file.
class DataFiles {
 public:
  explicit DataFiles(const std::filesystem::path& folder) {
    make_folder(folder);
    for (size_t i = 0; i < kDataFiles; ++i) file_.push_back(std::make_unique<GrowingFile>(folder / name_of_data(i)));
  }
  void append(const Data& data) {
    for (size_t i = 0; i < kDataFiles; ++i) {
      file_[i]->append(data[i]);
      empty_[i] = empty_[i] && data[i].empty();
    }
  }
  void finish() {
    for (size_t i = 0; i < kDataFiles; ++i) {
      if (empty_[i]) file_[i]->append("NaN NaN\n");
      file_[i]->finish();
    }
  }

 private:
  std::vector<std::unique_ptr<GrowingFile>> file_;
  std::array<bool, kDataFiles> empty_ = [] {
    std::array<bool, kDataFiles> all{};
    all.fill(true);
    return all;
  }();
};

// Plot command of the joints and the legend.
std::string joints_plot() {
  std::string plot;
  const auto add = [&](size_t file, const char* colour, double width) {
    for (const char* how : {"filledcurves closed fillcolor", "lines linecolor"})
      plot += fmt::format(", \\\n     \"{}\" with {} rgb \"{}\"{} notitle", name_of_data(file), how, colour,
                          *how == 'l' ? fmt::format(" linewidth {}", width) : std::string());
  };
  add(kJointsInUnits, kBlockColours.joint_in_unit, 0.7);
  for (const CrackStyle& style : kCrackStyles)
    add(kFirstCrack + static_cast<size_t>(style.crack), style.colour, style.width);
  for (const CrackStyle& style : kCrackStyles)
    plot += fmt::format(", \\\n     NaN with lines linewidth {} linecolor rgb \"{}\" title \"{}\"",
                        style.crack == Crack::intact ? 2.0 : 7.0, style.colour, style.label);
  return plot;
}

}  // namespace

std::string plot_cracks(const std::filesystem::path& folder, const Simulation& simulation, const Surfaces& surfaces,
                        const std::vector<HistoryRow>& rows, const std::string& law, const std::string& label) {
  if (simulation.block_count() > kMostBricks)
    return fmt::format("cracks.png: left out for more than {} blocks; use joints.pvd", kMostBricks);
  const Scene& scene = simulation.scene();
  Attempt attempt;
  std::optional<DataFiles> files;
  attempt([&] { files.emplace(folder / "plots"); });
  const Magnified view =
      collect_data(simulation, surfaces, [&](const Data& data) { attempt([&] { files->append(data); }); });
  attempt([&] { files->finish(); });
  attempt.rethrow();

  std::string state = "law " + law;
  if (!rows.empty() && !watches_nothing(scene, scene.stages.back())) {
    const Shown r = shown(rows.back(), scene);
    state = fmt::format("{} moved {:.2f} mm{}, {} force {:.1f} kN, law {}", moved_part(scene),
                        std::abs(r.displacement) * 1e3,
                        !is_vertical(scene)    ? ""
                        : r.displacement < 0.0 ? " down"
                                               : " up",
                        is_vertical(scene) ? "vertical" : "horizontal", std::abs(r.force) / 1e3, law);
  }
  const std::string moment = moment_of(rows, scene);
  // One scale on both axes. The height of the picture follows from the wall, with space for title and legend.
  const Vec3 &low = view.low, &high = view.high;
  const double width = (high[0] - low[0]) * 1e3, height = (high[1] - low[1]) * 1e3,
               sway = view.largest * view.factor * 1e3;
  const double margin = 0.03 * std::max(width, height);
  const double range_x = width + 2 * (margin + sway), range_y = height + 2 * margin + 0.3 * sway;
  const double scale = 1200.0 / std::max(range_x, range_y), above = 150.0, below = label.empty() ? 110.0 : 140.0;
  const double pixels_x = std::max(1000.0, range_x * scale + 40), pixels_y = range_y * scale + above + below;
  const std::string script = fmt::format(
      R"gp(set terminal pngcairo size {:.0f},{:.0f} font "Sans,17"
set label 1 {} at screen 0.5,{:.4f} center noenhanced font "Sans,21"
set label 2 {} at screen 0.5,{:.4f} center noenhanced font "Sans,16"
set label 3 {} at screen 0.5,{:.4f} center noenhanced font "Sans,16"
set size ratio -1
set tmargin at screen {:.4f}
set bmargin at screen {:.4f}
set lmargin at screen 0.02
set rmargin at screen 0.98
set xrange [{:.6g}:{:.6g}]
set yrange [{:.6g}:{:.6g}]
unset border
unset tics
{}set key at screen 0.5,{:.4f} center top horizontal maxrows 2 samplen 2.5 spacing 1.4 width 3 reverse Left
set style fill solid 1.0 noborder
plot "beams.dat" with filledcurves closed fillcolor rgb "{}" notitle, \
     "beams.dat" with lines linewidth 1.0 linecolor rgb "{}" notitle, \
     "bricks.dat" with filledcurves closed fillcolor rgb "{}" notitle{}
)gp",
      pixels_x, pixels_y, fitting_text(title_of(scene), pixels_x, 21), 1.0 - 0.27 * above / pixels_y,
      fitting_text(state, pixels_x, 16), 1.0 - 0.53 * above / pixels_y,
      fitting_text(
          fmt::format("{}{}displacements drawn {:g} times larger", moment, moment.empty() ? "" : "; ", view.factor),
          pixels_x, 16),
      1.0 - 0.76 * above / pixels_y, 1.0 - above / pixels_y, below / pixels_y, low[0] * 1e3 - margin - sway,
      high[0] * 1e3 + margin + sway, low[1] * 1e3 - margin, high[1] * 1e3 + margin + sway * 0.3, label,
      (below - 10.0) / pixels_y, kBlockColours.beam, kBlockColours.beam_edge, kBlockColours.face, joints_plot());
  return draw_picture(folder, "cracks", script);
}

void collect_cracks(const Simulation& simulation, const Surfaces& surfaces) {
  if (ranks_collect(simulation) && simulation.block_count() <= kMostBricks)
    collect_data(simulation, surfaces, [](const Data&) {});
}

}  // namespace quoin
