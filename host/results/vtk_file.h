// One of VTK's XML files: an unstructured grid whose arrays, raw or compressed, lie in one appended block. They come
// row by row, so that nobody needs all of them at once.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <type_traits>
#include <vector>

#include "files/file.h"

namespace quoin {

template <typename T>
constexpr const char* kVtkType = std::is_same_v<T, float>          ? "Float32"
                                 : std::is_same_v<T, std::int32_t> ? "Int32"
                                 : std::is_same_v<T, std::uint8_t> ? "UInt8"
                                                                   : "Int64";

// Items of which an array has one row each.
enum class VtkRows { point, cell, corner };

// How many rows there are.
struct VtkSizes {
  std::uint64_t points = 0, cells = 0, corners = 0;
  VtkSizes& operator+=(const VtkSizes& more) {
    points += more.points, cells += more.cells, corners += more.corners;
    return *this;
  }
};

struct VtkArray {
  const char* section;  // element of the XML: "Points", "Cells", "PointData" or "CellData"
  std::string name;
  const char* type;  // kVtkType
  int components = 1;
  VtkRows rows = VtkRows::point;
  const char* components_named = "";  // attributes that name them
  std::uint64_t bytes(const VtkSizes& sizes) const;
};

class VtkFile {
 public:
  // compressed: by zlib, as every reader of VTK reads it. All throw Error(bad_input); the file is not there without
  // finish().
  VtkFile(const std::filesystem::path& path, std::vector<VtkArray> arrays, const VtkSizes& sizes, bool compressed);
  // The next values of an array, as they lie in memory.
  void append(std::size_t array, const std::string& bytes);
  void finish();

 private:
  std::string head() const;
  void pack(std::size_t array, bool rest);

  PlacedFile file_;
  std::vector<VtkArray> arrays_;
  VtkSizes sizes_;
  bool compressed_;
  // By array. Raw: where its next values go. Compressed: those that fill no block yet, then blocks one after the other
  // and their sizes.
  std::vector<std::uint64_t> place_, begin_;  // begin: in the appended block
  std::vector<std::string> open_, packed_;
  std::vector<std::vector<std::uint64_t>> block_;
};

// What names the files of a grid in pieces, each with these arrays.
void write_vtk_index(const std::filesystem::path& path, const std::vector<VtkArray>& arrays,
                     const std::vector<std::string>& pieces);

// FOLDER/NAME.pvd: the files NAME_0000.vtu, ... over time, s; or NAME_0000.pvtu, which name pieces.
void write_collection(const std::filesystem::path& folder, const std::string& name, const std::vector<double>& times);

}  // namespace quoin
