#pragma once

#include "samples/simulator/scene.hpp"
#include "samples/simulator/sessions.hpp"

namespace ceilmap::simulator {

/// Adds the people and masts of the scene's session: people walk past the robot, every second mast
/// stands all the time close to the path, the others pass. None touches the robot; one for which no
/// place is found is left out.
/// @param scene  Of PathKind::kTum only without people and masts.
void AddSessionMovers(const Sessions& sessions, Scene& scene);

}  // namespace ceilmap::simulator
