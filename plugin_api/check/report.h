// Findings of the checker, by clause. Every section runs in a child process, so that a law that crashes, hangs, prints
// or exits is reported as a fault.
#pragma once

#include <functional>
#include <map>
#include <string>
#include <vector>

namespace check {

// Time limit of one call of the law, s; 0: none. The section in which a call takes longer is ended by SIGALRM.
inline unsigned law_seconds = 60;

struct Clause {
  const char* id;    // of plugin_api/README.md, as "C6.4"
  const char* text;  // requirement in one line
};
const std::vector<Clause>& clauses();

struct Outcome {
  int expectations = 0;
  int failures = 0;
  std::vector<std::string> details;  // the first few failures
  std::vector<std::string> skipped;  // reasons why nothing was checked
};

class Report {
 public:
  // Runs one section in a child process and adds its findings.
  void section(const std::string& name, const std::function<void(Report&)>& run);

  // Within a section: sets the clause of the following expectations.
  void clause(const char* id);
  // Counts one expectation of the current clause and returns holds. The text describes the failure.
  bool expect(bool holds, const char* format, ...) __attribute__((format(printf, 3, 4)));
  void skip(const char* format, ...) __attribute__((format(printf, 2, 3)));
  void note(const char* format, ...) __attribute__((format(printf, 2, 3)));

  bool passed() const;
  bool hangs() const { return hangs_; }  // whether a section was ended by the time limit
  const std::map<std::string, Outcome>& outcomes() const { return outcomes_; }
  const std::vector<std::string>& notes() const { return notes_; }

 private:
  [[noreturn]] void run_as_child(const std::string& name, const std::function<void(Report&)>& run);
  bool receive_all(int pipe);  // returns whether the section came to its end
  void send(char kind, const std::string& text);
  void receive(const std::string& line);

  bool hangs_ = false;
  int pipe_ = -1;
  char* current_ = nullptr;     // id of the current clause, in memory shared with the child, where it survives a crash
  Outcome* outcome_ = nullptr;  // outcome of the current clause, in the child
  std::map<std::string, Outcome> outcomes_;
  std::vector<std::string> notes_;
};

}  // namespace check
