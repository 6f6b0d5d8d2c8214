// Messages for exceptions of unknown kinds.
#include "base/any_error.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

namespace quoin {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

TEST(AnyError, MemoryThatIsMissingIsToldAsSuchWhoeverMissedIt) {
  const auto no_memory = std::make_error_code(std::errc::not_enough_memory);
  const std::bad_alloc of_new;
  const std::system_error of_thread(no_memory);
  const std::filesystem::filesystem_error of_files("cannot iterate", no_memory);
  for (const std::exception* error :
       {static_cast<const std::exception*>(&of_new), static_cast<const std::exception*>(&of_thread),
        static_cast<const std::exception*>(&of_files)}) {
    const Error converted = any_error(*error, "take fewer ranks");
    EXPECT_EQ(converted.exit_code, Exit::numerical);
    EXPECT_STREQ(converted.what(), "out of memory; take fewer ranks");
  }
}

TEST(AnyError, FaultsOfOursAskForAReport) {
  const Error converted = any_error(std::system_error(std::make_error_code(std::errc::io_error)), "", "the law");
  EXPECT_EQ(converted.exit_code, Exit::numerical);
  EXPECT_THAT(converted.what(), AllOf(HasSubstr("internal error: "), HasSubstr("please report it with the law"),
                                      Not(HasSubstr("memory"))));
}

TEST(AnyError, ErrorsStayAsTheyAre) {
  const Error converted = any_error(Error(Exit::bad_input, "scene.toml:3: no"));
  EXPECT_EQ(converted.exit_code, Exit::bad_input);
  EXPECT_STREQ(converted.what(), "scene.toml:3: no");
}

}  // namespace
}  // namespace quoin
