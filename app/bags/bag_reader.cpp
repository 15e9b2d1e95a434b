#include "app/bags/bag_reader.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <string_view>
#include <system_error>

#include "app/bags/folder_bag.hpp"
#include "app/bags/mcap_bag.hpp"
#include "app/bags/mcap_records.hpp"
#include "app/bags/ros1_bag.hpp"
#include "app/bags/sqlite_bag.hpp"
#include "app/bags/unpacked_file.hpp"
#include "app/bags/warning_list.hpp"
#include "calib/base/error.hpp"

namespace fs = std::filesystem;

namespace ceilmap::bags {
namespace {

enum class BagKind : std::uint8_t { kNone, kMcap, kRos1, kSqlite, kZstd, kFolder };

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
  const std::string name = path.filename().string();
  if ((name.ends_with(".db3.zstd") || name.ends_with(".mcap.zstd")) &&
      HasAt(start, 0, "\x28\xB5\x2F\xFD")) {
    return BagKind::kZstd;
  }
  if (HasAt(start, 0, {"SQLite format 3\0", 16}) && !package) return BagKind::kSqlite;
  return BagKind::kNone;
}

// A bag in one file.
std::unique_ptr<BagReader> OpenFile(BagKind kind, const fs::path& path, const std::string& name) {
  switch (kind) {
    case BagKind::kMcap:
      return std::make_unique<McapBag>(path, name);
    case BagKind::kRos1:
      return std::make_unique<Ros1Bag>(path, name);
    case BagKind::kSqlite:
      return std::make_unique<SqliteBag>(path, name);
    default:
      throw InputError(fmt::format(
          "{}: is no bag; must be MCAP, rosbag2 (.db3 or its folder with metadata.yaml) or ROS 1",
          name));
  }
}

// A bag that was compressed as a whole.
class UnpackedBag : public BagReader {
 public:
  explicit UnpackedBag(const fs::path& packed)
      : file_(packed),
        bag_(OpenFile(KindOf(file_.Path()), file_.Path(), packed.string())),
        warnings_(packed.string()) {
    if (!file_.Complete()) {
      warnings_.Add("is cut off or damaged; what can be decompressed is used");
    }
  }

  [[nodiscard]] const std::vector<Topic>& Topics() const override { return bag_->Topics(); }
  [[nodiscard]] BagFacts Facts() const override {
    BagFacts facts = bag_->Facts();
    facts.compression = "zstd";
    return facts;
  }
  void Select(const std::vector<std::size_t>& topics) override { bag_->Select(topics); }
  bool Next(RawMessage& message) override { return bag_->Next(message); }
  [[nodiscard]] std::vector<std::string> Warnings() const override {
    std::vector<std::string> all = warnings_.All();
    for (const std::string& warning : bag_->Warnings()) all.push_back(warning);
    return all;
  }

 private:
  UnpackedFile file_;
  std::unique_ptr<BagReader> bag_;
  WarningList warnings_;
};

}  // namespace

bool BagReader::IsBag(const fs::path& path) {
  return KindOf(path) != BagKind::kNone;
}

std::unique_ptr<BagReader> BagReader::Open(const fs::path& path) {
  std::error_code ignored;
  if (!fs::exists(path, ignored)) {
    throw InputError(fmt::format("{}: no such file", path.string()));
  }
  const BagKind kind = KindOf(path);
  if (kind == BagKind::kFolder) return std::make_unique<FolderBag>(path);
  if (kind == BagKind::kZstd) return std::make_unique<UnpackedBag>(path);
  return OpenFile(kind, path, path.string());
}

}  // namespace ceilmap::bags
