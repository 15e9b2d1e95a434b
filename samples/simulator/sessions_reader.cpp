#include <fmt/format.h>

#include <algorithm>

#include "calib/base/error.hpp"
#include "samples/simulator/scene_values.hpp"
#include "samples/simulator/sessions.hpp"

namespace ceilmap::simulator {
namespace {

/// The number of a session in a row of `list`.
int SessionNumber(const YamlValue& list, double number) {
  const int whole = static_cast<int>(std::clamp(number, -1.0, kMaxSession + 1.0));
  if (whole != number || whole < 0 || whole > kMaxSession) {
    list.Fail(fmt::format("with whole numbers of sessions {}", RangeText(0, kMaxSession)),
              fmt::format("correct {:g}", number));
  }
  return whole;
}

Sessions ReadSessions(const YamlValue& value, const Path& path) {
  Sessions sessions;
  AllowOnly(value, kSessionsFields, "night_sessions", "movers");
  ReadFields(value, kSessionsFields, sessions);
  ReadRows<1>(value, "night_sessions", "session", [&](const double* row) {
    sessions.night_sessions.push_back(SessionNumber(value.At("night_sessions", ""), *row));
  });
  ReadRows<kMoverFields.size() + 1>(value, "movers", kSessionMoverColumns, [&](const double* row) {
    const YamlValue list = value.At("movers", "");
    SessionMover& of = sessions.movers.emplace_back();
    of.session = SessionNumber(list, row[0]);
    SetRow(list, kMoverFields, row + 1, of.mover);
  });
  if (!(sessions.panel_share + sessions.opening_share + sessions.lamp_share +
            sessions.banner_share >
        0)) {
    value.Fail("with a share of panels, openings, lamps or banners above 0", "correct it");
  }
  if (path.kind != PathKind::kTum) return sessions;
  for (const char* key : {"path_jitter_m", "interval_s", "people", "masts"}) {
    RefuseUnless(false, value, key, "tum of path");
  }
  return sessions;
}

}  // namespace

std::optional<Sessions> ReadSessionsOf(const YamlValue& root,
                                       const Path& path,
                                       std::optional<int>& session) {
  const auto group = root.Find("sessions");
  const auto number = root.Find("session");
  if (!group && number) {
    number->Fail("absent without the group sessions", "remove it, or add the group");
  }
  if (!group && session) {
    throw InputError(fmt::format(
        "{}: has no group sessions to select session {} of; add it, or leave out the session",
        root.File().string(),
        *session));
  }
  if (!group) return std::nullopt;
  const int in_file = number ? number->WholeNumber(0, kMaxSession) : 0;
  session = session.value_or(in_file);
  return ReadSessions(*group, path);
}

}  // namespace ceilmap::simulator
