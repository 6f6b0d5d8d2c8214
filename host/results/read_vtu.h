// The VTU files of a run, read back: those that vtk_file.h writes, and no others. What a file says of itself is checked
// before it is used, so that no byte of it can do harm.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "results/vtk_file.h"

namespace quoin {

// Cells of a grid: cell c has the corners [end[c - 1], end[c]) of `corner`, indices of points, as many as its type has.
struct VtuGrid {
  std::vector<float> position;  // places of points, x y z, finite numbers
  std::vector<std::size_t> corner, end;
  std::vector<std::uint8_t> type;
  std::size_t points() const { return position.size() / 3; }
  std::size_t cells() const { return type.size(); }
  std::size_t first_corner(std::size_t cell) const { return cell == 0 ? 0 : end[cell - 1]; }
};

class VtuFile {
 public:
  // Throws Error(bad_input): no such file, not one of ours, or a damaged one.
  explicit VtuFile(const std::filesystem::path& path);
  const VtuGrid& grid() const { return grid_; }
  bool has(const std::string& name) const { return !element_of(name).empty(); }
  // Values of an array, its components side by side; T as it was written. Throws Error(bad_input) where there is none,
  // or not one row for each point or cell.
  template <class T>
  std::vector<T> read(const std::string& name, VtkRows rows, std::size_t components = 1) const;
  template <class T>
  std::vector<T> values_of(const std::string& name) const;  // the same, of any number
  // Values of int32, in [0, count).
  std::vector<std::int32_t> read_indices(const std::string& name, VtkRows rows, std::size_t count) const;
  [[noreturn]] void refuse(const std::string& why) const;  // Error(bad_input)

 private:
  void read_grid();
  std::string element_of(const std::string& name) const;  // element of the XML; empty: there is none
  std::string bytes_of(const std::string& name, const char* type) const;
  std::string unpacked(std::size_t place) const;
  std::uint64_t word_at(std::size_t* place) const;  // and past it

  std::filesystem::path path_;
  std::string file_;
  std::size_t data_ = 0;  // where the appended arrays begin
  bool compressed_ = false;
  VtuGrid grid_;
};

// Times of the frames of FOLDER/NAME.pvd, s. Throws Error(bad_input) for a collection that is none.
std::vector<double> read_collection(const std::filesystem::path& folder, const std::string& name);

}  // namespace quoin
