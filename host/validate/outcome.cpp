#include "validate/outcome.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "results/read_vtu.h"
#include "results/surface.h"

namespace quoin::validate {

namespace {

namespace fs = std::filesystem;
using reproduce::Curve;

// Shares of the displacement of the top due to one mechanism. Below kSeen the failure mode does not have it, above
// kLeading it is the leading one [assumed; equal for all walls].
constexpr double kSeen = 0.08, kLeading = 0.25, kSlides = 0.5;
constexpr double kSeenSliding = 0.2;
constexpr double kKept = 0.8;  // share of the peak: a conventional limit of a wall's capacity

double median(std::vector<double> values) {
  if (values.empty()) return 0.0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

// Key of contact points in one bed or one course: height in units of 0.1 mm.
long level_of(float y) { return std::lround(y * 1e4); }

double secant(const Curve& curve, double force) {
  for (std::size_t i = 0; i < curve.size(); ++i) {
    if (curve.force[i] >= force && curve.displacement[i] > 0.0) return curve.force[i] / curve.displacement[i];
  }
  return 0.0;
}

// Force of the envelope at a displacement with sign, kN, positive; nothing beyond its end.
std::optional<double> measured_at(const std::vector<std::array<double, 2>>& envelope, double displacement) {
  for (std::size_t i = 1; i < envelope.size(); ++i) {
    const auto &a = envelope[i - 1], &b = envelope[i];
    const double low = std::min(a[0], b[0]), high = std::max(a[0], b[0]);
    if (displacement < low || displacement > high || low == high) continue;
    return std::abs(a[1] + (displacement - a[0]) / (b[0] - a[0]) * (b[1] - a[1]));
  }
  return {};
}

// Least and largest ratio of predicted over measured force. Both sides have equal weight if both were measured.
std::optional<std::array<double, 2>> along_envelope(const WallRow& row, const Curve& curve) {
  constexpr int kFarthest = 10;  // mm
  std::optional<std::array<double, 2>> range;
  for (int d = 1; d <= kFarthest && !curve.empty() && d <= curve.displacement.back(); ++d) {
    const auto out = measured_at(row.envelope, d), back = measured_at(row.envelope, -d);
    if (!out && !back) continue;
    const double ratio = curve.force_at(d) / (out && back ? (*out + *back) / 2 : out ? *out : *back);
    if (!range) range = {ratio, ratio};
    range = {std::min((*range)[0], ratio), std::max((*range)[1], ratio)};
  }
  return range;
}

// Contact points of a bed joint: sums over its length, and least slip.
struct Bed {
  double area = 0.0, crushed = 0.0, least_slip = std::numeric_limits<double>::infinity();
};

}  // namespace

std::string mode_of(const Motion& m) {
  if (m.top <= 0.0) return "F";
  const double spread = m.spread / m.top, sliding = m.sliding / m.top;
  const std::string with_sliding = sliding > kSeenSliding ? "SL" : "";
  if (sliding > kSlides) return spread > kLeading ? "H-SLS" : "SL";
  // Diagonal cracks without loss of force are rocking with open joints.
  if (spread > kLeading && m.kept < kKept) return with_sliding.empty() ? "S" : "H-SSL";
  if (spread > kSeen) return "H-FS" + with_sliding;
  return with_sliding.empty() ? "F" : "H-FSL";
}

std::string leading_mode(const std::string& code) {
  const std::string bare = code.starts_with("H-") ? code.substr(2) : code;
  if (code.starts_with("H-")) return bare.substr(0, 1);
  return bare.starts_with("SL") ? "SL" : bare.substr(0, 1);
}

Motion read_motion(const fs::path& run_folder, double top_displacement) {
  Motion motion;
  motion.top = top_displacement;
  // The second of two frames: those at the begin and at the end of the run.
  const VtuFile file(run_folder / "joints_0001.vtu");
  const std::size_t points = file.grid().points();
  const auto normal = file.read<float>("normal", VtkRows::point, 3);
  const auto area = file.read<float>("area_m2", VtkRows::point),
             opening = file.read<float>("opening_m", VtkRows::point);
  const auto slip = file.read<float>("slip_m", VtkRows::point);
  const auto crack = file.read<std::int32_t>("crack", VtkRows::point);
  const auto a = file.read<std::int32_t>("block_a", VtkRows::point),
             b = file.read<std::int32_t>("block_b", VtkRows::point);
  struct Joint {
    double area = 0.0, opening = 0.0;
    float height = 0.0f;
    int points = 0;
  };
  std::map<std::pair<int, int>, Joint> heads;
  std::map<long, Bed> beds;
  for (std::size_t i = 0; i < points; ++i) {
    const float y = file.grid().position[3 * i + 1];
    if (std::abs(normal[3 * i + 1]) > 0.5f) {
      Bed& bed = beds[level_of(y)];
      bed.area += area[i];
      bed.crushed += crack[i] == static_cast<int>(Crack::crushed) ? area[i] : 0.0;
      bed.least_slip = std::min(bed.least_slip, static_cast<double>(slip[i]));
    } else if (std::abs(normal[3 * i]) > 0.5f) {
      Joint& joint = heads[{a[i], b[i]}];
      joint.area += area[i], joint.opening += area[i] * std::max(0.0f, opening[i]);
      joint.height += y, ++joint.points;
    }
  }
  std::map<long, double> courses;
  for (const auto& [blocks, joint] : heads)
    courses[level_of(joint.height / static_cast<float>(joint.points))] += joint.opening / joint.area;
  std::vector<double> spreads;
  for (const auto& [height, spread] : courses) spreads.push_back(spread);
  motion.spread = median(spreads);
  for (const auto& [height, bed] : beds) {
    motion.sliding = std::max(motion.sliding, bed.least_slip);
    motion.crushed = std::max(motion.crushed, bed.crushed / bed.area);
  }
  return motion;
}

double peak_of(const reproduce::RunResult& run) {
  if (!run.cycles) return run.curve.peak();
  const Curve envelope = reproduce::envelope_of(run.curve, *run.cycles);
  const auto [lowest, highest] = std::minmax_element(envelope.force.begin(), envelope.force.end());
  return envelope.empty() ? run.curve.peak() : (*highest - *lowest) / 2;
}

Outcome outcome_of(const WallRow& row, const TestScene& scene, reproduce::RunResult run) {
  Outcome o;
  if (run.cycles) {
    for (const reproduce::Loop& loop : reproduce::loops_of(run.curve, *run.cycles)) {
      if (loop.repetition == 0) o.loops.push_back(loop);
    }
  }
  for (double& d : run.curve.displacement) d *= scene.top_displacement;
  const Curve& curve = run.curve;
  const double height = 1e3 * row.height;  // mm
  o.peak = peak_of(run);
  o.drift_at_peak = 100.0 * curve.peak_displacement() / height;
  if (!run.cycles) {
    const double lost = curve.displacement_after_peak(0.8);
    if (lost > 0.0) o.ultimate_drift = 100.0 * lost / height;
    o.along_envelope = along_envelope(row, curve);
  }
  o.initial_stiffness = secant(curve, 0.1 * curve.peak());
  o.effective_stiffness = secant(curve, 0.7 * curve.peak());
  double farthest = 0.0;
  for (const double d : curve.displacement) farthest = std::max(farthest, std::abs(d));
  o.motion = read_motion(run.folder, 1e-3 * farthest);
  double last = curve.last_force();
  if (run.cycles) {
    const Curve envelope = reproduce::envelope_of(curve, *run.cycles);  // begins at the farthest negative displacement
    if (!envelope.empty()) last = (std::abs(envelope.force.front()) + std::abs(envelope.force.back())) / 2;
  }
  o.motion.kept = o.peak > 0.0 ? last / o.peak : 1.0;
  o.mode = mode_of(o.motion);
  o.run = std::move(run);
  return o;
}

}  // namespace quoin::validate
