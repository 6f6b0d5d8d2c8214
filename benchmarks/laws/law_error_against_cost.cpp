// Run time against error of fracture_energy and cyclic_joint on 256 cyclic paths of opening, sliding in two directions
// and varying pressure. Each path is computed with more and more increments and compared with 2^20 increments
// (cyclic_joint: 2^16). Monotonic paths of fracture_energy are compared with their closed forms. cyclic_joint has the
// starting values of the law's page, so that every branch is active, and a second kind of path with
// crushing. Writes CSV to the standard output:
//   law_error_against_cost > law_error_against_cost.csv && gnuplot law_error_against_cost.gp
#include <fmt/format.h>
#include <time.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "quoin/quoin.h"
#include "tests/kernels/plugin.h"
#include "tests/mixed_paths.h"
#include "tests/mortar.h"

namespace {

using namespace quoin::test::mortar;
using Law = quoin::api::Material;
using quoin::test::mixed::Jump, quoin::test::mixed::kPoints;
constexpr int kChecks = 64;  // number of positions along each path at which errors are computed

struct Answer {
  double sigma, tau_s, tau_t, dissipated;
};
using Path = Jump (*)(std::size_t point, double x);  // x from 0 to 1

// Returns the processor time of this thread, which other programs do not change.
double thread_seconds() {
  timespec now;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

// All points along their paths in the given number of increments: results at every check, and processor time of the
// law. The time is that of a second computation with tractions and states only.
struct Drive {
  std::vector<Answer> answers;  // kPoints results for each check
  double seconds = 0.0;

  Drive(const Law& law, Path path, int increments) : answers(kChecks * kPoints) {
    run(law, path, increments, true);
    run(law, path, increments, false);
  }

 private:
  void run(const Law& law, Path path, int increments, bool energies) {
    const std::size_t states = law.law().state_count;  // all 0 when bonded
    std::vector<std::vector<double>> columns(3 + 3 + states + 4, std::vector<double>(kPoints, 0.0));
    auto *jump = columns.data(), *traction = jump + 3, *state = traction + 3, *dissipated = state + states;
    std::vector<quoin_in> old_states(states);
    std::vector<quoin_out> new_states(states);
    quoin_batch batch{};
    batch.struct_size = sizeof batch;
    batch.count = kPoints;
    batch.normal_jump = {jump[0].data(), 1};
    for (std::size_t k = 0; k < 2; ++k) batch.slip_increment[k] = {jump[1 + k].data(), 1};
    for (std::size_t k = 0; k < 3; ++k) {
      batch.traction_old[k] = {traction[k].data(), 1};
      batch.traction_new[k] = {traction[k].data(), 1};
    }
    for (std::size_t k = 0; k < states; ++k) {
      if (law.law().states[k]->role == QUOIN_ROLE_DIAGNOSTIC) continue;
      old_states[k] = {state[k].data(), 1};
      new_states[k] = {state[k].data(), 1};
    }
    batch.state_old = old_states.data();
    batch.state_new = new_states.data();
    for (std::size_t k = 0; k < 4 && energies; ++k) batch.dissipated[k] = {dissipated[k].data(), 1};

    std::vector<Jump> last(kPoints);
    std::vector<double> total(kPoints, 0.0);
    for (std::size_t i = 0; i < kPoints; ++i) last[i] = path(i, 0.0);
    for (int step = 1; step <= increments; ++step) {
      for (std::size_t i = 0; i < kPoints; ++i) {
        const Jump to = path(i, static_cast<double>(step) / increments);
        jump[0][i] = to.n, jump[1][i] = to.s - last[i].s, jump[2][i] = to.t - last[i].t;
        last[i] = to;
      }
      const double start = thread_seconds();
      law.evaluate(batch);
      if (!energies) seconds += thread_seconds() - start;
      if (!energies) continue;
      for (std::size_t i = 0; i < kPoints; ++i) {
        for (std::size_t k = 0; k < 4; ++k) total[i] += dissipated[k][i];
      }
      if (static_cast<long>(step) * kChecks % increments != 0) continue;
      Answer* const here =
          &answers[(static_cast<std::size_t>(step) * kChecks / static_cast<std::size_t>(increments) - 1) * kPoints];
      for (std::size_t i = 0; i < kPoints; ++i) here[i] = {traction[0][i], traction[1][i], traction[2][i], total[i]};
    }
  }
};

Jump mixed(std::size_t point, double x) { return quoin::test::mixed::path(point, x); }
Jump crushing(std::size_t point, double x) { return quoin::test::mixed::crushing_path(point, x); }

// Monotonic paths, which for the last point end ten per cent beyond the end of softening, and their closed forms.
double reach(std::size_t point) { return 1.1 * static_cast<double>(point + 1) / kPoints; }
Jump opening(std::size_t point, double x) { return {2.0 * G1 / ft * reach(point) * x, 0.0, 0.0}; }
Jump sliding(std::size_t point, double x) { return {-1e-5, 2.0 * G2 / c0 * reach(point) * x, 0.0}; }
Jump closing(std::size_t point, double x) { return {-2.0 * Gc / fc * reach(point) * x, 0.0, 0.0}; }

// Returns the stress at a jump: elastic up to strength + residual, then linear softening down to the residual. It falls
// by strength over the inelastic jump `ultimate`, where the inelastic jump is jump - stress/stiffness.
double softened(double jump, double stiffness, double strength, double residual, double ultimate) {
  if (stiffness * jump <= strength + residual) return stiffness * jump;
  const double falling = (strength * (1.0 - jump / ultimate) + residual) / (1.0 - strength / (stiffness * ultimate));
  return std::max(residual, falling);
}
Answer opening_answer(const Jump& d) {
  const double lt = 2.0 * (G1 - 0.5 * ft * ft / kn) / ft, xi = (d.n - ft / kn) / lt;
  return {xi <= 0.0 ? kn * d.n : ft * std::max(0.0, 1.0 - xi), 0.0, 0.0, 0.0};
}
Answer sliding_answer(const Jump& d) {
  const double sigma = kn * d.n, friction = -sigma * std::tan(phi * (std::numbers::pi / 180.0));
  return {sigma, softened(d.s, ks, c0, friction, 2.0 * G2 / c0), 0.0, 0.0};
}
Answer closing_answer(const Jump& d) { return {-softened(-d.n, kn, fc, 0.0, 2.0 * Gc / fc), 0.0, 0.0, 0.0}; }

struct Errors {
  double largest = 0.0, rms = 0.0, energy = 0.0;
};

void print(const Law& law, const char* path, int increments, const Errors& e, double seconds) {
  const double nanoseconds = 1e9 * seconds / kPoints;
  fmt::print("{},{},{},{:.3e},{:.3e},{:.3e},{:.2f},{:.4g}\n", law.law().id, path, increments, e.largest, e.rms,
             e.energy, nanoseconds / increments, 1e-3 * nanoseconds);
  std::fflush(stdout);
}

// Compares with the path in `finest` increments, for up to finest/16 increments. Errors of tractions are relative to
// the stresses normal and shear.
void refine(const Law& law, const char* name, Path path, double normal, double shear, int finest) {
  const Drive exact(law, path, finest);
  double spent = 0.0;
  for (std::size_t i = 0; i < kPoints; ++i) spent += exact.answers[(kChecks - 1) * kPoints + i].dissipated;
  for (int increments = kChecks; increments <= finest / 16; increments *= 2) {
    const Drive drive(law, path, increments);
    Errors e;
    for (std::size_t k = 0; k < exact.answers.size(); ++k) {
      const Answer &a = drive.answers[k], &b = exact.answers[k];
      const double error =
          std::max(std::abs(a.sigma - b.sigma) / normal, std::hypot(a.tau_s - b.tau_s, a.tau_t - b.tau_t) / shear);
      e.largest = std::max(e.largest, error);
      e.rms += error * error / static_cast<double>(exact.answers.size());
      if (k >= (kChecks - 1) * kPoints) e.energy += std::abs(a.dissipated - b.dissipated) / spent;
    }
    e.rms = std::sqrt(e.rms);
    print(law, name, increments, e, drive.seconds);
  }
}

// Compares with a closed form.
void check(const Law& law, const char* name, Path path, Answer (*answer)(const Jump&)) {
  for (int increments = kChecks; increments <= 1 << 14; increments *= 16) {
    const Drive drive(law, path, increments);
    Errors e;
    for (int check = 0; check < kChecks; ++check) {
      for (std::size_t i = 0; i < kPoints; ++i) {
        const Answer& a = drive.answers[static_cast<std::size_t>(check) * kPoints + i];
        const Answer b = answer(path(i, static_cast<double>(check + 1) / kChecks));
        const double error = std::max(std::abs(a.sigma - b.sigma) / ft, std::abs(a.tau_s - b.tau_s) / c0);
        e.largest = std::max(e.largest, error);
        e.rms += error * error / (kChecks * kPoints);
      }
    }
    e.rms = std::sqrt(e.rms);
    print(law, name, increments, e, drive.seconds);
  }
}

Law joint(const char* law, std::vector<std::pair<std::string, double>> more = {}) {
  more.insert(more.begin(), properties.begin(), properties.end());
  return quoin::test::make_material(quoin::test::load_law(law), {std::move(more), {}, {}});
}

}  // namespace

int main() {
  fmt::print(
      "law,path,increments,largest_error_over_strength,rms_error_over_strength,error_of_dissipation,"
      "ns_per_point_and_increment,us_per_point_and_path\n");
  const Law fracture = joint("fracture_energy");
  refine(fracture, "mixed", mixed, ft, c0, 1 << 20);
  check(fracture, "opening", opening, opening_answer);
  check(fracture, "sliding", sliding, sliding_answer);
  check(fracture, "closing", closing, closing_answer);
  // contact_models/cyclic_joint/LAW.md, "Calibration": Start
  const Law cyclic = joint("cyclic_joint", {{"residual_opening", 0.3},
                                            {"dilation_angle", 15.0},
                                            {"dilation_pressure", 1.5e6},
                                            {"compressive_yield", fc / 3.0},
                                            {"compressive_peak_closure", 0.09e-3},
                                            {"crushing_recovery", 0.5}});
  refine(cyclic, "mixed", mixed, ft, c0, 1 << 16);
  refine(cyclic, "crushing", crushing, fc, fc / 3.0, 1 << 16);  // 3: square root of Cs
}
