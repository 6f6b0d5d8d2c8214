#include "results/picture_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "files/gnuplot.h"

namespace quoin {

std::string title_of(const Scene& scene) {
  return scene.title.empty() ? std::filesystem::path(scene.file).stem().string() : scene.title;
}

std::string moment_of(const std::vector<HistoryRow>& rows, const Scene& scene) {
  if (rows.empty()) return {};
  const HistoryRow& row = rows.back();
  return fmt::format("stage {} {}, {:.3g} s", row.stage + 1, scene.stages[static_cast<size_t>(row.stage)].name,
                     row.time);
}

std::string fitting_text(const std::string& text, double pixels, double points) {
  // 96 pixels an inch, 72 points an inch. English text of this font takes 0.56 to 0.61 of its size a character.
  constexpr double kWidth = 0.62 * 96.0 / 72.0;
  const auto starts_character = [](char c) { return (static_cast<unsigned char>(c) & 0xc0) != 0x80; };
  const auto most = static_cast<long>(pixels / (kWidth * points));
  if (std::count_if(text.begin(), text.end(), starts_character) <= most) return gnuplot_text(text);
  size_t end = 0;
  for (long characters = 0; end < text.size(); ++end) {
    if (starts_character(text[end]) && ++characters > most - 3) break;
  }
  return gnuplot_text(text.substr(0, end) + "...");
}

}  // namespace quoin
