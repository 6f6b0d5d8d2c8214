// Result folders. One process at a time writes there. A later run removes the results of the earlier one, and no other
// files.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace quoin {

// Makes the folder, and locks it for the lifetime of this object or of the process, however it ends. It is a lock of
// the kernel on FOLDER/.quoin-lock, which names the holder. Throws Error(bad_input) with the holder where there is one.
// Where the file system has no locks, it prints a warning and uses the folder.
class FolderLock {
 public:
  explicit FolderLock(const std::filesystem::path& folder);
  ~FolderLock();
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;

 private:
  int file_ = -1;
};

// Folder of a run. Locks it, removes the results in the manifest of the last run, and begins its own manifest,
// FOLDER/.quoin-manifest. Every file is added there before it is written, so that the manifest has the results of a
// killed run too. Throws Error(bad_input), with nothing removed, where other files have the name of a result.
class ResultFolder {
 public:
  // For a resumed run. held: lock of the folder, if already locked. kept: whether a name of the manifest, relative to
  // the folder, is kept.
  explicit ResultFolder(const std::filesystem::path& folder, std::shared_ptr<FolderLock> held = nullptr,
                        const std::function<bool(const std::string&)>& kept = {});
  ~ResultFolder();
  ResultFolder(const ResultFolder&) = delete;
  ResultFolder& operator=(const ResultFolder&) = delete;

 private:
  std::shared_ptr<FolderLock> lock_;
  std::filesystem::path path_;  // absolute
};

// For a rank that does not hold the folder: it lists what it writes there in FOLDER/.quoin-manifest_rRANK, which counts
// as part of the manifest. Called after the ResultFolder of rank 0 has begun, with its token (use_part_token).
void note_results_of_rank(const std::filesystem::path& folder, int rank);

// Throws Error(bad_input) where the folder has the results of a run, whose files would be overwritten.
void refuse_folder_of_run(const std::filesystem::path& folder);

// For commands that write files of fixed names into a folder that is no folder of a run. The names that they have
// written are in FOLDER/.quoin-files. Throws Error(bad_input) where a file of these names is there that is not in the
// list.
void refuse_files_of_others(const std::filesystem::path& folder, const std::vector<std::string>& names);
// The same; then makes the folder and adds the names to the list, before the files are written.
void list_own_files(const std::filesystem::path& folder, const std::vector<std::string>& names);

// Mark of the pages that quoin writes into result folders.
inline constexpr const char* kPageMark = "<meta name=\"generator\" content=\"quoin\">";
// Throws Error(bad_input) where a page of someone else is in the place of `page`.
void refuse_page_of_others(const std::filesystem::path& page);

// Adds FILE to the manifest of this process for the folder that contains it, if any. Thread-safe.
void note_result(const std::filesystem::path& file);

}  // namespace quoin
