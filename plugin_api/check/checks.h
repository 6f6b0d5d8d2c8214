// The sections of the checker. Each runs in a child process of its own.
#pragma once

#include "library.h"
#include "report.h"
#include "subject.h"

namespace check {

// The law that a section checks, with accepted property values.
struct Subject {
  const quoin_law& law;
  Settings base;                 // accepted property values
  std::vector<Settings> varied;  // base first, then variations
};

// Expects the same bits in both results; when: what was done before the second.
void expect_same(Report& report, const quoin_law& law, const Result& expected, const Result& found,
                 const std::string& when);

// Checks C2 on what a call writes: with whole, cut, null and short texts. call returns whether its result is the
// expected.
void check_text(Report& report, const char* what, const std::function<bool(quoin_text*)>& call);

void check_library(Report& report, const Library& library);
void check_metadata(Report& report, const quoin_law& law);
bool metadata_is_usable(const quoin_law& law);  // true if the other sections can read the metadata without a crash
void check_materials(Report& report, const Subject& subject);
void check_states(Report& report, const Subject& subject);
void check_purity(Report& report, const Subject& subject);
void check_memory(Report& report, const Subject& subject);
void check_threads(Report& report, const Subject& subject);
void check_optional(Report& report, const Subject& subject);
void check_refusals(Report& report, const Subject& subject);
void check_property_columns(Report& report, const Subject& subject);
void check_failed_points(Report& report, const Subject& subject);
void check_paths(Report& report, const Subject& subject);
void check_energy(Report& report, const Subject& subject);
void check_damage(Report& report, const Subject& subject);
void check_stiffness(Report& report, const Subject& subject);
void check_zero_strengths(Report& report, const Subject& subject);
void check_migration(Report& report, const Subject& subject);

}  // namespace check
