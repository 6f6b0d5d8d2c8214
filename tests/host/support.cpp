#include "support.h"

#include <cmath>
#include <random>

namespace quoin {

BlockMaterial brick_material(double poisson_ratio) { return {"brick", kYoung, poisson_ratio, kDensity}; }

JointFamily elastic_family(double kn, double ks) {
  JointFamily family;
  family.name = "joint";
  family.law = "elastic";
  family.properties = {{"normal_stiffness", {kn}, "", {}}, {"shear_stiffness", {ks}, "", {}}};
  return family;
}

JointFamily mortar_family() {
  JointFamily family = elastic_family();
  family.name = "mortar";
  family.law = "fracture_energy";
  for (const auto& [id, value] : std::map<std::string, double>{{"tensile_strength", 0.2e6},
                                                               {"cohesion", 0.3e6},
                                                               {"friction_angle", 35.0},
                                                               {"compressive_strength", 5e6},
                                                               {"fracture_energy_tension", 15.0},
                                                               {"fracture_energy_shear", 125.0},
                                                               {"fracture_energy_compression", 8000.0}}) {
    family.properties.push_back({id, {value}, "", {}});
  }
  return family;
}

Assembly brick_grid(std::array<int, 3> count, Vec3 size, std::array<int, 3> zones, JointFamily family,
                    BlockMaterial material) {
  Assembly assembly;
  assembly.materials = {material};
  assembly.families = {family};
  const auto index = [&](int i, int j, int k) { return i + count[0] * (j + count[1] * k); };
  for (int k = 0; k < count[2]; ++k) {
    for (int j = 0; j < count[1]; ++j) {
      for (int i = 0; i < count[0]; ++i) {
        Brick brick;
        brick.origin = {i * size[0], j * size[1], k * size[2]};
        brick.size = size;
        brick.zones = zones;
        brick.parity = (i * zones[0] + j * zones[1] + k * zones[2]) % 2;
        assembly.bricks.push_back(brick);
        if (i > 0) assembly.joints.push_back({index(i - 1, j, k), index(i, j, k), 1, 0});
        if (j > 0) assembly.joints.push_back({index(i, j, k), index(i, j - 1, k), 2, 0});  // in the opposite order
        if (k > 0) assembly.joints.push_back({index(i, j, k - 1), index(i, j, k), 5, 0});
      }
    }
  }
  return assembly;
}

Assembly in_units(Assembly assembly) {
  for (std::size_t i = 0; i < assembly.bricks.size(); ++i) assembly.bricks[i].unit = static_cast<int>(i / 2);
  return assembly;
}

Scene wall_scene(int courses, double units) {
  Scene scene;
  scene.materials["brick"] = brick_material();
  scene.joints["mortar"] = mortar_family();
  scene.joints["unit"] = elastic_family(1000e9, 1000e9);
  scene.joints["unit"].name = "unit";
  WallSpec wall;
  wall.courses = courses;
  wall.units_per_course = units;
  wall.unit = {0.22, 0.0625, 0.1};
  wall.unit_material = "brick";
  wall.bed_joint = wall.head_joint = wall.beam_joint = "mortar";
  wall.unit_joint = "unit";
  scene.wall = wall;
  scene.output.frames = 0;
  return scene;
}

Scene bare_scene(double fraction, DampingKind damping) {
  Scene scene;
  scene.solver.time_step_fraction = fraction;
  scene.solver.damping = damping;
  return scene;
}

namespace {

// Calls visit(corner indices, corner positions, volume) for the tetrahedra of a brick.
template <class Visit>
void for_each_tetrahedron(const Brick& brick, Visit visit) {
  const auto [nx, ny, nz] = brick.zones;
  static const int corners[2][5][4][3] = {{{{0, 0, 0}, {1, 1, 0}, {1, 0, 1}, {0, 1, 1}},
                                           {{1, 0, 0}, {0, 0, 0}, {1, 1, 0}, {1, 0, 1}},
                                           {{0, 1, 0}, {0, 0, 0}, {1, 1, 0}, {0, 1, 1}},
                                           {{0, 0, 1}, {0, 0, 0}, {1, 0, 1}, {0, 1, 1}},
                                           {{1, 1, 1}, {1, 1, 0}, {1, 0, 1}, {0, 1, 1}}},
                                          {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 1, 1}},
                                           {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}},
                                           {{1, 1, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 1}},
                                           {{1, 0, 1}, {1, 0, 0}, {0, 0, 1}, {1, 1, 1}},
                                           {{0, 1, 1}, {0, 1, 0}, {0, 0, 1}, {1, 1, 1}}}};
  for (int k = 0; k < nz; ++k) {
    for (int j = 0; j < ny; ++j) {
      for (int i = 0; i < nx; ++i) {
        for (const auto& tet : corners[(i + j + k + brick.parity) % 2]) {
          std::array<int, 4> node;
          Eigen::Matrix4d a;  // rows 1, x, y, z
          for (std::size_t c = 0; c < 4; ++c) {
            const int x = i + tet[c][0], y = j + tet[c][1], z = k + tet[c][2];
            node[c] = x + (nx + 1) * (y + (ny + 1) * z);
            a.row(static_cast<int>(c)) << 1.0, x * brick.size[0] / nx, y * brick.size[1] / ny, z * brick.size[2] / nz;
          }
          visit(node, a, std::abs(a.determinant()) / 6.0);
        }
      }
    }
  }
}

int node_count(const Brick& brick) { return (brick.zones[0] + 1) * (brick.zones[1] + 1) * (brick.zones[2] + 1); }

}  // namespace

Eigen::MatrixXd dense_stiffness(const Brick& brick, const BlockMaterial& material) {
  const double e = material.young_modulus, nu = material.poisson_ratio;
  Eigen::MatrixXd d = Eigen::MatrixXd::Zero(6, 6);
  const double factor = e / ((1 + nu) * (1 - 2 * nu));
  d.topLeftCorner(3, 3).setConstant(factor * nu);
  d.diagonal().head(3).setConstant(factor * (1 - nu));
  d.diagonal().tail(3).setConstant(e / (2 * (1 + nu)));
  Eigen::MatrixXd stiffness = Eigen::MatrixXd::Zero(3 * node_count(brick), 3 * node_count(brick));
  for_each_tetrahedron(brick, [&](const std::array<int, 4>& node, const Eigen::Matrix4d& a, double volume) {
    const Eigen::Matrix4d shape = a.inverse();  // column n: coefficients of N_n
    Eigen::MatrixXd b = Eigen::MatrixXd::Zero(6, 12);
    for (int n = 0; n < 4; ++n) {
      const double x = shape(1, n), y = shape(2, n), z = shape(3, n);
      b.middleCols(3 * n, 3) << x, 0, 0, 0, y, 0, 0, 0, z, y, x, 0, 0, z, y, z, 0, x;
    }
    const Eigen::MatrixXd k = volume * b.transpose() * d * b;
    for (int n = 0; n < 4; ++n) {
      for (int m = 0; m < 4; ++m) {
        stiffness.block(3 * node[static_cast<std::size_t>(n)], 3 * node[static_cast<std::size_t>(m)], 3, 3) +=
            k.block(3 * n, 3 * m, 3, 3);
      }
    }
  });
  return stiffness;
}

Eigen::VectorXd dense_mass(const Brick& brick, const BlockMaterial& material) {
  Eigen::VectorXd mass = Eigen::VectorXd::Zero(3 * node_count(brick));
  for_each_tetrahedron(brick, [&](const std::array<int, 4>& node, const Eigen::Matrix4d&, double volume) {
    for (int n : node) mass.segment(3 * n, 3).array() += 0.25 * volume * material.density;
  });
  return mass;
}

std::size_t dof(const Model& model, int block, int node, int c) {
  const auto& place = model.place[static_cast<std::size_t>(block)];
  const int line = model.groups[static_cast<std::size_t>(place.group)].first_line + node;
  return static_cast<std::size_t>(line * kLine + c * kLanes + place.lane);
}

void random_velocities(Simulation* simulation, unsigned seed, double largest) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> uniform(-largest, largest);
  for (std::size_t i = 0; i < lattice_velocity(*simulation).size(); ++i) {
    if (simulation->model().node_mass[i] > 0.0) lattice_velocity(*simulation)[i] = uniform(random);
  }
}

double largest_after(const Scene& scene, const Assembly& assembly, int steps) {
  Simulation simulation(scene, assembly, 1);
  random_velocities(&simulation, 7);
  try {
    simulation.advance(steps);
  } catch (const Error&) {
    return INFINITY;
  }
  double largest = 0.0;
  for (double u : lattice_displacement(simulation)) largest = std::max(largest, std::abs(u));
  return std::isfinite(largest) ? largest : INFINITY;
}

std::string undamped_stone(const std::string& kernels) {
  return "[solver]\ndamping = \"none\"\nkernels = \"" + kernels + R"("
[materials.stone]
density = 2000.0
young_modulus = 1e9
poisson_ratio = 0.2
[joints.dry]
law = "elastic"
normal_stiffness = 1e8
shear_stiffness = 5e7
)";
}

}  // namespace quoin
