// Input files as they were when they were first read. A study of a thousand samples finds one scene, whatever its file
// holds by then.
#pragma once

#include <filesystem>
#include <map>
#include <string>

namespace quoin {

// Bytes by absolute path. Reading of any number of threads, writing of one alone.
class KeptInputs {
 public:
  // Between the two each file is kept as it is read; what is kept is what readers get from then on.
  void begin() { keeping_ = true; }
  void end() { keeping_ = false; }
  bool keeping() const { return keeping_; }

  // Null: not kept. FILE counts from the working folder.
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
