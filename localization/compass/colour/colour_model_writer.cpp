#include <fmt/format.h>

#include <cmath>
#include <cstdint>
#include <fstream>
#include <nlohmann/json.hpp>

#include "calib/base/atomic_file.hpp"
#include "calib/base/error.hpp"
#include "localization/compass/colour/colour_model_file.hpp"
#include "localization/compass/colour/colour_model_format.hpp"

namespace fs = std::filesystem;

namespace ceilmap::colour {
namespace {

using nlohmann::ordered_json;

double Rounded(double value, double unit) {
  return std::round(value / unit) * unit;
}

// With this number of significant digits.
double Significant(double value, int digits) {
  return std::stod(fmt::format("{:.{}g}", value, digits));
}

// Rounded multiples of 1 / scale; a negative number counts zeros.
ordered_json Packed(const Eigen::VectorXf& values, double scale) {
  ordered_json packed = ordered_json::array();
  std::int64_t zeros = 0;
  const auto end_zeros = [&] {
    if (zeros > 0) packed.push_back(-zeros);
    zeros = 0;
  };
  for (const float value : values) {
    const auto multiple = static_cast<std::int64_t>(std::llround(value * scale));
    if (multiple == 0) {
      ++zeros;
      continue;
    }
    end_zeros();
    packed.push_back(multiple);
  }
  end_zeros();
  return packed;
}

ordered_json ToJson(const ColourClass& colour) {
  const auto rounded = [](const auto& values) {
    ordered_json list = ordered_json::array();
    for (const float value : values) list.push_back(Significant(value, 6));
    return list;
  };
  return {{"mean", rounded(colour.mean)},
          {"covariance", rounded(colour.covariance)},
          {"weight", Significant(colour.weight, 6)}};
}

ordered_json ToJson(const AngleBin& bin, std::size_t index) {
  // Rounded to a tenth of a millimetre and a millisecond, without superfluous digits.
  const auto place = [](double metres) { return Significant(Rounded(metres, 1e-4), 9); };
  ordered_json entry = {{"bin", index},
                        {"certainty", Significant(bin.certainty, 6)},
                        {"stamp_s", Significant(Rounded(bin.stamp_s, 1e-3), 14)},
                        {"place_m", {place(bin.place.x()), place(bin.place.y())}},
                        {"transitions", Packed(bin.transitions, kTransitionScale)}};
  if (bin.variance.size() > 0) entry["variance"] = Packed(bin.variance, kVarianceScale);
  return entry;
}

ordered_json HeadOf(const ColourModel& model) {
  ordered_json head = {{"format", kColourModelFormat},
                       {"version", ColourModel::kVersion},
                       {"program", "ceilmap " CEILMAP_VERSION},
                       {"kind", ToString(model.kind)},
                       {"bins", model.bins},
                       {"grid",
                        {{"min_x_m", model.grid.min_x_m},
                         {"min_y_m", model.grid.min_y_m},
                         {"width_m", model.grid.width_m},
                         {"height_m", model.grid.height_m},
                         {"columns", model.grid.columns},
                         {"rows", model.grid.rows}}},
                       {"depth_m", Significant(model.depth_m, 6)},
                       {"fading_s", model.fading_s},
                       {"frames", model.frames},
                       {"provenance", model.provenance},
                       {"classes", ordered_json::array()}};
  for (const ColourClass& colour : model.classes) head["classes"].push_back(ToJson(colour));
  return head;
}

// One line per bin, so that two models can be compared with text tools.
void AppendCell(const Cell& cell, std::string& text) {
  const char* separator = "";
  text += '[';
  for (std::size_t b = 0; b < cell.bins.size(); ++b) {
    if (cell.bins[b].empty()) continue;
    text += fmt::format("{}\n{}", separator, ToJson(cell.bins[b], b).dump());
    separator = ",";
  }
  text += ']';
}

}  // namespace

std::string FormatColourModel(const ColourModel& model) {
  // The provenance contains the command line as typed, in any encoding.
  std::string text = HeadOf(model).dump(-1, ' ', false, ordered_json::error_handler_t::replace);
  text.pop_back();  // the closing brace
  text += ",\"cells\":[\n";
  for (std::size_t c = 0; c < model.cells.size(); ++c) {
    if (c > 0) text += ",\n";
    AppendCell(model.cells[c], text);
  }
  text += "]}\n";
  return text;
}

void WriteColourModel(const ColourModel& model, const fs::path& file) {
  const std::string text = FormatColourModel(model);
  if (text.size() > kMaxColourModelBytes) {
    throw RunError(
        fmt::format("{}: would have {} bytes, at most {} can be read again; learn it with fewer "
                    "cells, bins or classes",
                    file.string(),
                    text.size(),
                    kMaxColourModelBytes));
  }
  AtomicFile target(file);
  std::ofstream stream(target.PartialPath(), std::ios::binary | std::ios::trunc);
  stream.write(text.data(), static_cast<std::streamsize>(text.size()));
  stream.close();
  if (!stream) {
    throw RunError(fmt::format("{}: cannot be written; is the disk full?", file.string()));
  }
  target.Commit();
}

}  // namespace ceilmap::colour
