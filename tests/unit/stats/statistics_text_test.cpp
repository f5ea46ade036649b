// SPDX-License-Identifier: GPL-3.0-or-later
#include <gmock/gmock.h>
#include <google/protobuf/struct.pb.h>
#include <gtest/gtest.h>
#include <cmath>
#include <limits>
#include <numeric>
#include <sstream>

#include "client/shared/numbers.h"
#include "client/stats/statistics_text.h"
#include "protocol/base/json.h"
#include "protocol/quantity/statistic.h"
#include "tests/support/random.h"

namespace mote::client {
namespace {

using test::Random;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

const std::vector<std::string> names{
    "n_particle",   "charge",   "mean_x",        "sigma_px",   "cov_x__px",   "norm_emit_x",   "norm_emit_y",
    "norm_emit_4d", "halo_H_x", "twiss_gamma_y", "mean_gamma", "mean_energy", "cov_my_own__x", "twiss_eta_x"};

StatisticsOfSteps anySteps(Random& random, std::size_t count) {
    StatisticsOfSteps steps;
    for (std::size_t i = 0; i < count; ++i) {
        StepStatistics step{static_cast<std::uint32_t>(2 * i),
                            static_cast<std::int64_t>(100 * i),
                            1e-9 * static_cast<double>(i),
                            names,
                            {},
                            {},
                            {}};
        for (std::size_t j = 0; j < names.size(); ++j)
            step.values.push_back(random.chance(0.2) ? std::numeric_limits<double>::quiet_NaN()
                                                     : random.sign() * random.magnitude(-40, 40));
        steps.push_back(std::move(step));
    }
    return steps;
}

ColumnUnits someUnits() {
    proto::ParticlesManifest manifest;
    auto& column = *manifest.add_columns();
    column.set_name("my_own");
    column.set_unit("A");
    return columnUnits(manifest);
}

TEST(StatisticName, SaysColumnsAndUnit) {
    const auto units = someUnits();
    EXPECT_THAT(columnsOf("n_particle"), IsEmpty());
    EXPECT_THAT(columnsOf("charge"), IsEmpty());
    EXPECT_THAT(columnsOf("mean_my_own"), ElementsAre("my_own"));
    EXPECT_THAT(columnsOf("cov_my_own__x"), ElementsAre("my_own", "x"));
    EXPECT_THAT(columnsOf("emit90_action_x"), ElementsAre("x"));
    EXPECT_THAT(columnsOf("twiss_gamma_y"), ElementsAre("y"));
    EXPECT_THAT(columnsOf("norm_emit_4d"), ElementsAre("x", "y"));
    EXPECT_THAT(columnsOf("mean_gamma"), ElementsAre("gamma"));
    EXPECT_EQ(unitOf("mean_my_own", units), "A");
    EXPECT_EQ(unitOf("cov_x__px", units), "m eV/c");
    EXPECT_EQ(unitOf("cov_x__x", units), "m^2");
    EXPECT_EQ(unitOf("cov_x__xp", units), "m rad");
    EXPECT_EQ(unitOf("norm_emit_x", units), "m");
    EXPECT_EQ(unitOf("norm_emit_4d", units), "m^2");
    EXPECT_EQ(unitOf("twiss_gamma_y", units), "1/m");
    EXPECT_EQ(unitOf("twiss_eta_x", units), "m");
    EXPECT_EQ(unitOf("twiss_etap_x", units), "1");
    EXPECT_EQ(unitOf("charge", units), "C");
    EXPECT_EQ(unitOf("mean_energy", units), "eV");
    EXPECT_EQ(unitOf("mean_hypot(x,y)", units), "m");
    EXPECT_EQ(unitOf("sigma_energy*1e-9", units), "");
    EXPECT_EQ(unitOf("sigma_zeta", units), "m");
    EXPECT_EQ(unitOf("something", units), "");
}

TEST(StatisticsText, ColumnsChooseStatistics) {
    const auto units = someUnits();
    const auto chosen = [&](const std::vector<std::string>& columns) {
        std::vector<std::string> kept;
        for (const auto place : namesOfColumns(names, columns)) kept.push_back(names[place]);
        return kept;
    };
    EXPECT_THAT(chosen({"x"}),
                ElementsAre("n_particle", "charge", "mean_x", "norm_emit_x", "halo_H_x", "twiss_eta_x"));
    EXPECT_THAT(chosen({"px", "x"}), ElementsAre("n_particle", "charge", "mean_x", "sigma_px", "cov_x__px",
                                                 "norm_emit_x", "halo_H_x", "twiss_eta_x"));
    EXPECT_THAT(chosen({"x", "y"}), testing::Contains("norm_emit_4d"));
    EXPECT_THAT(furtherNames(names, {"x", "zeta"}),
                ElementsAre("mean_zeta", "sigma_zeta", "min_zeta", "max_zeta"));
}

TEST(StatisticsText, JsonHasEveryNumberOrNull) {
    Random random(1);
    for (const auto& step : anySteps(random, 50)) {
        google::protobuf::Struct read;
        const auto line = jsonLine(step);
        ASSERT_TRUE(parseJson(line, read, "line").ok()) << line;
        EXPECT_EQ(std::count(line.begin(), line.end(), '\n'), 1);
        EXPECT_EQ(read.fields().size(), names.size() + 3);
        EXPECT_EQ(read.fields().at("iteration").number_value(), static_cast<double>(step.iteration));
        for (std::size_t i = 0; i < names.size(); ++i) {
            const auto& value = read.fields().at(names[i]);
            EXPECT_EQ(value.has_null_value(), std::isnan(step.values[i]));
            if (value.has_number_value()) {
                EXPECT_EQ(value.number_value(), step.values[i]);
            }
        }
    }
}

TEST(StatisticsText, CsvHasALineForEachStep) {
    Random random(2);
    const auto steps = anySteps(random, 20);
    std::istringstream lines(csvText(steps, columnUnits({})));
    std::string line;
    std::getline(lines, line);
    EXPECT_TRUE(line.starts_with("step,iteration,time [s],n_particle,charge [C],")) << line;
    for (const auto& step : steps) {
        ASSERT_TRUE(std::getline(lines, line));
        std::istringstream parts(line + ",");
        std::vector<std::string> fields;
        for (std::string part; std::getline(parts, part, ',');) fields.push_back(part);
        ASSERT_EQ(fields.size(), names.size() + 3);
        for (std::size_t i = 0; i < names.size(); ++i) {
            EXPECT_EQ(fields[i + 3].empty(), std::isnan(step.values[i]));
            if (!fields[i + 3].empty()) {
                EXPECT_EQ(std::stod(fields[i + 3]), step.values[i]);
            }
        }
    }
    EXPECT_FALSE(std::getline(lines, line));
}

TEST(StatisticsText, ATableOfOneStepHasAllNumbersBelowEachOther) {
    StepStatistics step{3,  159, 1.25e-9, {"n_particle", "charge", "mean_x", "cov_x__px", "halo_H_x"},
                        {}, {},  {}};
    step.values = {100000, 1.6021e-9, -12.345e-6, 1e-5, std::numeric_limits<double>::quiet_NaN()};
    EXPECT_EQ(tableText({step}, columnUnits({})),
              "step 3, iteration 159, time 1.2500 ns\n"
              "  n_particle  100000\n"
              "  charge           1.6021 nC\n"
              "  mean_x         -12.345  \u00b5m\n"
              "  cov_x__px        1.0000e-05 m eV/c\n"
              "  halo_H_x         -\n");
}

TEST(StatisticsText, ATableOfStepsHasOneUnitAColumn) {
    Random random(3);
    const auto steps = anySteps(random, 7);
    std::istringstream lines(tableText(steps, someUnits()));
    std::vector<std::size_t> lengths;
    for (std::string line; std::getline(lines, line);) lengths.push_back(widthOf(line));
    ASSERT_EQ(lengths.size(), steps.size() + 2);
    for (const auto length : lengths) EXPECT_EQ(length, lengths.front());
}

StepHistogram anyHistogram(Random& random, std::size_t columns, std::size_t mostBins) {
    StepHistogram histogram;
    histogram.step = static_cast<std::uint32_t>(random.below(100));
    std::size_t all = 1;
    for (std::size_t i = 0; i < columns; ++i) {
        const auto bins = 1 + random.below(mostBins);
        histogram.columns.push_back(i == 0 ? "x" : "px");
        auto& edges = histogram.edges.emplace_back();
        double edge = -random.unit();
        for (std::uint64_t j = 0; j <= bins; ++j) edges.push_back(edge += 1e-3);
        all *= bins;
    }
    for (std::size_t i = 0; i < all; ++i)
        histogram.counts.push_back(random.chance(0.3) ? 0.0 : random.unit());
    histogram.particles = random.below(1000);
    return histogram;
}

TEST(HistogramText, JsonIsReadAgain) {
    Random random(1);
    for (int i = 0; i < 100; ++i) {
        const auto histogram = anyHistogram(random, 1 + random.below(2), 12);
        google::protobuf::Struct read;
        ASSERT_TRUE(parseJson(jsonLine(histogram), read, "line").ok());
        const auto& fields = read.fields();
        EXPECT_EQ(fields.at("step").number_value(), histogram.step);
        EXPECT_EQ(fields.at("particles").number_value(), histogram.particles);
        const auto& edges = fields.at("edges").list_value();
        ASSERT_EQ(edges.values_size(), static_cast<int>(histogram.edges.size()));
        for (int column = 0; column < edges.values_size(); ++column) {
            std::vector<double> values;
            for (const auto& value : edges.values(column).list_value().values())
                values.push_back(value.number_value());
            EXPECT_EQ(values, histogram.edges[static_cast<std::size_t>(column)]);
        }
        std::vector<double> counts;
        for (const auto& row : fields.at("counts").list_value().values()) {
            if (histogram.edges.size() == 1) counts.push_back(row.number_value());
            if (histogram.edges.size() == 2) {
                EXPECT_EQ(row.list_value().values_size(), static_cast<int>(histogram.bins(1)));
            }
            for (const auto& value : row.list_value().values()) counts.push_back(value.number_value());
        }
        EXPECT_EQ(counts, histogram.counts);
    }
}

TEST(HistogramText, CsvHasALineForEachBin) {
    Random random(2);
    for (int i = 0; i < 100; ++i) {
        const auto histogram = anyHistogram(random, 1 + random.below(2), 8);
        const auto columns = histogram.edges.size();
        EXPECT_EQ(csvHead(histogram.columns, columnUnits({})),
                  columns == 1 ? "step,x_from [m],x_to [m],count\n"
                               : "step,x_from [m],x_to [m],px_from [eV/c],px_to [eV/c],count\n");
        std::istringstream lines(csvText(histogram));
        std::string line;
        std::size_t index = 0;
        while (std::getline(lines, line)) {
            std::vector<double> fields;
            std::istringstream parts(line);
            for (std::string part; std::getline(parts, part, ',');) fields.push_back(std::stod(part));
            ASSERT_EQ(fields.size(), 2 + 2 * columns);
            const auto high = columns == 2 ? histogram.bins(1) : 1;
            EXPECT_EQ(fields[0], histogram.step);
            EXPECT_EQ(fields[1], histogram.edges[0][index / high]);
            EXPECT_EQ(fields[2], histogram.edges[0][index / high + 1]);
            if (columns == 2) {
                EXPECT_EQ(fields[4], histogram.edges[1][index % high + 1]);
            }
            EXPECT_EQ(fields.back(), histogram.counts[index++]);
        }
        EXPECT_EQ(index, histogram.counts.size());
    }
}

TEST(HistogramText, LinesOfAPictureAddUpToAllCounts) {
    Random random(3);
    for (int i = 0; i < 100; ++i) {
        auto histogram = anyHistogram(random, 1, 300);
        for (auto& count : histogram.counts) count = std::floor(10.0 * count);
        std::istringstream lines(pictureText(histogram, {{"x", "m"}}));
        std::string line;
        std::getline(lines, line);
        std::getline(lines, line);
        double sum = 0.0;
        std::size_t shown = 0;
        while (std::getline(lines, line)) {
            std::istringstream parts(line);
            double edge = 0.0, count = 0.0;
            parts >> edge;
            if (!(parts >> count)) continue;  // the last edge
            sum += count;
            EXPECT_EQ(count > 0.0, line.find('#') != std::string::npos) << line;
            ++shown;
        }
        EXPECT_EQ(sum, std::accumulate(histogram.counts.begin(), histogram.counts.end(), 0.0));
        EXPECT_LE(shown, 40U);
        EXPECT_GT(2 * shown, std::min<std::size_t>(histogram.bins(0), 40));
    }
}

TEST(HistogramText, AFieldHasItsFirstColumnAlongAndItsSecondUp) {
    StepHistogram histogram;
    histogram.columns = {"x", "px"};
    histogram.edges = {{0.0, 1e-3, 2e-3, 3e-3}, {-1e3, 0.0, 1e3}};
    histogram.counts = {0.0, 4.0, 0.0, 0.0, 1e-9, 0.0};
    EXPECT_THAT(pictureText(histogram, {{"x", "m"}, {"px", "eV/c"}}),
                HasSubstr("along x from 0 to 3 mm, up px from -1 to 1 keV/c\n+---+\n|@  |\n|  .|\n+---+\n"));
}

TEST(HistogramText, NothingAtAllIsShownToo) {
    StepHistogram histogram;
    histogram.columns = {"x"};
    histogram.edges = {{0.0, 1.0}};
    histogram.counts = {0.0};
    histogram.outside = 2.5;
    EXPECT_THAT(pictureText(histogram, {}), HasSubstr("0 particles, a weight of 2.5 outside"));
}

}  // namespace
}  // namespace mote::client
