// A folder of results: one process at a time writes there, and a later run removes what an earlier one wrote and
// nothing else.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <string>

namespace quoin {

// Makes the folder, and holds it until the end of this object or of the process, however it ends. The lock is the
// kernel's, on FOLDER/.quoin-lock, which names the holder. Throws Error(bad_input) with the holder when there is one.
// Where the file system has no locks, a warning is printed and the folder is used.
class FolderLock {
 public:
  explicit FolderLock(const std::filesystem::path& folder);
  ~FolderLock();
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;

 private:
  int file_ = -1;
};

// The folder of a run. Locks it, removes the results that the manifest of the last run names, and begins a manifest of
// its own, FOLDER/.quoin-manifest. Every file is noted there before it is begun, so that results of a killed run are
// listed too. Throws Error(bad_input), with nothing removed, when the folder has something else under a name that a run
// gives its results.
class ResultFolder {
 public:
  // For a run that goes on: held is the lock of the folder if it is taken already. kept: whether a name of the
  // manifest, relative to the folder, stays.
  explicit ResultFolder(const std::filesystem::path& folder, std::shared_ptr<FolderLock> held = nullptr,
                        const std::function<bool(const std::string&)>& kept = {});
  ~ResultFolder();
  ResultFolder(const ResultFolder&) = delete;
  ResultFolder& operator=(const ResultFolder&) = delete;

 private:
  std::shared_ptr<FolderLock> lock_;
  std::filesystem::path path_;  // absolute
};

// Adds FILE to the manifest of the ResultFolder of this process that it lies in, if any. From any thread.
void note_result(const std::filesystem::path& file);

}  // namespace quoin
