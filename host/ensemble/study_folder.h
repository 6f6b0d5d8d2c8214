// The folder of a study, on which any number of processes and machines work at once:
//   study.json           what the study is; another one is refused
//   inputs/              the files that it is computed from, as they were read at the start
//   samples/000123/      one run, of a sample from 1 on, or of the means (0); sample.json says that it is finished
//   claims/000123        held by the process that computes it: a lock of the kernel, which ends with its process
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

// A lock on a file, for as long as this lives. Children that begin another program do not keep it.
class Claim {
 public:
  // Null: another process has it. Throws Error(bad_input) where the file cannot be made or the file system has no
  // locks.
  static std::unique_ptr<Claim> take(const std::filesystem::path& file);
  static std::unique_ptr<Claim> wait_for(const std::filesystem::path& file);
  ~Claim();
  // Adds a line that says who works on it, for people; what cannot be written is left out.
  void sign() const;
  Claim(const Claim&) = delete;
  Claim& operator=(const Claim&) = delete;

 private:
  explicit Claim(int file) : file_(file) {}
  int file_;
};

class StudyFolder {
 public:
  // Makes the folder, or enters one of the same study. The same are quantities and keys set, the text of the scene, the
  // files and laws that it names, byte by byte. So is the build of quoin. Keeps in the folder what `request` reads
  // (kept_study.h). Throws Error(bad_input), naming what differs.
  StudyFolder(std::filesystem::path path, const Study& study, const Scene& scene, const StudyRequest& request);

  const std::filesystem::path& path() const { return path_; }
  std::filesystem::path sample(std::uint64_t number) const;
  std::filesystem::path claim(std::uint64_t number) const;
  std::filesystem::path gathering() const { return path_ / "claims" / "gathering"; }

 private:
  std::filesystem::path path_;
};

// samples.csv: one row a finished sample from 1 to the last one, in order. Numbers in the shortest decimals that read
// back to the same double, nothing where there is none.
std::string table_text(const std::vector<std::pair<std::uint64_t, Sample>>& samples,
                       const std::vector<std::string>& outputs);

}  // namespace quoin::ensemble
