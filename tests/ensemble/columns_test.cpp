// Random properties: their values in the model, and results of runs.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <numeric>
#include <set>

#include "base/error.h"
#include "ensemble/run_sample.h"
#include "model/motion.h"
#include "scene/generate.h"
#include "scene/read_scene.h"
#include "step/findings.h"
#include "step/large_motion.h"
#include "step/simulation.h"

namespace quoin {
namespace {

const std::string kSmall = QUOIN_CLI_TESTS "/small_wall.toml";

struct Rows : Observer {
  std::vector<HistoryRow> rows;
  bool promoted = false;
  void on_row(const HistoryRow& row) override { rows.push_back(row); }
  void on_promotion(const Simulation&) override { promoted = true; }
};

using Settings = std::vector<std::string>;
Settings operator+(Settings a, const Settings& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

const Settings kQuick{"stage.shear.velocity=0.2", "stage.shear.displacement=0.0004", "output.frames=0"};
const Settings kConstant{"joints.mortar.tensile_strength={distribution=\"normal\",mean=0.2e6,sd=0}",
                         "joints.mortar.cohesion={distribution=\"lognormal\",mean=0.3e6,sd=0}",
                         "joints.mortar.friction_angle={distribution=\"normal\",mean=35,cov=0,level=\"unit\"}",
                         "joints.mortar.normal_stiffness={distribution=\"weibull\",mean=82e9,cov=0,level=\"wall\"}"};
const Settings kScattered{"joints.mortar.tensile_strength={distribution=\"lognormal\",mean=0.2e6,cov=0.3}",
                          "joints.mortar.cohesion={distribution=\"lognormal\",mean=0.3e6,cov=0.3}",
                          "joints.mortar.correlation=[[\"tensile_strength\",\"cohesion\",0.8]]"};

std::vector<HistoryRow> run(const Settings& settings, bool* promoted = nullptr) {
  Simulation simulation(read_scene(kSmall, settings));
  Rows rows;
  simulation.run(rows);
  if (promoted) *promoted = rows.promoted;
  return rows.rows;
}

double peak_of(const std::vector<HistoryRow>& rows) {
  double peak = 0.0;
  for (const HistoryRow& row : rows) peak = std::max(peak, row.resistance);
  return peak;
}

// Columns of a constant value are equal to the material with that value, to rounding (C6.9). On the lattice, in the
// general kernels, and through a promotion in mid-run.
TEST(Columns, OfOneValueComputeWhatTheMaterialDoes) {
  const std::vector<std::pair<const char*, Settings>> ways{
      {"lattice", {"solver.large_motion=never", "solver.past_motion_bound=warn"}},
      {"general", {"solver.kernels=general"}},
      {"promoted", {"solver.rotation_bound=1e-5"}}};
  for (const auto& [name, way] : ways) {
    bool promoted = false;
    const auto plain = run(kQuick + way, &promoted), columns = run(kQuick + way + kConstant);
    EXPECT_EQ(promoted, std::string(name) == "promoted");
    ASSERT_EQ(plain.size(), columns.size()) << name;
    const double peak = peak_of(plain);
    ASSERT_GT(peak, 1e3) << name;
    for (std::size_t i = 0; i < plain.size(); ++i)
      ASSERT_NEAR(columns[i].resistance, plain[i].resistance, 1e-6 * peak)
          << name << " " << i;  // 1e-9 in a step, amplified by cracking
  }
}

// Sample 0 is the wall with mean values. Other samples differ; an equal sample is bitwise identical.
TEST(Columns, SamplesAreWallsOfTheirOwn) {
  const auto sample = [](int i) { return Settings{fmt::format("random.sample={}", i)}; };
  const double plain = peak_of(run(kQuick)), means = peak_of(run(kQuick + kScattered + sample(0)));
  EXPECT_EQ(means, plain);
  const double first = peak_of(run(kQuick + kScattered + sample(1)));
  EXPECT_NE(first, plain);
  EXPECT_NE(first, peak_of(run(kQuick + kScattered + sample(2))));
  EXPECT_EQ(first, peak_of(run(kQuick + kScattered + sample(1))));
  EXPECT_EQ(first, peak_of(run(kQuick + kScattered)));  // 1 is the default
}

// Random values are preserved through a promotion and a checkpoint after it.
TEST(Columns, GoAlongIntoLargeMotionAndCheckpoints) {
  const Settings settings = kQuick + kScattered + Settings{"solver.rotation_bound=1e-5"};
  Simulation simulation(read_scene(kSmall, settings));
  const auto on_lattice = simulation.model().families[0].columns;
  Rows rows;
  simulation.run(rows);
  ASSERT_TRUE(rows.promoted);
  const auto& large_motion = simulation.large_motion()->contacts.families[0].columns;
  ASSERT_EQ(large_motion.size(), 2u);
  std::multiset<double> before(on_lattice[0].values.begin(), on_lattice[0].values.end()),
      after(large_motion[0].values.begin(), large_motion[0].values.end());
  EXPECT_EQ(before, after);
  Simulation other(read_scene(kSmall, settings));
  other.restore(simulation.save());
  EXPECT_EQ(other.hash(), simulation.hash());
  EXPECT_EQ(other.large_motion()->contacts.families[0].columns[1].values, large_motion[1].values);
}

struct Drawn {
  std::vector<PlacedPoint> point;
  std::vector<double> value;  // tensile_strength, Pa
  std::vector<int> unit_a, unit_b, course_a, course_b;
};
Drawn drawn(const Settings& settings) {
  const Scene scene = read_scene(kSmall, settings);
  const Assembly assembly = assemble(scene);
  const Model model(assembly, make_materials(assembly));
  Drawn d;
  const ContactFamily& family = model.families[0];
  for (int i = 0; i < family.point_count; ++i) {
    const auto p = static_cast<std::size_t>(family.first_point + i);
    const Joint& joint = model.assembly.joints[static_cast<std::size_t>(model.point_joint[p])];
    const Brick &a = model.assembly.bricks[static_cast<std::size_t>(joint.block_a)],
                &b = model.assembly.bricks[static_cast<std::size_t>(joint.block_b)];
    d.point.push_back({model.point_position[p], model.area[p], joint.block_a, joint.block_b});
    d.unit_a.push_back(a.unit), d.unit_b.push_back(b.unit), d.course_a.push_back(a.course),
        d.course_b.push_back(b.course);
    d.value.push_back(family.columns.at(0).values[static_cast<std::size_t>(i)]);
  }
  return d;
}
Settings strength(const std::string& rest, int sample = 1) {
  return {"wall.courses=8", "wall.units_per_course=6", fmt::format("random.sample={}", sample),
          "joints.mortar.fracture_energy_tension=150", "joints.mortar.tensile_strength={mean=0.2e6," + rest + "}"};
}

TEST(Columns, LevelsHaveOneValueEach) {
  const auto values_by = [](const Drawn& d, const auto& key) {
    std::map<decltype(key(d, std::size_t{0})), std::set<double>> values;
    for (std::size_t i = 0; i < d.value.size(); ++i) values[key(d, i)].insert(d.value[i]);
    std::set<std::size_t> sizes;
    std::set<double> all;
    for (const auto& [k, v] : values) sizes.insert(v.size()), all.insert(v.begin(), v.end());
    return std::tuple(sizes, values.size(), all.size());
  };
  const auto joint = [](const Drawn& d, std::size_t i) { return std::minmax(d.point[i].block_a, d.point[i].block_b); };
  const auto laid = [](const Drawn& d, std::size_t i) {
    return d.unit_b[i] < 0 ? d.unit_a[i] : d.unit_a[i] < 0 ? d.unit_b[i] : std::max(d.unit_a[i], d.unit_b[i]);
  };
  const std::set<std::size_t> one{1};
  const std::string normal = "distribution=\"normal\",cov=0.1,level=";
  const auto [j, joints, of_joints] = values_by(drawn(strength(normal + "\"joint\"")), joint);
  EXPECT_EQ(j, one);
  EXPECT_EQ(joints, of_joints);
  const auto [u, units, of_units] = values_by(drawn(strength(normal + "\"unit\"")), laid);
  EXPECT_EQ(u, one);
  EXPECT_EQ(units, of_units);
  const Drawn courses = drawn(strength(normal + "\"course\""));
  EXPECT_EQ(std::set<double>(courses.value.begin(), courses.value.end()).size(), 8u);
  const Drawn wall = drawn(strength(normal + "\"wall\""));
  EXPECT_EQ(std::set<double>(wall.value.begin(), wall.value.end()).size(), 1u);
  const Drawn points = drawn(strength(normal + "\"point\""));
  EXPECT_EQ(std::set<double>(points.value.begin(), points.value.end()).size(), points.value.size());
}

// The lattice and the general kernels have equal random values at equal positions.
void same_in_all_kernels(int courses) {
  const Settings settings = strength("distribution=\"lognormal\",cov=0.2,level=\"point\",correlation_length=0.2") +
                            Settings{fmt::format("wall.courses={}", courses)};
  const Drawn lattice = drawn(settings);
  const Simulation general(read_scene(kSmall, settings + Settings{"solver.kernels=general"}));
  const blocks::Family& family = general.large_motion()->contacts.families[0];
  ASSERT_EQ(family.size(), lattice.point.size());
  std::map<std::pair<int, int>, std::vector<std::size_t>> of_pair;
  for (std::size_t i = 0; i < lattice.point.size(); ++i)
    of_pair[std::minmax(lattice.point[i].block_a, lattice.point[i].block_b)].push_back(i);
  std::size_t found = 0;
  for (std::size_t k = 0; k < family.size(); ++k) {
    const blocks::Point& p = family.point[k];
    for (const std::size_t i : of_pair[std::minmax<int>(p.a, p.b)]) {
      const Vec3& x = lattice.point[i].position;
      if (std::abs(x[0] - p.at.x) + std::abs(x[1] - p.at.y) + std::abs(x[2] - p.at.z) > 1e-9) continue;
      ++found;
      EXPECT_NEAR(family.columns[0].values[k], lattice.value[i],
                  1e-6 * lattice.value[i]);  // rounding along chains of correlated positions
    }
  }
  EXPECT_EQ(found, family.size());
}
TEST(Columns, DoNotDependOnTheKernels) {
  for (const int courses : {1, 8}) same_in_all_kernels(courses);
}

// The rows below and above a wall are fields of their own, also if it has one course alone: their correlation is 0.
TEST(Columns, JointsOfTheBeamsAreRowsOfTheirOwn) {
  constexpr int kWalls = 100;
  constexpr double kMean = 0.2e6, kScatter = 0.02e6;
  for (const int courses : {1, 2}) {
    double product = 0.0;
    for (int wall = 1; wall <= kWalls; ++wall) {
      const Drawn d = drawn(strength("distribution=\"normal\",cov=0.1,level=\"joint\",correlation_length=0.3", wall) +
                            Settings{fmt::format("wall.courses={}", courses)});
      std::map<double, double> of_row;  // by height: value of the leftmost joint
      std::map<double, double> leftmost;
      for (std::size_t i = 0; i < d.value.size(); ++i) {
        if (d.unit_a[i] >= 0 && d.unit_b[i] >= 0) continue;
        const double x = d.point[i].position[0], y = d.point[i].position[1];
        if (const auto [at, is_new] = leftmost.try_emplace(y, x); is_new || x < at->second)
          at->second = x, of_row[y] = d.value[i];
      }
      ASSERT_EQ(of_row.size(), 2u);
      product += (of_row.begin()->second - kMean) * (of_row.rbegin()->second - kMean);
    }
    EXPECT_NEAR(product / kWalls / (kScatter * kScatter), 0.0, 5.0 / std::sqrt(kWalls)) << courses;  // standard errors
  }
}

// Over many walls mean and standard deviation of a joint's average are those given (scatter_of = "joint"). The
// correlation of neighbours in a course is exp(-distance/length).
TEST(Columns, JointAveragesScatterAsGivenAndNeighboursGoTogether) {
  constexpr double kLength = 0.3;
  constexpr int kWalls = 60;
  double n = 0, sum = 0, squares = 0, products = 0, pairs = 0, expected = 0;
  for (int wall = 1; wall <= kWalls; ++wall) {
    const Drawn d = drawn(strength(
        "distribution=\"lognormal\",cov=0.3,level=\"point\",scatter_of=\"joint\",correlation_length=0.3", wall));
    std::map<std::pair<int, int>, std::array<double, 4>> joints;  // area, value, x, y
    for (std::size_t i = 0; i < d.value.size(); ++i) {
      if (d.course_a[i] == d.course_b[i]) continue;  // head joints
      auto& j = joints[std::minmax(d.point[i].block_a, d.point[i].block_b)];
      const double a = d.point[i].area;
      j[0] += a, j[1] += a * d.value[i], j[2] += a * d.point[i].position[0], j[3] += a * d.point[i].position[1];
    }
    std::map<long, std::map<double, double>> rows;
    for (const auto& [key, j] : joints) {
      const double mean = j[1] / j[0];
      n += 1, sum += mean, squares += (mean - 0.2e6) * (mean - 0.2e6);
      rows[std::lround(j[3] / j[0] * 1e4)][j[2] / j[0]] = mean - 0.2e6;
    }
    for (const auto& [y, row] : rows) {
      for (auto next = std::next(row.begin()), last = row.begin(); next != row.end(); ++next, ++last) {
        products += next->second * last->second, pairs += 1;
        expected += std::exp(-(next->first - last->first) / kLength);
      }
    }
  }
  // Rows of a wall have about 1.3 m of a field with correlation length 0.3 m: walls x rows x 3 = 1600 independent
  // values. Tolerance of five standard errors.
  const double independent = kWalls * 9 * 3.0;
  EXPECT_NEAR(sum / n, 0.2e6, 5 * 0.06e6 / std::sqrt(independent));
  EXPECT_NEAR(std::sqrt(squares / n), 0.06e6, 5 * 0.06e6 * std::sqrt(1.2 / independent));
  // Correlations of lognormal averages differ by up to 0.03 from those of points at their centres.
  EXPECT_NEAR(products / pairs / (squares / n), expected / pairs, 0.03 + 5 / std::sqrt(independent));
}

// Along a row of positions z(k) = r z(k-1) + sqrt(1 - r^2) f(k) with r = exp(-d/length). Here f are the values of this
// sample without correlation, and d is the distance of the positions, which are rounded to 10 um.
TEST(Columns, NeighboursFollowEachOtherByTheirDistance) {
  const Assembly assembly = assemble(read_scene(kSmall));
  constexpr double kLength = 0.1, kMean = 0.2e6, kScatter = 0.02e6;
  const std::vector<PlacedBlock> blocks{{0, 0}, {1, 1}};
  std::vector<PlacedPoint> points;
  for (const double x : {0.0, 0.04, 0.06, 0.17, 0.2, 0.31}) points.push_back({{x, 0.1, 0.05}, 1e-3, 0, 1});
  const auto z = [&](const std::string& more) {
    const Assembly with = assemble(read_scene(
        kSmall,
        {fmt::format("joints.mortar.tensile_strength={{distribution=\"normal\",mean={},sd={},level=\"point\"{}}}",
                     kMean, kScatter, more)}));
    const auto columns = draw_properties(with.families[0], *make_materials(assembly)[0], points, blocks);
    std::vector<double> result;
    for (const double value : columns.at(0).values) result.push_back((value - kMean) / kScatter);
    return result;
  };
  const std::vector<double> alone = z(""), together = z(fmt::format(",correlation_length={}", kLength));
  EXPECT_NEAR(together[0], alone[0], 1e-9);
  for (std::size_t k = 1; k < points.size(); ++k) {
    const double r = std::exp(-(points[k].position[0] - points[k - 1].position[0]) / kLength);
    // The error of r is at most 10 um/kLength; f and z are at most a few.
    EXPECT_NEAR(together[k], r * together[k - 1] + std::sqrt(1 - r * r) * alone[k], 1e-3) << k;
  }
}

TEST(Columns, StiffnessThatScattersLowersTheTimeStep) {
  const Settings stiff{"joints.mortar.normal_stiffness={distribution=\"uniform\",lower=20e9,upper=160e9}"};
  const Simulation plain(read_scene(kSmall, kQuick)), scattered(read_scene(kSmall, kQuick + stiff));
  EXPECT_LT(scattered.time_step_report().time_step, plain.time_step_report().time_step);
  const Settings general{"solver.kernels=general"};
  const Simulation blocks(read_scene(kSmall, kQuick + general)),
      of_blocks(read_scene(kSmall, kQuick + stiff + general));
  EXPECT_LT(of_blocks.time_step_report().time_step, blocks.time_step_report().time_step);
}

// The monitoring compares tangents with the largest random stiffness, which also determines the time step, not with the
// mean, so there is no warning.
TEST(Columns, StiffnessThatScattersIsNoFaultOfTheLaw) {
  const Settings stiff{"joints.mortar.normal_stiffness={distribution=\"uniform\",lower=20e9,upper=160e9}"};
  for (const char* kernels : {"solver.kernels=automatic", "solver.kernels=general"}) {
    Simulation simulation(read_scene(kSmall, kQuick + stiff + Settings{kernels}));
    Observer nobody;
    simulation.run(nobody);
    EXPECT_LE(watch_of(simulation).stiffness_ratio, 1.0 + 1e-9) << kernels;
    EXPECT_GT(watch_of(simulation).stiffness_ratio, 0.9) << "some point is as stiff as the stiffest drawn";
    for (const Warning& warning : simulation.outcome().warnings) EXPECT_NE(warning.about, "time_step") << kernels;
  }
}

// The table of random values has the mean over the joints by area, and the smallest value of all points. Points at the
// edge of a joint have a quarter of the area of those inside, so the mean without weights differs.
TEST(Columns, MeansOfWhatWasDrawnAreByArea) {
  const Settings drawn_strength = strength("distribution=\"lognormal\",cov=0.5,level=\"point\"");
  for (const char* kernels : {"solver.kernels=automatic", "solver.kernels=general"}) {
    const Settings settings = kQuick + drawn_strength + Settings{kernels, "stage.shear.displacement=1e-6"};
    const Drawn d = drawn(drawn_strength);  // equal for all kernels
    double area = 0.0, sum = 0.0, plain = 0.0;
    for (std::size_t i = 0; i < d.value.size(); ++i) {
      area += d.point[i].area, sum += d.point[i].area * d.value[i];
      plain += d.value[i] / static_cast<double>(d.value.size());
    }
    ASSERT_GT(std::abs(plain - sum / area), 1e-3 * plain) << "areas must be seen";
    const auto folder =
        std::filesystem::temp_directory_path() / ("quoin_means_" + std::to_string(getpid()) + std::string(kernels));
    std::filesystem::create_directories(folder);
    ensemble::run_sample(
        {}, 1, [&] { return read_scene(kSmall, settings); }, folder);
    const ensemble::Sample sample = ensemble::read_sample(folder);
    std::filesystem::remove_all(folder);
    ASSERT_EQ(sample.status, "done") << sample.reason;
    const std::map<std::string, double> inputs(sample.inputs.begin(), sample.inputs.end());
    EXPECT_NEAR(inputs.at("joints.mortar.tensile_strength_mean"), sum / area, 1e-9 * plain) << kernels;
    EXPECT_NEAR(inputs.at("joints.mortar.tensile_strength_least"), *std::min_element(d.value.begin(), d.value.end()),
                1e-9 * plain);
  }
}

TEST(Columns, MissingMortarLeavesJointsOut) {
  const auto joints = [](const Settings& settings) {
    const Assembly a = assemble(read_scene(kSmall, Settings{"wall.courses=30", "wall.units_per_course=20"} + settings));
    return std::pair(a.joints.size(), a.apart.size());
  };
  const auto [all, none] = joints({});
  EXPECT_EQ(none, 0u);
  const auto [left, missing] = joints({"joints.mortar.missing_mortar=0.1"});
  EXPECT_EQ(left + missing, all);
  const auto n = static_cast<double>(all);
  EXPECT_NEAR(static_cast<double>(missing), 0.1 * n, 5 * std::sqrt(0.09 * n));
  EXPECT_EQ(joints({"joints.mortar.missing_mortar=0.1", "random.sample=0"}).second, 0u);
  // Joints without mortar have no contact, also in the general kernels.
  const Settings few = kQuick + Settings{"wall.courses=6", "joints.mortar.missing_mortar=0.3"};
  const Simulation lattice(read_scene(kSmall, few)),
      general(read_scene(kSmall, few + Settings{"solver.kernels=general"}));
  EXPECT_EQ(lattice.point_count(), general.point_count());
  EXPECT_LT(lattice.point_count(), Simulation(read_scene(kSmall, kQuick + Settings{"wall.courses=6"})).point_count());
}

std::string fault_of(const Settings& settings) {
  try {
    const Simulation simulation(read_scene(kSmall, kQuick + settings));
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

TEST(Columns, SayWhatIsWrong) {
  using testing::HasSubstr;
  const std::string tensile = "joints.mortar.tensile_strength=";
  EXPECT_THAT(fault_of({tensile + "{distribution=\"lognormal\",mean=1e5}"}), HasSubstr("one of cov"));
  EXPECT_THAT(fault_of({tensile + "{distribution=\"gauss\",mean=1e5,cov=0.1}"}), HasSubstr("one of normal, lognormal"));
  EXPECT_THAT(fault_of({tensile + "{distribution=\"normal\",mean=1e5,cov=0.1,level=\"brick\"}"}),
              HasSubstr("one of point, joint, unit, course, wall"));
  EXPECT_THAT(fault_of({tensile + "{distribution=\"lognormal\",mean=-1e5,cov=0.1}"}), HasSubstr("more than 0"));
  EXPECT_THAT(fault_of({tensile + "{distribution=\"normal\",mean=1e5,cov=0.1,level=\"wall\",correlation_length=1}"}),
              HasSubstr("only with level"));
  // A random value that the law refuses has a message with its position and the remedy.
  EXPECT_THAT(fault_of({tensile + "{distribution=\"normal\",mean=1e5,cov=3}"}),
              testing::AllOf(HasSubstr("sample 1 of seed 1"), HasSubstr("was drawn at ("), HasSubstr("truncate")));
  // A strong and brittle combination is refused.
  EXPECT_THAT(fault_of({tensile + "{distribution=\"uniform\",lower=1e4,upper=2.9e6}"}), HasSubstr("go together"));
  EXPECT_THAT(
      fault_of(kScattered + Settings{"joints.mortar.correlation=[[\"tensile_strength\",\"friction_angle\",0.5]]"}),
      HasSubstr("'friction_angle' is none of them"));
  // The second of two values for a pair decided alone, in silence.
  EXPECT_THAT(fault_of(kScattered + Settings{"joints.mortar.correlation=[[\"tensile_strength\",\"cohesion\",0.8],"
                                             "[\"cohesion\",\"tensile_strength\",-0.8]]"}),
              HasSubstr("cohesion and tensile_strength are given twice"));
}

}  // namespace
}  // namespace quoin
