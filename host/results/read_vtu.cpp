#include "results/read_vtu.h"

#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <cmath>
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

// Number of corners of a cell of this type; none: any number from 3 on, for a polygon; -1: a type that Quoin does not
// write.
long corners_of(std::uint8_t type) {
  switch (type) {
    case 1:
      return 1;
    case 3:
      return 2;
    case 7:
      return 0;
    case 9:
    case 10:
      return 4;
    case 12:
      return 8;
    default:
      return -1;
  }
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
  read_grid();
}

void VtuFile::refuse(const std::string& why) const {
  throw Error(Exit::bad_input, fmt::format("{}: {}; run the scene again", path_.string(), why));
}

void VtuFile::read_grid() {
  grid_.position = values_of<float>("position");
  if (grid_.position.size() % 3 != 0) refuse("is damaged: a point has three coordinates");
  if (!std::all_of(grid_.position.begin(), grid_.position.end(), [](float x) { return std::isfinite(x); }))
    refuse("is damaged: the place of a point is no number");
  const auto corner = values_of<std::int64_t>("connectivity"), end = values_of<std::int64_t>("offsets");
  grid_.type = values_of<std::uint8_t>("types");
  if (end.size() != grid_.type.size()) refuse("is damaged: cells without a type, or types without a cell");
  const auto points = static_cast<std::int64_t>(grid_.points());
  for (const std::int64_t point : corner) {
    if (point < 0 || point >= points) refuse(fmt::format("is damaged: a cell at point {} of {}", point, points));
    grid_.corner.push_back(static_cast<std::size_t>(point));
  }
  std::int64_t before = 0;
  for (std::size_t c = 0; c < end.size(); ++c) {
    const std::int64_t count = end[c] - before;
    const long wanted = corners_of(grid_.type[c]);
    if (end[c] < 0 || end[c] > static_cast<std::int64_t>(corner.size()) || wanted < 0 ||
        (wanted > 0 ? count != wanted : count < 3))
      refuse(fmt::format("is damaged: cell {} has type {} and ends at corner {} of {}", c, grid_.type[c], end[c],
                         corner.size()));
    before = end[c];
    grid_.end.push_back(static_cast<std::size_t>(end[c]));
  }
  if (before != static_cast<std::int64_t>(corner.size())) refuse("is damaged: it has corners without a cell");
}

std::string VtuFile::element_of(const std::string& name) const {
  const std::size_t at = file_.find(fmt::format(" Name=\"{}\"", name));
  if (at == std::string::npos || at > data_) return "";
  const std::size_t begin = file_.rfind('<', at);
  if (begin == std::string::npos) return "";
  return file_.substr(begin, file_.find('>', begin) - begin);
}

std::uint64_t VtuFile::word_at(std::size_t* place) const {
  std::uint64_t value = 0;
  if (*place > file_.size() || file_.size() - *place < sizeof value) refuse("is cut off");
  std::memcpy(&value, file_.data() + *place, sizeof value);
  *place += sizeof value;
  return value;
}

std::string VtuFile::bytes_of(const std::string& name, const char* type) const {
  const std::string element = element_of(name);
  if (element.empty()) refuse(fmt::format("has no array '{}'", name));
  if (attribute(element, "type") != type) refuse(fmt::format("the array '{}' is not of type {}", name, type));
  std::uint64_t offset = 0;
  if (!parse_number(attribute(element, "offset"), offset))
    refuse(fmt::format("is damaged: nothing says where the array '{}' is", name));
  if (offset > file_.size() - data_) refuse("is cut off");
  std::size_t place = data_ + static_cast<std::size_t>(offset);
  if (compressed_) return unpacked(place);
  const std::uint64_t bytes = word_at(&place);
  if (bytes > file_.size() - place) refuse("is cut off");
  return file_.substr(place, bytes);
}

// Decompresses the blocks of an array. Their head has the number of blocks, the size of each, the size of the last one
// (0: full size), and each compressed size.
std::string VtuFile::unpacked(std::size_t place) const {
  // zlib compresses by 1032 at most: a larger ratio means a damaged file, which would fill the memory.
  constexpr std::uint64_t kBest = 1100, kLeast = 1024;
  const std::uint64_t blocks = word_at(&place), whole = word_at(&place), last = word_at(&place);
  if (blocks > file_.size() / sizeof blocks) refuse("is damaged");
  std::vector<std::uint64_t> packed(blocks);
  for (std::uint64_t& size : packed) size = word_at(&place);
  std::string bytes;
  for (std::uint64_t b = 0; b < blocks; ++b) {
    if (packed[b] > file_.size() - place) refuse("is cut off");
    const std::uint64_t wanted = b + 1 == blocks && last > 0 ? last : whole;
    if (wanted > kBest * packed[b] + kLeast) refuse("is damaged");
    uLongf size = wanted;
    const std::size_t before = bytes.size();
    bytes.resize(before + size);
    if (uncompress(reinterpret_cast<Bytef*>(bytes.data() + before), &size,
                   reinterpret_cast<const Bytef*>(file_.data() + place), packed[b]) != Z_OK ||
        size != wanted)
      refuse("is damaged");
    place += packed[b];
  }
  return bytes;
}

template <class T>
std::vector<T> VtuFile::values_of(const std::string& name) const {
  const std::string bytes = bytes_of(name, kVtkType<T>);
  if (bytes.size() % sizeof(T) != 0) refuse(fmt::format("is damaged: the array '{}' ends inside a value", name));
  std::vector<T> values(bytes.size() / sizeof(T));
  if (!values.empty()) std::memcpy(values.data(), bytes.data(), bytes.size());
  return values;
}

template std::vector<float> VtuFile::values_of(const std::string&) const;
template std::vector<std::int32_t> VtuFile::values_of(const std::string&) const;
template std::vector<std::uint8_t> VtuFile::values_of(const std::string&) const;
template std::vector<std::int64_t> VtuFile::values_of(const std::string&) const;

template <class T>
std::vector<T> VtuFile::read(const std::string& name, VtkRows rows, std::size_t components) const {
  std::vector<T> values = values_of<T>(name);
  const std::size_t wanted = components * (rows == VtkRows::cell ? grid_.cells() : grid_.points());
  if (values.size() != wanted)
    refuse(fmt::format("is damaged: the array '{}' has {} values in place of {}", name, values.size(), wanted));
  return values;
}
template std::vector<float> VtuFile::read(const std::string&, VtkRows, std::size_t) const;
template std::vector<std::int32_t> VtuFile::read(const std::string&, VtkRows, std::size_t) const;

std::vector<std::int32_t> VtuFile::read_indices(const std::string& name, VtkRows rows, std::size_t count) const {
  std::vector<std::int32_t> values = read<std::int32_t>(name, rows);
  for (const std::int32_t value : values) {
    if (value < 0 || static_cast<std::size_t>(value) >= count)
      refuse(fmt::format("is damaged: the array '{}' has the value {}, which is not from 0 to {}", name, value,
                         count - 1));
  }
  return values;
}

std::vector<double> read_collection(const std::filesystem::path& folder, const std::string& name) {
  const std::string path = (folder / (name + ".pvd")).string(), text = read_input_file(path);
  std::vector<double> times;
  for (std::size_t at = 0; (at = text.find("<DataSet", at)) != std::string::npos; ++at) {
    double& time = times.emplace_back(0.0);
    if (!parse_number(attribute(text.substr(at, text.find('>', at) - at), "timestep"), time) || !std::isfinite(time))
      throw Error(Exit::bad_input,
                  fmt::format("{}: is damaged: frame {} has no time; run the scene again", path, times.size()));
  }
  return times;
}

}  // namespace quoin
