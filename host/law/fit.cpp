#include "law/fit.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <limits>
#include <numbers>
#include <optional>

#include "base/error.h"
#include "files/gnuplot.h"
#include "law/material_point.h"
#include "law/property_text.h"

namespace quoin {

namespace {

constexpr const char* kKindNames[] = {"couplet", "triplet", "prism"};

// Residuals; none for a curve that cannot run, as the law refuses the properties or cannot carry the stress.
using Residuals = std::optional<Eigen::VectorXd>;

double trapezoid(const std::vector<double>& x, const std::vector<double>& y) {
  double sum = 0.0;
  for (std::size_t i = 1; i < x.size(); ++i) sum += 0.5 * (y[i] + y[i - 1]) * (x[i] - x[i - 1]);
  return sum;
}

double largest(const std::vector<double>& values) { return *std::max_element(values.begin(), values.end()); }

// Quantile 0.975 of Student's t (Cornish-Fisher about the normal quantile; better than 1 % from 3 degrees of freedom
// on).
double student(double freedom) {
  constexpr double z = 1.959963984540054;
  const double z3 = z * z * z, z5 = z3 * z * z;
  return z + (z3 + z) / (4 * freedom) + (5 * z5 + 16 * z3 + 3 * z) / (96 * freedom * freedom);
}

class Fit {
 public:
  Fit(const Law& law, const std::vector<MeasuredCurve>& curves, const std::vector<PropertySetting>& given)
      : law_(law), curves_(curves), given_(given) {
    weights_.assign(curves.size(), 1.0);
    guess();
  }
  bool empty() const { return ids_.empty(); }

  // None where the cohesion vanishes: the curves show friction alone.
  std::optional<FitResult> run() {
    int rows = 0;
    for (const MeasuredCurve& curve : curves_) rows += static_cast<int>(curve.jump.size());
    const int unknowns = static_cast<int>(ids_.size());
    if (rows <= unknowns) throw Error(Exit::bad_input, fmt::format("fit: {} rows for {} unknowns", rows, unknowns));

    // Weights assume equal relative noise first, then the noise of each curve's own residuals.
    for (std::size_t k = 0; k < curves_.size(); ++k) weights_[k] = 1.0 / peak(curves_[k]);
    if (!minimise()) return std::nullopt;
    noise();
    for (std::size_t k = 0; k < curves_.size(); ++k) {
      // The bound keeps a curve without residuals from outweighing all others.
      weights_[k] = 1.0 / std::max(noise_[k], 1e-6 * peak(curves_[k]));
    }
    if (!minimise()) return std::nullopt;
    noise();
    return report();
  }

 private:
  static double peak(const MeasuredCurve& curve) {
    double result = 0.0;
    for (const double stress : curve.stress) result = std::max(result, std::abs(stress));
    return result;
  }
  bool is_given(const std::string& id) const {
    return std::any_of(given_.begin(), given_.end(), [&](const PropertySetting& s) { return s.id == id; });
  }
  double number(const std::string& id, double otherwise) const {
    double value = otherwise;
    for (const PropertySetting& s : given_) {
      if (s.id == id && s.numbers.size() == 1) value = s.numbers[0];
    }
    return value;
  }
  void unknown(const std::string& id, double start) {
    if (is_given(id) || find_property(*law_.law, id) == nullptr) return;
    if (!(start > 0.0)) {
      throw Error(Exit::bad_input,
                  fmt::format("fit: no start value for {}: the curves do not show it; give it by --set", id));
    }
    ids_.push_back(id);
    logs_.conservativeResize(static_cast<Eigen::Index>(ids_.size()));
    logs_[logs_.size() - 1] = std::log(start);
  }
  static bool is_angle(const std::string& id) { return id == "friction_angle"; }
  static double value_of(const std::string& id, double log) {
    return is_angle(id) ? std::atan(std::exp(log)) * 180.0 / std::numbers::pi : std::exp(log);
  }

  // Start values by estimates from the curves: peaks, areas, and the line through the peaks of the triplets.
  void guess() {
    const double kn = number("normal_stiffness", 0.0), ks = number("shear_stiffness", 0.0);
    if (!(kn > 0.0) || !(ks > 0.0)) {
      throw Error(Exit::bad_input,
                  "fit: give normal_stiffness and shear_stiffness by --set: the initial slopes of the curves");
    }
    double ft = 0.0, G1 = 0.0, fc = 0.0, Gc = 0.0, n1 = 0.0, nc = 0.0;
    std::vector<std::array<double, 3>> triplets;  // pressure, peak, last
    for (const MeasuredCurve& curve : curves_) {
      if (curve.kind == TestKind::couplet) {
        ft += largest(curve.stress), G1 += trapezoid(curve.jump, curve.stress), n1 += 1.0;
      } else if (curve.kind == TestKind::triplet) {
        double pressure = 0.0;
        for (const double sigma : curve.normal) pressure -= sigma / static_cast<double>(curve.normal.size());
        const std::size_t tail = std::max<std::size_t>(1, curve.stress.size() / 10);
        double last = 0.0;
        for (std::size_t i = curve.stress.size() - tail; i < curve.stress.size(); ++i) last += curve.stress[i];
        triplets.push_back({pressure, largest(curve.stress), last / static_cast<double>(tail)});
      } else {
        std::vector<double> closing, stress, closure;
        for (std::size_t i = 0; i < curve.jump.size(); ++i) {
          stress.push_back(-curve.stress[i]);
          closure.push_back(std::max(0.0, -curve.jump[i] - stress.back() / kn));
        }
        const double residual = number("compressive_strength_residual", 0.0);
        double area = 0.0;
        for (std::size_t i = 1; i < stress.size(); ++i) {
          area += std::max(0.0, 0.5 * (stress[i] + stress[i - 1]) - residual) * (closure[i] - closure[i - 1]);
        }
        fc += largest(stress), Gc += area, nc += 1.0;
      }
    }
    if (n1 > 0.0) {
      unknown("tensile_strength", ft / n1);
      unknown("fracture_energy_tension", std::max(G1 / n1, 1.1 * ft * ft / (n1 * n1) / (2 * kn)));
    }
    if (!triplets.empty()) {
      double mean_p = 0.0, mean_t = 0.0, pp = 0.0, pt = 0.0;
      const double n = static_cast<double>(triplets.size());
      for (const auto& t : triplets) mean_p += t[0] / n, mean_t += t[1] / n;
      for (const auto& t : triplets) pp += (t[0] - mean_p) * (t[0] - mean_p), pt += (t[0] - mean_p) * (t[1] - mean_t);
      double mu = pp > 1e-6 * mean_p * mean_p && pp > 0.0 ? pt / pp : 0.0;
      if (!(mu > 0.0) && mean_p > 0.0) {  // one confinement: friction from the end of the curve
        for (const auto& t : triplets) mu += t[2] / t[0] / n;
      }
      if (is_given("friction_angle")) mu = std::tan(number("friction_angle", 0.0) * std::numbers::pi / 180.0);
      double c0 = std::max(mean_t - mu * mean_p, 0.05 * mean_t);
      if (is_given("cohesion")) c0 = number("cohesion", c0);
      const double cr = number("cohesion_residual", 0.0);
      double G2 = 0.0;
      for (const MeasuredCurve& curve : curves_) {
        if (curve.kind != TestKind::triplet) continue;
        double last_slip = 0.0, last_excess = 0.0, area = 0.0;
        for (std::size_t i = 0; i < curve.jump.size(); ++i) {
          const double slip = std::max(last_slip, curve.jump[i] - curve.stress[i] / ks);
          const double excess = std::max(0.0, curve.stress[i] + mu * curve.normal[i] - cr);
          area += 0.5 * (excess + last_excess) * (slip - last_slip);
          last_slip = slip, last_excess = excess;
        }
        G2 += area / n;
      }
      unknown("cohesion", c0);
      unknown("friction_angle", mu);
      if (c0 > cr) {
        unknown("fracture_energy_shear", std::max(G2, 2.0 * c0 * c0 / ks));
      } else if (!is_given("fracture_energy_shear") && find_property(*law_.law, "fracture_energy_shear") != nullptr) {
        notes_.push_back("fracture_energy_shear: left out; curves whose cohesion does not soften do not determine it");
      }
      least_cohesion_ = cr > 0.0 ? 0.0 : 1e-6 * mean_t;
    }
    if (nc > 0.0) {
      const double strength = fc / nc;
      unknown("compressive_strength", strength);
      unknown("fracture_energy_compression", std::max(Gc / nc, 1.2 * strength * strength / kn));
    }
  }

  std::vector<PropertySetting> settings(const Eigen::VectorXd& logs) const {
    std::vector<PropertySetting> result = given_;
    for (std::size_t i = 0; i < ids_.size(); ++i) {
      result.push_back({ids_[i], {value_of(ids_[i], logs[static_cast<Eigen::Index>(i)])}, {}, {"fitted"}});
    }
    return result;
  }

  std::vector<std::vector<double>> model(const Eigen::VectorXd& logs) const {
    const auto all = settings(logs);
    std::vector<std::vector<double>> result;
    for (const MeasuredCurve& curve : curves_) {
      // Each curve has only the properties that its own test determines. A triplet runs at the pressure of its test.
      std::vector<PropertySetting> own = all;
      if (curve.kind != TestKind::prism) {
        std::erase_if(own, [&](const PropertySetting& s) {
          return s.source.text == "fitted" && (s.id == "compressive_strength" || s.id == "fracture_energy_compression");
        });
        if (!is_given("compressive_strength")) {
          std::erase_if(own, [](const PropertySetting& s) { return s.id == "compressive_strength_residual"; });
        }
      }
      MaterialPoint point(std::make_shared<const Material>(law_, own), "");
      std::vector<double> stress;
      for (std::size_t i = 0; i < curve.jump.size(); ++i) {
        if (curve.kind == TestKind::triplet) {
          if (i == 0) point.press_to(curve.normal[i], 0.0, 0.0);
          stress.push_back(point.press_to(curve.normal[i], curve.jump[i], 0.0).traction[1]);
        } else {
          stress.push_back(point.move_to(curve.jump[i], 0.0, 0.0).traction[0]);
        }
      }
      result.push_back(std::move(stress));
    }
    return result;
  }

  Residuals residuals(const Eigen::VectorXd& logs) const {
    std::vector<std::vector<double>> stress;
    try {
      stress = model(logs);
    } catch (const Error&) {
      return std::nullopt;
    }
    std::vector<double> values;
    for (std::size_t k = 0; k < curves_.size(); ++k) {
      for (std::size_t i = 0; i < stress[k].size(); ++i)
        values.push_back(weights_[k] * (stress[k][i] - curves_[k].stress[i]));
    }
    return Eigen::Map<Eigen::VectorXd>(values.data(), static_cast<Eigen::Index>(values.size()));
  }

  Eigen::MatrixXd jacobian(const Eigen::VectorXd& logs, const Eigen::VectorXd& here) const {
    constexpr double kStep = 1e-4;  // step of the logarithm, wide enough to average over single rows near a peak
    Eigen::MatrixXd result(here.size(), logs.size());
    for (Eigen::Index j = 0; j < logs.size(); ++j) {
      Eigen::VectorXd up = logs, down = logs;
      up[j] += kStep, down[j] -= kStep;
      const Residuals above = residuals(up), below = residuals(down);
      if (above && below) {
        result.col(j) = (*above - *below) / (2 * kStep);
      } else if (above) {  // at the bound of what the law admits
        result.col(j) = (*above - here) / kStep;
      } else if (below) {
        result.col(j) = (here - *below) / kStep;
      } else {
        throw Error(Exit::numerical,
                    fmt::format("fit: {} cannot be varied about {:.4g}", ids_[static_cast<std::size_t>(j)],
                                value_of(ids_[static_cast<std::size_t>(j)], logs[j])));
      }
    }
    return result;
  }

  std::optional<Eigen::Index> fitted_cohesion() const {
    const auto found = std::find(ids_.begin(), ids_.end(), "cohesion");
    if (found == ids_.end() || least_cohesion_ == 0.0) return std::nullopt;
    return found - ids_.begin();
  }

  // Half of the 95 % interval of each logarithm; infinite where the curves do not show the property.
  Eigen::VectorXd half_widths(const Eigen::VectorXd& here) const {
    const auto freedom = static_cast<double>(here.size() - logs_.size());
    const Eigen::MatrixXd normal = jacobian_.transpose() * jacobian_;
    const Eigen::MatrixXd inverse = normal.ldlt().solve(Eigen::MatrixXd::Identity(logs_.size(), logs_.size()));
    const double spread = student(freedom) * here.norm() / std::sqrt(freedom);
    // The inverse of a singular matrix is not positive.
    return inverse.diagonal().unaryExpr(
        [&](double v) { return v > 0.0 ? spread * std::sqrt(v) : std::numeric_limits<double>::infinity(); });
  }

  // True where the interval about the cohesion itself, c (1 -+ half), holds 0.
  bool cohesion_may_be_none(const Eigen::VectorXd& half) const {
    const auto cohesion = fitted_cohesion();
    return cohesion && half[*cohesion] >= 1.0;
  }

  // Levenberg-Marquardt with Marquardt's scaling. False where the cohesion vanishes.
  bool minimise() {
    if (empty()) return true;
    const auto cohesion = fitted_cohesion();
    Residuals here = residuals(logs_);
    if (!here) {
      model(logs_);  // throws the law's own message
      throw Error(Exit::numerical, "fit: the start values cannot be run");
    }
    double damping = 1e-3, cost = here->squaredNorm();
    for (int iteration = 0; iteration < 200; ++iteration) {
      // A logarithm has no zero: below a millionth of the peaks there is none.
      if (cohesion && std::exp(logs_[*cohesion]) < least_cohesion_) return false;
      ++iterations_;
      jacobian_ = jacobian(logs_, *here);
      const Eigen::MatrixXd normal = jacobian_.transpose() * jacobian_;
      const Eigen::VectorXd gradient = jacobian_.transpose() * *here;
      bool better = false, small = false;
      while (!better && damping < 1e12) {
        Eigen::MatrixXd damped = normal;
        damped.diagonal() += damping * (normal.diagonal().array() + 1e-12 * normal.diagonal().maxCoeff()).matrix();
        Eigen::VectorXd step = -damped.ldlt().solve(gradient);
        const double size = step.cwiseAbs().maxCoeff();
        if (size > 0.5) step *= 0.5 / size;  // a factor of 1.65 at most
        const Eigen::VectorXd next = logs_ + step;
        const Residuals there = residuals(next);
        if (there && there->squaredNorm() < cost) {
          small = step.cwiseAbs().maxCoeff() < 1e-9 || cost - there->squaredNorm() < 1e-13 * cost;
          logs_ = next;
          here = there;
          cost = there->squaredNorm();
          damping = std::max(damping / 5, 1e-12);
          better = true;
        } else {
          damping *= 4;
          if (size < 1e-12) break;
        }
      }
      if (!better || small) {
        jacobian_ = jacobian(logs_, *here);
        return true;
      }
      damping = std::min(damping, 1e3);
    }
    jacobian_ = jacobian(logs_, *here);
    if (cohesion_may_be_none(half_widths(*here))) return false;
    throw Error(Exit::numerical, "fit: no convergence in 200 iterations; check signs and units of the curves");
  }

  void noise() {
    fitted_ = model(logs_);
    noise_.clear();
    for (std::size_t k = 0; k < curves_.size(); ++k) {
      double sum = 0.0;
      for (std::size_t i = 0; i < fitted_[k].size(); ++i) sum += std::pow(fitted_[k][i] - curves_[k].stress[i], 2);
      noise_.push_back(std::sqrt(sum / static_cast<double>(fitted_[k].size())));
    }
  }

  std::optional<FitResult> report() const {
    const Eigen::VectorXd half = half_widths(*residuals(logs_));
    if (cohesion_may_be_none(half)) return std::nullopt;
    FitResult result;
    for (std::size_t i = 0; i < ids_.size(); ++i) {
      const auto j = static_cast<Eigen::Index>(i);
      FittedProperty property;
      property.id = ids_[i];
      const quoin_property_info& info = *find_property(*law_.law, property.id);
      property.symbol = law_text(info.symbol), property.unit = law_text(info.unit);
      property.value = value_of(ids_[i], logs_[j]);
      property.low = value_of(ids_[i], logs_[j] - half[j]);
      property.high = value_of(ids_[i], logs_[j] + half[j]);
      if (!(half[j] <= 5.0)) {
        throw Error(Exit::numerical,
                    fmt::format("fit: the curves do not determine {} (found {:.4g} {}); give it by --set", property.id,
                                property.value, property.unit));
      }
      result.properties.push_back(property);
    }
    result.model = fitted_;
    result.noise = noise_;
    result.iterations = iterations_;
    result.notes = notes_;
    result.settings = settings(logs_);
    return result;
  }

  const Law& law_;
  const std::vector<MeasuredCurve>& curves_;
  const std::vector<PropertySetting>& given_;
  std::vector<std::string> ids_;
  Eigen::VectorXd logs_;
  std::vector<double> weights_, noise_;
  Eigen::MatrixXd jacobian_;
  std::vector<std::vector<double>> fitted_;
  std::vector<std::string> notes_;
  double least_cohesion_ = 0.0;  // Pa; 0 where cohesion has a residual, or triplets are none
  int iterations_ = 0;
};

}  // namespace

MeasuredCurve read_curve(TestKind kind, const std::string& file) {
  const CsvTable table = read_csv(file);
  const bool triplet = kind == TestKind::triplet;
  const int jump = table.column(triplet ? "ds" : "dn", "m");
  const int stress = table.column(triplet ? "tau" : "sigma", "Pa");
  const int normal = table.column("sigma", "Pa");
  if (jump < 0 || stress < 0 || normal < 0) {
    throw Error(Exit::bad_input, fmt::format("{}: a {} needs the columns {}, with these units or without", file,
                                             kKindNames[static_cast<int>(kind)],
                                             triplet ? "ds (m), tau (Pa), sigma (Pa)" : "dn (m), sigma (Pa)"));
  }
  MeasuredCurve curve;
  curve.kind = kind;
  curve.file = file;
  for (std::size_t i = 0; i < table.rows.size(); ++i) {
    const auto& row = table.rows[i];
    if (triplet && row[normal] > 0.0) {
      throw Error(Exit::bad_input,
                  fmt::format("{}:{}: sigma = {}: a triplet is compressed, and compression is negative", file,
                              table.lines[i], row[normal]));
    }
    if (kind == TestKind::prism && row[jump] > 0.0) {
      throw Error(Exit::bad_input, fmt::format("{}:{}: dn = {}: a prism closes, and closing is negative", file,
                                               table.lines[i], row[jump]));
    }
    curve.jump.push_back(row[jump]);
    curve.stress.push_back(row[stress]);
    curve.normal.push_back(row[normal]);
  }
  if (curve.jump.size() < 5)
    throw Error(Exit::bad_input, fmt::format("{}: {} rows; a curve needs at least 5", file, curve.jump.size()));
  return curve;
}

FitResult fit_properties(const Law& law, const std::vector<MeasuredCurve>& curves,
                         const std::vector<PropertySetting>& given) {
  if (curves.empty()) throw Error(Exit::bad_input, "fit: no curve was given");
  // Modes without a curve have no strength drop, unless given: they need no fracture energy.
  Fit fit(law, curves, given);
  if (fit.empty()) {
    throw Error(
        Exit::bad_input,
        fmt::format("fit: nothing to find: law '{}' has no property that the curves determine, beside those given",
                    law.law->id));
  }
  if (const auto result = fit.run()) return *result;
  std::vector<PropertySetting> dry = given;
  dry.push_back({"cohesion", {0.0}, {}, {"without cohesion"}});
  FitResult result = *Fit(law, curves, dry).run();
  result.no_cohesion = true;
  return result;
}

std::string plot_fit(const std::vector<MeasuredCurve>& curves, const FitResult& result, const std::string& folder) {
  std::string script =
      "set terminal pngcairo size 1500,500 font 'sans,11' noenhanced\nset grid\nset multiplot layout 1,3\n";
  for (const TestKind kind : {TestKind::couplet, TestKind::triplet, TestKind::prism}) {
    const bool triplet = kind == TestKind::triplet;
    std::string plots;
    for (std::size_t k = 0; k < curves.size(); ++k) {
      if (curves[k].kind != kind) continue;
      const double sign = kind == TestKind::prism ? -1.0 : 1.0;
      script += fmt::format("$c{} << EOD\n", k);
      for (std::size_t i = 0; i < curves[k].jump.size(); ++i) {
        script += fmt::format("{:.9g} {:.9g} {:.9g}\n", sign * curves[k].jump[i] * 1e3,
                              sign * curves[k].stress[i] * 1e-6, sign * result.model[k][i] * 1e-6);
      }
      script += "EOD\n";
      const std::string name = std::filesystem::path(curves[k].file).stem().string();
      plots += fmt::format(
          "{}$c{} using 1:2 with points pt 6 ps 0.6 lc {} title {}, $c{} using 1:3 with lines lw 2 lc {} notitle",
          plots.empty() ? "" : ", ", k, k + 1, gnuplot_text(name), k, k + 1);
    }
    if (plots.empty()) {
      script += "set multiplot next\n";
      continue;
    }
    script += fmt::format("set title '{}'\nset xlabel '{} [mm]'\nset ylabel '{} [MPa]'\nplot {}\n",
                          kKindNames[static_cast<int>(kind)],
                          triplet                   ? "sliding"
                          : kind == TestKind::prism ? "closing"
                                                    : "opening",
                          triplet ? "tau" : "stress", plots);
  }
  script += "unset multiplot\n";
  const std::filesystem::path picture = std::filesystem::path(folder) / "fit.png";
  draw_picture_alone(picture, script);
  return picture.string();
}

}  // namespace quoin
