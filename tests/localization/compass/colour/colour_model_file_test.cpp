#include "localization/compass/colour/colour_model_file.hpp"

#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "tests/support/test_folder.hpp"

namespace ceilmap::colour {
namespace {

using nlohmann::json;
using testing::HasSubstr;

constexpr const char* kAnew = "; learn it anew with 'ceilmap compass learn'";

// Frequencies that sum to 1, most of them 0, as a line shows them.
Eigen::VectorXf SomeTransitions(int size, cv::RNG& random) {
  Eigen::VectorXf transitions = Eigen::VectorXf::Zero(size);
  for (int n = 0; n < 200; ++n) transitions[random.uniform(0, size)] += 0.005F;
  return transitions;
}

AngleBin SomeBin(int size, bool with_variance, cv::RNG& random) {
  AngleBin bin;
  bin.transitions = SomeTransitions(size, random);
  if (with_variance) bin.variance = 0.01F * bin.transitions;
  bin.certainty = random.uniform(0.01, 20.0);
  bin.stamp_s = 1.7e9 + random.uniform(0.0, 1000.0);
  bin.place = {random.uniform(-3.0, 3.0), random.uniform(-3.0, 3.0)};
  return bin;
}

/// @param filled  the first so many bins of each cell hold something.
ColourModel SomeModel(ModelKind kind, int classes, int filled) {
  constexpr std::uint64_t kSeed = 7;
  cv::RNG random(kSeed);
  ColourModel model;
  model.kind = kind;
  model.classes.resize(static_cast<std::size_t>(classes));
  for (ColourClass& colour : model.classes) {
    for (float& channel : colour.mean) channel = random.uniform(0.F, 255.F);
    colour.weight = 1 / static_cast<float>(classes);
  }
  model.grid.min_x_m = -1.0 / 3;
  const bool sturm = kind == ModelKind::kSturm;
  model.cells.resize(sturm ? 1 : static_cast<std::size_t>(model.grid.Cells()));
  for (Cell& cell : model.cells) {
    for (int b = 0; b < model.bins; ++b) {
      cell.bins.push_back(b < filled ? SomeBin(classes * classes, sturm, random) : AngleBin());
    }
  }
  model.depth_m = 2.75;
  model.frames = 91;
  model.provenance = "ceilmap compass learn \"a b\"\nceilmap compass update \xFF";
  return model;
}

void ExpectSameBin(const AngleBin& read, const AngleBin& stored) {
  ASSERT_EQ(read.empty(), stored.empty());
  ASSERT_EQ(read.variance.size(), stored.variance.size());
  if (stored.empty()) return;
  EXPECT_LT((read.transitions - stored.transitions).cwiseAbs().maxCoeff(), 0.6e-5F);
  if (stored.variance.size() > 0) {
    EXPECT_LT((read.variance - stored.variance).cwiseAbs().maxCoeff(), 0.6e-8F);
  }
  EXPECT_NEAR(read.certainty, stored.certainty, 1e-5 * stored.certainty);
  EXPECT_NEAR(read.stamp_s, stored.stamp_s, 0.6e-3);
  EXPECT_LT((read.place - stored.place).norm(), 1e-4);
}

void ExpectSame(const ColourModel& read, const ColourModel& stored) {
  EXPECT_EQ(read.kind, stored.kind);
  EXPECT_EQ(read.bins, stored.bins);
  EXPECT_EQ(read.grid.min_x_m, stored.grid.min_x_m);
  EXPECT_EQ(read.grid.Cells(), stored.grid.Cells());
  EXPECT_EQ(read.depth_m, stored.depth_m);
  EXPECT_EQ(read.fading_s, stored.fading_s);
  EXPECT_EQ(read.frames, stored.frames);
  EXPECT_THAT(read.provenance, HasSubstr("learn \"a b\"\nceilmap"));
  ASSERT_EQ(read.classes.size(), stored.classes.size());
  for (std::size_t i = 0; i < read.classes.size(); ++i) {
    for (std::size_t c = 0; c < 3; ++c) {
      EXPECT_NEAR(read.classes[i].mean[c], stored.classes[i].mean[c], 1e-3);
    }
  }
  ASSERT_EQ(read.cells.size(), stored.cells.size());
  for (std::size_t c = 0; c < read.cells.size(); ++c) {
    ASSERT_EQ(read.cells[c].bins.size(), stored.cells[c].bins.size());
    for (std::size_t b = 0; b < read.cells[c].bins.size(); ++b) {
      ExpectSameBin(read.cells[c].bins[b], stored.cells[c].bins[b]);
    }
  }
}

TEST(ColourModelFile, HoldsBothKinds) {
  const support::TestFolder folder;
  for (const auto kind : {ModelKind::kVictoria, ModelKind::kVictoria2013, ModelKind::kSturm}) {
    const ColourModel model = SomeModel(kind, 8, 31);
    WriteColourModel(model, folder / "m");
    ExpectSame(ReadColourModel(folder / "m"), model);
    EXPECT_THAT(folder.Names(), testing::ElementsAre("m"));
  }
}

// Only models whose classes are the same to the last digit can be merged.
TEST(ColourModelFile, ChangesNothingThatWasReadFromIt) {
  const support::TestFolder folder;
  WriteColourModel(SomeModel(ModelKind::kVictoria, 8, 31), folder / "m");
  const ColourModel once = ReadColourModel(folder / "m");
  WriteColourModel(once, folder / "again");
  EXPECT_EQ(support::ReadAll(folder / "m"), support::ReadAll(folder / "again"));
}

TEST(ColourModelFile, IsSmall) {
  const std::string text = FormatColourModel(SomeModel(ModelKind::kVictoria, 8, 180));
  EXPECT_LT(text.size(), 2'000'000U);
}

// A document with a mistake, and its message after the file's name.
struct BadModel {
  std::string name;
  std::function<void(json&)> damage;
  std::string message;
};
std::ostream& operator<<(std::ostream& stream, const BadModel& bad) {
  return stream << bad.name;
}

class BadModelTest : public testing::TestWithParam<BadModel> {};

std::string MessageOf(const std::filesystem::path& file) {
  try {
    (void)ReadColourModel(file);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST_P(BadModelTest, IsRefusedInOneLine) {
  const support::TestFolder folder;
  json document = json::parse(FormatColourModel(SomeModel(ModelKind::kVictoria, 8, 2)));
  GetParam().damage(document);
  const auto file = folder.Write("m", document.dump());
  EXPECT_EQ(MessageOf(file), file.string() + ": " + GetParam().message);
}

json& FirstBin(json& document) {
  return document["cells"][0][0];
}

const std::vector<BadModel> kBadModels = {
    {"OtherDocument",
     [](json& document) {
       document = {{"a", 1}};
     },
     "is no colour model; give one of 'ceilmap compass learn'"},
    {"OtherFormat",
     [](json& document) { document["format"] = "GeoJSON"; },
     "is no colour model; give one of 'ceilmap compass learn'"},
    {"List",
     [](json& document) {
       document = json::array({1, 2});
     },
     "is no colour model; give one of 'ceilmap compass learn'"},
    {"Deep",
     [](json& document) {
       for (int i = 0; i < 100; ++i) document = json::array({document});
     },
     "is no colour model; give one of 'ceilmap compass learn'"},
    {"NoVersion",
     [](json& document) { document.erase("version"); },
     std::string("has no 'version'") + kAnew},
    {"NewerVersion",
     [](json& document) { document["version"] = 2; },
     "is a colour model of version 2, this program reads up to version 1; use a newer ceilmap, or "
     "learn it anew"},
    {"UnknownKind",
     [](json& document) { document["kind"] = "fft"; },
     std::string("'kind' is 'fft', must be victoria, victoria-2013 or sturm") + kAnew},
    {"OtherKind",
     [](json& document) { document["kind"] = "sturm"; },
     std::string("'cells' has 15 entries, must have 1") + kAnew},
    {"MissingKey",
     [](json& document) { document.erase("depth_m"); },
     std::string("has no 'depth_m'") + kAnew},
    {"WrongType",
     [](json& document) { document["provenance"] = 3; },
     std::string("'provenance' must be a text") + kAnew},
    {"NoNumber",
     [](json& document) { document["depth_m"] = "far"; },
     std::string("'depth_m' must be a number") + kAnew},
    {"DepthOfNothing", [](json& document) { document["depth_m"] = 0; }, "depth 0 m, must be > 0"},
    {"ManyBins",
     [](json& document) { document["bins"] = 2'000'000'000; },
     std::string("'bins' must be a whole number in 36..720") + kAnew},
    {"HalfABin",
     [](json& document) { document["bins"] = 180.5; },
     std::string("'bins' must be a whole number in 36..720") + kAnew},
    {"ManyColumns",
     [](json& document) { document["grid"]["columns"] = 1'000'000; },
     std::string("grid: 'columns' must be a whole number in 1..100") + kAnew},
    {"GridIsNone",
     [](json& document) { document["grid"] = 5; },
     std::string("grid: must be an object") + kAnew},
    {"ManyBinsInAll",
     [](json& document) {
       document["bins"] = 720;
       document["grid"]["columns"] = 60;
       document["grid"]["rows"] = 60;
       document["cells"] = json(3600, json::array());
     },
     "3600 cells of 720 angle bins, must be at most 2000000 bins in all; take fewer cells"},
    {"OtherGrid",
     [](json& document) { document["grid"]["rows"] = 4; },
     std::string("'cells' has 15 entries, must have 20") + kAnew},
    {"FlatGrid",
     [](json& document) { document["grid"]["width_m"] = 0; },
     "a grid of 0 x 4 m, must be > 0"},
    {"OneClass",
     [](json& document) { document["classes"] = json::array({document["classes"][0]}); },
     std::string("'classes' has 1 entries, must have 2..32") + kAnew},
    {"OtherClasses",
     [](json& document) { document["classes"].erase(7); },
     std::string("cell 0, entry 0: 'transitions' has 64 entries, must have 1..49") + kAnew},
    {"ShortMean",
     [](json& document) { document["classes"][3]["mean"].erase(2); },
     std::string("class 3: 'mean' has 2 entries, must have 3") + kAnew},
    {"MeanIsText",
     [](json& document) { document["classes"][3]["mean"][0] = "red"; },
     std::string("class 3: 'mean' must hold numbers") + kAnew},
    {"CellIsNone",
     [](json& document) { document["cells"][2] = "none"; },
     std::string("cell 2: must be a list of at most 180 bins") + kAnew},
    {"CellOfManyBins",
     [](json& document) { document["cells"][2] = json(181, FirstBin(document)); },
     std::string("cell 2: must be a list of at most 180 bins") + kAnew},
    {"BinOutside",
     [](json& document) { FirstBin(document)["bin"] = 180; },
     std::string("cell 0, entry 0: 'bin' must be a whole number in 0..179") + kAnew},
    {"BinTwice",
     [](json& document) { document["cells"][0][1]["bin"] = 0; },
     std::string("cell 0, entry 1: bin 0 occurs twice") + kAnew},
    {"FewTransitions",
     [](json& document) {
       FirstBin(document)["transitions"] = {100000, -62};
     },
     std::string("cell 0, entry 0: 'transitions' stand for 63 values, must be 64, as many as pairs "
                 "of classes") +
         kAnew},
    {"EndlessZeros",
     [](json& document) { FirstBin(document)["transitions"] = {-4'000'000'000'000'000'000}; },
     std::string("cell 0, entry 0: 'transitions' stand for more than 64 values, as many as pairs "
                 "of classes") +
         kAnew},
    {"LargeTransition",
     [](json& document) {
       FirstBin(document)["transitions"] = {100001, -63};
     },
     std::string("cell 0, entry 0: 'transitions' must hold whole numbers up to 100000, not 0") +
         kAnew},
    {"ManyTransitions",
     [](json& document) { FirstBin(document)["transitions"] = json(65, 1); },
     std::string("cell 0, entry 0: 'transitions' has 65 entries, must have 1..64") + kAnew},
    {"CertaintyOfNothing",
     [](json& document) { FirstBin(document)["certainty"] = -1; },
     "a bin has a certainty, stamp or place that cannot be"},
    {"NothingLearned",
     [](json& document) { document["cells"] = json(15, json::array()); },
     std::string("is empty: nothing was learned in it") + kAnew},
};

INSTANTIATE_TEST_SUITE_P(Of, BadModelTest, testing::ValuesIn(kBadModels), [](const auto& param) {
  return param.param.name;
});

// A few bytes of text may stand for a thousand frequencies.
TEST(ColourModelFile, ThatUnpacksToTooMuch) {
  const std::string text = FormatColourModel(SomeModel(ModelKind::kVictoria, 8, 2));
  EXPECT_EQ(ParseColourModel(text, "m", 15 * 2 * 64).frames, 91);
  try {
    (void)ParseColourModel(text, "m", 15 * 2 * 64 - 1);
    ADD_FAILURE() << "no error";
  } catch (const InputError& error) {
    EXPECT_EQ(
        error.what(),
        std::string("m: cell 14, entry 1: more frequencies than the maximum of a model") + kAnew);
  }
}

TEST(ColourModelFile, ThatIsNone) {
  const support::TestFolder folder;
  const auto message = [&](const std::string& text) {
    const auto file = folder.Write("m", text);
    return MessageOf(file).substr(file.string().size());
  };
  EXPECT_EQ(message(""), std::string(": is empty") + kAnew);
  EXPECT_EQ(message("\x89PNG"),
            std::string(": is no colour model: no JSON from byte 1 on") + kAnew);
  const std::string text = FormatColourModel(SomeModel(ModelKind::kVictoria, 8, 2));
  EXPECT_EQ(message(text.substr(0, 3000)),
            std::string(": is no colour model: no JSON from byte 3001 on") + kAnew);
  EXPECT_EQ(message("{\"a\": 1e999}"),
            std::string(": is no colour model: has impossible numbers") + kAnew);
  EXPECT_EQ(message(std::string(1'000'000, '[')),
            ": is no colour model; give one of 'ceilmap compass learn'");
  EXPECT_EQ(MessageOf("/none/m"),
            "/none/m: no such file; make a model with 'ceilmap compass learn'");
  EXPECT_EQ(MessageOf(folder.Path()), folder.Path().string() + ": is not a file");
}

// A file with a hole takes no room on the disk, and none in memory: it is not read.
TEST(ColourModelFile, ThatIsTooLarge) {
  const support::TestFolder folder;
  const auto file = folder.Write("m", "{");
  std::filesystem::resize_file(file, kMaxColourModelBytes + 1);
  EXPECT_EQ(MessageOf(file),
            file.string() +
                ": has 67108865 bytes, more than the 67108864 that a colour model may have; give "
                "another file");
}

}  // namespace
}  // namespace ceilmap::colour
