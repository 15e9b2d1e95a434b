#include "mapping/store/history_tables.hpp"

#include <algorithm>
#include <array>
#include <string>
#include <utility>
#include <vector>

#include "calib/base/error.hpp"
#include "mapping/store/image_codec.hpp"
#include "mapping/store/map_tables.hpp"
#include "mapping/store/table_rows.hpp"

namespace ceilmap::store {
namespace {

constexpr std::array kChangeKinds = {
    Change::Kind::kSurface, Change::Kind::kBrightness, Change::Kind::kLamp, Change::Kind::kLight};
constexpr std::array kChangeStates = {
    Change::State::kCandidate, Change::State::kConfirmed, Change::State::kReplaced};

}  // namespace

const char* ToString(Change::Kind kind) {
  switch (kind) {
    case Change::Kind::kSurface:
      return "surface";
    case Change::Kind::kBrightness:
      return "brightness";
    case Change::Kind::kLamp:
      return "lamp";
    case Change::Kind::kLight:
      break;
  }
  return "light";
}

const char* ToString(Change::State state) {
  switch (state) {
    case Change::State::kCandidate:
      return "candidate";
    case Change::State::kConfirmed:
      return "confirmed";
    case Change::State::kReplaced:
      break;
  }
  return "replaced";
}

std::vector<Look> NumberedLooks(LookSquares squares) {
  if (squares.size() > kMaxLooks) {
    throw RunError("the ceiling looks otherwise in another light at more than " +
                   std::to_string(kMaxLooks) + " squares of " + std::to_string(Look::kSizePx) +
                   " px, too many for a map; make it with a coarser --resolution");
  }
  std::vector<Look> looks;
  looks.reserve(squares.size());
  for (auto& [at, look] : squares) {
    if (look.image.empty() || cv::countNonZero(look.image) == 0) continue;
    look.id = static_cast<std::int64_t>(looks.size()) + 1;
    looks.push_back(std::move(look));
  }
  return looks;
}

namespace tables {
namespace {

/// The value with the name that the column has.
template <typename Values>
auto Named(OGRFeature& row, const char* column, const Values& values) {
  const std::string text = Text(row, column);
  for (const auto value : values) {
    if (text == ToString(value)) return value;
  }
  ThrowDamaged(row, std::string("unknown ") + column);
}

/// More than any map has of anything. Sums of such numbers do not overflow.
constexpr std::int64_t kMaxCount = std::int64_t{1} << 50U;

/// A number of things, or of a session.
std::int64_t CountOf(OGRFeature& row, const char* column) {
  const std::int64_t count = Integer(row, column);
  if (count < 0) ThrowDamaged(row, std::string("negative ") + column);
  if (count > kMaxCount) ThrowDamaged(row, std::string("impossible ") + column);
  return count;
}

double AreaOf(OGRFeature& row, const char* column) {
  const double area = Real(row, column);
  if (!(area >= 0)) ThrowDamaged(row, "a negative area");
  return area;
}

OGRLayer* CreateSessions(GDALDataset& dataset) {
  OGRLayer* layer = CreateTable(dataset, kSessions, nullptr, wkbNone, "id");
  const bool done =
      layer != nullptr && AddField(*layer, "date", OFTString) &&
      AddField(*layer, "source", OFTString) && AddField(*layer, "robot", OFTString) &&
      AddField(*layer, "program_version", OFTString) && AddField(*layer, "frames", OFTInteger64) &&
      AddField(*layer, "placed", OFTInteger64) && AddField(*layer, "other_light", OFTInteger) &&
      AddField(*layer, "seen_area", OFTReal) && AddField(*layer, "changed_area", OFTReal);
  return done ? layer : nullptr;
}

OGRLayer* CreateChanges(GDALDataset& dataset, OGRSpatialReference& srs) {
  OGRLayer* layer = CreateTable(dataset, kChanges, &srs, wkbMultiPolygon, "id");
  const bool done =
      layer != nullptr && AddField(*layer, "kind", OFTString) &&
      AddField(*layer, "state", OFTString) && AddField(*layer, "first_session", OFTInteger64) &&
      AddField(*layer, "last_session", OFTInteger64) && AddField(*layer, "frames", OFTInteger64) &&
      AddField(*layer, "difference", OFTReal) && AddField(*layer, "area", OFTReal);
  return done ? layer : nullptr;
}

OGRLayer* CreateLooks(GDALDataset& dataset) {
  OGRLayer* layer = CreateTable(dataset, kLooks, nullptr, wkbNone, "id");
  const bool done = layer != nullptr && AddField(*layer, "session", OFTInteger64) &&
                    AddField(*layer, "x_px", OFTInteger64) &&
                    AddField(*layer, "y_px", OFTInteger64) && AddField(*layer, kPng, OFTBinary);
  return done ? layer : nullptr;
}

bool Append(OGRLayer& layer, const Session& session) {
  const OGRFeatureUniquePtr row = NewRow(layer);
  row->SetFID(session.id);
  row->SetField("date", session.date.c_str());
  row->SetField("source", session.source.c_str());
  row->SetField("robot", session.robot.c_str());
  row->SetField("program_version", session.program_version.c_str());
  row->SetField("frames", static_cast<GIntBig>(session.frames));
  row->SetField("placed", static_cast<GIntBig>(session.placed));
  row->SetField("other_light", session.other_light ? 1 : 0);
  row->SetField("seen_area", session.seen_area);
  row->SetField("changed_area", session.changed_area);
  return AddRow(layer, *row);
}

bool Append(OGRLayer& layer, const Change& change) {
  const OGRFeatureUniquePtr row = NewRow(layer);
  row->SetFID(change.id);
  row->SetField("kind", ToString(change.kind));
  row->SetField("state", ToString(change.state));
  row->SetField("first_session", static_cast<GIntBig>(change.first_session));
  row->SetField("last_session", static_cast<GIntBig>(change.last_session));
  row->SetField("frames", static_cast<GIntBig>(change.frames));
  row->SetField("difference", change.difference);
  row->SetField("area", change.area);
  SetPolygons(*row, change.polygons);
  return AddRow(layer, *row);
}

bool Append(OGRLayer& layer, const Look& look) {
  const OGRFeatureUniquePtr row = NewRow(layer);
  row->SetFID(look.id);
  row->SetField("session", static_cast<GIntBig>(look.session));
  row->SetField("x_px", static_cast<GIntBig>(look.origin_px.x));
  row->SetField("y_px", static_cast<GIntBig>(look.origin_px.y));
  const std::vector<unsigned char> png = EncodeImage(look.image);
  SetBytes(*row, kPng, png.data(), png.size());
  return AddRow(layer, *row);
}

}  // namespace

bool AddHistory(GDALDataset& dataset, OGRSpatialReference& srs, const MapHistory& history) {
  OGRLayer* sessions = CreateSessions(dataset);
  OGRLayer* changes = CreateChanges(dataset, srs);
  // Only where another light was seen.
  OGRLayer* looks = history.looks.empty() ? nullptr : CreateLooks(dataset);
  if (sessions == nullptr || changes == nullptr || (looks == nullptr && !history.looks.empty())) {
    return false;
  }
  return std::all_of(history.sessions.begin(),
                     history.sessions.end(),
                     [&](const Session& session) { return Append(*sessions, session); }) &&
         std::all_of(history.changes.begin(),
                     history.changes.end(),
                     [&](const Change& change) { return Append(*changes, change); }) &&
         std::all_of(history.looks.begin(), history.looks.end(), [&](const Look& look) {
           return Append(*looks, look);
         });
}

Session ToSession(OGRFeature& row) {
  Session session;
  session.id = row.GetFID();  // the next session has the next number
  if (session.id < 1 || session.id > kMaxCount) ThrowDamaged(row, "an impossible number");
  session.date = Text(row, "date");
  session.source = Text(row, "source");
  session.robot = Text(row, "robot");
  session.program_version = Text(row, "program_version");
  session.frames = CountOf(row, "frames");
  session.placed = CountOf(row, "placed");
  session.other_light = Integer(row, "other_light") != 0;
  session.seen_area = AreaOf(row, "seen_area");
  session.changed_area = AreaOf(row, "changed_area");
  return session;
}

Change ToChange(OGRFeature& row) {
  Change change;
  change.id = row.GetFID();
  change.kind = Named(row, "kind", kChangeKinds);
  change.state = Named(row, "state", kChangeStates);
  change.first_session = CountOf(row, "first_session");
  change.last_session = CountOf(row, "last_session");
  if (change.first_session < 1 || change.last_session < change.first_session) {
    ThrowDamaged(row, "sessions in the wrong order");
  }
  change.frames = CountOf(row, "frames");
  change.difference = Real(row, "difference");
  change.area = AreaOf(row, "area");
  change.polygons = PolygonsOf(row);
  return change;
}

Look ToLook(OGRFeature& row, const cv::Size& mosaic) {
  Look look;
  look.id = row.GetFID();
  look.session = CountOf(row, "session");
  const std::int64_t x = Integer(row, "x_px");
  const std::int64_t y = Integer(row, "y_px");
  if (x < 0 || y < 0 || x >= mosaic.width || y >= mosaic.height || x % Look::kSizePx != 0 ||
      y % Look::kSizePx != 0) {
    ThrowDamaged(row, "a look at an impossible place");
  }
  look.origin_px = {static_cast<int>(x), static_cast<int>(y)};
  const Bytes png = BytesOf(row, kPng);
  if (png.data == nullptr || png.size <= 0) ThrowDamaged(row, "a look without an image");
  try {
    look.image = DecodeImage({png.data, png.data + png.size}, {Look::kSizePx, Look::kSizePx});
  } catch (const InputError& error) {
    ThrowDamaged(row, error.what());
  }
  return look;
}

}  // namespace tables
}  // namespace ceilmap::store
