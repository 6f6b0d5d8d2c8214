// Pictures drawn by gnuplot as a child process. Scripts and data stay in DIR/plots, to be changed and run again.
#pragma once

#include <filesystem>
#include <string>

namespace quoin {

// Text of a title or label inside double quotes of gnuplot, with its enhanced mode switched off by noenhanced.
std::string gnuplot_text(const std::string& text);
// Text inside gnuplot's enhanced mode, its special characters escaped.
std::string enhanced(const std::string& text);

// Runs DIR/plots/NAME.gp; DIR/NAME.png appears only when gnuplot is content. Returns a one-line notice when there is no
// picture (no gnuplot), otherwise nothing.
std::string draw_picture(const std::filesystem::path& folder, const std::string& name, const std::string& script);

}  // namespace quoin
