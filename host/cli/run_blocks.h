// `quoin run` and `quoin check` for scenes of the general path.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace quoin {

// Results: history.csv, summary.json, blocks.pvd with its frames, mechanism.png. law: replaces the law of every family.
void run_blocks(const std::string& scene, const std::string& law, const std::vector<std::string>& overrides,
                const std::filesystem::path& folder, int& exit_code);

// Validates; prints sizes, time step and stages.
void check_blocks(const std::string& scene, const std::string& law, const std::vector<std::string>& overrides);

}  // namespace quoin
