// A VTK XML file: an unstructured grid whose arrays, raw or compressed, lie in one appended block. Rows are appended
// one by one, so that no rank needs the whole array in memory.
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

// Items with one row each of an array.
enum class VtkRows { point, cell, corner };

// Numbers of rows.
struct VtkSizes {
  std::uint64_t points = 0, cells = 0, corners = 0;
  VtkSizes& operator+=(const VtkSizes& more) {
    points += more.points, cells += more.cells, corners += more.corners;
    return *this;
  }
};

struct VtkArray {
  const char* section;  // XML element: "Points", "Cells", "PointData" or "CellData"
  std::string name;
  const char* type;  // kVtkType
  int components = 1;
  VtkRows rows = VtkRows::point;
  const char* components_named = "";  // attributes with the names of components
  std::uint64_t bytes(const VtkSizes& sizes) const;
};

class VtkFile {
 public:
  // compressed: by zlib. All throw Error(bad_input). Without finish() there is no file.
  VtkFile(const std::filesystem::path& path, std::vector<VtkArray> arrays, const VtkSizes& sizes, bool compressed);
  // Appends values of an array, with their bytes in memory.
  void append(std::size_t array, const std::string& bytes);
  void finish();

 private:
  std::string head() const;
  void pack(std::size_t array, bool rest);

  PlacedFile file_;
  std::vector<VtkArray> arrays_;
  VtkSizes sizes_;
  bool compressed_;
  // By array. Raw: place_ of its next values. Compressed: open_ values that do not fill a block yet, then packed_
  // blocks one after the other with the sizes block_.
  std::vector<std::uint64_t> place_, begin_;  // begin_: in the appended block
  std::vector<std::string> open_, packed_;
  std::vector<std::vector<std::uint64_t>> block_;
};

// Writes the index of a grid in pieces, each with these arrays.
void write_vtk_index(const std::filesystem::path& path, const std::vector<VtkArray>& arrays,
                     const std::vector<std::string>& pieces);

// Writes FOLDER/NAME.pvd, a collection of NAME_0000.vtu, ... over time, s; or of NAME_0000.pvtu, ..., which list
// pieces.
void write_collection(const std::filesystem::path& folder, const std::string& name, const std::vector<double>& times);

}  // namespace quoin
