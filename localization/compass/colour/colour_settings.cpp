#include "localization/compass/colour/colour_settings.hpp"

namespace ceilmap::colour {

using Range = SettingRange;

namespace {

void DescribeLines(ScanLineParams& params, const Settings& settings) {
  settings.Add("lines", params.lines, "", Range::Closed(2, 1000), "Scan lines per frame.");
  settings.Add("min_above_horizon",
               params.min_above_horizon,
               "",
               Range::Closed(0, 1),
               "Frames with a smaller fraction of their pixels above the horizon are skipped.");
}

}  // namespace

void Describe(LearnParams& params, const Settings& settings) {
  settings.AddChoice(
      "kind",
      params.kind,
      {{"victoria", ModelKind::kVictoria},
       {"victoria-2013", ModelKind::kVictoria2013},
       {"sturm", ModelKind::kSturm}},
      "Kind of the model: a grid of places (as in the paper of 2013: one observation "
      "for each direction), or one cylinder.");
  const Settings classes = settings.In("classes");
  classes.AddChoice("clustering",
                    params.classes.clustering,
                    {{"auto", Clustering::kOfMethod},
                     {"kmeans", Clustering::kMeans},
                     {"mixture", Clustering::kMixture}},
                    "How the classes of colours are found; auto: mixture for kind sturm, else "
                    "kmeans.");
  classes.Add("classes",
              params.classes.classes,
              "",
              Range::Closed(2, kMaxClasses),
              "Number of classes of colours.");
  DescribeLines(params.lines, settings.In("lines"));
  settings.Add("bins", params.bins, "", Range::Closed(36, 720), "Directions of each cell.");
  settings.Add("fading_s",
               params.fading_s,
               "s",
               Range::Above(0),
               "Time in which the weight of what was learned falls by a factor of e.");
}

void Describe(ColourCompassParams& params, const Settings& settings) {
  DescribeLines(params.lines, settings.In("lines"));
  settings.Add(
      "exposure_sigma",
      params.exposure_sigma,
      "",
      Range::AtLeast(0),
      "Standard deviation of the logarithm of pixel values relative to the model; 0: equal "
      "exposure.");
  settings.Add("parallax",
               params.parallax,
               "Whether the parallax between the robot and the learned positions is modelled.");
}

}  // namespace ceilmap::colour
