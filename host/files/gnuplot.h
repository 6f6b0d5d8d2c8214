// Pictures drawn by gnuplot as a child process. gnuplot executes its scripts, so no text of a user may become part of
// what it executes. Every title, label and name goes through gnuplot_text(). Numbers are formatted, files are opened
// here and not by the script, and no shell is started.
#pragma once

#include <filesystem>
#include <string>

namespace quoin {

// A string in gnuplot's grammar, quotes included, with every byte that could mean something to gnuplot written as its
// number. Control characters become spaces; text longer than a picture is wide ends in "...". Draw it with
// `noenhanced`: it has no markup then.
std::string gnuplot_text(const std::string& text);

// Draws FOLDER/NAME.png with a script that sets no output, run in FOLDER/plots. Script, data and messages stay there as
// NAME.gp, the caller's files and NAME.log, to be changed and run again. The picture appears only when gnuplot is
// content, within 300 s or the seconds in $QUOIN_PLOT_SECONDS. Returns a one-line notice when there is no picture,
// otherwise nothing. Throws Error(bad_input) when the folder cannot be written.
std::string draw_picture(const std::filesystem::path& folder, const std::string& name, const std::string& script);

// Draws what draw_picture has just drawn, as FOLDER/NAME.svg. Only for folders that this process has written: the
// script in them is run. Returns and throws as draw_picture.
std::string draw_as_svg(const std::filesystem::path& folder, const std::string& name);

// Draws PICTURE and leaves nothing beside it; its folder is made. Throws Error(bad_input) with gnuplot's message.
void draw_picture_alone(const std::filesystem::path& picture, const std::string& script);

}  // namespace quoin
