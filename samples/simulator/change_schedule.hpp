#pragma once

#include <vector>

#include "samples/simulator/ceiling_change.hpp"
#include "samples/simulator/scene.hpp"
#include "samples/simulator/sessions.hpp"

namespace ceilmap::simulator {

/// The changes of sessions 1..session, in their order. Those of a session do not overlap. Each
/// session adds to those of the session before, which remain the same; together they cover
/// `session` times changed_share_per_session of the ceiling's area, to one change of each kind.
///
/// Panels, openings and lamps fill whole tiles, of 0.6 m where the ceiling has no tiles. Banners
/// hang anywhere; nothing else changes behind one.
/// @param scene  As built. @throws InputError when there are more than 20000 changes.
std::vector<CeilingChange> ScheduleChanges(const Scene& scene,
                                           const Sessions& sessions,
                                           int session);

}  // namespace ceilmap::simulator
