// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/stats/options.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace mote::client {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

std::variant<StatsOptions, int> parse(std::vector<const char*> words) {
    words.insert(words.begin(), "mote-stats");
    return parseStatsOptions(static_cast<int>(words.size()), words.data());
}

StatsOptions parsed(const std::vector<const char*>& words) {
    const auto result = parse(words);
    EXPECT_TRUE(std::holds_alternative<StatsOptions>(result));
    return std::holds_alternative<StatsOptions>(result) ? std::get<StatsOptions>(result) : StatsOptions();
}

/// Wrong usage that is told with these words.
void expectRefused(std::vector<const char*> words, const std::string& why) {
    words.insert(words.begin(), {"data/beam", "--connect", "c.json"});
    testing::internal::CaptureStderr();
    const auto result = parse(words);
    const auto said = testing::internal::GetCapturedStderr();
    ASSERT_TRUE(std::holds_alternative<int>(result)) << why;
    EXPECT_EQ(std::get<int>(result), 2) << said;
    EXPECT_THAT(said, HasSubstr(why));
}

TEST(StatsOptions, OfAllForms) {
    const auto options =
        parsed({"data/beam", "--spawn", "data=plots", "--spawn", "more=there", "--steps", "0:6:2",
                "--columns", "x,px", "--csv", "out.csv", "--export", "halo.h5", "--quiet"});
    EXPECT_EQ(options.dataset, "data/beam");
    EXPECT_THAT(options.roots, ElementsAre("data=plots", "more=there"));
    EXPECT_FALSE(options.connect);
    EXPECT_THAT(options.columns, ElementsAre("x", "px"));
    EXPECT_EQ(options.form, NumbersForm::csv);
    EXPECT_EQ(options.file, "out.csv");
    EXPECT_TRUE(options.wantsNumbers());
    EXPECT_FALSE(parsed({"data/beam", "--connect", "c.json", "--export", "halo.npy"}).wantsNumbers());
    EXPECT_TRUE(parsed({"data/beam", "--connect", "c.json"}).wantsNumbers());
}

TEST(StatsOptions, AHistogramSaysItsBinsAndRanges) {
    const auto options = parsed({"--connect", "c.json", "--histogram", "x,px", "--bins", "512,64", "--range",
                                 "x=-1e-3:2e-3", "px=-5:5", "--unweighted", "data/beam"});
    ASSERT_TRUE(options.histogram);
    const auto& query = *options.histogram;
    ASSERT_EQ(query.axes_size(), 2);
    EXPECT_EQ(query.axes(0).column(), "x");
    EXPECT_EQ(query.axes(0).bins(), 512U);
    EXPECT_THAT(query.axes(0).range(), ElementsAre(-1e-3, 2e-3));
    EXPECT_EQ(query.axes(1).bins(), 64U);
    EXPECT_THAT(query.axes(1).range(), ElementsAre(-5, 5));
    EXPECT_TRUE(query.unweighted());
    const auto one = parsed({"data/beam", "--connect", "c.json", "--histogram", "x,y", "--bins", "7",
                             "--range", "y=0:1", "--range", "x=0:2", "--json"});
    EXPECT_EQ(one.histogram->axes(1).bins(), 7U);
    EXPECT_THAT(one.histogram->axes(0).range(), ElementsAre(0, 2));
    EXPECT_FALSE(
        parsed({"data/beam", "--connect", "c.json", "--histogram", "x"}).histogram->axes(0).has_bins());
}

TEST(StatsOptions, WrongUsageIsOneSentence) {
    expectRefused({"--steps", "3:1"}, "--steps: the last step lies before the first");
    expectRefused({"--columns", "x,,y"}, "--columns: the name of a column is missing");
    expectRefused({"--columns", "x,x"}, "\"x\" is given twice");
    expectRefused({"--bins", "7"}, "--histogram: is missing");
    expectRefused({"--histogram", "x,y,z"}, "one column or two");
    expectRefused({"--histogram", "x", "--bins", "1,2"}, "2 numbers for 1 columns");
    for (const char* bins : {"0", "4097", "-1", "ten", "1.5", "", "5,"})
        if (*bins != '\0') expectRefused({"--histogram", "x,y", "--bins", bins}, "--bins");
    for (const char* range : {"x", "x=1", "x=1:", "x=a:b", "=1:2"})
        expectRefused({"--histogram", "x", "--range", range}, "--range");
    expectRefused({"--histogram", "x", "--range", "x=1:1"}, "ascend");
    expectRefused({"--histogram", "x", "--range", "x=nan:1"}, "--range");
    expectRefused({"--histogram", "x", "--range", "x=0:inf"}, "finite");
    expectRefused({"--histogram", "x", "--range", "y=0:1"}, "none of the histogram's columns");
    expectRefused({"--histogram", "x", "--range", "x=0:1", "--range", "x=0:2"}, "twice");
    expectRefused({"--histogram", "x", "--columns", "x"}, "--columns");
    expectRefused({"--json", "--csv", "a.csv"}, "one of --json, --csv and --npy");
    expectRefused({"--export", "a.txt"}, ".h5, .npy or .csv");
    expectRefused({"--select", R"({"density": {"max": 0.4}})"}, "--select: is the name of a file");
    expectRefused({"--csv", "a.csv", "--export", "a.csv"}, "--export");
    expectRefused({"--spawn", "data=x"}, "--spawn");
    expectRefused({"more"}, "more");
    testing::internal::CaptureStderr();
    const auto nothing = parse({"--connect", "c.json", "--histogram", "x", "--range", "x=0:1"});
    EXPECT_THAT(testing::internal::GetCapturedStderr(), HasSubstr("DATASET: is required"));
    EXPECT_TRUE(std::holds_alternative<int>(nothing));
}

}  // namespace
}  // namespace mote::client
