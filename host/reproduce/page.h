// The report as an HTML page, DIR/index.html. The section of each study is in DIR/STUDY/section.html, so that the page
// has earlier studies too.
#pragma once

#include <filesystem>
#include <string>

#include "reproduce/study.h"

namespace quoin::reproduce {

void write_section(const std::filesystem::path& root, const Study& study, const Quality& quality,
                   const StudyReport& report);
void write_page(const std::filesystem::path& root);

}  // namespace quoin::reproduce
