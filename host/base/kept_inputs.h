// Input files as they were at their first read. All samples of a study get the same scene, even if its file changes
// meanwhile.
#pragma once

#include <filesystem>
#include <map>
#include <string>

namespace quoin {

// Bytes by absolute path. Any number of threads may read, or a single thread may write.
class KeptInputs {
 public:
  // Between begin() and end() each file that is read is kept; later readers get the kept bytes.
  void begin() { keeping_ = true; }
  void end() { keeping_ = false; }
  bool keeping() const { return keeping_; }

  // Kept bytes; null: not kept. FILE is relative to the working folder.
  const std::string* find(const std::string& file) const {
    if (files_.empty()) return nullptr;
    const auto found = files_.find(place_of(file));
    return found == files_.end() ? nullptr : &found->second;
  }
  void keep(const std::string& file, std::string bytes) { files_.insert_or_assign(place_of(file), std::move(bytes)); }
  const std::map<std::string, std::string>& files() const { return files_; }

 private:
  static std::string place_of(const std::string& file) {
    return std::filesystem::absolute(file).lexically_normal().string();
  }
  std::map<std::string, std::string> files_;
  bool keeping_ = false;
};

inline KeptInputs& kept_inputs() {
  static KeptInputs inputs;
  return inputs;
}

}  // namespace quoin
