// DIR/report.html: one page that opens from the disk without network and shows a run, or two side by side. The model
// in three dimensions, coloured, over time; the curve; energies; settings, warnings and the known error.
#pragma once

#include <filesystem>
#include <functional>
#include <vector>

namespace quoin {

// What the page is drawn with is there. Throws Error(bad_input) as write_report.
void require_report_library();

// folders: of finished runs, one or two; the page goes to the first. Its path. Throws Error(bad_input): a folder
// without results or frames, or three.js is not on this machine ($QUOIN_THREE_JS, or Debian's libjs-three).
// on_frame: told before each frame of a folder is read, from 1 on, and how many there are.
using OnFrame = std::function<void(const std::filesystem::path& folder, std::size_t frame, std::size_t frames)>;
std::filesystem::path write_report(const std::vector<std::filesystem::path>& folders, const OnFrame& on_frame = {});

}  // namespace quoin
