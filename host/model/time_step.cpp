#include "model/time_step.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "base/error.h"
#include "base/index.h"
#include "model/lanczos.h"
#include "model/undamaged_kernels.h"

namespace quoin {
namespace {

// Stiffness of joints by family, normal and shear, Pa/m, and factor on the stiffness of zones.
struct Springs {
  std::vector<std::array<double, 2>> of_family;
  double of_zones = 1.0;
};

Springs springs_of(const Model& model) {
  Springs springs;
  for (const ContactFamily& family : model.families)
    springs.of_family.push_back({family.normal_stiffness, family.shear_stiffness});
  return springs;
}

// The undamaged assembled system in generalised coordinates: gridpoints in lane layout, then 6 numbers a rigid body.
class UndamagedSystem {
 public:
  // chunks: those whose contact points count, ascending.
  UndamagedSystem(const Model& model, std::span<const int> chunks)
      : UndamagedSystem(model, chunks, springs_of(model)) {}
  UndamagedSystem(const Model& model, std::span<const int> chunks, Springs springs)
      : model_(model),
        springs_(std::move(springs)),
        body_base_(model.line_count * kLine),
        chunks_(chunks.begin(), chunks.end()) {
    slave_body_.resize(at((model.line_count - model.block_line_count) * kLanes), -1);
    slave_arm_.resize(slave_body_.size());
    for (std::size_t b = 0; b < model.bodies.size(); ++b) {
      for (std::size_t i = 0; i < model.bodies[b].slave.size(); ++i) {
        slave_body_[slave_index(model.bodies[b].slave[i])] = static_cast<int>(b);
        slave_arm_[slave_index(model.bodies[b].slave[i])] = model.bodies[b].arm[i];
      }
    }
    for (const int c : chunks) {
      for (std::int32_t i = model.chunks[at(c)].first_point;
           i < model.chunks[at(c)].first_point + model.chunks[at(c)].point_count; ++i)
        add_to_stretches(i);
    }
  }

  int size() const { return body_base_ + 6 * static_cast<int>(model_.bodies.size()); }
  int body_base() const { return body_base_; }
  double of_zones() const { return springs_.of_zones; }
  double free(int dof) const {
    if (dof < body_base_) return model_.node_free[at(dof)];
    return model_.bodies[at((dof - body_base_) / 6)].held[at((dof - body_base_) % 6)] ? 0.0 : 1.0;
  }

  // f = K u, for free degrees of freedom only.
  void apply(const std::vector<double>& u, std::vector<double>* f) const {
    f->assign(at(size()), 0.0);
    for (const UnitGroup& unit : model_.unit_groups) zone_stiffness(model_, unit, u.data(), f->data());
    add_contacts(u.data(), f->data());
    for (int i = 0; i < size(); ++i) (*f)[at(i)] *= free(i);
  }

  // f += K u of the contact points, in their order.
  void add_contacts(const double* u, double* f) const {
    const auto add = [&](const Participants& p, double stiffness, std::int32_t) {
      double jump = 0.0;
      for (int i = 0; i < p.count; ++i) jump += p.coefficient[i] * u[at(p.dof[i])];
      for (int i = 0; i < p.count; ++i) f[at(p.dof[i])] += p.coefficient[i] * stiffness * jump;
    };
    for (const Stretch& stretch : stretches_) {
      if (!stretch.of_bodies) {
        add_springs(model_, stretch, u, f);
        continue;
      }
      for (std::int32_t i = 0; i < stretch.point_count; ++i) visit_springs(stretch.first_point + i, add);
    }
  }

  // Row sums of |K|, its diagonal, and the part of the diagonal that contact points add. Rotations are in units of the
  // radius of gyration, so that all six inertias of a body are its mass. Any positive scale gives a valid bound. Rows
  // are those of the bodies and of these unit groups, whose contact points must all be in the chunks.
  struct Rows {
    LaneVector<double> sum, diagonal, contact_diagonal;
    LaneVector<std::int32_t> next_family;  // one more than the family of the stiffest contact point of a row; 0: none
  };
  Rows rows(const Inertia& inertia, std::span<const int> units) const {
    Rows rows;
    LaneVector<double> stiffest(at(size()));
    rows.sum = rows.diagonal = rows.contact_diagonal = stiffest;
    rows.next_family.resize(at(size()));
    std::vector<std::vector<const BlockGroup*>> groups(model_.templates.size());
    for (const int u : units) {
      const UnitGroup& unit = model_.unit_groups[at(u)];
      for (int g = unit.first_group; g < unit.first_group + unit.group_count; ++g)
        groups[at(model_.groups[at(g)].brick_template)].push_back(&model_.groups[at(g)]);
    }
    for (std::size_t t = 0; t < model_.templates.size(); ++t) {
      for (int row = 0; row < 3 * model_.templates[t].node_count; ++row) {
        double sum = 0.0, diagonal = 0.0;
        for (const auto& [column, k] : model_.templates[t].stiffness.row(row)) {
          sum += std::abs(k);
          if (column == row) diagonal = k;
        }
        for (const BlockGroup* group : groups[t]) {
          for (int lane = 0; lane < group->block_count; ++lane) {
            const std::size_t i = at((group->first_line + row / 3) * kLine + row % 3 * kLanes + lane);
            rows.sum[i] += sum;
            rows.diagonal[i] += diagonal;
          }
        }
      }
    }
    for_each_spring([&](Participants p, double stiffness, std::int32_t point) {
      double all = 0.0;
      for (int i = 0; i < p.count; ++i) {
        p.coefficient[i] *= free(p.dof[i]) / length_scale(p.dof[i], inertia);
        all += std::abs(p.coefficient[i]);
      }
      for (int i = 0; i < p.count; ++i) {
        const std::size_t dof = at(p.dof[i]);
        const double diagonal = stiffness * p.coefficient[i] * p.coefficient[i];
        rows.sum[dof] += stiffness * std::abs(p.coefficient[i]) * all;
        rows.diagonal[dof] += diagonal;
        rows.contact_diagonal[dof] += diagonal;
        if (diagonal > stiffest[dof]) {
          stiffest[dof] = diagonal;
          rows.next_family[dof] = family_of(point) + 1;
        }
      }
    });
    return rows;
  }

  // Inertia of a degree of freedom; scaled: rotations are in units of the radius of gyration.
  double inertia_of(int dof, const Inertia& inertia, bool scaled) const {
    if (dof < body_base_) return inertia.node[at(dof)];
    const std::size_t body = at((dof - body_base_) / 6), k = at((dof - body_base_) % 6);
    return k < 3 || scaled ? inertia.body_mass[body] : inertia.body_inertia[body][k - 3];
  }

  Vec3 position(int dof) const {
    if (dof >= body_base_) return model_.bodies[at((dof - body_base_) / 6)].centre;
    const auto [block, node] = gridpoint_of(dof);
    return model_.gridpoint_position(block, node);
  }

  std::string name(int dof) const {
    if (dof >= body_base_) {
      const RigidBody& body = model_.bodies[at((dof - body_base_) / 6)];
      return fmt::format("rigid block {}{}", body.block, body.name.empty() ? "" : " '" + body.name + "'");
    }
    const auto [block, node] = gridpoint_of(dof);
    return fmt::format("block {}, gridpoint {}", block, node);
  }

 private:
  struct Gridpoint {
    int block, node;
  };
  Gridpoint gridpoint_of(int dof) const {  // gridpoint of a deformable block
    const int line = dof / kLine;
    const auto after = std::upper_bound(model_.groups.begin(), model_.groups.end(), line,
                                        [](int l, const BlockGroup& group) { return l < group.first_line; });
    const BlockGroup& group = *std::prev(after);
    return {group.block[at(dof % kLanes)], line - group.first_line};
  }

  // Degrees of freedom that one component of a contact point's jump depends on.
  struct Participants {
    int count = 0;
    int dof[14];
    double coefficient[14];
    void add(int d, double c) {
      dof[count] = d;
      coefficient[count++] = c;
    }
  };

  // Consecutive contact points for one loop.
  struct Stretch : SpringRun {
    int family = 0;
    bool of_bodies = false;  // whether a side or both is a rigid body
    bool goes_on_with(const Stretch& next) const {
      return family == next.family && axis == next.axis && of_bodies == next.of_bodies &&
             first_point + point_count == next.first_point;
    }
  };

  void add_to_stretches(std::int32_t i) {
    const auto [normal, shear] = springs_.of_family[at(family_of(i))];
    const int blocks_end = model_.block_line_count * kLine;
    Stretch next{{i, 1, model_.point_axis[at(i)], normal, shear},
                 family_of(i),
                 model_.node_a[at(i)] >= blocks_end || model_.node_b[at(i)] >= blocks_end};
    if (stretches_.empty() || !stretches_.back().goes_on_with(next)) {
      stretches_.push_back(next);
    } else {
      ++stretches_.back().point_count;
    }
  }

  std::size_t slave_index(int offset) const {
    return at((offset / kLine - model_.block_line_count) * kLanes + offset % kLanes);
  }

  int family_of(std::int32_t point) const { return model_.assembly.joints[at(model_.point_joint[at(point)])].family; }

  double length_scale(int dof, const Inertia& inertia) const {
    if (dof < body_base_ || (dof - body_base_) % 6 < 3) return 1.0;
    const std::size_t body = at((dof - body_base_) / 6), k = at((dof - body_base_) % 6 - 3);
    return std::sqrt(inertia.body_inertia[body][k] / inertia.body_mass[body]);
  }

  void add_gridpoint(int offset, int c, double sign, Participants* p) const {
    if (offset < model_.block_line_count * kLine) {
      p->add(offset + kLanes * c, sign);
      return;
    }
    const int body = slave_body_[slave_index(offset)];
    const Vec3& r = slave_arm_[slave_index(offset)];
    const int base = body_base_ + 6 * body;
    // u = u_c + theta x r: component c has +r of the axis after next from the next rotation, and the reverse.
    const int next = (c + 1) % 3, last = (c + 2) % 3;
    p->add(base + c, sign);
    p->add(base + 3 + next, sign * r[at(last)]);
    p->add(base + 3 + last, -sign * r[at(next)]);
  }

  // Visits the three springs of a contact point: visit(participants, stiffness in N/m, point).
  template <class Visit>
  void visit_springs(std::int32_t point, Visit visit) const {
    const auto [normal, shear] = springs_.of_family[at(family_of(point))];
    for (int c = 0; c < 3; ++c) {
      Participants p;
      add_gridpoint(model_.node_a[at(point)], c, -1.0, &p);
      add_gridpoint(model_.node_b[at(point)], c, +1.0, &p);
      visit(p, (c == model_.point_axis[at(point)] ? normal : shear) * model_.area[at(point)], point);
    }
  }

  template <class Visit>
  void for_each_spring(Visit visit) const {
    for (const int c : chunks_) {
      const ContactChunk& chunk = model_.chunks[at(c)];
      for (std::int32_t i = 0; i < chunk.point_count; ++i) visit_springs(chunk.first_point + i, visit);
    }
  }

  const Model& model_;
  Springs springs_;
  int body_base_;
  std::vector<int> chunks_;
  std::vector<int> slave_body_;
  std::vector<Vec3> slave_arm_;
  std::vector<Stretch> stretches_;
};

// M'^-1/2 K M'^-1/2 of the free degrees of freedom, with the inertia M' in use.
class ScaledSystem {
 public:
  ScaledSystem(const Model& model, const UndamagedSystem& system, const Inertia& inertia, SharedModel* shared)
      : model_(model), system_(system), shared_(shared), scale_(at(system.size()), 0.0), scaled_(scale_) {
    for (int i = 0; i < system.size(); ++i) {
      const double m = system.inertia_of(i, inertia, false);
      if (system.free(i) != 0.0 && m > 0.0) scale_[at(i)] = 1.0 / std::sqrt(m);
    }
    if (inertia.deformation == 1.0 && inertia.unit == 1.0) return;
    root_mass_.resize(at(model.block_line_count * kLanes));
    for (std::size_t i = 0; i < root_mass_.size(); ++i) {
      const double m = inertia.node[i / kLanes * kLine + i % kLanes];
      if (m > 0.0) root_mass_[i] = std::sqrt(m);
    }
    scaling_ = {&inertia.rigid, 1.0 / std::sqrt(inertia.deformation), 1.0 / std::sqrt(inertia.unit), root_mass_.data()};
  }

  // Start vector; of length 0 where nothing can move.
  LaneVector<double> start() const {
    LaneVector<double> start(scale_.size(), 0.0);
    std::uint64_t random = 0x9e3779b97f4a7c15u;  // any seed serves; a fixed one makes the time step reproducible
    for (std::size_t i = 0; i < start.size(); ++i) {
      random = random * 6364136223846793005u + 1442695040888963407u;
      if (scale_[i] > 0.0) start[i] = static_cast<double>(random >> 11) * 0x1p-53 - 0.5;
    }
    return start;
  }

  // y = A x; returns x . y.
  double product(const LaneVector<double>& x, LaneVector<double>* y) {
    return shared_ ? product_of_part(x, y) : product_of_all(x, y);
  }

 private:
  double product_of_all(const LaneVector<double>& x, LaneVector<double>* y) {
    for (const UnitGroup& unit : model_.unit_groups) scale_and_strain(unit, x, y);
    const auto bodies = at(system_.body_base());
    for (std::size_t i = bodies; i < x.size(); ++i) {
      scaled_[i] = x[i] * scale_[i];
      (*y)[i] = 0.0;
    }
    system_.add_contacts(scaled_.data(), y->data());
    double sum = 0.0;
    for (const UnitGroup& unit : model_.unit_groups)
      sum = scale_motion_after(model_, unit, scaling_, scale_.data(), sum, x.data(), y->data());
    for (std::size_t i = bodies; i < x.size(); ++i) {
      (*y)[i] *= scale_[i];
      sum += (*y)[i] * x[i];
    }
    return sum;
  }

  // Computes the rows of this process; sums of its contact points in rows of other processes are incomplete and not
  // used.
  double product_of_part(const LaneVector<double>& x, LaneVector<double>* y) {
    for (const int u : shared_->units()) scale_and_strain(model_.unit_groups[at(u)], x, y);
    const auto bodies = at(system_.body_base());
    for (std::size_t i = bodies; i < x.size(); ++i) (*y)[i] = 0.0;
    each_of_bodies([&](std::size_t i) { scaled_[i] = x[i] * scale_[i]; });
    shared_->exchange(scaled_);
    system_.add_contacts(scaled_.data(), y->data());
    for (const int u : shared_->units())
      scale_motion_after(model_, model_.unit_groups[at(u)], scaling_, scale_.data(), 0.0, x.data(), y->data());
    each_of_bodies([&](std::size_t i) { (*y)[i] *= scale_[i]; });
    return shared_->sum([&](const VectorRow& row, double sum) {
      for (std::size_t i = row.first; i < row.end; ++i) sum += (*y)[i] * x[i];
      return sum;
    });
  }

  void scale_and_strain(const UnitGroup& unit, const LaneVector<double>& x, LaneVector<double>* y) {
    scale_motion_then(model_, unit, scaling_, scale_.data(), x.data(), scaled_.data());
    zone_stiffness(model_, unit, scaled_.data(), y->data());
    if (system_.of_zones() == 1.0) return;
    const auto u = static_cast<std::size_t>(&unit - model_.unit_groups.data());
    const Model::Extent of = model_.extent_of_units(u, u + 1);
    for (std::size_t i = of.first_line * kLine; i < of.end_line * kLine; ++i) (*y)[i] *= system_.of_zones();
  }

  // Visits the numbers of own bodies.
  template <class Visit>
  void each_of_bodies(Visit visit) const {
    const auto bodies = at(system_.body_base());
    for (const VectorRow& row : shared_->rows()) {
      for (std::size_t i = row.first; row.first >= bodies && i < row.end; ++i) visit(i);
    }
  }

  const Model& model_;
  const UndamagedSystem& system_;
  SharedModel* shared_;
  LaneVector<double> scale_;  // 1/sqrt(m); 0: held
  LaneVector<double> scaled_;
  LaneVector<double> root_mass_;
  MotionScaling scaling_;
};

LargestEigenvalue largest_eigenvalue(const Model& model, const UndamagedSystem& system, const Inertia& inertia,
                                     bool with_vector, SharedModel* shared) {
  LanczosSettings settings;
  settings.max_steps = 600;
  settings.check_interval = 10;
  // The residual is no measure of convergence. Walls have clusters of equal modes, between which the vector wanders
  // long after the value has converged. In large walls modes crowd, and the last 4e-5 of the step would take four times
  // the products.
  constexpr int kLarge = 1'000'000;
  settings.settled = system.size() > kLarge ? 1e-5 : 1e-7;
  settings.with_vector = with_vector;
  ScaledSystem scaled(model, system, inertia, shared);
  const auto product = [&](const LaneVector<double>& x, LaneVector<double>* y) { return scaled.product(x, y); };
  return largest_eigenvalue(product, scaled.start(), settings, shared);
}

std::string with_contact_share(const Model& model, const UndamagedSystem& system, const UndamagedSystem::Rows& rows,
                               int dof) {
  std::string text = system.name(dof);
  const std::size_t i = at(dof);
  if (rows.next_family[i] > 0 && rows.diagonal[i] > 0.0) {
    text += fmt::format(", joint family '{}' has {:.0f} % of its stiffness",
                        model.families[at(rows.next_family[i] - 1)].name,
                        100.0 * rows.contact_diagonal[i] / rows.diagonal[i]);
  }
  return text;
}

bool has_block(const Model& model, const SharedModel& shared, int block) {
  const auto after = std::upper_bound(model.unit_groups.begin(), model.unit_groups.end(), model.place[at(block)].group,
                                      [](int group, const UnitGroup& unit) { return group < unit.first_group; });
  const auto unit = static_cast<int>(after - model.unit_groups.begin()) - 1;
  return std::binary_search(shared.units().begin(), shared.units().end(), unit);
}

// 1/mass of each block of a name that a whiffletree pulls, 1/kg. Gridpoints of a deformable block share its force by
// mass.
std::vector<double> compliances(const Model& model, const Inertia& inertia, const std::string& name,
                                SharedModel* shared) {
  std::vector<double> found;
  for (const int block : model.blocks_named(name)) {
    if (const int body = model.place[at(block)].body; body >= 0) {
      found.push_back(1.0 / inertia.body_mass[at(body)]);
      continue;
    }
    if (shared && !has_block(model, *shared, block)) {
      found.push_back(0.0);
      continue;
    }
    double mass = 0.0, sum = 0.0;
    model.for_each_gridpoint(block, [&](std::size_t offset, double m) {
      mass += m;
      sum += m * m / inertia.node[offset];
    });
    found.push_back(sum / (mass * mass));
  }
  if (shared) shared->largest(found);  // the value of the process that owns the block
  return found;
}

std::vector<int> all_of(std::size_t count) {
  std::vector<int> all(count);
  std::iota(all.begin(), all.end(), 0);
  return all;
}

std::vector<int> chunks_here(const Model& model, const SharedModel* shared) {
  return shared ? std::vector<int>(shared->chunks().begin(), shared->chunks().end()) : all_of(model.chunks.size());
}

std::vector<int> units_here(const Model& model, const SharedModel* shared) {
  return shared ? std::vector<int>(shared->units().begin(), shared->units().end()) : all_of(model.unit_groups.size());
}

// Visits the generalised coordinates of this process: visit(dof).
template <class Visit>
void each_number(const UndamagedSystem& system, const SharedModel* shared, Visit visit) {
  const VectorRow all{0, at(system.size())};
  for (const VectorRow& row : shared ? shared->rows() : std::span(&all, 1)) {
    for (std::size_t i = row.first; i < row.end; ++i) visit(static_cast<int>(i));
  }
}

// tree: eigenvalue of the stiffest whiffletree, 1/s2.
TimeStepReport limits(const Model& model, const UndamagedSystem& system, const Inertia& inertia, double tree,
                      Limits wanted, SharedModel* shared) {
  TimeStepReport report;
  report.model_mass = model.total_mass();
  // The largest eigenvalue of a sum is at most the sum of the largest; whiffletrees are soft compared with joints.
  const auto step_of = [tree](double of_joints) {
    const double omega_squared = of_joints + tree;
    return omega_squared > 0.0 ? 2.0 / std::sqrt(omega_squared) : std::numeric_limits<double>::infinity();
  };
  const LargestEigenvalue lanczos = largest_eigenvalue(model, system, inertia, wanted == Limits::all, shared);
  report.critical.value = step_of(lanczos.value);
  report.lanczos_steps = lanczos.steps;
  if (wanted == Limits::critical) return report;

  const auto rows = system.rows(inertia, units_here(model, shared));
  if (wanted == Limits::nodal) {
    double worst[] = {0.0};
    each_number(system, shared, [&](int i) {
      const double m = system.inertia_of(i, inertia, true);
      if (system.free(i) != 0.0 && m > 0.0) worst[0] = std::max(worst[0], rows.diagonal[at(i)] / m);
    });
    if (shared) shared->largest(worst);
    report.nodal.value = step_of(worst[0]);
    return report;
  }
  const auto set_by = [&](int dof, TimeStepLimit* limit) {
    if (dof < 0) return;
    limit->position = system.position(dof);
    limit->where = with_contact_share(model, system, rows, dof);
  };
  double worst_sum = 0.0, worst_diagonal = 0.0;
  int sum_dof = -1, diagonal_dof = -1, vector_dof = -1;
  for (int i = 0; i < system.size(); ++i) {
    const double m = system.inertia_of(i, inertia, true);
    if (system.free(i) == 0.0 || m <= 0.0) continue;
    if (rows.sum[at(i)] / m > worst_sum) {
      worst_sum = rows.sum[at(i)] / m;
      sum_dof = i;
    }
    if (rows.diagonal[at(i)] / m > worst_diagonal) {
      worst_diagonal = rows.diagonal[at(i)] / m;
      diagonal_dof = i;
    }
  }
  for (std::size_t i = 0; i < lanczos.vector.size(); ++i) {
    if (vector_dof < 0 || std::abs(lanczos.vector[i]) > std::abs(lanczos.vector[at(vector_dof)]))
      vector_dof = static_cast<int>(i);
  }
  report.gershgorin.value = step_of(worst_sum);
  report.nodal.value = step_of(worst_diagonal);
  set_by(vector_dof, &report.critical);
  set_by(sum_dof, &report.gershgorin);
  set_by(diagonal_dof, &report.nodal);
  return report;
}

// The lightest block at the joints of a family sets its viscosity. Joints between the halves of units are bonded from
// the start, and nothing lands there. With the stiffness of units they would reduce the step far too much.
std::vector<std::array<double, 2>> impact_viscosities(const Model& model, const SolverSettings& settings) {
  const Assembly& assembly = model.assembly;
  std::vector<std::array<double, 2>> squares(assembly.families.size()), viscosities;
  std::vector<char> lands(squares.size(), 0);
  for (const Joint& joint : assembly.joints) {
    const auto f = at(joint.family);
    const int unit = assembly.bricks[at(joint.block_a)].unit;
    if (unit < 0 || unit != assembly.bricks[at(joint.block_b)].unit) lands[f] = 1;
    for (const int block : {joint.block_a, joint.block_b}) {
      const Brick& brick = assembly.bricks[at(block)];
      if (brick.is_support()) continue;
      const std::size_t n = at(joint.face_a / 2), s = (n + 1) % 3, t = (n + 2) % 3;
      const Vec3& size = brick.size;
      const double mass =
          settings.mass_scaling * assembly.materials[at(brick.material)].density * size[0] * size[1] * size[2];
      const auto about = [&](double p, double q) { return mass * (p * p + q * q) / 12.0; };
      const double along_s = 0.25 * size[s] * size[s], along_t = 0.25 * size[t] * size[t];
      const double about_s = about(size[n], size[t]), about_t = about(size[n], size[s]);
      const LandingBlock landing{mass, size[s] * size[t], std::max(along_s / about_t, along_t / about_s),
                                 std::min(about_s, about_t), 0.5 * size[n]};
      const auto of_block =
          landing_squares(landing, model.families[f].normal_stiffness, model.families[f].shear_stiffness);
      for (std::size_t k = 0; k < 2; ++k) squares[f][k] = std::max(squares[f][k], of_block[k]);
    }
  }
  for (std::size_t f = 0; f < squares.size(); ++f)
    viscosities.push_back(lands[f] ? impact_viscosity(squares[f], damping_of(settings).impacts->share)
                                   : std::array{0.0, 0.0});
  return viscosities;
}

// Impact damping of the settings.
ImpactDamping all_damping(const Model& model, const SolverSettings& settings) {
  ImpactDamping damping{impact_viscosities(model, settings), 0.0, damping_of(settings).impacts->share};
  for (const Brick& brick : model.assembly.bricks) {
    if (!brick.rigid)
      lower_zone_viscosity(damping.of_zones, std::hypot(brick.size[0], brick.size[1], brick.size[2]),
                           model.assembly.materials[at(brick.material)], settings.mass_scaling);
  }
  return damping;
}

// tree: as in limits.
ImpactStep damp_impacts(const Model& model, const SolverSettings& settings, const Inertia& inertia, double tree,
                        SharedModel* shared, TimeStepReport* report) {
  ImpactDamping& damping = report->impacts = all_damping(model, settings);
  const std::vector<int> chunks = chunks_here(model, shared);
  // Largest eigenvalue of of_stiffness K + of_viscosity C over the inertia.
  const auto eigenvalue = [&](double of_stiffness, double of_viscosity) {
    Springs springs = springs_of(model);
    for (std::size_t f = 0; f < springs.of_family.size(); ++f) {
      for (std::size_t k = 0; k < 2; ++k)
        springs.of_family[f][k] *= of_stiffness + of_viscosity * damping.viscosity[f][k];
    }
    springs.of_zones = of_stiffness + of_viscosity * damping.of_zones;
    return largest_eigenvalue(model, UndamagedSystem(model, chunks, std::move(springs)), inertia, false, shared).value;
  };
  const ImpactStep step =
      step_under_impacts(report->critical.value, eigenvalue(0.0, 1.0),
                         [&](double share, double dt) { return tree + eigenvalue(1.0, 2.0 * share / dt); });
  for (auto& of_family : damping.viscosity) of_family = {step.share * of_family[0], step.share * of_family[1]};
  damping.of_zones *= step.share;
  damping.in_use *= step.share;
  return step;
}

// Stable step of zones, s. Joints' springs and dashpots with implicit contacts (step/implicit_contacts.h) do not limit
// the step. With C = beta K of the zones, central differences are stable where dt^2 + 2 beta dt <= 4/omega^2.
double step_of_zones(const Model& model, const SolverSettings& settings, const Inertia& inertia, double tree,
                     SharedModel* shared, TimeStepReport* report) {
  const auto refuse = [](const std::string& what) {
    throw Error(Exit::bad_input, "solver.implicit_contacts takes " + what + "; remove it");
  };
  if (shared) refuse("one process");
  if (inertia.deformation != 1.0 || inertia.unit != 1.0 || settings.selective_time_step > 0.0)
    refuse("true inertia, not deformation_inertia, unit_inertia or selective_time_step");
  for (const RigidBody& body : model.bodies) {
    const Brick& brick = model.assembly.bricks[at(body.block)];
    if (brick.is_support()) continue;
    refuse(fmt::format("no rigid block that moves freely, and block {}{} is one", body.block,
                       body.name.empty() ? "" : " '" + body.name + "'"));
  }
  if (model.unit_groups.empty()) refuse("deformable blocks");
  const double of_zones = (report->impacts = all_damping(model, settings)).of_zones;
  Springs zones{std::vector<std::array<double, 2>>(model.families.size()), 1.0};
  const UndamagedSystem system(model, chunks_here(model, shared), std::move(zones));
  const double squared = tree + largest_eigenvalue(model, system, inertia, false, shared).value;
  report->critical = {2.0 / std::sqrt(squared), {}, ""};
  return std::sqrt(of_zones * of_zones + 4.0 / squared) - of_zones;
}

// Mass in use over all ranks, kg; a body counts in the row where its six numbers begin.
double mass_in_use(const Model& model, const UndamagedSystem& system, const Inertia& inertia, SharedModel* shared) {
  const auto add = [&](const VectorRow& row, double sum) {
    const auto bodies = at(system.body_base());
    const std::size_t end_line = std::min(row.end / kLine, at(model.block_line_count));
    for (std::size_t line = row.first / kLine; line < end_line; ++line) {
      for (std::size_t lane = 0; lane < kLanes; ++lane) sum += inertia.node[line * kLine + lane];
    }
    for (std::size_t i = std::max(row.first, bodies); i < row.end; i += 6) sum += inertia.body_mass[(i - bodies) / 6];
    return sum;
  };
  return shared ? shared->sum(add) : add({0, at(system.size())}, 0.0);
}

}  // namespace

std::string TimeStepReport::warning() const {
  if (time_step <= quiet_fraction * critical.value * (1.0 + 1e-12)) return {};
  if (time_step > critical.value) {
    return fmt::format(
        "the time step is {:.2f} of the critical one, 2/omega_max: the run is unstable, and its results are those of "
        "the instability. Take solver.critical_time_step = \"assembled\"",
        time_step / critical.value);
  }
  return fmt::format(
      "the time step is {:.2f} of the critical one; with this damping stiff modes chatter above {:.2f}, and "
      "their noise breaks joints. Lower solver.time_step_fraction or solver.local_damping",
      time_step / critical.value, quiet_fraction);
}

void apply_undamaged_stiffness(const Model& model, const std::vector<double>& u, std::vector<double>* f) {
  UndamagedSystem(model, all_of(model.chunks.size())).apply(u, f);
}

double whiffletree_eigenvalue(const std::vector<Stage>& stages,
                              const std::function<std::vector<double>(const Stage&, const std::string&)>& compliances) {
  double largest = 0.0;
  for (const Stage& stage : stages) {
    if (!stage.whiffletree) continue;
    double compliance = 0.0;
    for (const std::vector<std::string>& floor : stage.whiffletree->floors) {
      double of_floor = 0.0, count = 0.0;
      for (const std::string& name : floor) {
        for (const double of_block : compliances(stage, name)) of_floor += of_block, ++count;
      }
      if (count > 0.0) compliance += of_floor / (count * count);
    }
    const auto floors = static_cast<double>(stage.whiffletree->floors.size());
    largest = std::max(largest, stage.whiffletree->stiffness / floors * compliance);
  }
  return largest;
}

double quiet_fraction_of(const SolverSettings& settings) {
  return 1.0 / std::sqrt(1.0 + std::max(damping_of(settings).gamma, damping_of(settings, true).gamma));
}

bool needs_rows(const SolverSettings& settings) {
  return settings.critical_time_step == CriticalTimeStep::nodal || settings.selective_time_step > 0.0;
}

Inertia inertia_in_use(const Model& model, const SolverSettings& settings, SharedModel* shared) {
  Inertia inertia;
  inertia.node = model.node_mass;
  if (settings.mass_scaling != 1.0) {
    for (double& m : inertia.node) {
      if (m > 0.0) m *= settings.mass_scaling;
    }
  }
  for (const RigidBody& body : model.bodies) {
    inertia.body_mass.push_back(settings.mass_scaling * body.mass);
    inertia.body_inertia.push_back(settings.mass_scaling * body.inertia);
  }

  if (settings.selective_time_step > 0.0) {
    // omega_max^2 <= max (row sum / inertia): an inertia with this ratio at 4/(dt/fraction)^2 in every row suffices for
    // the step.
    const UndamagedSystem system(model, chunks_here(model, shared));
    const std::vector<int> units = units_here(model, shared);
    const auto rows = system.rows(inertia, units);
    const double target = settings.selective_time_step / settings.time_step_fraction;
    const double factor = 0.25 * target * target;
    for (const int u : units) {
      const Model::Extent of = model.extent_of_units(at(u), at(u) + 1);
      for (std::size_t line = of.first_line; line < of.end_line; ++line) {
        for (std::size_t lane = 0; lane < kLanes; ++lane) {
          const std::size_t i = line * kLine + lane;
          if (inertia.node[i] <= 0.0) continue;
          double needed = inertia.node[i];
          for (std::size_t c = 0; c < 3; ++c) needed = std::max(needed, factor * rows.sum[i + kLanes * c]);
          for (std::size_t c = 0; c < 3; ++c) inertia.node[i + kLanes * c] = needed;
        }
      }
    }
    // A process that lacks points of a body finds no larger row sums than the process that has all of them.
    std::vector<double> ratios(model.bodies.size(), 1.0);
    for (std::size_t b = 0; b < ratios.size(); ++b) {
      for (std::size_t k = 0; k < 6; ++k)
        ratios[b] = std::max(ratios[b], factor * rows.sum[at(system.body_base()) + 6 * b + k] / inertia.body_mass[b]);
    }
    if (shared) shared->largest(ratios);
    for (std::size_t b = 0; b < ratios.size(); ++b) {
      inertia.body_mass[b] *= ratios[b];
      for (double& moment : inertia.body_inertia[b]) moment *= ratios[b];
    }
  }

  inertia.deformation = settings.deformation_inertia;
  inertia.unit = settings.unit_inertia;
  if (inertia.deformation != 1.0 || inertia.unit != 1.0 || damping_of(settings).splits_motion())
    inertia.rigid = rigid_motions(model, inertia.node);
  return inertia;
}

TimeStepReport choose_time_step(const Model& model, const SolverSettings& settings, Inertia* inertia, Limits wanted,
                                const std::vector<Stage>& stages, SharedModel* shared) {
  if (settings.critical_time_step == CriticalTimeStep::nodal && wanted == Limits::critical) wanted = Limits::nodal;
  *inertia = inertia_in_use(model, settings, shared);
  const UndamagedSystem system(model, chunks_here(model, shared));
  const double tree = whiffletree_eigenvalue(
      stages, [&](const Stage&, const std::string& name) { return compliances(model, *inertia, name, shared); });
  TimeStepReport report = limits(model, system, *inertia, tree, wanted, shared);
  report.added_mass = std::max(0.0, mass_in_use(model, system, *inertia, shared) - report.model_mass);

  if (!std::isfinite(report.critical.value) && !(settings.selective_time_step > 0.0)) {
    throw Error(Exit::bad_input,
                "the model has no stiffness (no deformable block, no contact point), so no time step follows "
                "from it; give solver.selective_time_step");
  }
  // Damping forces use the velocity half a step ago, which reduces the stable step. Its bound is dt <= 2/omega (sqrt(1
  // + xi^2) - xi) with the damping ratio xi at the highest frequency.
  const Damping damping = damping_of(settings);
  const double omega = 2.0 / report.critical.value;
  double xi = damping.zone_ratio;
  if (damping.alpha > 0.0 || damping.beta > 0.0) xi += 0.5 * (damping.alpha / omega + damping.beta * omega);
  report.quiet_fraction = quiet_fraction_of(settings);
  report.stiffness_damping = report.joint_damping = damping.beta;
  if (damping.zone_ratio > 0.0) report.stiffness_damping += 2.0 * damping.zone_ratio / omega;
  const double limit =
      settings.critical_time_step == CriticalTimeStep::nodal ? report.nodal.value : report.critical.value;
  report.time_step = settings.time_step_fraction * step_left(xi) * limit;
  if (damping.impacts && std::isfinite(report.critical.value)) {
    constexpr double kClose = 0.95;  // share of the limit
    report.time_step = damping.is_implicit() ? std::min(settings.time_step_fraction, kClose) *
                                                   step_of_zones(model, settings, *inertia, tree, shared, &report)
                                             : std::min(report.time_step, kClose * limit) *
                                                   damp_impacts(model, settings, *inertia, tree, shared, &report).left;
    report.stiffness_damping = report.impacts.of_zones;
  }
  if (settings.selective_time_step > 0.0) report.time_step = std::min(settings.selective_time_step, report.time_step);
  return report;
}

}  // namespace quoin
