// The folder of a study, in which any number of processes and machines work at once:
//   study.json           identity of the study; another study is refused
//   inputs/              copies of its input files
//   samples/000123/      a sample from 1, or the means (0); sample.json marks it as finished
//   claims/000123        a kernel lock of the process that computes the sample; it ends with the process
//   samples.csv, summary.json, index.html, ...   the results, written by the last process
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "ensemble/kept_study.h"
#include "ensemble/run_sample.h"
#include "ensemble/study.h"

namespace quoin::ensemble {

// A lock on a file during the life of this object. Child processes that exec another program do not keep it.
class Claim {
 public:
  // Null: another process has the lock. Throws Error(bad_input) when the file cannot be created or the file system has
  // no locks.
  static std::unique_ptr<Claim> take(const std::filesystem::path& file);
  static std::unique_ptr<Claim> wait_for(const std::filesystem::path& file);
  ~Claim();
  // Appends a line that identifies the process, for users. Errors are ignored.
  void sign() const;
  Claim(const Claim&) = delete;
  Claim& operator=(const Claim&) = delete;

 private:
  explicit Claim(int file) : file_(file) {}
  int file_;
};

class StudyFolder {
 public:
  // Creates the folder, or opens one of the same study. Such a study has equal quantities and keys, text of the scene,
  // files, laws and build of quoin, byte by byte. Copies the input of `request` into the folder (kept_study.h). Throws
  // Error(bad_input) with the first difference.
  StudyFolder(std::filesystem::path path, const Study& study, const Scene& scene, const StudyRequest& request);

  const std::filesystem::path& path() const { return path_; }
  std::filesystem::path sample(std::uint64_t number) const;
  std::filesystem::path claim(std::uint64_t number) const;
  std::filesystem::path gathering() const { return path_ / "claims" / "gathering"; }

 private:
  std::filesystem::path path_;
};

// samples.csv: one row per finished sample from 1 to the last one. Numbers are the shortest decimals that read back to
// the same double; a missing one is empty.
std::string table_text(const std::vector<std::pair<std::uint64_t, Sample>>& samples,
                       const std::vector<std::string>& outputs);

}  // namespace quoin::ensemble
