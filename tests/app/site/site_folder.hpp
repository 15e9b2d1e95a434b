#pragma once

#include <fcntl.h>
#include <sys/stat.h>

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>

#include "app/site/manifest.hpp"
#include "app/site/plan.hpp"
#include "tests/support/test_folder.hpp"

namespace ceilmap::site {

/// A folder with the files that a manifest names.
class SiteFolder {
 public:
  SiteFolder() {
    for (const char* const name :
         {"rig.yaml", "a.mp4", "b.mp4", "c.mp4", "a.csv", "wheels.csv", "points.csv"}) {
      folder.Write(name, "x");
    }
    folder.Write("old.gpkg", "map");
  }

  [[nodiscard]] Manifest Parse(const std::string& text) const {
    return ParseManifest(text, folder / "site.yaml");
  }
  [[nodiscard]] Plan PlanOf(const std::string& text) const { return MakePlan(Parse(text)); }

  /// Sets the time of modification, seconds since 1970.
  void Touch(const std::string& name, std::int64_t seconds) const {
    const std::array<timespec, 2> times{timespec{seconds, 0}, timespec{seconds, 0}};
    ASSERT_EQ(utimensat(AT_FDCWD, (folder / name).c_str(), times.data(), 0), 0) << name;
  }

  /// Writes a program that stands for ceilmap.
  std::filesystem::path Script(const std::string& name, const std::string& text) const {
    std::filesystem::path file = folder.Write(name, "#!/bin/sh\n" + text);
    std::filesystem::permissions(file, std::filesystem::perms::owner_all);
    return file;
  }

  support::TestFolder folder;
};

inline constexpr const char* kTwoRecordings =
    "output: site.gpkg\n"
    "recordings:\n"
    "  - {name: a, rig: rig.yaml, up: a.mp4}\n"
    "  - {name: b, rig: rig.yaml, up: b.mp4}\n";

/// A program that writes its arguments and those of its inputs that are files to its `-o` file, as
/// ceilmap does: aside, and renamed.
inline constexpr const char* kStandIn =
    "for word; do\n"
    "  case $before in -o) output=$word ;; esac\n"
    "  before=$word\n"
    "done\n"
    "{ echo \"$SOURCE_DATE_EPOCH\"\n"
    "  for word; do echo \"$word\"; file=${word#--*=}\n"
    "    if [ -f \"$file\" ] && [ \"$file\" != \"$output\" ]; then cat \"$file\"; fi; done\n"
    "} >\"$output.partial\"\n"
    "mv \"$output.partial\" \"$output\"\n";

}  // namespace ceilmap::site
