// DIR/report.html: one page without network access that shows a run, or two side by side. It has the model in three
// dimensions over time, coloured by results, the curve, energies, settings, warnings and the known error.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace quoin {

// Throws Error(bad_input), as write_report, when three.js is not installed.
void require_report_library();

// Writes the page of one or two finished runs into the first folder, and returns its path. Throws Error(bad_input) for
// a folder without results or frames, or without three.js ($QUOIN_THREE_JS, or Debian's libjs-three). on_frame: called
// before each frame of a folder is read, with its number from 1 and their count.
using OnFrame = std::function<void(const std::filesystem::path& folder, std::size_t frame, std::size_t frames)>;
std::filesystem::path write_report(const std::vector<std::filesystem::path>& folders, const OnFrame& on_frame = {});

// A motion that is not of a run: an array of a file of virtual_motion.h, and its label.
struct ShownMotion {
  std::string array, label;
};
// Writes report.html next to that file, with the shapes in oscillation. one_way: from rest to the shape and back, for
// mechanisms. Returns its path. Throws as write_report.
std::filesystem::path write_motion_report(const std::filesystem::path& vtu, const std::string& title,
                                          const std::vector<ShownMotion>& motions, bool one_way);

// A running simulation for its page: each frame is read once, when it appears.
class GrowingRun {
 public:
  explicit GrowingRun(std::filesystem::path folder);
  ~GrowingRun();
  GrowingRun(const GrowingRun&) = delete;
  GrowingRun& operator=(const GrowingRun&) = delete;
  // JSON {head, data}, as in a page. summary, history: JSON; times: of the frames in the folder, s.
  std::string part(const std::string& summary, const std::string& history, const std::vector<double>& times);

 private:
  struct Frames;
  std::filesystem::path folder_;
  std::unique_ptr<Frames> frames_;
};
// Text of a page that requests `state` and `run` of its server until that ends. Throws as require_report_library.
std::string live_page_text(const std::string& title);

}  // namespace quoin
