#include "results/read_vtu.h"

#include <fmt/format.h>
#include <zlib.h>

#include <cstdlib>
#include <cstring>
#include <limits>

#include "base/error.h"
#include "base/input_file.h"
#include "base/number_text.h"

namespace quoin {

namespace {

std::string attribute(const std::string& element, const std::string& name) {
  const std::string key = " " + name + "=\"";
  const std::size_t begin = element.find(key);
  if (begin == std::string::npos) return "";
  const std::size_t from = begin + key.size();
  return element.substr(from, element.find('"', from) - from);
}

template <class T>
constexpr const char* type_name() {
  if constexpr (std::is_same_v<T, float>) return "Float32";
  if constexpr (std::is_same_v<T, std::int32_t>) return "Int32";
  if constexpr (std::is_same_v<T, std::uint8_t>) return "UInt8";
  return "Int64";
}

}  // namespace

VtuFile::VtuFile(const std::filesystem::path& path)
    : path_(path), file_(read_input_file(path.string(), std::numeric_limits<std::size_t>::max())) {
  const std::size_t appended = file_.find("<AppendedData encoding=\"raw\">\n_");
  const std::size_t head = file_.find("<VTKFile ");
  if (appended == std::string::npos || head == std::string::npos || head > appended)
    refuse("is no file of results of quoin");
  data_ = file_.find('_', appended) + 1;
  compressed_ = !attribute(file_.substr(head, file_.find('>', head) - head), "compressor").empty();
}

void VtuFile::refuse(const std::string& why) const {
  throw Error(Exit::bad_input, fmt::format("{}: {}; run the scene again", path_.string(), why));
}

std::string VtuFile::bytes_of(const std::string& name, const char* type) const {
  const std::size_t at = file_.find(fmt::format(" Name=\"{}\"", name));
  if (at == std::string::npos || at > data_) refuse(fmt::format("has no array '{}'", name));
  const std::size_t begin = file_.rfind('<', at);
  const std::string element = file_.substr(begin, file_.find('>', begin) - begin);
  if (attribute(element, "type") != type) refuse(fmt::format("the array '{}' is not of type {}", name, type));
  std::size_t place = data_ + std::strtoull(attribute(element, "offset").c_str(), nullptr, 10);
  const auto word = [&] {
    std::uint64_t value = 0;
    if (place > file_.size() || file_.size() - place < sizeof value) refuse("is cut off");
    std::memcpy(&value, file_.data() + place, sizeof value);
    place += sizeof value;
    return value;
  };
  if (!compressed_) {
    const std::uint64_t bytes = word();
    if (bytes > file_.size() - place) refuse("is cut off");
    return file_.substr(place, bytes);
  }
  const std::uint64_t blocks = word(), whole = word(), last = word();
  if (blocks > file_.size() / sizeof blocks || whole > std::uint64_t{1} << 40) refuse("is damaged");
  std::vector<std::uint64_t> packed(blocks);
  for (std::uint64_t& size : packed) size = word();
  std::string bytes;
  for (std::uint64_t b = 0; b < blocks; ++b) {
    if (packed[b] > file_.size() - place) refuse("is cut off");
    uLongf size = b + 1 == blocks && last > 0 ? last : whole;
    const std::size_t before = bytes.size();
    bytes.resize(before + size);
    if (uncompress(reinterpret_cast<Bytef*>(bytes.data() + before), &size,
                   reinterpret_cast<const Bytef*>(file_.data() + place), packed[b]) != Z_OK)
      refuse("is damaged");
    place += packed[b];
  }
  return bytes;
}

template <class T>
std::vector<T> VtuFile::read(const std::string& name) const {
  const std::string bytes = bytes_of(name, type_name<T>());
  std::vector<T> values(bytes.size() / sizeof(T));
  if (!values.empty()) std::memcpy(values.data(), bytes.data(), values.size() * sizeof(T));
  return values;
}
template std::vector<float> VtuFile::read(const std::string&) const;
template std::vector<std::int32_t> VtuFile::read(const std::string&) const;
template std::vector<std::uint8_t> VtuFile::read(const std::string&) const;
template std::vector<std::int64_t> VtuFile::read(const std::string&) const;

std::vector<double> read_collection(const std::filesystem::path& folder, const std::string& name) {
  const std::string text = read_input_file((folder / (name + ".pvd")).string());
  std::vector<double> times;
  for (std::size_t at = 0; (at = text.find("<DataSet", at)) != std::string::npos; ++at) {
    double time = 0.0;
    parse_number(attribute(text.substr(at, text.find('>', at) - at), "timestep"), time);
    times.push_back(time);
  }
  return times;
}

}  // namespace quoin
