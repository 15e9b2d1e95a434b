// Readers of lines of text: trajectories and tables.

#include <cmath>
#include <filesystem>
#include <limits>
#include <string>

#include "app/files/csv.hpp"
#include "app/files/heading_csv.hpp"
#include "app/files/image_pairs.hpp"
#include "app/files/stamps.hpp"
#include "app/files/status_csv.hpp"
#include "app/files/tum.hpp"
#include "tests/fuzz/promise.hpp"
#include "tests/fuzz/targets.hpp"

namespace ceilmap::fuzz {
namespace {

using files::CsvTable;

std::optional<CsvTable> Table(std::string_view bytes) {
  return Accepted([&] { return files::ParseCsv(bytes, "file.csv"); });
}

// Between strings of numbers that rise there may be one that is not finite only by mistake.
void RequireRising(double before, double now) {
  Require(std::isfinite(now) && now > before, "stamps that do not rise");
}

constexpr double kBeforeAll = -std::numeric_limits<double>::infinity();

}  // namespace

void ReadAsTum(std::string_view bytes) {
  const auto poses = Accepted([&] { return files::ParseTum(bytes, "file.tum"); });
  if (!poses) return;
  Require(!poses->empty(), "no poses");
  double before = kBeforeAll;
  double most = 0;
  double shortest_s = std::numeric_limits<double>::infinity();
  for (const StampedPose& pose : *poses) {
    RequireRising(before, pose.stamp_s);
    Require(pose.position.allFinite() && std::abs(pose.orientation.norm() - 1) < 1.1e-3,
            "a pose that cannot be");
    shortest_s = std::min(shortest_s, pose.stamp_s - before);
    most = std::max({most, std::abs(pose.stamp_s), pose.position.cwiseAbs().maxCoeff()});
    before = pose.stamp_s;
  }
  // What is written keeps microseconds and nanometres.
  if (most > 1e6 || shortest_s < 1e-5) return;
  const auto again = files::ParseTum(files::FormatTum(*poses), "again.tum");
  Require(again.size() == poses->size(), "poses are lost");
  for (std::size_t i = 0; i < again.size(); ++i) {
    Require(std::abs(again[i].stamp_s - (*poses)[i].stamp_s) < 1e-6 &&
                (again[i].position - (*poses)[i].position).norm() < 1e-8,
            "a pose reads back as another one");
  }
}

void ReadAsCsv(std::string_view bytes) {
  const auto table = Table(bytes);
  if (!table) return;
  Require(!table->header.empty(), "no header");
  std::string text = "\xEF\xBB\xBF";  // the header may begin with a second one
  const auto append = [&text](const std::vector<std::string>& fields) {
    for (std::size_t i = 0; i < fields.size(); ++i) {
      text += (i == 0 ? "" : ",") + files::CsvField(fields[i]);
    }
    text += '\n';
  };
  append(table->header);
  for (const CsvTable::Row& row : table->rows) {
    Require(row.fields.size() == table->header.size() && row.line > 0, "a row that cannot be");
    (void)Accepted([&] { return table->Number(row, 0); });
    append(row.fields);
  }
  // A row of one empty field would be a blank line, and blanks about a field are no part of it.
  if (table->header.size() < 2) return;
  const auto again = Table(text);
  Require(again && again->header == table->header && again->rows.size() == table->rows.size(),
          "a table reads back as another one");
  for (std::size_t i = 0; i < table->rows.size(); ++i) {
    Require(again->rows[i].fields == table->rows[i].fields, "a row reads back as another one");
  }
}

void ReadAsStamps(std::string_view bytes) {
  const auto table = Table(bytes);
  if (!table) return;
  const auto stamps = Accepted([&] { return files::StampsIn(*table); });
  if (!stamps) return;
  Require(!stamps->empty() && stamps->size() == table->rows.size(), "stamps are lost");
  double before = kBeforeAll;
  for (const double stamp_s : *stamps) {
    RequireRising(before, stamp_s);
    before = stamp_s;
  }
}

void ReadAsHeadings(std::string_view bytes) {
  const auto table = Table(bytes);
  if (!table) return;
  const auto headings = Accepted([&] { return files::HeadingsIn(*table); });
  if (!headings) return;
  Require(!headings->empty(), "no headings");
  double before = kBeforeAll;
  for (const HeadingSample& sample : *headings) {
    RequireRising(before, sample.stamp_s);
    Require(std::isfinite(sample.heading_rad) && sample.sigma_rad > 0, "a heading that cannot be");
    before = sample.stamp_s;
  }
}

void ReadAsStatus(std::string_view bytes) {
  const auto table = Table(bytes);
  if (!table) return;
  const auto record = Accepted([&] { return files::StatusIn(*table); });
  if (!record) return;
  Require(record->poses.size() == record->covariances.size() &&
              record->poses.size() == record->placed.size() &&
              record->placed.size() + record->unplaced.size() == table->rows.size(),
          "frames are lost");
  for (const StampedPose& pose : record->poses) {
    Require(pose.position.allFinite() && std::abs(pose.orientation.norm() - 1) < 1e-9,
            "a pose that cannot be");
  }
  for (const Eigen::Matrix3d& covariance : record->covariances) {
    Require(covariance.diagonal().minCoeff() >= 0 && covariance.allFinite(), "a covariance");
  }
}

void ReadAsPairs(std::string_view bytes) {
  const auto table = Accepted([&] { return files::ParseCsv(bytes, "/nowhere/pairs.csv"); });
  if (!table) return;
  const auto pairs = Accepted([&] { return files::PairsIn(*table); });
  Require(!pairs || pairs->size() == table->rows.size(), "pairs are lost");
}

}  // namespace ceilmap::fuzz
