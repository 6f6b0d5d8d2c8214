// Arrays of VTK's XML files, raw or compressed, in one appended block.
#pragma once

#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <string>
#include <type_traits>
#include <vector>

#include "files/file.h"
#include "files/markup.h"

namespace quoin {

// As the value of an attribute. Bytes that XML or UTF-8 cannot hold become "?".
inline std::string xml_text(std::string text) {
  for (char& c : text) {
    const auto code = static_cast<unsigned char>(c);
    if (code < 0x20 || code >= 0x7f) c = '?';
  }
  return escaped(text);
}

template <typename T>
constexpr const char* kVtkType = std::is_same_v<T, float>          ? "Float32"
                                 : std::is_same_v<T, std::int32_t> ? "Int32"
                                 : std::is_same_v<T, std::uint8_t> ? "UInt8"
                                                                   : "Int64";

class VtkArrays {
 public:
  explicit VtkArrays(bool compressed = false) : compressed_(compressed) {}  // by zlib, as every reader of VTK reads it
  // The element that names the array; its values go to the appended block. T: float, int32_t, uint8_t or int64_t.
  template <typename T>
  std::string add(const std::string& name, const std::vector<T>& values, int components = 1, const char* extra = "") {
    std::string element = fmt::format(
        "<DataArray type=\"{}\" Name=\"{}\" NumberOfComponents=\"{}\" format=\"appended\" offset=\"{}\"{}/>\n",
        kVtkType<T>, xml_text(name), components, appended_.size(), extra);
    const std::uint64_t bytes = values.size() * sizeof(T);
    if (compressed_) {
      append_compressed(reinterpret_cast<const Bytef*>(values.data()), bytes);
    } else {
      append(&bytes, sizeof bytes);
      append(values.data(), bytes);
    }
    return element;
  }

  // An unstructured grid: the <Piece> with its arrays.
  void write(const std::filesystem::path& path, const std::string& piece) const {
    write_file(path, fmt::format("<?xml version=\"1.0\"?>\n"
                                 "<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" "
                                 "header_type=\"UInt64\"{}>\n<UnstructuredGrid>\n{}</UnstructuredGrid>\n"
                                 "<AppendedData encoding=\"raw\">\n_",
                                 compressed_ ? " compressor=\"vtkZLibDataCompressor\"" : "", piece) +
                         appended_ + "\n</AppendedData>\n</VTKFile>\n");
  }

 private:
  void append(const void* data, std::size_t bytes) {
    if (bytes > 0) appended_.append(static_cast<const char*>(data), bytes);
  }
  // Blocks of one size and a rest; before them their number, that size, the rest, and what each is packed to.
  void append_compressed(const Bytef* data, std::uint64_t bytes) {
    constexpr std::uint64_t kBlock = 1 << 18;
    std::vector<std::uint64_t> head{(bytes + kBlock - 1) / kBlock, kBlock, bytes % kBlock};
    std::string packed;
    for (std::uint64_t begin = 0; begin < bytes; begin += kBlock) {
      const std::uint64_t size = std::min(kBlock, bytes - begin);
      uLongf room = compressBound(size);
      const std::size_t before = packed.size();
      packed.resize(before + room);
      compress2(reinterpret_cast<Bytef*>(packed.data() + before), &room, data + begin, size, Z_BEST_SPEED);
      packed.resize(before + room);
      head.push_back(room);
    }
    append(head.data(), head.size() * sizeof head[0]);
    append(packed.data(), packed.size());
  }
  bool compressed_;
  std::string appended_;
};

// FOLDER/NAME.pvd: the files NAME_0000.vtu, ... over time, s; or NAME_0000.pvtu, which name pieces.
inline void write_collection(const std::filesystem::path& folder, const std::string& name,
                             const std::vector<double>& times) {
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
