// Reads the VTU files of a run, as written by vtk_file.h. All contents are checked before use, so that a damaged file
// does no harm.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "results/vtk_file.h"

namespace quoin {

// Cells of a grid. Cell c has the corners [end[c - 1], end[c]) of `corner`, which are indices of points. Their number
// fits its type.
struct VtuGrid {
  std::vector<float> position;  // places of points, x y z, finite numbers, m
  std::vector<std::size_t> corner, end;
  std::vector<std::uint8_t> type;
  std::size_t points() const { return position.size() / 3; }
  std::size_t cells() const { return type.size(); }
  std::size_t first_corner(std::size_t cell) const { return cell == 0 ? 0 : end[cell - 1]; }
};

class VtuFile {
 public:
  // Throws Error(bad_input) for a file that is missing, damaged, or not written by Quoin.
  explicit VtuFile(const std::filesystem::path& path);
  const VtuGrid& grid() const { return grid_; }
  bool has(const std::string& name) const { return !element_of(name).empty(); }
  // Values of an array, row by row; T is the type in the file. Throws Error(bad_input) for an array that is missing or
  // does not have one row per point or cell.
  template <class T>
  std::vector<T> read(const std::string& name, VtkRows rows, std::size_t components = 1) const;
  template <class T>
  std::vector<T> values_of(const std::string& name) const;  // values of an array of any length
  // Values of an int32 array, in [0, count).
  std::vector<std::int32_t> read_indices(const std::string& name, VtkRows rows, std::size_t count) const;
  [[noreturn]] void refuse(const std::string& why) const;  // Error(bad_input)

 private:
  void read_grid();
  std::string element_of(const std::string& name) const;  // XML element of an array; empty: there is none
  std::string bytes_of(const std::string& name, const char* type) const;
  std::string unpacked(std::size_t place) const;
  std::uint64_t word_at(std::size_t* place) const;  // reads a word and moves *place past it

  std::filesystem::path path_;
  std::string file_;
  std::size_t data_ = 0;  // place of the appended arrays
  bool compressed_ = false;
  VtuGrid grid_;
};

// Times of the frames of FOLDER/NAME.pvd, s. Throws Error(bad_input) for a file that is no collection.
std::vector<double> read_collection(const std::filesystem::path& folder, const std::string& name);

}  // namespace quoin
