// DIR/verdict.json and, of studies beyond the paper, DIR/beyond.json: what every study found, one object a claim.
// Studies that were not run this time keep what they had.
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
