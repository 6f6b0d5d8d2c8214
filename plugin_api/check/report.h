// What the checker found, clause by clause. Every section runs in a child process, so that a law that crashes, hangs,
// prints or exits is reported like any other fault.
#pragma once

#include <functional>
#include <map>
#include <string>
#include <vector>

namespace check {

struct Clause {
  const char* id;    // as in plugin_api/README.md
  const char* text;  // the promise in one line
};
const std::vector<Clause>& clauses();
const char* clause_text(const std::string& id);

struct Outcome {
  int expectations = 0;
  int failures = 0;
  std::vector<std::string> details;  // the first few failures
  std::vector<std::string> skipped;  // why nothing was checked
};

class Report {
 public:
  // Runs one section in a child process and takes over its findings.
  void section(const std::string& name, const std::function<void(Report&)>& run);

  // Within a section: what follows is about this clause, until the next call.
  void clause(const char* id);
  // Counts one expectation of the current clause; the text says what was seen when it does not hold.
  bool expect(bool holds, const char* format, ...) __attribute__((format(printf, 3, 4)));
  void skip(const char* format, ...) __attribute__((format(printf, 2, 3)));
  void note(const char* format, ...) __attribute__((format(printf, 2, 3)));

  bool passed() const;
  const std::map<std::string, Outcome>& outcomes() const { return outcomes_; }
  const std::vector<std::string>& notes() const { return notes_; }

 private:
  void send(char kind, const std::string& text);
  void receive(const std::string& line);

  int pipe_ = -1;
  char* current_ = nullptr;  // id of the clause, in memory that the child process shares: the last one, however it ends
  Outcome* outcome_ = nullptr;  // outcome of the current clause, in the child
  std::map<std::string, Outcome> outcomes_;
  std::vector<std::string> notes_;
};

}  // namespace check
