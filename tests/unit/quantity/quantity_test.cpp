// SPDX-License-Identifier: GPL-3.0-or-later
//
// How names become quantities of a run: which are found, what they are made from, and what is said of others.
#include "protocol/quantity/quantity.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "protocol/quantity/plot_axes.h"
#include "protocol/quantity/statistic.h"

namespace mote {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

RunColumns beam() {
    return {{{"x", "m"},
             {"y", "m"},
             {"z", "m"},
             {"px", "eV/c"},
             {"py", "eV/c"},
             {"pz", "eV/c"},
             {"spin/x", "hbar"}},
            0.511e6,
            false,
            "run",
            ""};
}

std::string errorOf(const std::string& name, const RunColumns& run) {
    const auto made = Quantity::make(name, run);
    return made.ok() ? std::string("made") : made.error().message;
}

TEST(Quantity, IsAColumnAKnownOneOrAnExpression) {
    const auto run = beam();
    EXPECT_TRUE(Quantity::make("spin/x", run)->isColumn());
    EXPECT_EQ(Quantity::make("spin/x", run)->unit(), "hbar");
    EXPECT_THAT(Quantity::make("energy", run)->columns(), ElementsAre(3, 4, 5));
    EXPECT_FALSE(Quantity::make("energy", run)->needsMeans());
    EXPECT_TRUE(Quantity::make("zeta", run)->needsMeans());
    const auto both = Quantity::make("zeta + 'spin/x' * delta", run);
    EXPECT_THAT(both->columns(), ElementsAre(2, 6, 3, 4, 5));
    EXPECT_TRUE(both->needsMeans());
    EXPECT_EQ(both->unit(), "");
}

TEST(Quantity, MakesWhatItNames) {
    const auto run = beam();
    const std::vector<double> z{10.0, 12.0}, px{3.0, 0.0}, py{4.0, 0.0}, pz{12.0, 0.0};
    BeamContext context{13.0, 6.5, {0, 0, 11.0, 0, 0, 0, 0}};
    const auto made = Quantity::make("hypot(zeta, 0) + energy/13 + 0*delta", run);
    ASSERT_TRUE(made.ok()) << made.error().message;
    std::vector<double> out(2);
    Quantity::Scratch scratch;
    const std::vector<std::span<const double>> columns{z, px, py, pz};
    made->evaluate(columns, context, scratch, out);
    EXPECT_DOUBLE_EQ(out[0], std::sqrt(2.0));
    EXPECT_DOUBLE_EQ(out[1], 1.0);
}

TEST(Quantity, SaysWhatIsMissing) {
    auto run = beam();
    EXPECT_EQ(errorOf("tau", run),
              "needs t, which the run does not have; it has x, y, z, px, py, pz, spin/x");
    EXPECT_THAT(errorOf("enrgy", run),
                HasSubstr("is neither a column of the run nor derived from one; near it: energy"));
    EXPECT_THAT(errorOf("2*enrgy", run), HasSubstr("at 3: \"enrgy\" is neither"));
    EXPECT_THAT(errorOf("xx", run), HasSubstr("near it: x, px, xp; it has"));  // x is a column and known
    EXPECT_THAT(errorOf("x + t", run), HasSubstr("at 5: \"t\" needs t"));
    run.mass = 0.0;
    EXPECT_THAT(errorOf("gamma", run), HasSubstr("needs the particles' mass"));
    EXPECT_EQ(errorOf("delta", run), "made");
    run.photons = true;
    EXPECT_EQ(errorOf("energy", run), "made");
    EXPECT_THAT(errorOf("gamma", run), HasSubstr("needs the particles' mass"));
    EXPECT_FALSE(Quantity::checkForm("hypot(x").ok());
    EXPECT_TRUE(Quantity::checkForm("anything").ok());
}

TEST(PlotAxes, AStepHasItsOwnWhereItsDatasetSaysSo) {
    proto::ParticlesManifest plot;
    const auto add = [](auto& axes, double max) {
        for (int axis = 0; axis < axesOfPlot; ++axis) axes.Add()->set_max(max + axis);
    };
    add(*plot.mutable_axes(), 10.0);
    plot.add_steps();
    plot.add_steps();
    EXPECT_EQ(axisOf(plot, 2, 1).max(), 12.0);
    auto before = plot;  // behind the plot's, as datasets once had them
    for (const double max : {20.0, 30.0}) add(*before.mutable_axes(), max);
    EXPECT_EQ(axisOf(before, 2, 1).max(), 32.0);
    EXPECT_EQ(axisOf(before, 2, 7).max(), 12.0);
    add(*plot.mutable_steps(1)->mutable_axes(), 30.0);
    EXPECT_EQ(axisOf(plot, 2, 0).max(), 12.0);
    EXPECT_EQ(axisOf(plot, 2, 1).max(), 32.0);
}

/// A row for each family.
std::string tableOfStatistics() {
    std::string rows = "| name | unit | definition |\n| --- | --- | --- |\n";
    std::vector<std::string_view> told;
    for (const auto& statistic : statistics()) {
        if (std::ranges::count(told, statistic.family) > 0) continue;
        told.push_back(statistic.family);
        const bool one = std::ranges::all_of(statistics(), [&](const Statistic& other) {
            return other.family != statistic.family || other.unit == statistic.unit;
        });
        const auto unit = one ? statistic.unit : statistic.of.size() == 1 ? "Q's" : "A's times B's";
        rows += fmt::format("| `{}` | {} | {} |\n", statistic.family, unit, statistic.definition);
    }
    return rows;
}

TEST(Statistic, TheTableOfTheDocsIsThisOne) {
    constexpr std::string_view begin =
        "<!-- made by MOTE_WRITE_DOCS=1 test-quantity from protocol/quantity/statistic.cpp -->\n";
    const auto file = std::filesystem::path(MOTE_TEST_DATA).parent_path().parent_path() / "docs/NUMBERS.md";
    std::ifstream in(file);
    std::string text((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
    const auto from = text.find(begin), to = text.find("<!-- end of what is made -->");
    ASSERT_TRUE(from != text.npos && to != text.npos && from < to);
    const auto start = from + begin.size();
    if (std::getenv("MOTE_WRITE_DOCS") != nullptr) {
        text.replace(start, to - start, tableOfStatistics());
        std::ofstream(file) << text;
    } else {
        EXPECT_EQ(text.substr(start, to - start), tableOfStatistics());
    }
}

TEST(Statistic, OfAnyQuantity) {
    EXPECT_EQ(findStatistic("cov_px__x"), findStatistic("cov_x__px"));
    const auto mean = parseQuantityStatistic("mean_hypot(x,y)");
    ASSERT_TRUE(mean);
    EXPECT_EQ(mean->kind, "mean");
    EXPECT_THAT(mean->quantities, ElementsAre("hypot(x,y)"));
    EXPECT_THAT(parseQuantityStatistic("cov_spin_x__zeta")->quantities, ElementsAre("spin_x", "zeta"));
    for (const char* none : {"norm_emit_x", "mean_", "cov_x", "cov___x", "charge", "meanx"})
        EXPECT_FALSE(parseQuantityStatistic(none)) << none;
}

}  // namespace
}  // namespace mote
