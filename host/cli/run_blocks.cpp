#include "cli/run_blocks.h"

#include <fmt/format.h>

#include <chrono>
#include <csignal>
#include <fstream>
#include <nlohmann/json.hpp>

#include "blocks/run.h"
#include "results/file.h"
#include "results/gnuplot.h"
#include "results/result_folder.h"
#include "scene/error.h"

namespace quoin {

namespace {

using blocks::Model;
using blocks::Run;
using geometry::Vector;
namespace fs = std::filesystem;

std::atomic<Run*> running{nullptr};
extern "C" void stop_blocks(int) {
  if (Run* run = running.load()) run->stop();
}

// Faces of all blocks as they stand: VTK PolyData with the number and the displacement of each block.
class Frames {
 public:
  explicit Frames(fs::path folder) : folder_(std::move(folder)) {}
  void add(const Run& run) {
    const Model& m = run.model();
    std::vector<float> points, displacement;
    std::vector<int32_t> connectivity, offsets, block;
    for (int i = 0; i < m.block_count(); ++i) {
      const auto& b = m.block(i);
      const Vector d = m.position(i) - run.start_position(i);
      const auto polygon = [&](const std::vector<Vector>& corners) {
        for (const Vector& p : corners) {
          connectivity.push_back(int32_t(points.size() / 3));
          for (int k = 0; k < 3; ++k) points.push_back(float(p[k]));
        }
        offsets.push_back(int32_t(connectivity.size()));
        block.push_back(i);
        for (int k = 0; k < 3; ++k) displacement.push_back(float(d[k]));
      };
      if (b.body >= 0) {
        for (const auto& face : b.shape->faces) {
          std::vector<Vector> corners;
          for (int v : face) corners.push_back(m.corner(i, v));
          polygon(corners);
        }
      } else {
        for (const auto& t : b.surface) {
          polygon({m.node_positions()[t.node[0]], m.node_positions()[t.node[1]], m.node_positions()[t.node[2]]});
        }
      }
    }
    std::string appended, cells, polys, pts;
    const auto array = [&](std::string& section, const char* name, const char* type, const auto& values,
                           int components) {
      section += fmt::format(
          "<DataArray type=\"{}\" Name=\"{}\" NumberOfComponents=\"{}\" format=\"appended\" offset=\"{}\"/>\n", type,
          name, components, appended.size());
      const uint64_t bytes = values.size() * sizeof(values[0]);
      appended.append(reinterpret_cast<const char*>(&bytes), sizeof bytes);
      appended.append(reinterpret_cast<const char*>(values.data()), bytes);
    };
    array(pts, "position", "Float32", points, 3);
    array(polys, "connectivity", "Int32", connectivity, 1);
    array(polys, "offsets", "Int32", offsets, 1);
    array(cells, "block", "Int32", block, 1);
    array(cells, "displacement", "Float32", displacement, 3);
    const std::string name = fmt::format("blocks_{:04}.vtp", times_.size());
    write_file(
        folder_ / name,
        fmt::format(
            "<?xml version=\"1.0\"?>\n<VTKFile type=\"PolyData\" version=\"1.0\" byte_order=\"LittleEndian\" "
            "header_type=\"UInt64\">\n<PolyData>\n<Piece NumberOfPoints=\"{}\" NumberOfVerts=\"0\" NumberOfLines=\"0\" "
            "NumberOfStrips=\"0\" "
            "NumberOfPolys=\"{}\">\n<Points>\n{}</Points>\n<Polys>\n{}</Polys>\n<CellData>\n{}</CellData>\n"
            "</Piece>\n</PolyData>\n<AppendedData encoding=\"raw\">\n_",
            points.size() / 3, offsets.size(), pts, polys, cells) +
            appended + "\n</AppendedData>\n</VTKFile>\n");
    times_.push_back(m.time());
    std::string pvd = "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"1.0\">\n<Collection>\n";
    for (size_t i = 0; i < times_.size(); ++i) {
      pvd += fmt::format("<DataSet timestep=\"{:.9g}\" file=\"blocks_{:04}.vtp\"/>\n", times_[i], i);
    }
    write_file(folder_ / "blocks.pvd", pvd + "</Collection>\n</VTKFile>\n");
  }

 private:
  fs::path folder_;
  std::vector<double> times_;
};

// Front view of the blocks where they stand now, coloured by displacement.
std::string draw_mechanism(const fs::path& folder, const Run& run) {
  const Model& m = run.model();
  if (m.block_count() > 3000) return "mechanism.png: left out for more than 3000 blocks; use blocks.pvd";
  const double largest = std::max(1e-12, run.largest_displacement());
  std::string script = fmt::format(
      "set terminal pngcairo size 1000,900\nset size ratio -1\nunset key\n"
      "set title {} noenhanced\nset xlabel 'x, m'\nset ylabel 'y, m'\nset cblabel 'displacement, mm'\nset cbrange "
      "[0:{:.6g}]\n"
      "set palette defined (0 '#e9e2d0', 1 '#c0392b')\n",
      gnuplot_text(run.scene().title.empty() ? run.scene().file : run.scene().title), largest * 1e3);
  geometry::Box view;
  for (int i = 0; i < m.block_count(); ++i) {
    if (m.assembly().blocks[i].fixed) continue;
    for (size_t v = 0; v < m.block(i).shape->vertices.size(); ++v) view.include(m.corner(i, int(v)));
  }
  std::string data;
  for (int i = 0; i < m.block_count(); ++i) {
    const auto& shape = *m.block(i).shape;
    const double d = norm(m.position(i) - run.start_position(i)) * 1e3;
    for (const auto& face : shape.faces) {
      const Vector a = m.corner(i, face[0]), b = m.corner(i, face[1]), c = m.corner(i, face[2]);
      if (normalized(cross(b - a, c - a)).z < 0.5) continue;
      for (int v : face) {
        const Vector p = m.corner(i, v);
        data += fmt::format("{:.6g} {:.6g} {:.6g}\n", p.x, p.y, d);
      }
      data += fmt::format("{:.6g} {:.6g} {:.6g}\n\n", a.x, a.y, d);
    }
  }
  const double margin = 0.1 * std::max(view.upper.x - view.lower.x, view.upper.y - view.lower.y);
  script += fmt::format("$blocks << EOD\n{}EOD\nset xrange [{:.6g}:{:.6g}]\nset yrange [{:.6g}:{:.6g}]\n", data,
                        view.lower.x - margin, view.upper.x + margin, view.lower.y - margin, view.upper.y + margin);
  script +=
      "plot $blocks using 1:2:3 with filledcurves closed fillcolor palette, $blocks using 1:2 with lines linewidth 1.5 "
      "linecolor '#333333'\n";
  return draw_picture(folder, "mechanism", script);
}

}  // namespace

namespace {

std::unique_ptr<Run> make_run(const std::string& file, const std::string& law,
                              const std::vector<std::string>& overrides) {
  BlockScene scene = read_block_scene(file, overrides);
  if (!law.empty()) {
    for (auto& [name, family] : scene.joints) family.law = law;
  }
  return std::make_unique<Run>(std::move(scene));
}

size_t point_count(const Model& m) {
  size_t points = 0;
  for (const auto& f : m.families()) points += f.size();
  return points;
}

std::string sizes(const std::string& file, const Model& m) {
  return fmt::format("{}: {} blocks, {} zones, {} contact points; time step {:.3g} s (2/omega_max {:.3g} s)\n", file,
                     m.block_count(), m.zones().size(), point_count(m), m.time_step(), m.critical_time_step());
}

}  // namespace

void check_blocks(const std::string& file, const std::string& law, const std::vector<std::string>& overrides) {
  const std::unique_ptr<Run> run = make_run(file, law, overrides);
  fmt::print("{}", sizes(file, run->model()));
  for (const auto& stage : run->scene().stages) fmt::print("  stage {}\n", stage.name);
}

void run_blocks(const std::string& file, const std::string& law, const std::vector<std::string>& overrides,
                const fs::path& folder, int& exit_code) {
  const auto started = std::chrono::steady_clock::now();
  const std::unique_ptr<Run> made = make_run(file, law, overrides);
  Run& run = *made;
  const ResultFolder own(folder);
  const Model& m = run.model();
  fmt::print(stderr, "{}", sizes(file, m));
  std::string history =
      "stage,step,time_s,multiplier,monitor_dx_m,monitor_dy_m,monitor_dz_m,monitor_fx_N,monitor_fy_N,monitor_fz_N,"
      "largest_displacement_m,unbalanced_ratio,kinetic_J,strain_J,contact_stored_J,dissipated_tension_J,dissipated_"
      "cohesion_J,"
      "dissipated_friction_J,dissipated_crushing_J,damping_J,external_J,detection_J\n";
  Frames frames(folder);
  int stage = -1;
  const auto on_row = [&](const blocks::Row& r) {
    if (r.stage != stage) {
      stage = r.stage;
      fmt::print(stderr, "stage {}/{} {}\n", stage + 1, run.scene().stages.size(),
                 run.scene().stages[size_t(stage)].name);
    }
    const auto& e = r.energies;
    history += fmt::format("{},{},{:.9g},{:.9g}", r.stage + 1, r.step, r.time, r.multiplier);
    for (double x : {r.displacement.x, r.displacement.y, r.displacement.z, r.force.x, r.force.y, r.force.z,
                     r.largest_displacement, r.unbalanced_ratio, e.kinetic, e.strain, e.contact_stored, e.dissipated[0],
                     e.dissipated[1], e.dissipated[2], e.dissipated[3], e.damping, e.external, e.detection}) {
      history += fmt::format(",{:.9g}", x);
    }
    history += '\n';
  };
  blocks::Outcome outcome;
  std::string status = "done", message;
  running = &run;
  std::signal(SIGINT, stop_blocks);
  std::signal(SIGTERM, stop_blocks);
  try {
    outcome = run.run(on_row, [&](int) { frames.add(run); });
  } catch (const Error& error) {
    if (error.exit_code != Exit::interrupted && error.exit_code != Exit::numerical) throw;
    status = error.exit_code == Exit::interrupted ? "interrupted" : "failed";
    message = error.what();
    exit_code = int(error.exit_code);
  }
  std::signal(SIGINT, SIG_DFL);
  std::signal(SIGTERM, SIG_DFL);
  running = nullptr;

  write_file(folder / "history.csv", history);
  if (run.scene().picture) {
    const std::string notice = draw_mechanism(folder, run);
    if (!notice.empty()) fmt::print(stderr, "quoin: {}\n", notice);
  }
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - started).count();
  nlohmann::ordered_json json;
  json["version"] = QUOIN_VERSION;
  json["scene"] = file;
  json["title"] = run.scene().title;
  json["status"] = status;
  if (!message.empty()) json["message"] = message;
  json["collapse_multiplier"] =
      outcome.collapse_multiplier ? nlohmann::ordered_json(*outcome.collapse_multiplier) : nullptr;
  json["base_slip_at_uplift_m"] =
      outcome.base_slip_at_uplift ? nlohmann::ordered_json(*outcome.base_slip_at_uplift) : nullptr;
  json["largest_displacement_m"] = run.largest_displacement();
  json["blocks"] = m.block_count();
  json["zones"] = m.zones().size();
  json["contact_points"] = point_count(m);
  json["steps"] = m.steps();
  json["simulated_time_s"] = m.time();
  json["time_step_s"] = m.time_step();
  json["critical_time_step_s"] = m.critical_time_step();
  json["small_displacement"] = m.small_displacement();
  json["contact_detections"] = m.detections();
  json["wall_clock_s"] = seconds;
  json["set"] = overrides;
  if (run.scene().energy) {
    const auto e = m.energies();
    json["energy_J"] = {{"kinetic", e.kinetic},
                        {"strain", e.strain},
                        {"contact_stored", e.contact_stored},
                        {"dissipated", e.dissipated_total()},
                        {"damping", e.damping},
                        {"external", e.external},
                        {"detection", e.detection},
                        {"balance_error", e.balance_error(0)}};
  }
  write_file(folder / "summary.json", json.dump(2) + "\n");
  if (outcome.collapse_multiplier) fmt::print("collapse multiplier {:.4f}\n", *outcome.collapse_multiplier);
  fmt::print("{} steps in {:.1f} s; results in {}\n", m.steps(), seconds, folder.string());
  if (!message.empty()) fmt::print(stderr, "quoin: {}\n", message);
}

}  // namespace quoin
