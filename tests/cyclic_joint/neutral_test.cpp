// With neutral values cyclic_joint is equal to fracture_energy (contact_models/cyclic_joint/LAW.md, "Neutral values").
// Compares both laws along every path test of fracture_energy, up to the intended differences.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "law/path_file.h"

namespace {

using quoin::PathFile;
using quoin::PointResult;

double property(const PathFile& path, const std::string& id, double otherwise) {
  for (const quoin::PropertySetting& setting : path.properties) {
    if (setting.id == id) return setting.numbers[0];
  }
  return otherwise;
}

// Detects the intended differences of the law's page along a path of fracture_energy.
class Agreement {
 public:
  Agreement(const PathFile& path, const quoin::Law& law)
      : psi0_(property(path, "dilation_angle", 0.0)),
        dry_(path.initial == "dry"),
        xi_t_(law.state_index("xi_t")),
        slip_(law.state_index("slip")),
        w_(law.state_index("w")) {
    for (const quoin::PropertySetting& setting : path.properties) {
      if (setting.id == "coupling") two_damages_ = setting.text == "none";
    }
  }

  // Returns the reason why the laws differ from this step on; empty while they agree.
  std::string ends_at(const PointResult& was, const PointResult& now, double slip_from_seat, double F) const {
    const bool open = (now.flags & QUOIN_FLAG_OPEN) != 0, slips = (now.flags & QUOIN_FLAG_SLIPPING) != 0;
    const bool slipped = was.state[slip_] > 0.0, crushed = was.state[w_] > 0.0;
    const double p = std::max(0.0, -now.traction[0]), tau = std::hypot(now.traction[1], now.traction[2]);
    if (two_damages_ && now.state[xi_t_] > 0.0 && (tau > 0.0 || slipped)) return "one damage here, two there";
    if (open && slips) return "slip with opening";
    if (open && slipped) return "slip does not move kappa";
    if (open && crushed) return "crushing takes bond";
    if (tau > 0.0 && crushed) return "crushing takes bond";
    if (tau > 0.0 && std::sqrt(p * p + 9.0 * tau * tau) > F * (1.0 - 1e-9)) return "shear meets the cap";
    if (psi0_ > 0.0 && dry_ && slips) return "uplift on dry joints too";
    if (psi0_ > 0.0 && std::abs(slip_from_seat - now.state[slip_]) > 1e-12 * now.state[slip_])
      return "uplift comes down";
    return {};
  }

 private:
  double psi0_;
  bool dry_;
  std::size_t xi_t_, slip_, w_;
  bool two_damages_ = false;
};

TEST(Neutral, EveryPathOfFractureEnergyAsFarAsThePageSays) {
  const quoin::Law energy = quoin::Law::find("fracture_energy"), cyclic = quoin::Law::find("cyclic_joint");
  const std::size_t g_s = cyclic.state_index("g_s"), w = energy.state_index("w");
  int to_the_end = 0, files = 0;
  std::size_t steps = 0;
  double worst = 0.0;
  std::map<std::string, int> ends;
  std::vector<std::filesystem::path> paths;
  for (const auto& entry : std::filesystem::directory_iterator(QUOIN_PATHS_FOLDER)) paths.push_back(entry.path());
  std::sort(paths.begin(), paths.end());
  for (const auto& file : paths) {
    if (file.extension() != ".toml") continue;
    PathFile path = quoin::read_path_file(file.string());
    if (path.law != "fracture_energy") continue;
    ++files;
    const auto rows = run_path(path).rows;
    const Agreement agreement(path, energy);
    std::erase_if(path.properties, [](const auto& setting) { return setting.id == "coupling"; });
    std::shared_ptr<const quoin::Material> material;
    try {
      material = std::make_shared<const quoin::Material>(cyclic, path.properties);
    } catch (const std::exception& error) {
      ++ends["refused: " + std::string(error.what()).substr(0, 160)];
      continue;
    }
    quoin::MaterialPoint point(material, path.initial.empty() ? "bonded" : path.initial);
    const double fc = property(path, "compressive_strength", HUGE_VAL);
    double scale = std::max(property(path, "tensile_strength", 0.0), property(path, "cohesion", 0.0));
    for (const PointResult& row : rows) {
      for (const double t : row.traction) scale = std::max(scale, std::abs(t));
    }
    std::string reason;
    for (std::size_t k = 1; k < rows.size() && !::testing::Test::HasFailure(); ++k) {
      const auto& [dn, ds, dt] = rows[k].jump;
      const PointResult& now = point.move_to(dn, ds, dt);
      const double r = std::hypot(now.state[g_s], now.state[g_s + 1]);
      reason = agreement.ends_at(rows[k - 1], rows[k], r, rows[k].state[w] > 0.0 ? 0.0 : fc);
      if (!reason.empty()) break;
      ++steps;
      for (int c = 0; c < 3; ++c) {
        const double gap = std::abs(now.traction[c] - rows[k].traction[c]) / scale;
        worst = std::max(worst, gap);
        EXPECT_LT(gap, 1e-12) << path.file << " row " << k << " component " << c << ": " << now.traction[c] << " and "
                              << rows[k].traction[c];
      }
    }
    if (reason.empty()) ++to_the_end;
    if (!reason.empty()) ++ends[reason];
  }
  std::printf("%d of %d paths to the end, %zu steps, largest difference %.1e of the scale\n", to_the_end, files, steps,
              worst);
  for (const auto& [reason, count] : ends) std::printf("%3d end at: %s\n", count, reason.c_str());
  EXPECT_GE(to_the_end, 50);
}

}  // namespace
