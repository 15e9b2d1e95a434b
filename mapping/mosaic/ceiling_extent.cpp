#include "mapping/mosaic/ceiling_extent.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "mapping/mosaic/outlines.hpp"
#include "mapping/mosaic/view_placement.hpp"

namespace ceilmap::mosaic {
namespace {

/// Limits of the raster: a larger map gets larger cells.
constexpr double kMaxCells = 1 << 24;
/// Slope d ln(rho) / d ln(distance from the principal point) from which on a surface is a vertical
/// face: 0 for level surfaces, 1 for walls. Stereo flattens what it sees obliquely to 0.3.
constexpr double kMaxSteepness = 0.2;
constexpr int kSlopeReach = 3;       // cells of a height field, to each side
constexpr int kMinSlopeCells = 4;    // measured ones
constexpr double kNoiseOfSlope = 6;  // px, regularizes the slope where few cells are measured
/// A ray ends before a place if its ratio is larger by this part.
constexpr float kRayEnds = 0.03F;
/// A measured cell counts within this distance, steps of its field.
constexpr double kReachSteps = 1.2;
constexpr int kMaxKeyframes = 3;  // more that agree do not make a place more certain
/// A ray that a vertical face ends before a place is more evidence than one that ends there: cells
/// at the edge of a wall are seen as if they were behind it.
constexpr float kBlockedWeight = 2;
constexpr int kMovingReach = 5;         // cells of which most move
constexpr double kSmoothing = 2;        // standard deviation, cells
constexpr float kEnoughSupport = 0.5F;  // keyframes, after smoothing
// Parts of the height of the reference plane above the camera.
constexpr double kGap = 0.25;           // half the width of a gap in the measurements
constexpr double kSpike = 0.12;         // half the width of a spike of the border
constexpr double kIsland = 0.3;         // side of the smallest part of the ceiling
constexpr double kHole = 0.5;           // side of the largest hole that is filled
constexpr double kPlaneReach = 0.7;     // of an image without heights: 35 degrees from the vertical
constexpr double kMovingArea = 0.01;    // smallest thing that moves, parts of its square
constexpr double kUnknownFocal = 0.75;  // parts of an image's longer side

/// What the keyframes tell about the cells of a raster.
struct Evidence {
  cv::Mat_<unsigned char> seen;     // any image shows the place on the reference plane
  cv::Mat_<unsigned char> support;  // keyframes that measured a surface from below
  cv::Mat_<unsigned char> plane;    // any image without heights shows it steeply
  cv::Mat_<unsigned char> blocked;  // keyframes whose rays end at a wall before the place
};

/// Height of the reference plane above the camera, map units.
double ReferenceHeight(const store::MapMetadata& metadata) {
  const double longer = std::max(metadata.view_size.width, metadata.view_size.height);
  const double focal_px =
      metadata.view_focal_px > 0 ? metadata.view_focal_px : kUnknownFocal * longer;
  return focal_px * metadata.view_units_per_px;
}

store::MosaicGrid RasterOver(const std::vector<ViewPlacement>& views, double resolution) {
  cv::Rect2d box = views.front().Bounds();
  for (const ViewPlacement& view : views) box |= view.Bounds();
  while (box.area() > kMaxCells * resolution * resolution) resolution *= 2;
  store::MosaicGrid grid;
  grid.resolution = resolution;
  grid.min_x = std::floor(box.x / resolution) * resolution;
  grid.max_y = std::ceil(box.br().y / resolution) * resolution;
  grid.width_px = static_cast<int>(std::ceil((box.br().x - grid.min_x) / resolution)) + 1;
  grid.height_px = static_cast<int>(std::ceil((grid.max_y - box.y) / resolution)) + 1;
  return grid;
}

/// Cells of a raster that a box touches.
cv::Rect CellsIn(const store::MosaicGrid& grid, const cv::Rect2d& box) {
  const cv::Point first(cvFloor((box.x - grid.min_x) / grid.resolution),
                        cvFloor((grid.max_y - box.br().y) / grid.resolution));
  const cv::Point end(cvCeil((box.br().x - grid.min_x) / grid.resolution),
                      cvCeil((grid.max_y - box.y) / grid.resolution));
  return cv::Rect(first, end) & cv::Rect(0, 0, grid.width_px, grid.height_px);
}

bool IsMeasured(const heights::HeightCell& cell) {
  return cell.sigma < heights::kMeasuredSigma && cell.rho > 0;
}

/// Whether a cell shows a surface from below: the slope of a plane through the ratios around it.
/// A cell whose slope is not known shows none.
bool IsSeenFromBelow(const heights::HeightField& field,
                     const cv::Point& cell,
                     const Eigen::Vector2d& principal_px) {
  double count = 0;
  double mean_rho = 0;
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  Eigen::Matrix2d square = Eigen::Matrix2d::Zero();
  Eigen::Vector2d product = Eigen::Vector2d::Zero();
  const int last_row = std::min(cell.y + kSlopeReach, field.grid.height - 1);
  const int last_col = std::min(cell.x + kSlopeReach, field.grid.width - 1);
  for (int row = std::max(cell.y - kSlopeReach, 0); row <= last_row; ++row) {
    for (int col = std::max(cell.x - kSlopeReach, 0); col <= last_col; ++col) {
      const int index = row * field.grid.width + col;
      const auto i = static_cast<std::size_t>(index);
      if (!IsMeasured(field.cells[i])) continue;
      const Eigen::Vector2d at = field.Centre(i) - principal_px;
      const double rho = field.cells[i].rho;
      count += 1;
      mean += at;
      mean_rho += rho;
      square += at * at.transpose();
      product += rho * at;
    }
  }
  if (count < kMinSlopeCells) return false;
  mean /= count;
  mean_rho /= count;
  square = square / count - mean * mean.transpose() +
           kNoiseOfSlope * kNoiseOfSlope * Eigen::Matrix2d::Identity();
  product = product / count - mean_rho * mean;
  const Eigen::Vector2d gradient = square.inverse() * product;
  const int index = cell.y * field.grid.width + cell.x;
  const Eigen::Vector2d at = field.Centre(static_cast<std::size_t>(index)) - principal_px;
  return gradient.dot(at) <= kMaxSteepness * mean_rho;
}

/// What each cell of a height field shows.
enum class Face : unsigned char { kUnknown, kFromBelow, kVertical };

std::vector<Face> FacesOf(const heights::HeightField& field, const Eigen::Vector2d& principal_px) {
  std::vector<Face> faces(field.cells.size(), Face::kUnknown);
  for (int row = 0; row < field.grid.height; ++row) {
    for (int col = 0; col < field.grid.width; ++col) {
      const int index = row * field.grid.width + col;
      const auto i = static_cast<std::size_t>(index);
      if (!IsMeasured(field.cells[i])) continue;
      const bool below = IsSeenFromBelow(field, {col, row}, principal_px);
      faces[i] = below ? Face::kFromBelow : Face::kVertical;
    }
  }
  return faces;
}

/// Marks the cells of the raster above which a keyframe measured a surface from below.
void MarkSurfaces(const heights::HeightField& field,
                  const std::vector<Face>& faces,
                  const ViewPlacement& view,
                  const store::MapMetadata& metadata,
                  const store::MosaicGrid& grid,
                  cv::Mat_<unsigned char>& marks) {
  const cv::Point2d centre((metadata.view_size.width - 1) / 2.0,
                           (metadata.view_size.height - 1) / 2.0);
  const double step = field.step_px.minCoeff() * metadata.view_units_per_px;
  for (std::size_t i = 0; i < field.cells.size(); ++i) {
    if (faces[i] != Face::kFromBelow) continue;
    const heights::HeightCell& cell = field.cells[i];
    const Eigen::Vector2d at = field.Centre(i);
    const cv::Point2d place = view.ToMap(centre.x + at.x(), centre.y + at.y(), cell.rho);
    // Cells of the raster whose centres are within the reach.
    const double reach = kReachSteps * step / cell.rho - 0.5 * grid.resolution;
    const cv::Rect2d box(place.x - reach, place.y - reach, 2 * reach, 2 * reach);
    marks(CellsIn(grid, box)).setTo(1);
  }
}

/// Marks what one keyframe sees of the raster: places on its image, those that it sees as a plane,
/// and those before which its rays end.
void MarkView(const graph::Keyframe& keyframe,
              const std::vector<Face>& faces,
              const ViewPlacement& view,
              const store::MapMetadata& metadata,
              const HeightMap& heights,
              const store::MosaicGrid& grid,
              Evidence& evidence) {
  const cv::Rect box = CellsIn(grid, view.Bounds());
  const double max_u = metadata.view_size.width - 0.5;
  const double max_v = metadata.view_size.height - 0.5;
  const cv::Point2d centre((metadata.view_size.width - 1) / 2.0,
                           (metadata.view_size.height - 1) / 2.0);
  const double plane_reach = kPlaneReach * ReferenceHeight(metadata) / metadata.view_units_per_px;
  for (int row = box.y; row < box.br().y; ++row) {
    const double y = grid.max_y - (row + 0.5) * grid.resolution;
    for (int col = box.x; col < box.br().x; ++col) {
      const double x = grid.min_x + (col + 0.5) * grid.resolution;
      const cv::Point2d pixel = view.ToPixel(x, y);
      if (!(pixel.x > -0.5 && pixel.y > -0.5 && pixel.x < max_u && pixel.y < max_v)) continue;
      if (!metadata.view_mask.empty() &&
          metadata.view_mask.at<unsigned char>(cvRound(pixel.y), cvRound(pixel.x)) == 0) {
        continue;
      }
      evidence.seen(row, col) = 1;
      if (!keyframe.heights) {
        if (cv::norm(pixel - view.Principal()) <= plane_reach) evidence.plane(row, col) = 1;
        continue;
      }
      const float rho = std::max(heights.RatioAt(x, y), 1.0F);
      const cv::Point2d at = view.ToPixel(x, y, rho) - centre;
      const auto cell = keyframe.heights->CellAt({at.x, at.y});
      if (!cell || faces[*cell] != Face::kVertical) continue;
      auto& blocked = evidence.blocked(row, col);
      if (keyframe.heights->cells[*cell].rho > rho * (1 + kRayEnds) && blocked < kMaxKeyframes) {
        ++blocked;
      }
    }
  }
}

Evidence Gather(const std::vector<graph::Keyframe>& keyframes,
                const std::vector<ViewPlacement>& views,
                const store::MapMetadata& metadata,
                const HeightMap& heights,
                const store::MosaicGrid& grid) {
  const cv::Size size(grid.width_px, grid.height_px);
  Evidence evidence;
  for (cv::Mat_<unsigned char>* raster :
       {&evidence.seen, &evidence.support, &evidence.plane, &evidence.blocked}) {
    *raster = cv::Mat_<unsigned char>::zeros(size);
  }
  cv::Mat_<unsigned char> marks = cv::Mat_<unsigned char>::zeros(size);
  for (std::size_t k = 0; k < keyframes.size(); ++k) {
    const heights::HeightField* field = keyframes[k].heights.get();
    const std::vector<Face> faces =
        field != nullptr ? FacesOf(*field, metadata.view_principal_px) : std::vector<Face>();
    MarkView(keyframes[k], faces, views[k], metadata, heights, grid, evidence);
    if (field == nullptr) continue;
    MarkSurfaces(*field, faces, views[k], metadata, grid, marks);
    // What is measured from a view is inside of its image, or nearer to its foot.
    const cv::Rect box = CellsIn(grid, views[k].Bounds() | views[k].Bounds(0.5));
    cv::Mat support = evidence.support(box);
    cv::add(support, marks(box), support);
    cv::min(support, kMaxKeyframes, support);
    marks(box).setTo(0);
  }
  return evidence;
}

/// Removes connected parts of a mask, of its content or of its holes, that are smaller than an
/// area. Holes at the border of the raster are none.
void RemoveSmall(double min_cells, bool holes, cv::Mat& mask) {
  cv::Mat labels;
  cv::Mat stats;
  cv::Mat centroids;
  const cv::Mat parts = holes ? cv::Mat(mask == 0) : mask;
  const int count = cv::connectedComponentsWithStats(parts, labels, stats, centroids, 4);
  std::vector<bool> remove(static_cast<std::size_t>(count), false);
  for (int i = 1; i < count; ++i) {
    remove[static_cast<std::size_t>(i)] = stats.at<int>(i, cv::CC_STAT_AREA) < min_cells;
    const int left = stats.at<int>(i, cv::CC_STAT_LEFT);
    const int top = stats.at<int>(i, cv::CC_STAT_TOP);
    const bool at_border = left == 0 || top == 0 ||
                           left + stats.at<int>(i, cv::CC_STAT_WIDTH) == mask.cols ||
                           top + stats.at<int>(i, cv::CC_STAT_HEIGHT) == mask.rows;
    if (holes && at_border) remove[static_cast<std::size_t>(i)] = false;
  }
  for (int row = 0; row < mask.rows; ++row) {
    const int* label = labels.ptr<int>(row);
    auto* values = mask.ptr<unsigned char>(row);
    for (int col = 0; col < mask.cols; ++col) {
      if (remove[static_cast<std::size_t>(label[col])]) values[col] = holes ? 255 : 0;
    }
  }
}

/// Morphological closing by a disc, or the opening: that of the complement.
cv::Mat Close(const cv::Mat& mask, double radius, unsigned char around = 0) {
  const int margin = cvCeil(radius) + 1;
  cv::Mat wide;
  cv::copyMakeBorder(
      mask, wide, margin, margin, margin, margin, cv::BORDER_CONSTANT, cv::Scalar(around));
  cv::Mat distance;
  cv::distanceTransform(wide == 0, distance, cv::DIST_L2, cv::DIST_MASK_PRECISE);
  cv::distanceTransform(distance <= radius, distance, cv::DIST_L2, cv::DIST_MASK_PRECISE);
  return cv::Mat(distance > radius)(cv::Rect({margin, margin}, mask.size())) | mask;
}

cv::Mat Open(const cv::Mat& mask, double radius) {
  return ~Close(~mask, radius, 255);
}

/// 255 where a cell is ceiling. @param height_cells  of the reference plane above the camera.
cv::Mat Decide(const Evidence& evidence, double height_cells) {
  cv::Mat votes;
  evidence.support.convertTo(votes, CV_32F);
  votes.setTo(1, (evidence.plane != 0) & (evidence.support == 0) & (evidence.blocked == 0));
  cv::Mat against;
  evidence.blocked.convertTo(against, CV_32F, kBlockedWeight);
  against.setTo(0, evidence.support >= kMaxKeyframes);
  votes -= against;
  cv::GaussianBlur(votes, votes, {}, kSmoothing, kSmoothing, cv::BORDER_CONSTANT);
  cv::Mat mask = votes > kEnoughSupport;
  RemoveSmall(std::pow(kIsland * height_cells, 2), false, mask);
  mask = Open(Close(mask, kGap * height_cells), kSpike * height_cells);
  RemoveSmall(std::pow(kHole * height_cells, 2), true, mask);
  return mask;
}

/// What a mask shows, as places left out.
store::LeftOut PlacesOf(const cv::Mat& mask, const store::MosaicGrid& grid) {
  store::LeftOut result;
  result.area = cv::countNonZero(mask) * grid.resolution * grid.resolution;
  result.polygons = OutlinesOf(mask, grid);
  return result;
}

}  // namespace

CeilingExtent::CeilingExtent(const std::vector<graph::Keyframe>& keyframes,
                             const store::MapMetadata& metadata,
                             const HeightMap& heights) {
  if (heights.empty()) return;
  const std::vector<ViewPlacement> views = PlaceViews(keyframes, metadata);
  reference_height_ = ReferenceHeight(metadata);
  grid_ = RasterOver(views, heights.Grid().resolution);
  const Evidence evidence = Gather(keyframes, views, metadata, heights, grid_);
  const cv::Mat mask = Decide(evidence, ReferenceHeight(metadata) / grid_.resolution);
  if (cv::countNonZero(mask) == 0) {  // too few measurements for a decision
    grid_ = {};
    return;
  }
  const cv::Mat left_out = (evidence.seen != 0) & ~mask;
  if (cv::countNonZero(left_out) > 0) left_out_.push_back(PlacesOf(left_out, grid_));
  cv::GaussianBlur(mask, inside_, {}, 1, 1, cv::BORDER_CONSTANT);
}

void CeilingExtent::AddMoving(const std::vector<cv::Point2d>& places, double spacing) {
  if (empty()) return;
  cv::Mat mask(inside_.size(), CV_8UC1, cv::Scalar(0));
  for (const cv::Point2d& at : places) {
    const cv::Rect2d box(at.x - spacing / 2, at.y - spacing / 2, spacing, spacing);
    mask(CellsIn(grid_, box)).setTo(255);
  }
  mask.setTo(0, inside_ < 128);
  // What moves covers an area; single cells are wrong measurements.
  cv::Mat dense;
  cv::boxFilter(mask, dense, -1, {kMovingReach, kMovingReach}, {-1, -1}, true, cv::BORDER_CONSTANT);
  mask = dense > 127;
  RemoveSmall(
      kMovingArea / (grid_.resolution * grid_.resolution) * reference_height_ * reference_height_,
      false,
      mask);
  if (cv::countNonZero(mask) == 0) return;
  left_out_.push_back(PlacesOf(mask, grid_));
  left_out_.back().kind = store::LeftOut::Kind::kMoves;
}

cv::Rect2d CeilingExtent::Bounds() const {
  if (empty()) return {};
  const cv::Rect cells = cv::boundingRect(inside_ > 0);
  return {grid_.min_x + cells.x * grid_.resolution,
          grid_.max_y - cells.br().y * grid_.resolution,
          cells.width * grid_.resolution,
          cells.height * grid_.resolution};
}

cv::Mat CeilingExtent::Over(const cv::Rect& window, const store::MosaicGrid& grid) const {
  if (empty()) return {};
  cv::Mat mask(window.size(), CV_8UC1, cv::Scalar(0));
  const double scale = grid.resolution / grid_.resolution;
  const double left = (grid.min_x - grid_.min_x) / grid_.resolution - 0.5;
  const double top = (grid_.max_y - grid.max_y) / grid_.resolution - 0.5;
  for (int row = 0; row < window.height; ++row) {
    const double y = top + (window.y + row + 0.5) * scale;
    const int v = cvFloor(y);
    if (v < 0 || v + 1 >= inside_.rows) continue;
    const double fy = y - v;
    const auto* upper = inside_.ptr<unsigned char>(v);
    const auto* lower = inside_.ptr<unsigned char>(v + 1);
    auto* values = mask.ptr<unsigned char>(row);
    for (int col = 0; col < window.width; ++col) {
      const double x = left + (window.x + col + 0.5) * scale;
      const int u = cvFloor(x);
      if (u < 0 || u + 1 >= inside_.cols) continue;
      const double fx = x - u;
      const double value = (1 - fy) * ((1 - fx) * upper[u] + fx * upper[u + 1]) +
                           fy * ((1 - fx) * lower[u] + fx * lower[u + 1]);
      if (value > 127.5) values[col] = 255;
    }
  }
  return mask;
}

}  // namespace ceilmap::mosaic
