// The loader throws Error(law_refused), with fault, reason and remedy, for every fault of a library.
#include <elf.h>
#include <gtest/gtest.h>
#include <link.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "base/error.h"
#include "law/law_library.h"
#include "law/property_text.h"

namespace quoin {
namespace {

// Returns the message of a refusal. The test fails if the call does not throw or has another exit code.
template <typename Call>
std::string refusal(Call call, Exit expected = Exit::law_refused) {
  try {
    call();
  } catch (const Error& error) {
    EXPECT_EQ(error.exit_code, expected) << error.what();
    return error.what();
  }
  ADD_FAILURE() << "nothing was refused";
  return {};
}

void expect_words(const std::string& message, std::initializer_list<const char*> words) {
  for (const char* word : words) EXPECT_NE(message.find(word), std::string::npos) << word << " in: " << message;
}

std::vector<PropertySetting> elastic_properties() {
  return {{"normal_stiffness", {82e9}, {}, {"scene.toml:3: joints.mortar.normal_stiffness"}},
          {"shear_stiffness", {36e9}, {}, {"scene.toml:4: joints.mortar.shear_stiffness"}}};
}

TEST(Loader, FindsAShippedLawByName) {
  const Law law = Law::find("elastic");
  EXPECT_STREQ(law.law->id, "elastic");
  EXPECT_EQ(law.state_index("no such state"), -1);
  const Material material(law, elastic_properties());
  EXPECT_EQ(material.number("normal_stiffness"), 82e9);
  EXPECT_EQ(material.stiffness_bounds().shear, 36e9);
  EXPECT_EQ(material.initial_state("bonded").size(), law.law->state_count);
}

TEST(Loader, LoadsFromAPathOnceAsLongAsTheFileIsTheSame) {
  const std::string path = LawLibrary::load("elastic")->path();
  EXPECT_NE(Law::find(path).law, nullptr);
  const auto first = LawLibrary::load(path);
  const auto second = LawLibrary::load("elastic");
  EXPECT_EQ(&first->info(), &second->info());
  EXPECT_EQ(first->path(), path);
}

// A developer rebuilds a law in place while a host program runs. The next load must return the new one, although the
// old one is in use. (dlopen itself returns the loaded library with the same inode.)
TEST(Loader, SeesARebuiltLibraryWithoutARestart) {
  namespace fs = std::filesystem;
  const fs::path law = fs::temp_directory_path() / ("quoin_rebuilt_" + std::to_string(::getpid()) + ".so");
  const auto build = [&](const char* file) {  // in place: the name and the inode do not change
    std::ifstream from(file, std::ios::binary);
    std::ofstream(law, std::ios::binary | std::ios::trunc) << from.rdbuf();
  };
  build(QUOIN_REBUILT_LAW_1);
  const auto first = LawLibrary::load(law.string());
  EXPECT_STREQ(first->info().laws[0]->version, "1.0.0");
  build(QUOIN_REBUILT_LAW_2);
  const auto second = LawLibrary::load(law.string());
  EXPECT_STREQ(second->info().laws[0]->version, "2.0.0");
  EXPECT_STREQ(first->info().laws[0]->version, "1.0.0") << "the old one stays whole while somebody holds it";
  fs::remove(law);
}

TEST(Loader, NamesEverythingThatItTried) {
  expect_words(refusal([] { Law::find("no_such_law"); }), {"no_such_law", "tried", "laws/no_such_law.so", "elastic"});
  expect_words(refusal([] { Law::find("./no_such_file.so"); }), {"./no_such_file.so", "no such file"});
  expect_words(refusal([] { Law::find("/tmp/"); }), {"folder"});
  expect_words(refusal([] { Law::find(""); }), {"no law was named"});
}

// A library file with another name is found by that name, but has no law with it.
TEST(Loader, NamesTheLawsOfALibraryThatLacksTheOneAskedFor) {
  namespace fs = std::filesystem;
  const fs::path folder = fs::temp_directory_path() / ("quoin_renamed_" + std::to_string(::getpid()));
  fs::create_directories(folder);
  fs::copy_file(LawLibrary::load("elastic")->path(), folder / "renamed_law.so", fs::copy_options::overwrite_existing);
  setenv("QUOIN_LAW_PATH", folder.c_str(), 1);
  expect_words(refusal([] { Law::find("renamed_law"); }),
               {"law 'renamed_law'", "renamed_law.so holds no law of that id, only: elastic; give the library's path"});
  unsetenv("QUOIN_LAW_PATH");
  EXPECT_STREQ(Law::find((folder / "renamed_law.so").string()).law->id, "elastic");
  fs::remove_all(folder);
}

TEST(Loader, RefusesWhatIsNoLaw) {
  const auto text = std::filesystem::temp_directory_path() / "quoin_loader_test.so";
  std::ofstream(text) << "not a library\n";
  expect_words(refusal([&] { Law::find(text.string()); }), {"dynamic loader", "shared library"});
  std::filesystem::remove(text);
}

// A truncated library is refused if a part that the system's loader maps is incomplete. This does not depend on the
// section table, which the system's loader does not read.
TEST(Loader, RefusesALibraryThatEndsWithinAPart) {
  std::ifstream from(LawLibrary::load("elastic")->path(), std::ios::binary);
  std::string bytes{std::istreambuf_iterator<char>(from), {}};
  ElfW(Ehdr) head;
  std::memcpy(&head, bytes.data(), sizeof head);
  head.e_shoff = 0, head.e_shnum = 0, head.e_shstrndx = 0;
  std::memcpy(bytes.data(), &head, sizeof head);
  std::size_t end = 0;
  for (std::size_t i = 0; i < head.e_phnum; ++i) {
    ElfW(Phdr) part;
    std::memcpy(&part, bytes.data() + head.e_phoff + i * sizeof part, sizeof part);
    end = std::max<std::size_t>(end, part.p_offset + part.p_filesz);
  }
  const auto law = std::filesystem::temp_directory_path() / ("quoin_cut_" + std::to_string(::getpid()) + ".so");
  std::ofstream(law, std::ios::binary) << bytes.substr(0, end - 1);
  expect_words(refusal([&] { Law::find(law.string()); }),
               {("the file has " + std::to_string(end - 1) + " bytes of " + std::to_string(end)).c_str(),
                "it was not copied or built to its end"});
  std::ofstream(law, std::ios::binary | std::ios::trunc) << bytes.substr(0, end);
  EXPECT_STREQ(Law::find(law.string()).law->id, "elastic");
  std::filesystem::remove(law);
}

TEST(Loader, UnknownInitialStateNamesTheKnown) {
  const Material material(Law::find("elastic"), elastic_properties());
  expect_words(refusal([&] { material.initial_state("wet"); }, Exit::bad_input), {"wet", "elastic", "bonded"});
}

TEST(Loader, FaultsCarryTheirSource) {
  auto settings = elastic_properties();
  settings[0].numbers[0] = -1.0;
  settings[1].numbers[0] = 0.0;
  const std::string message = refusal([&] { Material(Law::find("elastic"), settings); });
  expect_words(
      message,
      {"scene.toml:3: joints.mortar.normal_stiffness: ", "scene.toml:4: joints.mortar.shear_stiffness: ", "-1"});
}

// A fault about two properties has the sources of both, and of no other: cohesion is not found in cohesion_residual.
TEST(Loader, FaultsCarryTheSourceOfEveryWholeWord) {
  auto settings = elastic_properties();
  const auto set = [&](const char* id, double value, const char* source) {
    settings.push_back({id, {value}, {}, {source}});
  };
  set("tensile_strength", 0.16e6, "scene.toml:5");
  set("cohesion", 0.2e6, "scene.toml:6");
  set("friction_angle", 35, "scene.toml:7");
  set("fracture_energy_tension", 12, "scene.toml:8");
  set("fracture_energy_shear", 50, "scene.toml:9");
  set("cohesion_residual", 0.3e6, "scene.toml:10");
  expect_words(refusal([&] { Material(Law::find("fracture_energy"), settings); }),
               {"\nscene.toml:6, scene.toml:10: cohesion_residual = ", "must not exceed cohesion = "});
  settings.back() = {"cohesion_residual", {-1.0}, {}, {"scene.toml:10"}};
  expect_words(refusal([&] { Material(Law::find("fracture_energy"), settings); }),
               {"\nscene.toml:10: cohesion_residual"});
}

TEST(Loader, ALaterSettingReplacesAnEarlierOne) {
  auto settings = elastic_properties();
  settings.push_back({"normal_stiffness", {1e9}, {}, {"--set"}});
  EXPECT_EQ(Material(Law::find("elastic"), settings).number("normal_stiffness"), 1e9);
}

TEST(PropertyText, NumbersWordsAndTables) {
  const Law law = Law::find("elastic");
  EXPECT_EQ(parse_setting(*law.law, "normal_stiffness=8.2e10", {"--set"}).numbers, std::vector<double>{8.2e10});
  expect_words(refusal([&] { parse_setting(*law.law, "normal_stiffness=8.2e10x", {"--set"}); }, Exit::bad_input),
               {"--set normal_stiffness", "8.2e10x", "Pa/m"});
  expect_words(refusal([&] { parse_setting(*law.law, "normal_stiffness", {"--set"}); }, Exit::usage), {"id=value"});
  double value = 0.0;
  EXPECT_TRUE(parse_number(" +1e3 ", value));
  EXPECT_EQ(value, 1e3);
  for (const char* wrong : {"", "1e", "1,0", "0x10", "one"}) EXPECT_FALSE(parse_number(wrong, value)) << wrong;
}

}  // namespace
}  // namespace quoin
