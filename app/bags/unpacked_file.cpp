#include "app/bags/unpacked_file.hpp"

#include <fmt/format.h>
#include <stdlib.h>
#include <unistd.h>
#include <zstd.h>

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <memory>
#include <new>
#include <span>
#include <system_error>

#include "app/bags/byte_file.hpp"
#include "calib/base/error.hpp"

namespace fs = std::filesystem;

namespace ceilmap::bags {
namespace {

[[noreturn]] void ThrowNoRoom(const fs::path& folder) {
  throw RunError(
      fmt::format("{}: a bag cannot be decompressed there ({}); name a folder with more "
                  "room by the environment variable TMPDIR",
                  folder.string(),
                  std::generic_category().message(errno)));
}

void WriteAll(int descriptor, std::span<const std::uint8_t> bytes, const fs::path& folder) {
  while (!bytes.empty()) {
    const ssize_t count = write(descriptor, bytes.data(), bytes.size());
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) ThrowNoRoom(folder);
    bytes = bytes.subspan(static_cast<std::size_t>(count));
  }
}

}  // namespace

UnpackedFile::UnpackedFile(const fs::path& packed) {
  std::string name = (fs::temp_directory_path() / "ceilmap-bag-XXXXXX").string();
  const int descriptor = mkstemp(name.data());
  if (descriptor < 0) ThrowNoRoom(fs::temp_directory_path());
  path_ = name;
  try {
    Unpack(packed, descriptor);
  } catch (...) {
    close(descriptor);
    unlink(path_.c_str());
    throw;
  }
  close(descriptor);
}

UnpackedFile::~UnpackedFile() {
  unlink(path_.c_str());
}

void UnpackedFile::Unpack(const fs::path& packed, int descriptor) {
  // A recording of black images may become a thousandth; more than that is made to fill the disk.
  constexpr std::uint64_t kAlwaysAllowed = std::uint64_t{1} << 30U;
  constexpr std::uint64_t kMaxPerByte = 1000;
  const std::unique_ptr<ZSTD_DCtx, decltype(&ZSTD_freeDCtx)> context(ZSTD_createDCtx(),
                                                                     &ZSTD_freeDCtx);
  if (!context) throw std::bad_alloc();
  const ByteFile file(packed, packed.string());
  Buffer in_bytes;
  Buffer out_bytes;
  out_bytes.Resize(ZSTD_DStreamOutSize());
  const std::uint64_t most = std::max(kAlwaysAllowed, kMaxPerByte * file.Size());
  std::uint64_t written = 0;
  std::size_t left = 1;
  for (std::uint64_t at = 0; at < file.Size(); at += in_bytes.Size()) {
    in_bytes.Resize(
        static_cast<std::size_t>(std::min<std::uint64_t>(ZSTD_DStreamInSize(), file.Size() - at)));
    file.Read(at, in_bytes.Bytes());
    ZSTD_inBuffer in{in_bytes.Data(), in_bytes.Size(), 0};
    bool full = true;
    while (in.pos < in.size || full) {
      ZSTD_outBuffer out{out_bytes.Data(), out_bytes.Size(), 0};
      left = ZSTD_decompressStream(context.get(), &out, &in);
      if (ZSTD_isError(left) != 0) return;
      full = out.pos == out.size;
      written += out.pos;
      if (written > most) {
        throw InputError(
            fmt::format("{}: becomes more than {} GB, which no recording of {} bytes does",
                        file.Name(),
                        most >> 30U,
                        file.Size()));
      }
      WriteAll(descriptor, out_bytes.Bytes().first(out.pos), path_.parent_path());
    }
  }
  complete_ = left == 0;
}

}  // namespace ceilmap::bags
