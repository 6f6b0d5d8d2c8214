#include "files/file_bytes.h"

#include <algorithm>

#include "base/input_file.h"

namespace quoin {

namespace {

constexpr std::size_t kWindow = std::size_t{1} << 18;  // bytes; skipping within it is faster than another system call

}  // namespace

FileBytes::FileBytes(const std::filesystem::path& path)
    : path_(path.string()), file_(open_input_file(path_)), end_(file_->size) {}
FileBytes::~FileBytes() = default;

void FileBytes::take(void* to, std::size_t size) {
  auto* bytes = static_cast<std::uint8_t*>(to);
  while (size > 0) {
    if (position_ >= window_begin_ && position_ < window_begin_ + window_.size()) {
      const std::size_t within = position_ - window_begin_, count = std::min(size, window_.size() - within);
      std::memcpy(bytes, window_.data() + within, count);
      bytes += count, size -= count, position_ += count;
    } else if (size >= kWindow) {
      read_at(position_, bytes, size);
      position_ += size;
      return;
    } else {
      window_.resize(std::min(kWindow, end_ - position_));
      window_begin_ = position_;
      read_at(window_begin_, window_.data(), window_.size());
    }
  }
}

void FileBytes::read_at(std::size_t position, void* to, std::size_t size) const {
  auto* bytes = static_cast<std::uint8_t*>(to);
  while (size > 0) {
    const ssize_t count = pread(file_->number, bytes, size, static_cast<off_t>(position));
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) refuse_input(path_, system_words());
    if (count == 0) refuse_input(path_, "it has become shorter meanwhile");
    bytes += count, position += static_cast<std::size_t>(count), size -= static_cast<std::size_t>(count);
  }
}

}  // namespace quoin
