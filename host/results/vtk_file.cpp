#include "results/vtk_file.h"

#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <cstring>
#include <utility>

#include "files/markup.h"

namespace quoin {

namespace {

constexpr std::array kSections{"Points", "Cells", "PointData", "CellData"};
constexpr std::uint64_t kBlock = 1 << 18;  // bytes compressed together

// Text as the value of an attribute. Bytes that XML or UTF-8 cannot hold become "?".
std::string xml_text(std::string text) {
  for (char& c : text) {
    const auto code = static_cast<unsigned char>(c);
    if (code < 0x20 || code >= 0x7f) c = '?';
  }
  return escaped(text);
}

// Attributes of an array that all its elements have.
std::string attributes_of(const VtkArray& array) {
  return fmt::format("type=\"{}\" Name=\"{}\" NumberOfComponents=\"{}\"", array.type, xml_text(array.name),
                     array.components);
}

std::uint64_t width_of(const VtkArray& array) {  // width of a value, bytes
  const std::string type = array.type;
  return type == "UInt8" ? 1 : type == "Int64" ? 8 : 4;
}

std::string words(const std::vector<std::uint64_t>& values) {
  std::string bytes(values.size() * sizeof values[0], '\0');
  std::memcpy(bytes.data(), values.data(), bytes.size());
  return bytes;
}

constexpr const char* kTail = "\n</AppendedData>\n</VTKFile>\n";

}  // namespace

std::uint64_t VtkArray::bytes(const VtkSizes& sizes) const {
  const std::uint64_t of_rows = rows == VtkRows::point  ? sizes.points
                                : rows == VtkRows::cell ? sizes.cells
                                                        : sizes.corners;
  return of_rows * static_cast<std::uint64_t>(components) * width_of(*this);
}

VtkFile::VtkFile(const std::filesystem::path& path, std::vector<VtkArray> arrays, const VtkSizes& sizes,
                 bool compressed)
    : file_(path), arrays_(std::move(arrays)), sizes_(sizes), compressed_(compressed) {
  if (compressed_) {
    open_.resize(arrays_.size()), packed_.resize(arrays_.size()), block_.resize(arrays_.size());
    return;
  }
  std::uint64_t end = 0;
  for (const VtkArray& array : arrays_) {
    begin_.push_back(end);
    end += sizeof(std::uint64_t) + array.bytes(sizes_);
  }
  const std::string text = head();
  file_.write_at(0, text);
  for (std::size_t i = 0; i < arrays_.size(); ++i) {
    place_.push_back(text.size() + begin_[i]);
    append(i, words({arrays_[i].bytes(sizes_)}));
  }
  file_.write_at(text.size() + end, std::string(kTail));
}

void VtkFile::append(std::size_t array, const std::string& bytes) {
  if (compressed_) {
    open_[array] += bytes;
    return pack(array, false);
  }
  file_.write_at(place_[array], bytes);
  place_[array] += bytes.size();
}

// Compresses full blocks; rest: also what remains.
void VtkFile::pack(std::size_t array, bool rest) {
  std::string &values = open_[array], &packed = packed_[array];
  std::size_t done = 0;
  while (values.size() - done >= kBlock || (rest && done < values.size())) {
    const std::size_t size = std::min<std::size_t>(kBlock, values.size() - done), before = packed.size();
    uLongf room = compressBound(size);
    packed.resize(before + room);
    compress2(reinterpret_cast<Bytef*>(packed.data() + before), &room,
              reinterpret_cast<const Bytef*>(values.data() + done), size, Z_BEST_SPEED);
    packed.resize(before + room);
    block_[array].push_back(room);
    done += size;
  }
  values.erase(0, done);
}

void VtkFile::finish() {
  if (compressed_) {
    // Head of the compressed blocks: their number, their size, the size of the last one, and each compressed size.
    std::uint64_t end = 0;
    std::vector<std::string> heads;
    for (std::size_t i = 0; i < arrays_.size(); ++i) {
      pack(i, true);
      std::vector<std::uint64_t> sizes{block_[i].size(), kBlock, arrays_[i].bytes(sizes_) % kBlock};
      sizes.insert(sizes.end(), block_[i].begin(), block_[i].end());
      heads.push_back(words(sizes));
      begin_.push_back(end);
      end += heads.back().size() + packed_[i].size();
    }
    std::uint64_t place = 0;
    const auto write = [&](const std::string& bytes) {
      file_.write_at(place, bytes);
      place += bytes.size();
    };
    write(head());
    for (std::size_t i = 0; i < arrays_.size(); ++i) write(heads[i]), write(packed_[i]);
    write(kTail);
  }
  file_.finish();
}

std::string VtkFile::head() const {
  std::string piece = fmt::format("<Piece NumberOfPoints=\"{}\" NumberOfCells=\"{}\">\n", sizes_.points, sizes_.cells);
  for (const char* section : kSections) {
    piece += fmt::format("<{}>\n", section);
    for (std::size_t i = 0; i < arrays_.size(); ++i) {
      if (std::strcmp(arrays_[i].section, section) != 0) continue;
      piece += fmt::format("<DataArray {} format=\"appended\" offset=\"{}\"{}/>\n", attributes_of(arrays_[i]),
                           begin_[i], arrays_[i].components_named);
    }
    piece += fmt::format("</{}>\n", section);
  }
  return fmt::format(
      "<?xml version=\"1.0\"?>\n"
      "<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" "
      "header_type=\"UInt64\"{}>\n<UnstructuredGrid>\n{}</Piece>\n</UnstructuredGrid>\n"
      "<AppendedData encoding=\"raw\">\n_",
      compressed_ ? " compressor=\"vtkZLibDataCompressor\"" : "", piece);
}

void write_vtk_index(const std::filesystem::path& path, const std::vector<VtkArray>& arrays,
                     const std::vector<std::string>& pieces) {
  std::string text =
      "<?xml version=\"1.0\"?>\n<VTKFile type=\"PUnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" "
      "header_type=\"UInt64\">\n<PUnstructuredGrid GhostLevel=\"0\">\n";
  for (const char* section : kSections) {
    if (std::strcmp(section, "Cells") == 0) continue;
    text += fmt::format("<P{}>\n", section);
    for (const VtkArray& array : arrays) {
      if (std::strcmp(array.section, section) == 0)
        text += fmt::format("<PDataArray {}{}/>\n", attributes_of(array), array.components_named);
    }
    text += fmt::format("</P{}>\n", section);
  }
  for (const std::string& piece : pieces) text += fmt::format("<Piece Source=\"{}\"/>\n", piece);
  write_file(path, text + "</PUnstructuredGrid>\n</VTKFile>\n");
}

void write_collection(const std::filesystem::path& folder, const std::string& name, const std::vector<double>& times) {
  std::string text = "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"1.0\">\n<Collection>\n";
  for (std::size_t i = 0; i < times.size(); ++i) {
    std::error_code none;
    const bool in_pieces = std::filesystem::exists(folder / fmt::format("{}_{:04}.pvtu", name, i), none);
    text += fmt::format("<DataSet timestep=\"{:.9g}\" file=\"{}_{:04}.{}\"/>\n", times[i], name, i,
                        in_pieces ? "pvtu" : "vtu");
  }
  write_file(folder / (name + ".pvd"), text + "</Collection>\n</VTKFile>\n");
}

}  // namespace quoin
