#include "app/files/image_pairs.hpp"

#include <fmt/format.h>

#include <set>
#include <system_error>

#include "app/files/text_file.hpp"
#include "calib/base/error.hpp"
#include "calib/base/one_line.hpp"

namespace fs = std::filesystem;

namespace ceilmap::files {

std::vector<ImagePair> ReadPairs(const fs::path& file) {
  return PairsIn(ReadCsv(file));
}

std::vector<ImagePair> PairsIn(const CsvTable& table) {
  const std::size_t id = table.Column("id");
  const std::size_t reference = table.Column("reference");
  const std::size_t current = table.Column("current");
  constexpr std::size_t kMaxPathBytes = 1000;
  std::set<std::string> ids;
  std::vector<ImagePair> pairs;
  const fs::path folder = fs::path(table.name).parent_path();
  for (const CsvTable::Row& row : table.rows) {
    const ImagePair pair{row.fields[id],
                         folder / row.fields[reference],
                         folder / row.fields[current],
                         table.Place(row)};
    if (!ids.insert(pair.id).second) {
      throw InputError(fmt::format("{}: the id '{}' occurs twice", pair.place, Shown(pair.id)));
    }
    for (const fs::path& image : {pair.reference, pair.current}) {
      std::error_code ignored;
      if (fs::is_regular_file(image, ignored)) continue;
      throw InputError(
          fmt::format("{}: {}: no such file", pair.place, Shown(image.string(), kMaxPathBytes)));
    }
    pairs.push_back(pair);
  }
  if (pairs.empty()) throw InputError(fmt::format("{}: holds no pairs", table.name));
  return pairs;
}

}  // namespace ceilmap::files
