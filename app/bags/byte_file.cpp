#include "app/bags/byte_file.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <system_error>
#include <utility>

#include "calib/base/error.hpp"

namespace ceilmap::bags {
namespace {

[[noreturn]] void ThrowUnreadable(const std::string& name, int error) {
  throw InputError(
      fmt::format("{}: cannot be read ({})", name, std::generic_category().message(error)));
}

}  // namespace

void Buffer::Resize(std::size_t size) {
  if (size > capacity_) {
    bytes_.reset();  // before the new memory is taken
    bytes_ = std::make_unique_for_overwrite<std::uint8_t[]>(size);
    capacity_ = size;
  }
  size_ = size;
}

void Buffer::Grow(std::size_t size) {
  if (size > capacity_) {
    auto grown = std::make_unique_for_overwrite<std::uint8_t[]>(size);
    std::copy_n(bytes_.get(), size_, grown.get());
    bytes_ = std::move(grown);
    capacity_ = size;
  }
  size_ = size;
}

ByteFile::ByteFile(const std::filesystem::path& path, std::string name) : name_(std::move(name)) {
  descriptor_ = open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);  // a pipe does not block
  if (descriptor_ < 0) {
    if (errno == ENOENT) throw InputError(fmt::format("{}: no such file", name_));
    ThrowUnreadable(name_, errno);
  }
  struct stat status {};
  const bool regular = fstat(descriptor_, &status) == 0 && S_ISREG(status.st_mode);
  if (!regular) {
    close(descriptor_);
    throw InputError(fmt::format("{}: is no file; a bag must be one", name_));
  }
  size_ = static_cast<std::uint64_t>(status.st_size);
  posix_fadvise(descriptor_, 0, 0, POSIX_FADV_SEQUENTIAL);
}

ByteFile::~ByteFile() {
  close(descriptor_);
}

void ByteFile::Read(std::uint64_t at, std::span<std::uint8_t> bytes) const {
  while (!bytes.empty()) {
    const ssize_t count = pread(descriptor_, bytes.data(), bytes.size(), static_cast<off_t>(at));
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) ThrowUnreadable(name_, errno);
    if (count == 0) throw InputError(fmt::format("{}: became shorter while it was read", name_));
    bytes = bytes.subspan(static_cast<std::size_t>(count));
    at += static_cast<std::uint64_t>(count);
  }
}

std::span<const std::uint8_t> FileWindow::View(std::uint64_t at, std::size_t size) {
  if (at >= file_.Size()) return {};
  size = static_cast<std::size_t>(std::min<std::uint64_t>(size, file_.Size() - at));
  if (at < at_ || at + size > at_ + buffer_.Size()) {
    const auto wanted = static_cast<std::size_t>(
        std::min<std::uint64_t>(std::max(size, ahead_), file_.Size() - at));
    buffer_.Resize(0);
    buffer_.Resize(wanted);
    at_ = at;
    file_.Read(at, buffer_.Bytes());
  }
  return buffer_.Bytes().subspan(static_cast<std::size_t>(at - at_), size);
}

}  // namespace ceilmap::bags
