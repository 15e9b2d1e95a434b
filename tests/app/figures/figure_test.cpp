#include "app/figures/figure.hpp"

#include <gtest/gtest.h>

#include <cstdlib>

#include "app/figures/gnuplot.hpp"
#include "app/figures/heading_figures.hpp"
#include "tests/support/test_folder.hpp"

namespace ceilmap::figures {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;
using testing::StartsWith;
using testing::UnorderedElementsAre;

Figure Line() {
  Figure figure;
  figure.name = "line";
  figure.settings = "set title " + GnuplotQuote("it's `date` \"a\\b\"\n") + "\n";
  figure.plot = "  plot 'line.csv' using 1:2 every ::1 with lines ls 1 notitle\n";
  figure.data = {{"line.csv", "x,y\n0,1\n1,3\n2,2\n"}};
  return figure;
}

/// PATH of its own while it lives.
class WithPath {
 public:
  explicit WithPath(const std::string& path) : before_(std::getenv("PATH")) {
    setenv("PATH", path.c_str(), 1);
  }
  ~WithPath() { setenv("PATH", before_.c_str(), 1); }
  WithPath(const WithPath&) = delete;
  WithPath& operator=(const WithPath&) = delete;

 private:
  std::string before_;
};

class FigureTest : public testing::Test {
 protected:
  void SetUp() override {
    if (!FindGnuplot()) GTEST_SKIP() << "gnuplot is not installed";
  }
  support::TestFolder folder_;
};

TEST(Gnuplot, QuotesWhateverStandsInAText) {
  EXPECT_EQ(GnuplotQuote("it's \"so\" `date` \\n\n"), "'it''s \"so\" `date` \\n '");
}

TEST_F(FigureTest, KeepsScriptAndDataBesideTheImages) {
  FigureFolder figures(folder_ / "plots");
  EXPECT_THAT(folder_.Names(), IsEmpty());  // nothing before it is needed
  figures.Draw(Line());
  EXPECT_THAT(support::NamesIn(folder_ / "plots"),
              UnorderedElementsAre("line.csv", "line.gp", "line.svg", "line.png", "line.pdf"));
  EXPECT_EQ(figures.Files().size(), 5U);
  EXPECT_THAT(support::ReadAll(folder_ / "plots/line.svg"), HasSubstr("</svg>"));
  EXPECT_THAT(support::ReadAll(folder_ / "plots/line.svg"), HasSubstr("it's `date`"));
  EXPECT_THAT(support::ReadAll(folder_ / "plots/line.png"), StartsWith("\x89PNG"));
  EXPECT_THAT(support::ReadAll(folder_ / "plots/line.pdf"), StartsWith("%PDF"));
  // Again, over them; and by hand, from the script alone.
  FigureFolder(folder_ / "plots").Draw(Line());
  std::filesystem::remove(folder_ / "plots/line.svg");
  EXPECT_EQ(RunGnuplot(*FindGnuplot(), folder_ / "plots", "line.gp").exit_code, 0);
  EXPECT_TRUE(std::filesystem::exists(folder_ / "plots/line.svg"));
}

TEST_F(FigureTest, ReportsTheErrorOfGnuplot) {
  FigureFolder figures(folder_.Path());
  Figure figure = Line();
  figure.plot = "  plot 'none.csv' using 1:2\n";
  try {
    figures.Draw(figure);
    ADD_FAILURE() << "no error";
  } catch (const RunError& error) {
    EXPECT_THAT(error.what(), HasSubstr("line.gp: gnuplot could not draw it: "));
    EXPECT_THAT(error.what(), HasSubstr("none.csv"));
    EXPECT_THAT(error.what(), testing::Not(HasSubstr("\n")));
  }
  EXPECT_THAT(folder_.Names(), UnorderedElementsAre("line.csv", "line.gp"));
}

TEST_F(FigureTest, RefusesWhatIsNoFolder) {
  folder_.Write("file", "");
  support::ExpectInputError([&] { FigureFolder(folder_ / "file"); }, {"file: is a file"});
  support::ExpectInputError([&] { FigureFolder(folder_ / "none/plots"); }, {"does not exist"});
}

TEST(FigureFolder, NeedsGnuplot) {
  const support::TestFolder folder;
  const WithPath nowhere(folder.Path().string());
  EXPECT_FALSE(FindGnuplot());
  try {
    const FigureFolder figures(folder / "plots");
    ADD_FAILURE() << "no error";
  } catch (const RunError& error) {
    EXPECT_THAT(error.what(), StartsWith("gnuplot, which draws figures, is not installed; "));
  }
  EXPECT_THAT(folder.Names(), IsEmpty());
}

std::vector<files::MeasuredHeading> TurnsLeft() {
  std::vector<files::MeasuredHeading> headings;
  for (int i = 0; i < 5; ++i) {
    const double turn = 1.5 * i;
    headings.push_back({2 * i,
                        10 + 0.1 * i,
                        {.heading_rad = std::remainder(turn, 2 * M_PI),
                         .variance_rad2 = 1e-4 * i,
                         .confidence = 0.5}});
  }
  return headings;
}

TEST_F(FigureTest, HeadingsWithAndWithoutTruth) {
  FigureFolder figures(folder_.Path());
  const std::vector<files::MeasuredHeading> headings = TurnsLeft();
  figures.Draw(HeadingFigure(headings, nullptr));
  const std::string alone = support::ReadAll(folder_ / "heading.csv");
  EXPECT_THAT(alone, HasSubstr("\n0.400000,8,343.77468,1.14592,0.5000,,\n"));  // beyond 180
  evaluation::HeadingErrors errors;
  errors.of = {{.heading = 1, .true_deg = 85, .error_deg = 0.9436693}};
  figures.Draw(HeadingFigure(headings, &errors));
  EXPECT_THAT(support::ReadAll(folder_ / "heading.csv"),
              HasSubstr("\n0.100000,2,85.94367,0.57296,0.5000,85.00000,0.94367\n"));
  EXPECT_THAT(support::ReadAll(folder_ / "heading.svg"), HasSubstr("error (deg)"));
  figures.Draw(HeadingFigure({headings.front()}, nullptr));  // a single one is drawn too
}

TEST_F(FigureTest, DistancesFromHalfATurnRightToHalfATurnLeft) {
  FigureFolder figures(folder_.Path());
  compass::DistanceProfile profile;
  profile.distance = {5, 4, 3, 4, 5, 6, 7, 6};
  profile.shift_columns = 2.1;
  profile.reference_frame = 3;
  figures.Draw(DistanceFigure(9, profile));
  EXPECT_EQ(support::ReadAll(folder_ / "distance-9.csv"),
            "shift_columns,turn_deg,distance\n-4,-180.000000,5\n-3,-135.000000,6\n-2,-90.000000,7\n"
            "-1,-45.000000,6\n0,0.000000,5\n1,45.000000,4\n2,90.000000,3\n3,135.000000,4\n");
  EXPECT_THAT(support::ReadAll(folder_ / "distance-9.svg"), HasSubstr("Frame 9 against frame 3"));
  EXPECT_THAT(support::ReadAll(folder_ / "distance-9.svg"), HasSubstr("94.50 deg"));
}

}  // namespace
}  // namespace ceilmap::figures
