#include "samples/simulator/ceiling_texture.hpp"

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

CeilingWindow CeilingTexture::Window(double x0_m, double y0_m, double x1_m, double y1_m) const {
  CeilingWindow window{{}, 0, 0, pattern_.PitchX(), pattern_.PitchY()};
  std::int64_t columns = 0;
  std::int64_t rows = 0;
  int level = -1;
  do {
    if (++level > 0) {
      window.pitch_x_m *= 2;
      window.pitch_y_m *= 2;
    }
    window.column0 = FloorToInt(x0_m / window.pitch_x_m) - 2;
    window.row0 = FloorToInt(y0_m / window.pitch_y_m) - 2;
    columns = FloorToInt(x1_m / window.pitch_x_m) + 3 - window.column0;
    rows = FloorToInt(y1_m / window.pitch_y_m) + 3 - window.row0;
  } while (std::max(columns, rows) > kMaxTexels);
  const cv::Rect whole(0, 0, static_cast<int>(columns), static_cast<int>(rows));
  window.light.create(whole.size(), CV_16UC1);
  const auto first_column = FloorToInt(static_cast<double>(window.column0) / kTileSize);
  const auto first_row = FloorToInt(static_cast<double>(window.row0) / kTileSize);
  for (auto row = first_row; row * kTileSize < window.row0 + rows; ++row) {
    for (auto column = first_column; column * kTileSize < window.column0 + columns; ++column) {
      const cv::Point at(static_cast<int>(column * kTileSize - window.column0),
                         static_cast<int>(row * kTileSize - window.row0));
      const cv::Rect part = cv::Rect(at, cv::Size(kTileSize, kTileSize)) & whole;
      Tile({level, column, row})(part - at).copyTo(window.light(part));
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
