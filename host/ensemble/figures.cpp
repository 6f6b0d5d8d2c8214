#include "ensemble/figures.h"

#include <fmt/format.h>

#include "files/file.h"
#include "files/gnuplot.h"
#include "files/markup.h"
#include "files/notice.h"

namespace quoin::ensemble {

namespace {

std::string head(const std::string& title, const std::string& x, const std::string& y) {
  return fmt::format(
      "set terminal pngcairo size 1500,950 font \"Sans,19\" linewidth 1.5\nset title {} noenhanced font \"Sans,23\"\n"
      "set xlabel {} noenhanced\nset ylabel {} noenhanced\nset border 3 linecolor rgb \"#404040\"\nset tics nomirror\n"
      "set grid xtics ytics linecolor rgb \"#d0d0d0\" linewidth 0.8\n"
      "set key below maxcols 3 font \"Sans,16\" spacing 1.25 noenhanced reverse Left\nset style fill transparent solid "
      "0.3 noborder\n",
      gnuplot_text(title), gnuplot_text(x), gnuplot_text(y));
}

}  // namespace

void Pictures::draw(const std::string& name, const std::string& data, const std::string& x, const std::string& y,
                    const std::string& script, const std::string& caption) {
  write_file(folder_ / "plots" / (name + ".dat"), data);
  const std::string fault = draw_picture(folder_, name, head(title_, x, y) + script);
  if (!fault.empty()) return notice("quoin: " + fault);
  figures_ += fmt::format("<figure><img src=\"{}.png\" alt=\"{}\"><figcaption>{}</figcaption></figure>\n", name,
                          escaped(caption), escaped(caption));
}

void write_page_of(const std::filesystem::path& folder, const std::string& title, const std::string& body) {
  write_file(folder / "index.html", fmt::format(R"(<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<title>{0}</title>
<style>
body {{ font: 16px/1.5 "Helvetica Neue", Arial, sans-serif; color: #222; max-width: 62rem; margin: 2rem auto; padding: 0 1rem; }}
figure {{ margin: 1.2rem 0; }} figure img {{ max-width: 100%; border: 1px solid #ddd; }} figcaption {{ color: #555; }}
table {{ border-collapse: collapse; }} th, td {{ border-bottom: 1px solid #ddd; padding: .25rem .7rem .25rem 0; text-align: left; }}
</style>
</head>
<body>
<h1>{0}</h1>
{1}</body>
</html>
)",
                                                escaped(title), body));
}

}  // namespace quoin::ensemble
