#include "app/bags/bag_reader.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <string_view>
#include <system_error>

#include "app/bags/mcap_bag.hpp"
#include "app/bags/mcap_records.hpp"
#include "calib/base/error.hpp"

namespace fs = std::filesystem;

namespace ceilmap::bags {
namespace {

enum class BagKind : std::uint8_t { kNone, kMcap, kRos1, kSqlite, kFolder };

bool HasAt(std::span<const char> bytes, std::size_t at, std::string_view text) {
  return bytes.size() >= at + text.size() &&
         std::equal(text.begin(), text.end(), bytes.begin() + static_cast<std::ptrdiff_t>(at));
}

// By the first bytes of a file; maps (GeoPackages) are SQLite databases too, with another
// application_id.
BagKind KindOf(const fs::path& path) {
  std::error_code ignored;
  if (fs::is_directory(path, ignored)) {
    return fs::is_regular_file(path / "metadata.yaml", ignored) ? BagKind::kFolder : BagKind::kNone;
  }
  if (!fs::is_regular_file(path, ignored)) return BagKind::kNone;
  std::array<char, 72> buffer{};
  std::ifstream stream(path, std::ios::binary);
  stream.read(buffer.data(), buffer.size());
  const auto start = std::span(buffer).first(static_cast<std::size_t>(stream.gcount()));
  constexpr std::size_t kApplicationIdAt = 68;
  if (HasAt(start, 0, {reinterpret_cast<const char*>(mcap::kMagic.data()), mcap::kMagic.size()})) {
    return BagKind::kMcap;
  }
  if (HasAt(start, 0, "#ROSBAG V")) return BagKind::kRos1;
  const bool package = HasAt(start, kApplicationIdAt, "GP");
  if (HasAt(start, 0, {"SQLite format 3\0", 16}) && !package) return BagKind::kSqlite;
  return BagKind::kNone;
}

}  // namespace

bool BagReader::IsBag(const fs::path& path) {
  return KindOf(path) != BagKind::kNone;
}

std::unique_ptr<BagReader> BagReader::Open(const fs::path& path) {
  std::error_code ignored;
  if (!fs::exists(path, ignored)) {
    throw InputError(fmt::format("{}: no such file", path.string()));
  }
  switch (KindOf(path)) {
    case BagKind::kMcap:
      return std::make_unique<McapBag>(path);
    default:
      throw InputError(fmt::format(
          "{}: is no bag; must be MCAP, rosbag2 (.db3 or its folder with metadata.yaml) or ROS 1",
          path.string()));
  }
}

}  // namespace ceilmap::bags
