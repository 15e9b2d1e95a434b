#include "calib/solve/camera_calibration.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <utility>

#include "calib/base/error.hpp"
#include "calib/solve/view_choice.hpp"

namespace ceilmap::calibration {
namespace {

constexpr std::size_t kMinViews = 3;
constexpr const char* kHowToHold =
    "show the board some 15 times, in all parts of the image, tilted by 30 to 45 deg to all "
    "sides";

[[noreturn]] void Refuse(const BoardImages& images, const std::string& why) {
  throw InputError(fmt::format("{}: {}", images.name, why));
}

std::string OtherSize(cv::Size corners, const Board& board) {
  return fmt::format(
      "the images show a chessboard of {0}x{1} corners, not {2}x{3}; give {0}x{1} corners",
      corners.width,
      corners.height,
      board.columns,
      board.rows);
}

std::string Blurred(std::int64_t images) {
  return fmt::format(
      "the board is blurred in all of {} images; hold it still, add light, and focus the lens",
      images);
}

// True when a chessboard of this size is found with all its corners.
bool IsSeen(const cv::Mat& image, cv::Size corners, Board board) {
  board.kind = BoardKind::kChessboard;
  board.columns = corners.width;
  board.rows = corners.height;
  const auto view = DetectBoard(image, board);
  return view && view->ids.size() == static_cast<std::size_t>(corners.area());
}

// Counts images that show a board of another size. Two images must agree if there are two, because
// tiles and windows may appear as small boards.
class SizeVotes {
 public:
  SizeVotes(const BoardImages& images, const Board& board)
      : board_(board), needed_(std::min<std::size_t>(2, images.unseen.size())) {}
  bool Add(const cv::Mat& image, cv::Size corners) {
    constexpr int kMinBoardCorners = 20;
    if (corners.area() < kMinBoardCorners || !IsSeen(image, corners, board_)) return false;
    return ++votes_[{corners.width, corners.height}] >= needed_;
  }

 private:
  const Board& board_;
  std::size_t needed_;
  std::map<std::pair<int, int>, std::size_t> votes_;
};

// Explains why images have no board, from the first one that gives a reason.
std::string WhyNoBoard(const BoardImages& images, const Board& board) {
  using Kind = BoardGuess::Kind;
  SizeVotes votes(images, board);
  for (const cv::Mat& image : images.unseen) {
    const BoardGuess guess = GuessBoard(image, board);
    switch (guess.kind) {
      case Kind::kOtherSize:
        if (votes.Add(image, guess.corners)) return OtherSize(guess.corners, board);
        break;
      case Kind::kMirrored:
        return "the board appears mirrored, by a mirror before the camera or a driver that flips; "
               "give "
               "images that are not, here and to all other commands";
      case Kind::kBlurred:
        return Blurred(images.images);
      case Kind::kMarkers:
        return fmt::format(
            "there are markers of {} but no {}; check the counts of corners, and the order of the "
            "markers, which must be that of OpenCV's aruco module",
            board.dictionary,
            board.Name());
      default:
        break;
    }
  }
  return fmt::format(
      "no {} in any of {} images; is it whole, flat and evenly lit, and are its corners the points "
      "where four squares meet?",
      board.Name(),
      images.images);
}

// The detected board may be a part of a larger one.
void CheckSize(const BoardImages& images, const Board& board) {
  if (board.kind != BoardKind::kChessboard) return;
  const BoardGuess guess = GuessSize(images.sample);
  const bool larger =
      guess.kind == BoardGuess::Kind::kOtherSize && guess.corners.area() > board.CornerCount();
  if (larger && IsSeen(images.sample, guess.corners, board)) {
    Refuse(images, OtherSize(guess.corners, board));
  }
}

// Keeps sharp views only.
std::vector<BoardView> SharpViews(const BoardImages& images, CameraCalibration& result) {
  const double usual_px = UsualEdge(images.views);
  std::vector<BoardView> sharp;
  for (const BoardView& view : images.views) {
    if (IsBlurred(view, usual_px)) {
      result.left_out.push_back(
          {view.name, fmt::format("blurred: edges are {:.1f} px wide", view.edge_px)});
    } else {
      sharp.push_back(view);
    }
  }
  if (sharp.empty()) Refuse(images, Blurred(images.images));
  return sharp;
}

void CheckViews(const BoardImages& images, const std::vector<BoardView>& views) {
  if (views.size() < kMinViews) {
    Refuse(images,
           fmt::format("{} of {} images {} the board sharp and whole, at least {} are needed; {}",
                       views.size(),
                       images.images,
                       views.size() == 1 ? "shows" : "show",
                       kMinViews,
                       kHowToHold));
  }
  const std::size_t distinct = DistinctViews(views, images.size);
  if (distinct >= kMinViews) return;
  Refuse(images,
         fmt::format("the {} views of the board are too similar ({} different one{}), at least {} "
                     "are needed; {}",
                     views.size(),
                     distinct,
                     distinct == 1 ? "" : "s",
                     kMinViews,
                     kHowToHold));
}

void Choose(const Board& board,
            std::vector<BoardView> sharp,
            LensModel model,
            std::size_t max_views,
            CameraCalibration& result) {
  const std::vector<std::size_t> chosen =
      ChooseViews(board, sharp, result.images.size, model, max_views);
  for (std::size_t i = 0, next = 0; i < sharp.size(); ++i) {
    if (next < chosen.size() && chosen[next] == i) {
      result.views.push_back(std::move(sharp[i]));
      ++next;
    } else {
      result.left_out.push_back({sharp[i].name, "less informative than the others"});
    }
  }
}

}  // namespace

CameraCalibration CalibrateCamera(const Board& board,
                                  BoardImages images,
                                  const SolverParams& params,
                                  std::size_t max_views) {
  CameraCalibration result;
  result.board = board;
  if (images.views.empty()) Refuse(images, WhyNoBoard(images, board));
  CheckSize(images, board);
  for (const std::string& name : images.without_board)
    result.left_out.push_back({name, "no board found"});
  std::vector<BoardView> sharp = SharpViews(images, result);
  CheckViews(images, sharp);
  result.images = std::move(images);
  Choose(board, std::move(sharp), params.model, max_views, result);
  auto solution = SolveCamera(board, result.views, result.images.size, params);
  if (!solution) {
    Refuse(result.images, fmt::format("these views do not determine the camera; {}", kHowToHold));
  }
  result.solution = std::move(*solution);
  std::vector<BoardView> used;
  for (const SolvedView& view : result.solution.views) {
    if (view.used) {
      used.push_back(result.views[view.view]);
    } else {
      result.left_out.push_back(
          {result.views[view.view].name,
           fmt::format("does not fit the others: RMS {:.2f} px", view.rms_px)});
    }
  }
  result.coverage = FindCoverage(used, result.images.size);
  Judgement judgement = JudgeCamera(result.solution, result.coverage);
  if (!judgement.faults.empty()) Refuse(result.images, judgement.faults.front());
  result.warnings = std::move(judgement.warnings);
  return result;
}

}  // namespace ceilmap::calibration
