// DIR/verdict.json and, for studies beyond the paper, DIR/beyond.json: findings of each study, one object per claim.
// Studies without new runs keep their objects.
#pragma once

#include <filesystem>
#include <string>

#include "reproduce/study.h"

namespace quoin::reproduce {

std::filesystem::path verdict_file(const std::filesystem::path& root, const Study& study);
void write_verdicts(const std::filesystem::path& file, const std::string& study, const StudyReport& report);
// "reproduced  walls  peak at 0.30 MPa: ..."
std::string verdict_line(const std::string& study, const Verdict& verdict);

}  // namespace quoin::reproduce
