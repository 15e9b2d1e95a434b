#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <iterator>
#include <map>
#include <opencv2/core.hpp>
#include <system_error>
#include <utility>
#include <vector>

#include "app/commands/commands.hpp"
#include "app/files/csv.hpp"
#include "app/files/image_pairs.hpp"
#include "app/files/output_files.hpp"
#include "app/recordings/images.hpp"
#include "app/terminal/clock.hpp"
#include "app/terminal/console.hpp"
#include "app/terminal/interrupt.hpp"
#include "app/terminal/progress.hpp"
#include "app/terminal/table.hpp"
#include "calib/base/degrees.hpp"
#include "calib/base/error.hpp"
#include "mapping/registration/registrar.hpp"

namespace fs = std::filesystem;

namespace ceilmap::commands {
namespace {

using registration::Registration;

struct RegisterOptions {
  std::vector<fs::path> images;  // reference, current
  fs::path pairs;
  fs::path output;
  bool fixed_scale = false;

  // @throws InputError
  void Validate(files::Existing existing) const;
};

void RegisterOptions::Validate(files::Existing existing) const {
  const bool list = !pairs.empty();
  if (list == !images.empty() || (!list && images.size() != 2)) {
    throw InputError("give two images, REF.png CUR.png, or a list with --pairs PAIRS.csv");
  }
  if (list && output.empty()) {
    throw InputError("--pairs needs -o OUT.csv for the results");
  }
  files::CheckOutputFiles({output}, existing);
}

struct PairResult {
  std::string id;
  Registration registration;
  double ms = 0;  // analysis of both images and their registration; no file access
};

// Registers pairs of any size. The FFT plans of a size are created once.
class PairRegistrar {
 public:
  explicit PairRegistrar(bool fixed_scale) {
    params_.estimate_scale = !fixed_scale;
    params_.local_features = true;
  }

  // @throws InputError when an image cannot be read or the sizes differ.
  PairResult Run(const files::ImagePair& pair) {
    const cv::Mat reference = Read(pair, pair.reference);
    const cv::Mat current = Read(pair, pair.current);
    if (reference.size() != current.size()) {
      throw InputError(
          fmt::format("{}: reference is {}x{} px, current is {}x{} px; both must "
                      "have one size",
                      pair.place,
                      reference.cols,
                      reference.rows,
                      current.cols,
                      current.rows));
    }
    registration::Registrar& registrar = ForSize(reference.size());
    const auto start = std::chrono::steady_clock::now();
    const registration::FrameSpectrum reference_spectrum = registrar.Analyze(reference);
    const registration::FrameSpectrum current_spectrum = registrar.Analyze(current);
    PairResult result{pair.id, registrar.RegisterAnyPlaces(reference_spectrum, current_spectrum)};
    result.ms = terminal::MillisecondsSince(start);
    return result;
  }

 private:
  static cv::Mat Read(const files::ImagePair& pair, const fs::path& image) {
    try {
      return recordings::ReadGreyImage(image);
    } catch (const InputError& error) {
      if (pair.place == image.string()) throw;
      throw InputError(fmt::format("{}: {}", pair.place, error.what()));
    }
  }

  registration::Registrar& ForSize(cv::Size size) {
    constexpr std::size_t kMaxSizes = 8;  // bounds memory for lists of many sizes
    const std::pair key(size.width, size.height);
    if (registrars_.size() >= kMaxSizes && !registrars_.contains(key)) registrars_.clear();
    return registrars_.try_emplace(key, size, params_).first->second;
  }

  registration::RegistrarParams params_;
  std::map<std::pair<int, int>, registration::Registrar> registrars_;
};

std::string FormatCsv(const std::vector<PairResult>& results) {
  std::string text = "id,ok,tx,ty,theta_deg,scale,peak,runner_up,ms\n";
  for (const PairResult& result : results) {
    const Registration& found = result.registration;
    text += files::CsvField(result.id);
    if (found.ok()) {
      fmt::format_to(std::back_inserter(text),
                     ",1,{:.6f},{:.6f},{:.6f},{:.8f},{:.6f},{:.6f},{:.3f}\n",
                     found.motion.tx_px,
                     found.motion.ty_px,
                     kDegPerRad * found.motion.theta_rad,
                     found.motion.scale,
                     found.peak,
                     found.runner_up,
                     result.ms);
    } else {
      text += ",0,,,,,,,\n";
    }
  }
  return text;
}

void Summarize(const std::vector<PairResult>& results, terminal::Summary& summary) {
  std::vector<double> ms;
  double total_ms = 0;
  std::map<std::string, std::int64_t> verdicts;
  for (const PairResult& result : results) {
    ++verdicts[registration::ToString(result.registration.verdict)];
    ms.push_back(result.ms);
    total_ms += result.ms;
  }
  std::sort(ms.begin(), ms.end());
  summary.frames = static_cast<std::int64_t>(results.size());
  summary.interrupted = terminal::Interrupted();
  summary.stages_ms = {{"register", total_ms}};
  summary.quality = {{"verdicts", verdicts}, {"median_ms", ms.empty() ? 0 : ms[ms.size() / 2]}};
}

void PrintReport(const terminal::Summary& summary) {
  terminal::Table table;
  table.AddRow({"pairs", fmt::format("{}", summary.frames)});
  for (const auto& [verdict, count] : summary.quality["verdicts"].items()) {
    table.AddRow({verdict, fmt::format("{}", count.get<std::int64_t>())});
  }
  table.AddRow({"median", fmt::format("{:.2f}", summary.quality["median_ms"].get<double>()), "ms"});
  fmt::print("{}", table.Format());
}

void PrintResult(const PairResult& result) {
  const Registration& found = result.registration;
  terminal::Table table;
  table.AddRow({"verdict", registration::ToString(found.verdict)});
  if (found.ok()) {
    table.AddRow({"tx", fmt::format("{:.4f}", found.motion.tx_px), "px, to the right"});
    table.AddRow({"ty", fmt::format("{:.4f}", found.motion.ty_px), "px, down"});
    table.AddRow(
        {"theta", fmt::format("{:.4f}", kDegPerRad * found.motion.theta_rad), "deg, clockwise"});
    table.AddRow({"scale", fmt::format("{:.6f}", found.motion.scale)});
    table.AddRow({"overlap", fmt::format("{:.1f}", 100 * found.overlap), "%"});
    table.AddRow(
        {"blocks", fmt::format("{}", found.blocks), fmt::format("{} agree", found.inliers)});
  }
  table.AddRow({"peak", fmt::format("{:.4f}", found.peak)});
  table.AddRow({"runner-up", fmt::format("{:.4f}", found.runner_up)});
  table.AddRow({"time", fmt::format("{:.2f}", result.ms), "ms"});
  fmt::print("{}", table.Format());
}

std::vector<PairResult> RegisterAll(const std::vector<files::ImagePair>& pairs, bool fixed_scale) {
  PairRegistrar registrar(fixed_scale);
  terminal::Progress progress("registering", "pairs", static_cast<std::int64_t>(pairs.size()));
  std::vector<PairResult> results;
  for (const files::ImagePair& pair : pairs) {
    if (terminal::Interrupted()) {
      terminal::Note("interrupted: {} of {} pairs were kept", results.size(), pairs.size());
      break;
    }
    results.push_back(registrar.Run(pair));
    progress.Update(static_cast<std::int64_t>(results.size()));
    terminal::Detail(
        "{}: {}", pair.id, registration::ToString(results.back().registration.verdict));
  }
  return results;
}

void RunRegister(const RegisterOptions& params,
                 const CommonOptions& common,
                 terminal::Summary& summary) {
  params.Validate(common.Existing());
  const bool list = !params.pairs.empty();
  std::vector<files::ImagePair> pairs;
  if (list) {
    pairs = files::ReadPairs(params.pairs);
  } else {
    const fs::path& current = params.images[1];
    pairs = {{current.stem().string(), params.images[0], current, current.string()}};
  }
  const std::vector<PairResult> results = RegisterAll(pairs, params.fixed_scale);
  Summarize(results, summary);
  if (!params.output.empty()) {
    files::WriteFileAtomically(params.output, FormatCsv(results));
    summary.files.push_back(params.output);
  }
  if (list) {
    if (!common.quiet) PrintReport(summary);
  } else if (!results.empty()) {
    PrintResult(results.front());
  }
}

}  // namespace

Command AddRegisterCommand(CLI::App& program) {
  Command command = MakeCommand(program,
                                "register",
                                "Finds the motion between two images of one size: x' = s R(theta) "
                                "(x - c) + c + t.",
                                "ceilmap register reference.png current.png\n"
                                "  ceilmap register --pairs pairs.csv -o results.csv");
  auto params = std::make_shared<RegisterOptions>();
  CLI::App& cli = *command.cli;
  cli.add_option("images", params->images, "The reference and the current image")
      ->expected(0, 2)
      ->type_name("REF.png CUR.png");
  cli.add_option("--pairs", params->pairs, "List of pairs: id,reference,current")
      ->type_name("PAIRS.csv");
  cli.add_option("-o,--output", params->output, "Results as CSV")->type_name("OUT.csv");
  cli.add_flag(
      "--fixed-scale", params->fixed_scale, "The images have the same scale (a level robot)");
  command.run = [params](const CommonOptions& common, terminal::Summary& summary) {
    RunRegister(*params, common, summary);
  };
  return command;
}

}  // namespace ceilmap::commands
