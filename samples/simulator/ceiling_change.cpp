#include "samples/simulator/ceiling_change.hpp"

#include <algorithm>
#include <array>

namespace ceilmap::simulator {
namespace {

using Eigen::AlignedBox2d;
using Eigen::Vector2d;

/// Adds what remains of a box without another one: up to four boxes.
void AddRest(const AlignedBox2d& box, const AlignedBox2d& cover, std::vector<AlignedBox2d>& rest) {
  const AlignedBox2d hidden = box.intersection(cover);
  if (hidden.isEmpty() || hidden.volume() <= 0) {
    rest.push_back(box);
    return;
  }
  const Vector2d& low = hidden.min();
  const Vector2d& high = hidden.max();
  const std::array<AlignedBox2d, 4> sides{
      AlignedBox2d(box.min(), Vector2d(low.x(), box.max().y())),
      AlignedBox2d(Vector2d(high.x(), box.min().y()), box.max()),
      AlignedBox2d(Vector2d(low.x(), box.min().y()), Vector2d(high.x(), low.y())),
      AlignedBox2d(Vector2d(low.x(), high.y()), Vector2d(high.x(), box.max().y()))};
  for (const AlignedBox2d& side : sides) {
    if (side.volume() > 0) rest.push_back(side);
  }
}

}  // namespace

std::string_view NameOf(ChangeKind kind) {
  constexpr std::array<std::string_view, 4> kNames{"panel", "opening", "lamp", "banner"};
  return kNames.at(static_cast<std::size_t>(kind));
}

std::string_view NameOf(ChangeDetail detail) {
  constexpr std::array<std::string_view, 7> kNames{
      "replaced", "opened", "hung", "taken_away", "mounted", "switched_off", "switched_on"};
  return kNames.at(static_cast<std::size_t>(detail));
}

double VisibleShare(const std::vector<CeilingChange>& changes, std::size_t index) {
  const AlignedBox2d& area = changes[index].area_m;
  std::vector<AlignedBox2d> visible{area};
  for (std::size_t i = index + 1; i < changes.size() && !visible.empty(); ++i) {
    if (!changes[i].area_m.intersects(area)) continue;
    std::vector<AlignedBox2d> rest;
    for (const AlignedBox2d& box : visible) AddRest(box, changes[i].area_m, rest);
    visible = std::move(rest);
  }
  double sum = 0;
  for (const AlignedBox2d& box : visible) sum += box.volume();
  return std::clamp(sum / area.volume(), 0.0, 1.0);
}

}  // namespace ceilmap::simulator
