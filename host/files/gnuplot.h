// Drawings by gnuplot in a child process. gnuplot executes its scripts, so user text must never become part of a
// command. Every title, label and name passes through gnuplot_text(), and numbers are formatted. This module opens the
// files, not the script, and starts no shell.
#pragma once

#include <atomic>
#include <filesystem>
#include <string>

namespace quoin {

// Set by handlers of signals: drawings under way end, and no other begins. The caller clears it.
inline std::atomic<bool> stop_drawing{false};

// A quoted string in gnuplot's grammar. Bytes with a meaning for gnuplot are written as numbers. Control characters
// become spaces; text longer than a drawing is wide ends in "...". Draw it with `noenhanced`, which has no markup.
std::string gnuplot_text(const std::string& text);

// Draws FOLDER/NAME.png with a script that sets no output, run in FOLDER/plots. Script, data and messages stay there as
// NAME.gp, the caller's files and NAME.log, to be edited and run again. The drawing appears only if gnuplot succeeds
// within 300 s, or the seconds in $QUOIN_PLOT_SECONDS. After one that did not, the next has a tenth. Returns a
// notice of one line when there is no drawing, else an empty text. Throws Error(bad_input) when the folder cannot be
// written.
std::string draw_picture(const std::filesystem::path& folder, const std::string& name, const std::string& script);

// Draws the last drawing of draw_picture as FOLDER/NAME.svg. Only for folders that this process has written, as it runs
// their script. Returns and throws as draw_picture.
std::string draw_as_svg(const std::filesystem::path& folder, const std::string& name);

// Draws PICTURE without other files beside it, and makes its folder. Throws Error(bad_input) with gnuplot's message.
void draw_picture_alone(const std::filesystem::path& picture, const std::string& script);

}  // namespace quoin
