// DIR/report.html: one page that opens from the disk without network and shows a run, or two side by side. The model
// in three dimensions, coloured, over time; the curve; energies; settings, warnings and the known error.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace quoin {

// What the page is drawn with is there. Throws Error(bad_input) as write_report.
void require_report_library();

// folders: of finished runs, one or two; the page goes to the first. Its path. Throws Error(bad_input): a folder
// without results or frames, or three.js is not on this machine ($QUOIN_THREE_JS, or Debian's libjs-three).
// on_frame: called before each frame of a folder is read, from 1 on, and how many there are.
using OnFrame = std::function<void(const std::filesystem::path& folder, std::size_t frame, std::size_t frames)>;
std::filesystem::path write_report(const std::vector<std::filesystem::path>& folders, const OnFrame& on_frame = {});

// A motion that no run has made: an array of a file of virtual_motion.h, and what the page says of it.
struct ShownMotion {
  std::string array, label;
};
// report.html beside that file: the shapes, swinging; one_way: from rest and back, as mechanisms do. Its path. Throws
// as write_report.
std::filesystem::path write_motion_report(const std::filesystem::path& vtu, const std::string& title,
                                          const std::vector<ShownMotion>& motions, bool one_way);

// A run that goes on, for its page: frames are read once, as they come.
class GrowingRun {
 public:
  explicit GrowingRun(std::filesystem::path folder);
  ~GrowingRun();
  GrowingRun(const GrowingRun&) = delete;
  GrowingRun& operator=(const GrowingRun&) = delete;
  // JSON {head, data}, as a page holds it. summary, history: as JSON; times: of the frames in the folder, s.
  std::string part(const std::string& summary, const std::string& history, const std::vector<double>& times);

 private:
  struct Frames;
  std::filesystem::path folder_;
  std::unique_ptr<Frames> frames_;
};
// A page that requests `state` and `run` beside it, until the server ends. Throws as require_report_library.
std::string live_page_text(const std::string& title);

}  // namespace quoin
