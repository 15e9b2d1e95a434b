#include "samples/simulator/ceiling_texture.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "samples/simulator/random.hpp"

namespace ceilmap::simulator {
namespace {

constexpr std::int64_t kMaxTexels = 4096;

std::int64_t FloorToInt(double value) {
  return static_cast<std::int64_t>(std::floor(value));
}

std::int64_t TileOf(std::int64_t texel) {
  return FloorToInt(static_cast<double>(texel) / CeilingTexture::kTileSize);
}

/// Texels of an area and a margin of two.
struct Texels {
  std::int64_t column0;
  std::int64_t row0;
  std::int64_t columns;
  std::int64_t rows;
};

Texels TexelsOf(const Eigen::AlignedBox2d& area, double pitch_x_m, double pitch_y_m) {
  Texels texels{
      FloorToInt(area.min().x() / pitch_x_m) - 2, FloorToInt(area.min().y() / pitch_y_m) - 2, 0, 0};
  texels.columns = FloorToInt(area.max().x() / pitch_x_m) + 3 - texels.column0;
  texels.rows = FloorToInt(area.max().y() / pitch_y_m) + 3 - texels.row0;
  return texels;
}

}  // namespace

// Short loops, because compilers vectorise all but the second one, which doubles the speed of the
// whole simulator.
void CeilingWindow::Sample(const float* column, const float* row, int count, float* sampled) const {
  const auto* data = light.ptr<std::uint16_t>();
  const auto step = static_cast<std::ptrdiff_t>(light.step1());
  std::array<int, kMaxSamples> u, v, a, b, c, d;
  std::array<float, kMaxSamples> part_u, part_v;
  for (int i = 0; i < count; ++i) {
    u[i] = static_cast<int>(column[i]);
    v[i] = static_cast<int>(row[i]);
    part_u[i] = column[i] - static_cast<float>(u[i]);
    part_v[i] = row[i] - static_cast<float>(v[i]);
  }
  for (int i = 0; i < count; ++i) {
    const std::uint16_t* at = data + v[i] * step + u[i];
    a[i] = at[0];
    b[i] = at[1];
    c[i] = at[step];
    d[i] = at[step + 1];
  }
  for (int i = 0; i < count; ++i) {
    const auto left = static_cast<float>(a[i]);
    const auto low_left = static_cast<float>(c[i]);
    const float top = left + part_u[i] * (static_cast<float>(b[i]) - left);
    const float low = low_left + part_u[i] * (static_cast<float>(d[i]) - low_left);
    sampled[i] = (top + part_v[i] * (low - top)) / kOne;
  }
}

std::size_t CeilingTexture::KeyHash::operator()(const Key& key) const {
  return HashAt(static_cast<std::uint64_t>(key.level), key.column, key.row);
}

CeilingWindow CeilingTexture::Window(const Eigen::AlignedBox2d& area) const {
  return Window(area, {area});
}

CeilingWindow CeilingTexture::Window(const Eigen::AlignedBox2d& area,
                                     const std::vector<Eigen::AlignedBox2d>& parts) const {
  CeilingWindow window{{}, 0, 0, pattern_.PitchX(), pattern_.PitchY()};
  Texels whole = TexelsOf(area, window.pitch_x_m, window.pitch_y_m);
  int level = 0;
  while (std::max(whole.columns, whole.rows) > kMaxTexels) {
    ++level;
    window.pitch_x_m *= 2;
    window.pitch_y_m *= 2;
    whole = TexelsOf(area, window.pitch_x_m, window.pitch_y_m);
  }
  window.column0 = whole.column0;
  window.row0 = whole.row0;
  window.light.create(static_cast<int>(whole.rows), static_cast<int>(whole.columns), CV_16UC1);
  const std::int64_t first_column = TileOf(whole.column0);
  const std::int64_t first_row = TileOf(whole.row0);
  cv::Mat_<std::uint8_t> filled(
      static_cast<int>(TileOf(whole.row0 + whole.rows - 1) - first_row + 1),
      static_cast<int>(TileOf(whole.column0 + whole.columns - 1) - first_column + 1),
      std::uint8_t{0});
  const auto fill = [&](int tile_row, int tile_column) {
    if (filled(tile_row, tile_column) != 0) return;
    filled(tile_row, tile_column) = 1;
    const Key key{level, first_column + tile_column, first_row + tile_row};
    const cv::Point at(static_cast<int>(key.column * kTileSize - window.column0),
                       static_cast<int>(key.row * kTileSize - window.row0));
    const cv::Rect shared = cv::Rect(at, cv::Size(kTileSize, kTileSize)) &
                            cv::Rect(cv::Point(0, 0), window.light.size());
    Tile(key)(shared - at).copyTo(window.light(shared));
  };
  for (const Eigen::AlignedBox2d& part : parts) {
    if (part.isEmpty()) continue;
    const Texels texels = TexelsOf(part, window.pitch_x_m, window.pitch_y_m);
    const auto within = [](std::int64_t texel, std::int64_t first, int count) {
      return std::clamp(static_cast<int>(TileOf(texel) - first), 0, count - 1);
    };
    const int last_row = within(texels.row0 + texels.rows - 1, first_row, filled.rows);
    const int last_column = within(texels.column0 + texels.columns - 1, first_column, filled.cols);
    for (int row = within(texels.row0, first_row, filled.rows); row <= last_row; ++row) {
      int column = within(texels.column0, first_column, filled.cols);
      for (; column <= last_column; ++column) fill(row, column);
    }
  }
  return window;
}

cv::Mat CeilingTexture::Tile(const Key& key) const {
  cv::Mat tile = Find(key);
  if (tile.empty()) {  // two threads may draw the same tile, with the same result
    tile = Draw(key);
    Keep(key, tile);
  }
  return tile;
}

cv::Mat CeilingTexture::Draw(const Key& key) const {
  cv::Mat tile;
  if (key.level == 0) {
    pattern_.Sample(key.column * kTileSize, key.row * kTileSize, kTileSize, kTileSize)
        .convertTo(tile, CV_16UC1, CeilingWindow::kOne);
    return tile;
  }
  cv::Mat four(2 * kTileSize, 2 * kTileSize, CV_16UC1);
  for (const int row : {0, 1}) {
    for (const int column : {0, 1}) {
      Draw({key.level - 1, 2 * key.column + column, 2 * key.row + row})
          .copyTo(four(cv::Rect(column * kTileSize, row * kTileSize, kTileSize, kTileSize)));
    }
  }
  cv::resize(four, tile, {kTileSize, kTileSize}, 0, 0, cv::INTER_AREA);
  return tile;
}

cv::Mat CeilingTexture::Find(const Key& key) const {
  const std::lock_guard lock(mutex_);
  const auto place = places_.find(key);
  if (place == places_.end()) return {};
  tiles_.splice(tiles_.begin(), tiles_, place->second);
  return place->second->tile;
}

void CeilingTexture::Keep(const Key& key, const cv::Mat& tile) const {
  const std::lock_guard lock(mutex_);
  if (places_.contains(key)) return;
  tiles_.push_front({key, tile});
  places_[key] = tiles_.begin();
  if (tiles_.size() > kMaxTiles) {
    places_.erase(tiles_.back().key);
    tiles_.pop_back();
  }
}

}  // namespace ceilmap::simulator
