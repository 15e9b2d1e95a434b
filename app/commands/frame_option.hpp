#pragma once

#include <CLI/CLI.hpp>
#include <string>

#include "mapping/store/export.hpp"

namespace ceilmap::commands {

/// --frame: coordinates of results, those of the map or of its building.
struct FrameOption {
  std::string frame = "map";

  CLI::Option* AddTo(CLI::App& cli);
  [[nodiscard]] store::Frame Value() const {
    return frame == "site" ? store::Frame::kSite : store::Frame::kMap;
  }
};

}  // namespace ceilmap::commands
