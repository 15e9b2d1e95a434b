#include "localization/compass/labrosse/compass_settings.hpp"

#include "localization/compass/labrosse/constants.hpp"

namespace ceilmap::labrosse {

using Range = SettingRange;

void Describe(CompassParams& params, const Settings& settings) {
  const Settings fft = settings.In("fft");
  fft.Add("field_of_view_rad",
          params.fft.field_of_view_rad,
          "rad",
          Range::LeftOpen(0, kTurn),
          "Width of each of the two fields of view in which the first estimate is searched.");
  fft.Add("recent_references",
          params.fft.recent_references,
          "",
          Range::AtLeast(1),
          "Recent references that a new one is measured against.");
  fft.Add("kept_references",
          params.fft.kept_references,
          "",
          Range::AtLeast(4),
          "References that are kept for recognition when the robot returns.");
  fft.Add("revisits",
          params.fft.revisits,
          "",
          Range::AtLeast(0),
          "Old references that are compared with a new one.");
  const Settings paper = settings.In("labrosse2006");
  paper.Add("field_of_view_rad",
            params.labrosse2006.field_of_view_rad,
            "rad",
            Range::LeftOpen(0, kTurn),
            "Width of each of the two fields of view.");
  paper.Add("threshold",
            params.labrosse2006.threshold,
            "",
            Range::Closed(0, 1),
            "A reference is kept until the normalised amplitude of its minimum falls below this.");
  paper.AddChoice(
      "variant",
      params.labrosse2006.variant,
      {{"published", Labrosse2006Variant::kPublished}, {"probes", Labrosse2006Variant::kProbes}},
      "The published method, or that of `--method labrosse2006-probes`.");
}

}  // namespace ceilmap::labrosse
