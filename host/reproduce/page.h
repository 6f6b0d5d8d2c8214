// The report as a page of HTML that is read from top to bottom, DIR/index.html. One section a study is in
// DIR/STUDY/section.html, so that studies that were not run this time keep their place.
#pragma once

#include <filesystem>
#include <string>

#include "reproduce/study.h"

namespace quoin::reproduce {

void write_section(const std::filesystem::path& root, const Study& study, const Quality& quality,
                   const StudyReport& report);
void write_page(const std::filesystem::path& root);

}  // namespace quoin::reproduce
