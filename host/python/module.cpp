// Compiled part of the package `quoin`, on which the Python files are based. It is not for users.
#include <fmt/format.h>
#include <pybind11/functional.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <array>
#include <atomic>
#include <cmath>
#include <map>
#include <memory>
#include <optional>
#include <variant>

#ifdef QUOIN_LIMIT
#include <nlohmann/json.hpp>

#include "analysis/limit_of_scene.h"
#endif
#ifdef QUOIN_MODES
#include <nlohmann/json.hpp>

#include "analysis/modes.h"
#include "analysis/state_modes.h"
#endif
#include "base/error.h"
#include "base/input_file.h"
#include "cli/prepare.h"
#include "geometry/mesh_file.h"
#include "law/law_library.h"
#include "python/document.h"
#include "python/session.h"
#ifdef QUOIN_VORO
#include "python/stones.h"
#include "python/voronoi.h"
#endif
#include "records/response_spectrum.h"
#include "results/colours.h"
#include "results/provenance.h"
#include "results/report.h"
#include "scene/collapse_load.h"
#include "scene/read_scene.h"
#include "scene/read_tests.h"
#include "scene/reader.h"
#include "scene/stage_named.h"
#include "step/large_motion.h"
#include "step/steer.h"

namespace {

namespace py = pybind11;
using quoin::BlockArray;
using quoin::PointArray;
using quoin::python::Session;

using Hashes = std::map<std::string, std::string>;  // SHA-256 by file

// Hashes of the files that the scene reads.
Hashes hashes_of(const quoin::Scene& scene) {
  Hashes hashes;
  for (const std::string& file : scene.inputs) hashes[file] = quoin::sha256_of_file(file);
  return hashes;
}

// Prepares a scene as `quoin run` does: from a document, or from the text of the file `path`, so that messages have its
// lines. files: hashes_of the scene when it was loaded.
quoin::Scene scene_of(const std::variant<py::dict, std::string>& source, const std::string& path, const Hashes& files,
                      bool runs = false) {
  quoin::SceneOptions options;
  options.scene = path;
  options.runs = runs;
  quoin::Scene scene;
  if (const auto* text = std::get_if<std::string>(&source)) {
    scene = quoin::read_with_laws(options, [&] { return quoin::read_scene_text(*text, path); });
  } else {
    const toml::table table = quoin::python::table_of(std::get<py::dict>(source));
    scene = quoin::read_with_laws(options, [&] { return quoin::reader::read_scene(table, path); });
    scene.text = quoin::python::text_of(table);
  }
  for (const auto& [file, hash] : hashes_of(scene)) {
    const auto loaded = files.find(file);
    if (loaded != files.end() && loaded->second != hash)
      throw quoin::Error(quoin::Exit::bad_input,
                         fmt::format("{}: has changed since the scene that names it was loaded, {}: load that again "
                                     "(quoin.Scene.load), or bring the file of then back",
                                     file, path));
  }
  return quoin::prepare_scene(std::move(scene), options);
}

py::dict dict_of(const quoin::LawSwap& swap) {
  py::dict d;
  d["joint"] = swap.family, d["from"] = swap.from, d["to"] = swap.to, d["points"] = swap.points;
  d["limited"] = swap.limited, d["stored_before_J"] = swap.stored_before, d["energy_jump_J"] = swap.energy_jump;
  return d;
}

// Blocks of a mesh file: name, corners (rows of x, y, z, m), faces, and whether it is fixed.
py::list mesh_of(const std::string& path, double scale, const std::function<bool(const std::string&)>& fixed) {
  py::list blocks;
  for (const quoin::geometry::NamedShape& s : quoin::geometry::read_mesh_file(path, scale, fixed)) {
    std::vector<quoin::Vec3> corners;
    for (const quoin::geometry::Vector& p : s.shape.vertices) corners.push_back(array(p));
    blocks.append(py::make_tuple(s.name, corners, s.shape.faces, s.support));
  }
  return blocks;
}

// Properties from tests. tests: keys of a table [tests].
py::dict properties_of(const py::dict& tests) {
  const toml::table table = quoin::python::table_of(tests);
  quoin::reader::Context context;
  context.file = "quoin.properties_of";
  const quoin::TestedMasonry tested = quoin::read_tests({context, table, "tests"}, 0.0, 0.0);
  context.throw_faults();
  const quoin::MasonryNumbers numbers = quoin::properties_of(tested);
  py::dict result, unit;
  unit["young_modulus"] = numbers.young_modulus, unit["poisson_ratio"] = numbers.poisson_ratio;
  unit["density"] = numbers.density;
  result["unit"] = unit;
  for (const char* part : {"bed", "head", "inside"}) {
    py::dict joint;
    joint["law"] = "fracture_energy";
    for (const auto& [id, value] : quoin::joint_properties(numbers, part, "fracture_energy")) joint[id] = value;
    result[part] = joint;
  }
  py::list derivation;
  for (const quoin::Derivation& d : numbers.derivation) {
    py::dict line;
    line["name"] = d.name, line["value"] = d.value, line["unit"] = d.unit, line["from"] = d.from;
    line["spread"] = d.spread;
    derivation.append(line);
  }
  result["derivation"] = derivation;
  return result;
}

// Periods, and w^2 Sd, w Sd and Sd at each.
std::array<std::vector<double>, 4> spectrum_of(const std::vector<double>& time, const std::vector<double>& acceleration,
                                               double damping, const std::optional<std::vector<double>>& periods) {
  const py::gil_scoped_release others_go_on;
  std::array<std::vector<double>, 4> columns;
  for (const quoin::SpectralOrdinates& o :
       quoin::response_spectrum({time, acceleration}, damping, periods ? *periods : quoin::default_periods())) {
    columns[0].push_back(o.period), columns[1].push_back(o.pseudo_acceleration);
    columns[2].push_back(o.pseudo_velocity), columns[3].push_back(o.displacement);
  }
  return columns;
}

#ifdef QUOIN_LIMIT
// Text of limit.json; velocity and spin of each block; blocks, place, and force along n, s, t of each point.
py::tuple limit(const std::variant<py::dict, std::string>& source, const std::string& path, const Hashes& files,
                const std::vector<double>& direction, double given, int facets, bool associated, bool moving,
                const std::string& multiply, const std::string& stage, double seconds) {
  quoin::LimitOptions options{direction, given, {}, associated};
  options.settings.facets = facets, options.moving = moving, options.seconds = seconds;
  options.multiplied = quoin::multiplied_named(multiply);
  const quoin::Scene scene = quoin::for_limit(scene_of(source, path, files), options.multiplied);
  if (!stage.empty()) options.stage = &scene.stages[static_cast<std::size_t>(quoin::stage_named(scene, stage))];
  // Ctrl-C ends the analysis. Only the main thread sees it, so the flag ends the others.
  const auto stopped = std::make_shared<std::atomic<bool>>(false);
  options.settings.progress = [stopped, notices = quoin::notices_of_progress(scene.file)](const std::string& step) {
    if (*stopped) throw quoin::Error(quoin::Exit::interrupted, "interrupted");
    notices(step);
    const py::gil_scoped_acquire lock;
    if (PyErr_CheckSignals() == 0) return;
    *stopped = true;
    throw py::error_already_set();
  };
  quoin::SceneLimit found;
  std::string text;
  {
    const py::gil_scoped_release others_go_on;
    const quoin::Simulation simulation(scene, 1);
    found = quoin::limit_of(simulation, options);
    text = quoin::json_of(scene.file, found, options).dump();
  }
  std::vector<std::array<double, 6>> velocity;
  std::vector<std::array<int, 2>> blocks;
  std::vector<std::array<double, 3>> place, force;
  if (found.limit) {
    for (const auto& [v, w] : found.limit->velocity) velocity.push_back({v.x, v.y, v.z, w.x, w.y, w.z});
    force = found.limit->force;
    velocity.resize(found.block_count), force.resize(found.point_count);  // nodes of floors and beams come after these
  }
  for (std::size_t i = 0; i < found.point_count; ++i) {
    const quoin::LimitPoint& p = found.problem.points[i];
    blocks.push_back({p.a, p.b});
    place.push_back(quoin::geometry::array(p.position));
  }
  return py::make_tuple(text, velocity, blocks, place, force);
}
#endif

}  // namespace

PYBIND11_MODULE(_quoin, m) {
  m.attr("version") = QUOIN_VERSION;
  py::register_exception_translator([](std::exception_ptr thrown) {
    try {
      if (thrown) std::rethrow_exception(thrown);
    } catch (const quoin::Error& error) {
      const py::object raised =
          py::module_::import("quoin.errors").attr("from_exit_code")(static_cast<int>(error.exit_code), error.what());
      PyErr_SetObject(py::type::of(raised).ptr(), raised.ptr());
    }
  });
  m.def("add_law_folder", &quoin::add_law_folder);
  m.def("law_path", [](const std::string& name) { return quoin::LawLibrary::load(name)->path(); });
  m.def("installed_laws", &quoin::installed_laws);
  m.def("parse", [](const std::string& path) {
    const std::string text = quoin::read_input_file(path);
    return std::pair(quoin::python::document_of(quoin::reader::parse(text, path)), text);
  });
  m.def("text", [](const py::dict& document) { return quoin::python::text_of(quoin::python::table_of(document)); });
  m.def("check", [](const std::variant<py::dict, std::string>& source, const std::string& path, const Hashes& files) {
    return hashes_of(scene_of(source, path, files));
  });

#ifdef QUOIN_LIMIT
  m.def("limit", &limit);
#endif
#ifdef QUOIN_MODES
  m.def("modes", [](const std::variant<py::dict, std::string>& source, const std::string& path, const Hashes& files,
                    int count, const std::string& stage, const std::string& state, const std::array<double, 2>& ratios,
                    const std::array<double, 2>& at) {
    const bool undamaged = state == "undamaged";
    const quoin::Scene scene = scene_of(source, path, files, !undamaged);
    const py::gil_scoped_release others_go_on;
    const quoin::Vibrating v = undamaged ? quoin::vibrating(scene, quoin::stage_named(scene, stage))
                                         : quoin::vibrating_about(scene, state, stage);
    const quoin::Modes modes = quoin::find_modes(v, {count, ratios, at});
    return std::pair(quoin::json_of(scene.file, v, modes).dump(), quoin::shapes_of(v, modes));
  });
#endif
  m.def("properties_of", &properties_of);
  m.def("response_spectrum", &spectrum_of);
  m.def("read_mesh", &mesh_of);
  m.def("colours", [] {
    py::list cracks;
    for (const quoin::CrackStyle& style : quoin::kCrackStyles) cracks.append(py::make_tuple(style.label, style.colour));
    py::dict d;
    d["cracks"] = cracks;
    d["cold"] = quoin::kQuantityColours.cold, d["middle"] = quoin::kQuantityColours.middle;
    d["warm"] = quoin::kQuantityColours.warm;
    d["face"] = quoin::kBlockColours.face, d["edge"] = quoin::kBlockColours.edge;
    d["pens"] = std::vector<std::string>(quoin::kPens.begin(), quoin::kPens.end());
    return d;
  });
  m.def("report", [](const std::string& folder) { return quoin::write_report({folder}).string(); });
#ifdef QUOIN_VORO
  m.def("voronoi", &quoin::python::voronoi);
  m.def("stones", [](const std::vector<quoin::Vec3>& seeds, const quoin::Vec3& size, double shortest) {
    std::vector<quoin::geometry::Vector> places;
    for (const quoin::Vec3& p : seeds) places.push_back(quoin::geometry::vector(p));
    const auto made = quoin::python::stones(std::move(places), quoin::geometry::vector(size), shortest);
    std::vector<std::vector<quoin::Vec3>> corners(made.corners.size());
    for (std::size_t i = 0; i < corners.size(); ++i) {
      for (const quoin::geometry::Vector& p : made.corners[i]) corners[i].push_back(array(p));
    }
    return py::make_tuple(corners, made.shortest_edge);
  });
#endif

  py::class_<Session>(m, "Session")
      .def(py::init([](const std::variant<py::dict, std::string>& source, const std::string& path, const Hashes& files,
                       int threads, bool keep_frames, const std::string& folder, bool isolate_law, double law_seconds) {
        return std::make_unique<Session>(scene_of(source, path, files, true), threads, keep_frames, folder, isolate_law,
                                         law_seconds);
      }))
      .def("step", &Session::step)
      .def("set_progress", &Session::set_progress)
      .def("history", &Session::history)
      .def("measure", &Session::measure)
      .def("finish",
           [](Session& s, const std::string& status, const std::string& message) {
             std::string summary = s.finish(status, message);
             s.tell_warnings();
             return summary;
           })
      .def("close", &Session::close)
      .def("frames", &Session::frames)
      .def("mesh", &Session::mesh)
      .def("contacts", [](const Session& s, const std::string& joint) { return s.contacts(s.family_named(joint)); })
      .def("damage", [](const Session& s, const std::string& joint) { return s.damage(s.family_named(joint)); })
      .def("displacement",
           [](Session& s, const py::object& block) {
             return s.block_array(BlockArray::displacement, s.block_named(block));
           })
      .def(
          "velocity",
          [](Session& s, const py::object& block) { return s.block_array(BlockArray::velocity, s.block_named(block)); })
      .def("sigma",
           [](Session& s, const std::string& joint) { return s.point_array(PointArray::sigma, s.family_named(joint)); })
      .def("tau_s",
           [](Session& s, const std::string& joint) { return s.point_array(PointArray::tau_s, s.family_named(joint)); })
      .def("tau_t",
           [](Session& s, const std::string& joint) { return s.point_array(PointArray::tau_t, s.family_named(joint)); })
      .def("area",
           [](Session& s, const std::string& joint) { return s.point_array(PointArray::area, s.family_named(joint)); })
      .def("position",
           [](Session& s, const std::string& joint) {
             return s.point_array(PointArray::position, s.family_named(joint));
           })
      .def("state", [](Session& s, const std::string& joint,
                       const std::string& id) { return s.state(s.family_named(joint), id); })
      .def("velocities_changed", &Session::velocities_changed)
      .def("set_velocity",
           [](Session& s, const std::string& body, const quoin::Vec3& value) { set_velocity(s.use(), body, value); })
      .def("set_force",
           [](Session& s, const std::string& body, const quoin::Vec3& value) { set_force(s.use(), body, value); })
      .def("swap_law",
           [](Session& s, const std::string& joint, const std::string& law) { return dict_of(s.swap_law(joint, law)); })
      .def("save", &Session::save)
      .def("restore", &Session::restore)
      .def("checkpoint", &Session::checkpoint)
      .def("resume", &Session::resume)
      .def_property_readonly("steps", [](const Session& s) { return s.use().step(); })
      .def_property_readonly("time", [](const Session& s) { return s.use().time(); })
      .def("require_report",
           [](const Session& s) {
             if (!s.use().scene().has_frames())
               throw quoin::Error(quoin::Exit::bad_input,
                                  "report: the page shows frames, and with output.frames = 0 there are none; set "
                                  "scene.output.frames, for instance to 20");
             quoin::require_report_library();
           })
      .def_property_readonly("time_step", [](const Session& s) { return s.use().time_step_report().time_step; })
      .def_property_readonly("stage", [](const Session& s) { return s.use().stage(); })
      .def_property_readonly("stages_ended", [](const Session& s) { return s.use().stages_ended(); })
      .def_property_readonly("stage_names",
                             [](const Session& s) {
                               std::vector<std::string> names;
                               for (const quoin::Stage& stage : s.use().scene().stages) names.push_back(stage.name);
                               return names;
                             })
      .def_property_readonly("blocks", [](const Session& s) { return s.use().block_count(); })
      .def_property_readonly("zones", [](const Session& s) { return s.use().zone_count(); })
      .def_property_readonly("points", [](const Session& s) { return s.use().point_count(); })
      .def_property_readonly("joints",
                             [](const Session& s) {
                               std::vector<std::string> names;
                               for (const quoin::ContactFamily& f : s.use().model().families) names.push_back(f.name);
                               return names;
                             })
      .def_property_readonly("threads", [](const Session& s) { return s.use().thread_count(); })
      .def_property_readonly("large_motion", [](const Session& s) { return s.use().large_motion() != nullptr; })
      .def_property_readonly(
          "collapse_lag",
          [](const Session& s) { return quoin::collapse_lag(s.use().scene(), s.use().outcome().collapse_multiplier); })
      .def_property_readonly("collapse_multiplier",
                             [](const Session& s) { return s.use().outcome().collapse_multiplier; })
      .def_property_readonly("hash", [](const Session& s) { return s.use().hash(); });
}
