#include "app/commands/new_ground.hpp"

#include <algorithm>
#include <optional>
#include <vector>

#include "app/terminal/progress.hpp"
#include "calib/base/result_date.hpp"
#include "localization/robot/ceiling_mapper.hpp"
#include "mapping/change/map_pruning.hpp"
#include "mapping/store/map_revision.hpp"

namespace fs = std::filesystem;

namespace ceilmap::commands {
namespace {

/// Maps the recording into the map.
void Extend(const LocalizeInputs& inputs, const fs::path& map, const std::string& provenance) {
  const CommandSettings settings = inputs.settings.Read();
  std::optional<calib::Rig> rig = inputs.Rig();
  const recordings::SensorFiles files = inputs.SensorFiles();
  recordings::ReserveTopics(files);
  recordings::FrameSource source(inputs.up,
                                 {.stamps = inputs.stamps, .bag = inputs.bags.Topic("up")});
  recordings::SensorInputs sensors(files, rig);
  inputs.bags.Bags().ReleaseReserved();
  robot::CeilingMapperParams params;
  params.sensors = sensors.Params(settings.sensors);
  params.mapping = settings.mapping;
  params.append = mapping::HeldPoses::kFirstPart;
  params.source = inputs.up;
  params.provenance = provenance + "; new ground; " + ResultDate();
  robot::CeilingMapper mapper(*rig, map, params);
  terminal::Progress progress("new ground", "frames", source.ExpectedFrames());
  sensors.AddHeadings(mapper);
  std::int64_t done = 0;
  for (recordings::Frame frame; source.Read(frame); frame = {}) {
    sensors.ReadTo(frame.stamp_s, mapper);
    mapper.AddCeilingPipelined({frame.image, frame.stamp_s, frame.index, frame.encoding});
    progress.Update(++done);
  }
  mapper.Flush();
  mapper.Finish();
}

}  // namespace

bool CanBeReadAgain(const std::string& source) {
  return source.find("://") == std::string::npos && source.rfind("/dev/", 0) != 0 && source != "-";
}

std::int64_t AddNewGround(const LocalizeInputs& inputs,
                          const fs::path& map,
                          const std::string& provenance) {
  const auto last_id = [&map] {
    const std::vector<graph::Keyframe> keyframes = store::MapReader(map).ReadKeyframes();
    return keyframes.empty() ? -1 : keyframes.back().id;
  };
  const std::int64_t first_new = last_id() + 1;
  Extend(inputs, map, provenance);
  store::MapRevision revision(map, map, provenance + "; keyframes of old ground retired");
  change::RetireKeyframes(revision, std::nullopt, {}, 0, first_new);
  revision.Commit();
  const std::vector<graph::Keyframe> keyframes = store::MapReader(map).ReadKeyframes();
  return std::count_if(keyframes.begin(), keyframes.end(), [&](const graph::Keyframe& keyframe) {
    return keyframe.id >= first_new;
  });
}

}  // namespace ceilmap::commands
