// Titles and names with commands, in gnuplot itself: it must print them unchanged, draw, and start no program.
#include "files/gnuplot.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <vector>

#include "base/error.h"
#include "base/input_file.h"
#include "files/file.h"
#include "folder.h"

namespace quoin {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

std::vector<fs::path> parts_in(const fs::path& folder) {
  std::vector<fs::path> parts;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    if (entry.path().extension() == ".part") parts.push_back(entry.path());
  }
  return parts;
}

class Gnuplot : public InFolder {
 protected:
  void SetUp() override {
    if (std::system("gnuplot --version > /dev/null 2>&1") != 0) GTEST_SKIP() << "gnuplot is not installed";
    InFolder::SetUp();
    canary_ = folder_ / "canary";
  }
  std::string touch() const { return "touch " + canary_.string(); }

  // Texts for gnuplot's grammar: each would run touch() in some kind of quotes, macro, line or markup.
  std::vector<std::string> hostile() const {
    std::string control;
    for (char c = 1; c < 32; ++c) control += c;
    return {"a `" + touch() + "` b",
            "`" + touch(),
            "$(" + touch() + ")",
            "\"; system(\"" + touch() + "\"); print \"",
            "'; system('" + touch() + "'); print '",
            "''; system('" + touch() + "') #",
            "x\" . system(\"" + touch() + "\") . \"",
            "x' . system('" + touch() + "') . '",
            "\\' . system('" + touch() + "') . '",
            "a\n!" + touch() + "\n",
            "a\nsystem '" + touch() + "'\nb",
            "a\r!" + touch() + "\r",
            "!" + touch(),
            "@ARG0 @macro `@macro`",
            "EOD\n!" + touch() + "\nEOD",
            "$data << EOD",
            "# comment",
            "ends with \\",
            "\\",
            "\\n \\101 \\\\",
            "'",
            "''",
            "\"",
            "{",
            "}}",
            "[(",
            "{/*5 large}_{sub}^{super}@x&{y}~z{.6w}",
            "%s %d %n {:g}",
            control + "\x7f",
            std::string("a\0b", 3),
            "",
            "M\xc3\xb6rtel \xe2\x82\xac",
            "not UTF-8: \xff\xfe\xc3"};
  }

  fs::path canary_;
};

// The SVG picture contains the texts of titles and labels.
TEST_F(Gnuplot, DrawsThePictureAsSvgToo) {
  const std::string script =
      "set terminal pngcairo size 600,400\nset title " + gnuplot_text("Pushed & held") + " noenhanced\nplot x\n";
  ASSERT_EQ(draw_picture(folder_, "curve", script), "");
  ASSERT_EQ(draw_as_svg(folder_, "curve"), "");
  const std::string svg = read_input_file((folder_ / "curve.svg").string());
  EXPECT_THAT(svg, HasSubstr("<svg"));
  EXPECT_THAT(svg, HasSubstr("Pushed &amp; held"));
  EXPECT_TRUE(parts_in(folder_).empty());
  EXPECT_THAT(draw_as_svg(folder_, "curve"), "");  // again, over the first
  EXPECT_THROW(draw_as_svg(folder_, "nothing"), Error);
}

TEST_F(Gnuplot, PrintsAndDrawsHostileTextAndRunsNothing) {
  for (const std::string& title : hostile()) {
    SCOPED_TRACE(::testing::PrintToString(title));
    const std::string text = gnuplot_text(title);
    EXPECT_EQ(draw_picture(folder_, "test",
                           "macro = '`" + touch() + "`'\nset terminal pngcairo size 300,200\nset title " + text +
                               " noenhanced\nset label 1 " + text + " at screen 0.5,0.5 noenhanced\nset xlabel " +
                               text + " noenhanced\nset key noenhanced\nplot 1 title " + text +
                               "\nset print 'printed'\nprint " + text + "\n"),
              "");
    EXPECT_TRUE(fs::remove(folder_ / "test.png"));
    EXPECT_FALSE(fs::remove(canary_)) << "a command was run";
    std::string expected = title;
    for (char& c : expected) {
      if ((c >= 0 && c < 32) || c == 127) c = ' ';
    }
    EXPECT_EQ(read_all(folder_ / "plots/printed"), expected + "\n");
  }
}

TEST_F(Gnuplot, CutsTextThatIsWiderThanAnyPicture) {
  std::string two_bytes;
  for (int i = 0; i < 50000; ++i) two_bytes += "\xc3\xb6";
  for (const std::string& title : {std::string(1000000, 'x'), "x" + two_bytes}) {
    const std::string text = gnuplot_text(title);
    EXPECT_LT(text.size(), 310u);
    EXPECT_EQ(draw_picture(folder_, "test",
                           "set terminal pngcairo\nset title " + text + "\nplot 1\nset print 'printed'\nprint " + text),
              "");
    const std::string printed = read_all(folder_ / "plots/printed");
    EXPECT_TRUE(printed.ends_with(title.substr(title.size() - 2) + "...\n")) << printed;  // whole characters
  }
}

TEST_F(Gnuplot, DrawsInFoldersOfAnyName) {
  for (const std::string& name : hostile()) {
    if (name.empty() || name.find('/') != std::string::npos || name.find('\0') != std::string::npos) continue;
    SCOPED_TRACE(::testing::PrintToString(name));
    EXPECT_EQ(draw_picture(folder_ / name, "test", "set terminal pngcairo size 300,200\nplot 1\n"), "");
    EXPECT_TRUE(fs::exists(folder_ / name / "test.png"));
    draw_picture_alone(folder_ / name / (name + ".png"), "set terminal pngcairo size 300,200\nplot 1\n");
    EXPECT_TRUE(fs::exists(folder_ / name / (name + ".png")));
  }
  // With slashes: nested folders.
  const fs::path deep = folder_ / ("`" + touch() + "`\n!" + touch() + "\n$(" + touch() + ")';\"");
  EXPECT_EQ(draw_picture(deep, "test", "set terminal pngcairo size 300,200\nplot 1\n"), "");
  EXPECT_TRUE(fs::exists(deep / "test.png"));
  EXPECT_FALSE(fs::exists(canary_)) << "a command was run";
}

TEST_F(Gnuplot, ScriptsDrawTheSamePictureByHand) {
  ASSERT_EQ(draw_picture(folder_, "test", "set terminal pngcairo size 300,200\nplot 1\n"), "");
  const std::string drawn = read_all(folder_ / "test.png");
  fs::remove(folder_ / "test.png");
  ASSERT_EQ(std::system(("cd '" + (folder_ / "plots").string() + "' && gnuplot test.gp").c_str()), 0);
  EXPECT_EQ(read_all(folder_ / "test.png"), drawn);
}

TEST_F(Gnuplot, FaultsLeaveNoPicture) {
  EXPECT_THAT(draw_picture(folder_, "test", "set terminal pngcairo\nplot no_such_thing\n"),
              HasSubstr("gnuplot failed"));
  EXPECT_THAT(read_all(folder_ / "plots/test.log"), HasSubstr("no_such_thing"));
  EXPECT_THROW(draw_picture_alone(folder_ / "alone.png", "plot no_such_thing\n"), Error);
  // A valid script that draws nothing.
  EXPECT_THAT(draw_picture(folder_, "test", "set terminal pngcairo\n"), HasSubstr("gnuplot failed"));

  const std::string path = std::getenv("PATH");
  setenv("PATH", folder_.c_str(), 1);
  EXPECT_THAT(draw_picture(folder_, "test", "plot 1\n"), HasSubstr("gnuplot is not installed"));
  setenv("PATH", path.c_str(), 1);

  EXPECT_FALSE(fs::exists(folder_ / "test.png"));
  EXPECT_FALSE(fs::exists(folder_ / "alone.png"));
  EXPECT_THAT(parts_in(folder_), ::testing::IsEmpty());
}

}  // namespace
}  // namespace quoin
