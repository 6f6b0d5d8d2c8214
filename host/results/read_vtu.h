// The VTU files of a run, read back: those that vtk_file.h writes, and no others.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace quoin {

class VtuFile {
 public:
  // Throws Error(bad_input): no such file, or not one of ours.
  explicit VtuFile(const std::filesystem::path& path);
  // Values of an array, its components side by side; T as it was written. Throws Error(bad_input) where there is none.
  template <class T>
  std::vector<T> read(const std::string& name) const;

 private:
  [[noreturn]] void refuse(const std::string& why) const;
  std::string bytes_of(const std::string& name, const char* type) const;
  std::filesystem::path path_;
  std::string file_;
  std::size_t data_ = 0;  // where the appended arrays begin
  bool compressed_ = false;
};

// Times of the frames of FOLDER/NAME.pvd, s.
std::vector<double> read_collection(const std::filesystem::path& folder, const std::string& name);

}  // namespace quoin
