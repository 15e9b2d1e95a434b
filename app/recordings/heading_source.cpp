#include "app/recordings/heading_source.hpp"

#include <fmt/format.h>

#include <utility>

#include "app/files/heading_csv.hpp"
#include "app/recordings/colour_headings.hpp"
#include "app/recordings/omni_headings.hpp"
#include "calib/base/error.hpp"
#include "localization/heading_track.hpp"

namespace ceilmap::recordings {
namespace {

/// The headings of a file.
class FileHeadings : public HeadingSource {
 public:
  explicit FileHeadings(const std::filesystem::path& file)
      : file_(file), track_(files::ReadHeadings(file)) {}

  std::optional<HeadingPrior> At(double stamp_s) override {
    const auto heading = track_.At(stamp_s);
    ++(heading ? told_ : missing_);
    return heading;
  }
  void Locate(double /*stamp_s*/, const std::optional<Pose2>& /*T_map_base*/) override {}
  [[nodiscard]] std::vector<std::string> Warnings() const override {
    if (missing_ == 0) return {};
    return {fmt::format("{}: {} of {} upward frames have no heading near their time",
                        file_.string(),
                        missing_,
                        told_ + missing_)};
  }
  [[nodiscard]] nlohmann::ordered_json Quality() const override {
    return {{"by", "file"}, {"headings", told_}, {"missing", missing_}};
  }
  void AddTimes(nlohmann::ordered_json& /*stages_ms*/) const override {}
  void AddRows(terminal::Table& table) const override {
    table.AddRow({"headings",
                  fmt::format("{}", told_),
                  fmt::format("of {}; {} missing", file_.filename().string(), missing_)});
  }

 private:
  std::filesystem::path file_;
  localization::HeadingTrack track_;
  std::int64_t told_ = 0;
  std::int64_t missing_ = 0;
};

}  // namespace

void HeadingOptions::AddTo(CLI::App& cli, const std::string& inputs, const std::string& priors) {
  cli.add_option("--omni", omni, "Camera under a convex mirror, for the heading")
      ->type_name("SOURCE")
      ->group(inputs);
  cli.add_option("--omni-stamps", omni_stamps, "Time of each mirror frame [--stamps]")
      ->type_name("FRAMES.csv")
      ->group(inputs);
  cli.add_option("--heading", file, "Headings instead: timestamp,heading_deg,sigma_deg")
      ->type_name("H.csv")
      ->group(priors);
}

void HeadingOptions::AddModelTo(CLI::App& cli, const std::string& priors) {
  cli.add_option("--heading-model",
                 model,
                 "Headings by the colours that --forward sees instead: a model of 'compass learn', "
                 "learned at poses on this map")
      ->type_name("MODEL")
      ->group(priors);
}

void HeadingOptions::Check(bool have_rig) const {
  if (!omni.empty() && !file.empty()) {
    throw InputError("--omni and --heading: give one of the two");
  }
  if (!model.empty() && (!omni.empty() || !file.empty())) {
    throw InputError(fmt::format("--heading-model and {}: give one of the two",
                                 omni.empty() ? "--heading" : "--omni"));
  }
  if (!model.empty() && forward.empty()) {
    throw InputError("--heading-model: needs the forward camera; give --forward");
  }
  if (!omni.empty() && !have_rig) {
    throw InputError("--omni: the mirror is described in the robot's geometry; give --rig");
  }
  if (omni.empty() && !omni_stamps.empty()) {
    throw InputError("--omni-stamps: there are no mirror frames; give --omni");
  }
}

std::unique_ptr<HeadingSource> HeadingSource::Make(const HeadingOptions& options,
                                                   const std::optional<calib::Rig>& rig,
                                                   const std::filesystem::path& rig_file,
                                                   const std::filesystem::path& stamps) {
  if (!options.file.empty()) return std::make_unique<FileHeadings>(options.file);
  if (!rig) return nullptr;
  if (!options.model.empty()) {
    return ColourHeadings::Make(options.model,
                                options.forward,
                                options.forward_stamps.empty() ? stamps : options.forward_stamps,
                                *rig,
                                rig_file);
  }
  if (options.omni.empty()) return nullptr;
  const auto& frames = options.omni_stamps.empty() ? stamps : options.omni_stamps;
  return OmniHeadings::Make(options.omni, frames, *rig, rig_file);
}

}  // namespace ceilmap::recordings
