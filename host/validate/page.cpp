#include "validate/page.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "files/markup.h"

namespace quoin::validate {

namespace {

const char* const kHead = R"(<!DOCTYPE html>
<html lang="en"><head><meta charset="utf-8"><meta name="viewport" content="width=device-width, initial-scale=1">
<title>Quoin: walls that were tested, predicted by one rule</title>
<style>
body { font: 16px/1.5 sans-serif; color: #222; max-width: 66rem; margin: 2rem auto; padding: 0 1rem; }
h2 { margin-top: 3rem; border-top: 3px solid #0072b2; padding-top: .5rem; }
table { border-collapse: collapse; font-size: .9rem; margin: 1rem 0; }
th, td { border-bottom: 1px solid #ddd; padding: .2rem .7rem .2rem 0; text-align: left; vertical-align: top; }
td.n, th.n { text-align: right; }
.far { color: #b3321e; font-weight: bold; }
.pair { display: flex; flex-wrap: wrap; gap: 1rem; align-items: flex-start; }
.pair > * { flex: 1 1 24rem; max-width: 31rem; min-width: 0; }
img, svg { max-width: 100%; height: auto; border: 1px solid #ddd; }
.small { color: #555; font-size: .9rem; }
</style></head><body>
)";

std::string given_text(const Given& value, const char* format_unit) {
  return value ? fmt::format("{:.3g}{}", *value, format_unit) : "-";
}

std::string statistics_row(const std::string& name, const std::vector<double>& ratios) {
  const Statistics s = statistics_of(ratios);
  const auto cell = [&](std::size_t least, double value) {
    return fmt::format("<td class=\"n\">{}</td>", ratios.size() >= least ? fmt::format("{:.2f}", value) : "-");
  };
  return fmt::format("<tr><td>{}</td><td class=\"n\">{}</td>{}{}{}</tr>\n", escaped(name), s.count, cell(1, s.mean),
                     cell(1, s.median), cell(2, s.variation));
}

std::string statistics_table(const Campaign& campaign) {
  std::string out =
      "<table><tr><th>Ratio of predicted to measured peak</th><th class=\"n\">walls</th><th class=\"n\">mean</th>"
      "<th class=\"n\">median</th><th class=\"n\">coefficient of variation</th></tr>\n";
  out += statistics_row("all walls", ratios_of(campaign, false));
  out += statistics_row("without those more than 15 % above a rigid wall's equilibrium", ratios_of(campaign, true));
  std::map<std::string, std::vector<double>> by_campaign, by_mode;
  for (const Prediction& p : campaign.done) {
    by_campaign[p.row.campaign].push_back(p.ratio());
    by_mode[p.row.failure_mode.empty() ? "not given" : p.row.failure_mode].push_back(p.ratio());
  }
  for (const auto& [name, ratios] : by_campaign) out += statistics_row("campaign " + name, ratios);
  for (const auto& [name, ratios] : by_mode) out += statistics_row("failure in the test " + name, ratios);
  return out + "</table>\n";
}

std::string walls_table(const Campaign& campaign) {
  std::string out =
      "<table><tr><th>No.</th><th>Wall</th><th class=\"n\">predicted kN</th><th class=\"n\">measured kN (+/-)</th>"
      "<th class=\"n\">ratio</th><th class=\"n\">N L/(2 H0) and weight, kN</th><th class=\"n\">measured over it</th>"
      "<th>mode predicted</th><th>measured</th><th class=\"n\">drift at peak %, predicted / measured</th>"
      "<th class=\"n\">ultimate drift %, predicted / measured</th><th class=\"n\">stiffness kN/mm, initial / to 70 "
      "%</th></tr>\n";
  for (const Prediction& p : campaign.done) {
    const Outcome& o = p.outcome;
    out += fmt::format(
        "<tr><td>{0}</td><td><a href=\"#{1}\">{2}</a></td><td class=\"n\">{3:.1f}</td><td class=\"n\">{4} / {5}</td>"
        "<td class=\"n{6}\">{7:.2f}</td><td class=\"n\">{8:.1f}</td><td class=\"n{9}\">{10:.2f}</td><td>{11}</td>"
        "<td{12}>{13}</td><td class=\"n\">{14:.2f} / {15}</td><td class=\"n\">{16} / {17}</td>"
        "<td class=\"n\">{18:.1f} / {19:.1f}</td></tr>\n",
        escaped(p.row.number), p.row.folder_name(), escaped(p.row.name()), o.peak, given_text(p.row.peak_positive, ""),
        given_text(p.row.peak_negative, ""), std::abs(p.ratio() - 1) > 0.2 ? " far" : "", p.ratio(),
        rocking_force_with_weight(p.row), p.within_equilibrium() ? "" : " far", p.beyond_equilibrium(), o.mode,
        p.mode_known() && !p.mode_met() ? " class=\"far\"" : "", escaped(p.row.failure_mode), o.drift_at_peak,
        given_text(p.row.drift_at_peak, ""), given_text(o.ultimate_drift, ""), given_text(p.row.ultimate_drift, ""),
        o.initial_stiffness, o.effective_stiffness);
  }
  return out + "</table>\n";
}

std::string bands_table(const Campaign& campaign) {
  if (campaign.bands.empty()) return "";
  std::string out =
      "<table><tr><th>Scatter of properties, as the rule states it</th><th class=\"n\">samples</th>"
      "<th class=\"n\">peak kN, 16 %</th><th class=\"n\">median</th><th class=\"n\">84 %</th>"
      "<th class=\"n\">measured</th></tr>\n";
  for (const Band& b : campaign.bands)
    out += fmt::format(
        "<tr><td>{}</td><td class=\"n\">{}</td><td class=\"n\">{:.1f}</td><td class=\"n\">{:.1f}</td><td "
        "class=\"n\">{:.1f}</td><td class=\"n\">{:.1f}</td></tr>\n",
        escaped(b.row.name()), b.peaks.size(), b.quantile(0.16), b.quantile(0.5), b.quantile(0.84), b.row.peak());
  return out + "</table>\n";
}

std::string loops_table(const Prediction& p) {
  if (p.outcome.loops.empty()) return "";
  std::string out =
      "<table><tr><th class=\"n\">drift of the first cycle, %</th><th class=\"n\">energy dissipated, J</th>"
      "<th class=\"n\">equivalent damping E/(2 pi F d), %</th></tr>\n";
  for (const reproduce::Loop& loop : p.outcome.loops)
    out += fmt::format("<tr><td class=\"n\">{:.2f}</td><td class=\"n\">{:.3g}</td><td class=\"n\">{:.1f}</td></tr>\n",
                       100 * loop.amplitude * p.scene.top_displacement / (1e3 * p.row.height), loop.dissipated,
                       100 * loop.damping());
  return out + "</table>\n";
}

// Four to eight round numbers between two values.
std::vector<double> ticks(double from, double to) {
  const double rough = (to - from) / 4, power = std::pow(10.0, std::floor(std::log10(rough)));
  const double step = rough >= 5 * power ? 5 * power : rough >= 2 * power ? 2 * power : power;
  std::vector<double> values;
  for (double k = std::ceil(from / step); k * step <= to; ++k) values.push_back(k * step);
  return values;
}

// Curve with the measured peaks and the force of the rigid wall as lines.
std::string curve_svg(const Prediction& p) {
  constexpr double kWidth = 520, kHeight = 360, kLeft = 60, kBottom = 45, kTop = 12, kRight = 12;
  const reproduce::Curve& c = p.outcome.run.curve;
  double right = 1e-9, left = 0.0, top = p.row.peak(), bottom = 0.0;
  for (std::size_t i = 0; i < c.size(); ++i) {
    right = std::max(right, c.displacement[i]), left = std::min(left, c.displacement[i]);
    top = std::max(top, c.force[i]), bottom = std::min(bottom, c.force[i]);
  }
  // A wall that is pushed one way has negative forces from rounding alone.
  bottom = bottom < -0.1 * top ? std::min(bottom, -p.row.peak()) : 0.0;
  top *= 1.08, bottom *= 1.08;
  const auto x = [&](double v) { return kLeft + (v - left) / (right - left) * (kWidth - kLeft - kRight); };
  const auto y = [&](double v) { return kTop + (top - v) / (top - bottom) * (kHeight - kTop - kBottom); };
  std::string out =
      fmt::format("<svg viewBox=\"0 0 {} {}\" role=\"img\" aria-label=\"force over displacement\">", kWidth, kHeight);
  const auto level = [&](double force, const char* colour, const std::string& label) {
    if (force > top || force < bottom) return;
    out += fmt::format(
        "<line x1=\"{:.1f}\" x2=\"{:.1f}\" y1=\"{:.1f}\" y2=\"{:.1f}\" stroke=\"{}\" "
        "stroke-dasharray=\"6 4\"/><text x=\"{:.1f}\" y=\"{:.1f}\" font-size=\"11\" fill=\"{}\" "
        "text-anchor=\"end\">{}</text>",
        kLeft, kWidth - kRight, y(force), y(force), colour, kWidth - kRight - 2, y(force) - 3, colour, label);
  };
  if (p.row.peak_positive)
    level(std::abs(*p.row.peak_positive), "#d55e00", fmt::format("measured {:.1f} kN", std::abs(*p.row.peak_positive)));
  if (bottom < 0 && p.row.peak_negative) level(-std::abs(*p.row.peak_negative), "#d55e00", "measured");
  level(rocking_force_with_weight(p.row), "#009e73", "rigid wall");
  level(0.0, "#404040", "");
  std::string points;
  const std::size_t step = std::max<std::size_t>(1, c.size() / 1500);
  for (std::size_t i = 0; i < c.size(); i += step)
    points += fmt::format("{:.1f},{:.1f} ", x(c.displacement[i]), y(c.force[i]));
  out += fmt::format("<polyline fill=\"none\" stroke=\"#0072b2\" stroke-width=\"1.6\" points=\"{}\"/>", points);
  std::string measured;
  for (const auto& [d, f] : p.row.envelope) {
    if (d >= left && d <= right && f >= bottom && f <= top) measured += fmt::format("{:.1f},{:.1f} ", x(d), y(f));
  }
  if (!measured.empty())
    out += fmt::format("<polyline fill=\"none\" stroke=\"#d55e00\" stroke-width=\"1.4\" points=\"{}\"/>", measured);
  if (p.row.drift_at_peak)
    out += fmt::format("<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"5\" fill=\"#d55e00\"/>",
                       std::min(x(*p.row.drift_at_peak * 10 * p.row.height), kWidth - kRight), y(p.row.peak()));
  constexpr const char* kTick = "<text x=\"{:.1f}\" y=\"{:.1f}\" font-size=\"11\" text-anchor=\"{}\">{:g}</text>";
  for (const double d : ticks(left, right)) out += fmt::format(kTick, x(d), kHeight - kBottom + 14, "middle", d);
  for (const double f : ticks(bottom, top)) out += fmt::format(kTick, kLeft - 4, y(f) + 4, "end", f);
  out += fmt::format(
      "<text x=\"{}\" y=\"{}\" font-size=\"12\" text-anchor=\"middle\">displacement of the top, mm</text>"
      "<text x=\"14\" y=\"{}\" font-size=\"12\" transform=\"rotate(-90 14 {})\" text-anchor=\"middle\">horizontal "
      "force, "
      "kN</text></svg>\n",
      kWidth / 2, kHeight - 8, kHeight / 2, kHeight / 2);
  return out;
}

std::string wall_section(const Prediction& p, const CampaignSettings& settings) {
  const Outcome& o = p.outcome;
  const std::string folder = o.run.folder.lexically_relative(settings.out).generic_string();
  std::string out = fmt::format(
      "<h2 id=\"{}\">{}: {}</h2>\n<p>{:g} x {:g} x {:g} m (length, height, thickness), {:g} MPa, H0/H {}. Predicted "
      "{:.1f} kN, measured {:.1f} kN: {:+.0f} %. Mode {} (measured {}).</p>\n",
      p.row.folder_name(), escaped(p.row.number), escaped(p.row.name()), p.row.length, p.row.height, p.row.thickness,
      p.row.axial_stress, p.row.shear_span ? fmt::format("{:g}", *p.row.shear_span) : "not given, 0.5 assumed", o.peak,
      p.row.peak(), 100 * (p.ratio() - 1), o.mode, p.mode_known() ? escaped(p.row.failure_mode) : "not given");
  out += fmt::format(
      "<p class=\"small\">At the end of the run, of {:.1f} mm: horizontal spread by cracks {:.1f} mm, sliding along "
      "one "
      "bed joint {:.1f} mm, {:.0f} % of the worst bed joint crushed.</p>\n<div class=\"pair\">{}"
      "<img src=\"{}/cracks.png\" alt=\"cracks at the end\" loading=\"lazy\"></div>\n",
      1e3 * o.motion.top, 1e3 * o.motion.spread, 1e3 * o.motion.sliding, 100 * o.motion.crushed, curve_svg(p), folder);
  if (o.along_envelope)
    out += fmt::format(
        "<p class=\"small\">Force over that of the measured envelope from 1 to 10 mm: {:.2f} to {:.2f}.</p>\n",
        (*o.along_envelope)[0], (*o.along_envelope)[1]);
  out += loops_table(p);
  out += "<details><summary>Properties and where they come from</summary><table>\n";
  for (const Derivation& d : p.scene.numbers.derivation)
    out += fmt::format("<tr><td>{}</td><td class=\"n\">{:.4g} {}</td><td>{}</td></tr>\n", escaped(d.name), d.value,
                       d.unit, escaped(d.from));
  return out + "</table></details>\n";
}

}  // namespace

std::string statistics_text(const Statistics& s) {
  if (s.count == 0) return "none";
  return fmt::format("mean {:.2f}, median {:.2f}, coefficient of variation {:.2f} ({} walls)", s.mean, s.median,
                     s.variation, s.count);
}

std::vector<double> ratios_of(const Campaign& campaign, bool within_equilibrium_only) {
  std::vector<double> ratios;
  for (const Prediction& p : campaign.done) {
    if (!within_equilibrium_only || p.within_equilibrium()) ratios.push_back(p.ratio());
  }
  return ratios;
}

std::pair<int, int> modes_met(const Campaign& campaign) {
  int met = 0, known = 0;
  for (const Prediction& p : campaign.done) {
    known += p.mode_known();
    met += p.mode_known() && p.mode_met();
  }
  return {met, known};
}

std::string page_of(const Campaign& campaign, const CampaignSettings& settings) {
  const auto [met, known] = modes_met(campaign);
  std::string out = kHead;
  out += fmt::format(
      "<h1>Walls that were tested, predicted by one rule</h1>\n<p>{} walls, {}. All properties by the rule of "
      "host/validate/README.md from what the table gives; nothing is set wall by wall. The mode is right in {} of {} "
      "walls. Data: <a href=\"validation.csv\">validation.csv</a>; scenes in scenes/, runs in runs/.</p>\n",
      campaign.done.size(), settings.cyclic ? "in cycles, law cyclic_joint" : "pushed one way, law fracture_energy",
      met, known);
  out += statistics_table(campaign) + bands_table(campaign) + walls_table(campaign);
  if (!campaign.faults.empty()) {
    out += "<h3>Left out</h3><ul>\n";
    for (const std::string& fault : campaign.faults) out += "<li>" + escaped(fault) + "</li>\n";
    out += "</ul>\n";
  }
  for (const Prediction& p : campaign.done) out += wall_section(p, settings);
  return out + "</body></html>\n";
}

}  // namespace quoin::validate
