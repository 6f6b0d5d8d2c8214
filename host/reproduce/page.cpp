#include "reproduce/page.h"

#include <fmt/format.h>

#include <cctype>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>

#include "files/file.h"
#include "files/markup.h"

namespace quoin::reproduce {

namespace {

namespace fs = std::filesystem;

// A relative address in which special bytes are escaped.
std::string link(const fs::path& file) {
  std::string result;
  for (const char c : file.generic_string()) {
    const bool plain =
        std::isalnum(static_cast<unsigned char>(c)) != 0 || std::string("/._-").find(c) != std::string::npos;
    result += plain ? std::string(1, c) : fmt::format("%{:02X}", static_cast<unsigned char>(c));
  }
  return result;
}

std::string list(const char* heading, const std::vector<std::string>& items) {
  if (items.empty()) return {};
  std::string out = fmt::format("<h3>{}</h3>\n<ul>\n", heading);
  for (const std::string& item : items) out += "<li>" + escaped(item) + "</li>\n";
  return out + "</ul>\n";
}

std::string read_text(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

const char* const kHead = R"(<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>Quoin: the paper reproduced</title>
<style>
body { font: 16px/1.5 "Helvetica Neue", Arial, sans-serif; color: #222; max-width: 62rem; margin: 2rem auto; padding: 0 1rem; }
h1 { font-size: 1.9rem; line-height: 1.2; }
h2 { margin-top: 3.5rem; border-top: 3px solid #b3321e; padding-top: .6rem; }
h3 { margin: 1.4rem 0 .3rem; font-size: 1.05rem; }
figure { margin: 1.2rem 0; }
figure img { max-width: 100%; height: auto; border: 1px solid #ddd; }
figure.half { display: inline-block; width: 49%; vertical-align: top; }
figcaption { color: #555; font-size: .92rem; }
table { border-collapse: collapse; margin: .8rem 0; font-size: .92rem; }
th, td { border-bottom: 1px solid #ddd; padding: .25rem .7rem .25rem 0; text-align: left; vertical-align: top; }
th { border-bottom: 2px solid #999; }
caption { text-align: left; color: #555; padding-bottom: .3rem; }
.yes { color: #1b7837; font-weight: bold; white-space: nowrap; }
.no { color: #b3321e; font-weight: bold; white-space: nowrap; }
.claim { border-left: 4px solid #bbb; padding-left: .8rem; color: #333; }
.small { color: #555; font-size: .92rem; }
</style>
</head>
<body>
)";

}  // namespace

void write_section(const fs::path& root, const Study& study, const Quality& quality, const StudyReport& report) {
  std::string out = fmt::format("<h2 id=\"{0}\">{1} <span class=\"small\">({0}; {2})</span></h2>\n", study.id,
                                escaped(study.title), escaped(study.figures));
  out += fmt::format("<p class=\"claim\"><b>{}:</b> {}</p>\n", study.beyond ? "Asked" : "The paper says",
                     escaped(study.claim));
  out += fmt::format("<p class=\"small\">Quality {}: {:g} mm/s for a wall of 1 m; expected error {}.</p>\n",
                     quality.name, quality.velocity * 1e3, escaped(quality.error));
  for (const Verdict& v : report.verdicts)
    out += fmt::format("<p><span class=\"{}\">{}</span> {}: {}</p>\n", v.reproduced ? "yes" : "no",
                       v.reproduced ? "Reproduced." : "Not reproduced.", escaped(v.claim), escaped(v.text));
  for (const Picture& p : report.pictures) {
    const bool cracks = p.file.filename() == "cracks.png";
    out += fmt::format(
        "<figure{}><a href=\"{}\"><img src=\"{}\" alt=\"{}\" "
        "loading=\"lazy\"></a><figcaption>{}</figcaption></figure>\n",
        cracks ? " class=\"half\"" : "", link(p.file), link(p.file), escaped(p.caption), escaped(p.caption));
  }
  for (const Table& t : report.tables) {
    out += "<table><caption>" + escaped(t.caption) + "</caption>\n<tr>";
    for (const std::string& h : t.header) out += "<th>" + escaped(h) + "</th>";
    out += "</tr>\n";
    for (const auto& row : t.rows) {
      out += "<tr>";
      for (const std::string& cell : row) out += "<td>" + escaped(cell) + "</td>";
      out += "</tr>\n";
    }
    out += "</table>\n";
  }
  out += list("What agrees", report.agrees);
  out += list("What does not, and why", report.differs);
  out += list("Seen by people in runs of standard quality, November 2026", report.seen);
  out += list("Notes", report.notes);
  out += list("Not done", report.notices);
  write_file(root / study.id / "section.html", out);
}

void write_page(const fs::path& root) {
  std::string out = kHead;
  out +=
      "<h1>Masonry walls and buildings with discrete elements: the paper reproduced, figure by figure</h1>\n"
      "<p>Pulatsu, Erdogmus, Louren&ccedil;o, Lemos and Tuncay, <i>Simulation of the in-plane structural behavior of "
      "unreinforced masonry walls and buildings using DEM</i> (2020), held against Quoin " QUOIN_VERSION
      ". Reference values say what they are: <b>[P]</b> printed in the paper, <b>[D]</b> derived from what it prints, "
      "<b>[S]</b> seen in another public source, <b>[R]</b> recalled from the literature, not seen: for orientation "
      "only. Nothing is tuned to meet a reference.</p>\n"
      "<p class=\"small\">Pictures of cracks show the end of the run, displacements enlarged as they say: bricks, "
      "joints "
      "coloured by the worst that happened in them. Data: the CSV files in the folder of each study; every run with "
      "its "
      "summary, history and log in runs/. The verdicts as data: <a href=\"verdict.json\">verdict.json</a>.</p>\n";
  for (const char* file : {"verdict.json", "beyond.json"}) {
    const auto verdicts = nlohmann::json::parse(read_text(root / file), nullptr, false);
    if (!verdicts.is_array()) continue;
    out += "<table><tr><th>Study</th><th>Claim</th><th>Number</th><th>Reference</th><th></th></tr>\n";
    for (const auto& v : verdicts) {
      if (!v.is_object() || !v.contains("reference")) continue;
      const std::string id = escaped(v.value("study", "")), unit = escaped(v.value("unit", ""));
      const bool yes = v.value("reproduced", false);
      out += fmt::format(
          "<tr><td><a href=\"#{0}\">{0}</a></td><td>{1}</td><td>{2} {3}</td><td>{4}</td><td class=\"{5}\">{6}</td>"
          "</tr>\n",
          id, escaped(v.value("claim", "")),
          v["number"].is_number() ? fmt::format("{:.4g}", v["number"].get<double>()) : "none", unit,
          v["reference"].is_number() ? fmt::format("{:.4g} {} <span class=\"small\">{}</span>",
                                                   v["reference"].get<double>(), unit, escaped(v.value("kind", "")))
                                     : escaped(v.value("kind", "")),
          yes ? "yes" : "no", yes ? "reproduced" : "not reproduced");
    }
    out += "</table>\n";
  }
  for (const Study& study : studies()) out += read_text(root / study.id / "section.html");
  write_file(root / "index.html", out + "</body>\n</html>\n");
}

}  // namespace quoin::reproduce
