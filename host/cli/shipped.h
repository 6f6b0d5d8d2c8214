// Scenes, studies, path tests and pages that come with the program, in its help.
#pragma once

#include <filesystem>
#include <string>
#include <utility>

namespace quoin {

// Replaces places in the source tree by those of an installed program: PREFIX/share/quoin/scenes/arch.toml for
// host/scenes/arch.toml. CMakeLists.txt in this folder installs them. share: that folder; empty: found from the place
// of the program.
inline std::string with_shipped_places(std::string text, std::filesystem::path share = {}) {
  if (share.empty()) {
    std::error_code fault;
    const std::filesystem::path program = std::filesystem::read_symlink("/proc/self/exe", fault);
    share = (program.parent_path() / "../share/quoin").lexically_normal();
    if (!std::filesystem::exists(share / "scenes", fault)) return text;
  }
  for (const auto& [source, name] : {std::pair{"host/scenes", "scenes"},
                                     {"host/studies", "studies"},
                                     {"host/ensemble", "ensemble"},
                                     {"host/law/path_file.h", "paths/path_file.h"},
                                     {"tests/law/paths", "paths"}}) {
    const std::string from = source, to = (share / name).string();
    for (std::size_t at = text.find(from); at != std::string::npos; at = text.find(from, at + to.size()))
      text.replace(at, from.size(), to);
  }
  return text;
}

}  // namespace quoin
