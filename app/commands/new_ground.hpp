#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "app/commands/localize_run.hpp"

namespace ceilmap::commands {

/// Whether a recording can be read a second time: no camera, no stream.
bool CanBeReadAgain(const std::string& source);

/// Reads a recording again and adds the ground beyond the map, as `map --append` does, while the
/// keyframes of the map keep their poses to the last bit. Of the new keyframes those remain that
/// others do not cover.
/// @return the number of new keyframes that remain.
/// @throws InputError, RunError as robot::CeilingMapper; the map is then as it was.
std::int64_t AddNewGround(const LocalizeInputs& inputs,
                          const std::filesystem::path& map,
                          const std::string& provenance);

}  // namespace ceilmap::commands
