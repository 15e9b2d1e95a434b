#include "localization/compass/colour/colour_model_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <system_error>
#include <vector>

#include "calib/base/error.hpp"
#include "calib/base/one_line.hpp"
#include "localization/compass/colour/colour_model_format.hpp"

namespace fs = std::filesystem;

namespace ceilmap::colour {
namespace {

using nlohmann::json;

constexpr const char* kAnew = "learn it anew with 'ceilmap compass learn'";

std::string ReadText(const fs::path& file) {
  const auto refuse = [&file](const std::string& what) {
    throw InputError(fmt::format("{}: {}", file.string(), what));
  };
  std::error_code error;
  const fs::file_status status = fs::status(file, error);
  if (!fs::exists(status)) {
    refuse("no such file; make a model with 'ceilmap compass learn'");
  }
  if (!fs::is_regular_file(status)) refuse("is not a file");
  const std::uintmax_t bytes = fs::file_size(file, error);
  if (!error && bytes > kMaxColourModelBytes) {
    refuse(fmt::format(
        "has {} bytes, more than the {} that a colour model may have; give another file",
        bytes,
        kMaxColourModelBytes));
  }
  std::ifstream stream(file, std::ios::binary);
  if (error || !stream) refuse("cannot be read; check its permissions");
  std::string text(std::istreambuf_iterator<char>(stream), {});
  if (text.empty()) refuse(fmt::format("is empty; {}", kAnew));
  return text;
}

// Values need more memory than text: content that no model has is refused while it is read.
json Parse(const std::string& text) {
  constexpr int kMaxDepth = 8;
  constexpr std::int64_t kMaxValues = 16'000'000;
  std::int64_t values = 0;
  const auto check = [&values](int depth, json::parse_event_t /*event*/, const json& /*parsed*/) {
    if (depth > kMaxDepth || ++values > kMaxValues) {
      throw InputError("is no colour model; give one of 'ceilmap compass learn'");
    }
    return true;
  };
  try {
    return json::parse(text, check);
  } catch (const json::parse_error& error) {
    throw InputError(
        fmt::format("is no colour model: no JSON from byte {} on; {}", error.byte, kAnew));
  } catch (const json::exception&) {
    throw InputError(fmt::format("is no colour model: has impossible numbers; {}", kAnew));
  }
}

// An object of the document, with its position.
class Fields {
 public:
  Fields(const json& object, std::string place) : object_(object), place_(std::move(place)) {
    if (!object_.is_object()) Refuse("must be an object");
  }

  [[nodiscard]] const json& At(const char* key) const {
    const auto found = object_.find(key);
    if (found == object_.end()) Refuse(fmt::format("has no '{}'", key));
    return *found;
  }
  [[nodiscard]] bool Has(const char* key) const { return object_.contains(key); }

  [[nodiscard]] double Number(const char* key) const {
    const json& value = At(key);
    const double number = value.is_number() ? value.get<double>() : NAN;
    if (!std::isfinite(number)) Refuse(fmt::format("'{}' must be a number", key));
    return number;
  }
  [[nodiscard]] std::int64_t Whole(const char* key, std::int64_t least, std::int64_t most) const {
    const json& value = At(key);
    const bool fits = value.is_number_integer() && value.get<double>() >= double(least) &&
                      value.get<double>() <= double(most);
    if (!fits) Refuse(fmt::format("'{}' must be a whole number in {}..{}", key, least, most));
    return value.get<std::int64_t>();
  }
  [[nodiscard]] std::string Text(const char* key) const {
    const json& value = At(key);
    if (!value.is_string()) Refuse(fmt::format("'{}' must be a text", key));
    return value.get<std::string>();
  }
  [[nodiscard]] const json& List(const char* key, std::size_t least, std::size_t most) const {
    const json& value = At(key);
    if (!value.is_array()) Refuse(fmt::format("'{}' must be a list", key));
    if (value.size() < least || value.size() > most) {
      const std::string wanted =
          least == most ? fmt::format("{}", least) : fmt::format("{}..{}", least, most);
      Refuse(fmt::format("'{}' has {} entries, must have {}", key, value.size(), wanted));
    }
    return value;
  }
  // A list of numbers.
  template <typename Values>
  void Numbers(const char* key, Values& values) const {
    const json& list = List(key, values.size(), values.size());
    for (std::size_t i = 0; i < list.size(); ++i) {
      const double number = list[i].is_number() ? list[i].get<double>() : NAN;
      if (!(std::abs(number) < 1e9)) Refuse(fmt::format("'{}' must hold numbers", key));
      values[i] = static_cast<typename Values::value_type>(number);
    }
  }
  // The inverse of Packed: `size` values, or no values at all.
  [[nodiscard]] Eigen::VectorXf Unpacked(const char* key, int size, double scale) const {
    const json& list = List(key, 1, static_cast<std::size_t>(size));
    Eigen::VectorXf values = Eigen::VectorXf::Zero(size);
    std::int64_t at = 0;
    for (const json& entry : list) {
      const double number = entry.is_number_integer() ? entry.get<double>() : NAN;
      if (!(number <= scale) || number == 0) {  // frequencies and their variances are at most 1
        Refuse(fmt::format("'{}' must hold whole numbers up to {}, not 0", key, scale));
      }
      const double taken = number < 0 ? -number : 1;
      if (static_cast<double>(at) + taken > size) {
        Refuse(fmt::format(
            "'{}' stand for more than {} values, as many as pairs of classes", key, size));
      }
      if (number > 0) values[at] = static_cast<float>(number / scale);
      at += static_cast<std::int64_t>(taken);
    }
    if (at != size) {
      Refuse(fmt::format(
          "'{}' stand for {} values, must be {}, as many as pairs of classes", key, at, size));
    }
    return values;
  }

  [[noreturn]] void Refuse(const std::string& what) const {
    throw InputError(fmt::format("{}{}{}; {}", place_, place_.empty() ? "" : ": ", what, kAnew));
  }

 private:
  const json& object_;
  std::string place_;
};

void CheckColourModelFormat(const json& document) {
  const auto text_at = [&document](const char* key) {
    const auto found = document.is_object() ? document.find(key) : document.end();
    return found != document.end() && found->is_string() ? found->get<std::string>() : "";
  };
  if (!document.is_object() || text_at("format") != kColourModelFormat) {
    throw InputError("is no colour model; give one of 'ceilmap compass learn'");
  }
  const std::int64_t version = Fields(document, "").Whole("version", 1, 1'000'000);
  if (version > ColourModel::kVersion) {
    throw InputError(
        fmt::format("is a colour model of version {}, this program reads up to version {}; use a "
                    "newer ceilmap, or learn it anew",
                    version,
                    ColourModel::kVersion));
  }
}

ModelKind KindOf(const Fields& fields) {
  const std::string kind = fields.Text("kind");
  for (const ModelKind known :
       {ModelKind::kVictoria, ModelKind::kSturm, ModelKind::kVictoria2013}) {
    if (kind == ToString(known)) return known;
  }
  fields.Refuse(fmt::format("'kind' is '{}', must be {}, {} or {}",
                            Shown(kind),
                            ToString(ModelKind::kVictoria),
                            ToString(ModelKind::kVictoria2013),
                            ToString(ModelKind::kSturm)));
}

colour::GridGeometry GridOf(const Fields& fields) {
  constexpr int kMaxSide = 100;
  colour::GridGeometry grid;
  grid.min_x_m = fields.Number("min_x_m");
  grid.min_y_m = fields.Number("min_y_m");
  grid.width_m = fields.Number("width_m");
  grid.height_m = fields.Number("height_m");
  grid.columns = static_cast<int>(fields.Whole("columns", 1, kMaxSide));
  grid.rows = static_cast<int>(fields.Whole("rows", 1, kMaxSide));
  return grid;
}

ColourClass ClassOf(const Fields& fields) {
  ColourClass colour;
  fields.Numbers("mean", colour.mean);
  fields.Numbers("covariance", colour.covariance);
  colour.weight = static_cast<float>(fields.Number("weight"));
  return colour;
}

/// @param room  Remaining number of frequencies; reduced by those of the bin.
void TakeBin(const Fields& fields, const ColourModel& model, std::int64_t& room, Cell& cell) {
  const auto index = static_cast<std::size_t>(fields.Whole("bin", 0, model.bins - 1));
  // Memory is allocated only for bins with content.
  if (cell.bins.empty()) cell.bins.resize(static_cast<std::size_t>(model.bins));
  AngleBin& bin = cell.bins[index];
  if (!bin.empty()) fields.Refuse(fmt::format("bin {} occurs twice", index));
  const auto size = static_cast<int>(model.classes.size() * model.classes.size());
  room -= fields.Has("variance") ? 2 * size : size;
  if (room < 0) fields.Refuse("more frequencies than the maximum of a model");
  bin.transitions = fields.Unpacked("transitions", size, kTransitionScale);
  if (fields.Has("variance")) bin.variance = fields.Unpacked("variance", size, kVarianceScale);
  bin.certainty = fields.Number("certainty");
  bin.stamp_s = fields.Number("stamp_s");
  std::vector<double> place(2);
  fields.Numbers("place_m", place);
  bin.place = {place[0], place[1]};
}

void TakeCells(const json& cells, std::int64_t room, ColourModel& model) {
  for (const json& list : cells) {
    Cell& cell = model.cells.emplace_back();
    const std::string place = fmt::format("cell {}", model.cells.size() - 1);
    if (!list.is_array() || list.size() > static_cast<std::size_t>(model.bins)) {
      throw InputError(
          fmt::format("{}: must be a list of at most {} bins; {}", place, model.bins, kAnew));
    }
    std::size_t position = 0;
    for (const json& entry : list) {
      TakeBin(Fields(entry, fmt::format("{}, entry {}", place, position++)), model, room, cell);
    }
    cell.bins.resize(static_cast<std::size_t>(model.bins));
  }
}

ColourModel ModelOf(const json& document, std::int64_t max_frequencies) {
  constexpr int kMinBins = 36;
  constexpr int kMaxBins = 720;
  CheckColourModelFormat(document);
  const Fields fields(document, "");
  ColourModel model;
  model.kind = KindOf(fields);
  model.bins = static_cast<int>(fields.Whole("bins", kMinBins, kMaxBins));
  model.grid = GridOf(Fields(fields.At("grid"), "grid"));
  model.depth_m = fields.Number("depth_m");
  model.fading_s = fields.Number("fading_s");
  model.frames = fields.Whole("frames", 0, std::int64_t{1} << 53U);
  model.provenance = fields.Text("provenance");
  for (const json& entry : fields.List("classes", 2, kMaxClasses)) {
    const std::string place = fmt::format("class {}", model.classes.size());
    model.classes.push_back(ClassOf(Fields(entry, place)));
  }
  const auto cells = static_cast<std::size_t>(
      model.kind == ModelKind::kSturm ? 1 : model.grid.columns * model.grid.rows);
  CheckBinCount(static_cast<int>(cells), model.bins);
  TakeCells(fields.List("cells", cells, cells), max_frequencies, model);
  return model;
}

}  // namespace

ColourModel ParseColourModel(const std::string& text,
                             const fs::path& file,
                             std::int64_t max_frequencies) {
  try {
    ColourModel model = ModelOf(Parse(text), max_frequencies);
    model.Validate();
    const auto filled = [](const Cell& cell) { return !cell.empty(); };
    if (!std::any_of(model.cells.begin(), model.cells.end(), filled)) {
      throw InputError(fmt::format("is empty: nothing was learned in it; {}", kAnew));
    }
    return model;
  } catch (const InputError& error) {
    throw InputError(fmt::format("{}: {}", file.string(), error.what()));
  }
}

ColourModel ReadColourModel(const fs::path& file) {
  return ParseColourModel(ReadText(file), file);
}

}  // namespace ceilmap::colour
