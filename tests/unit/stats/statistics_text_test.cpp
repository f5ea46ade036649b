// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/stats/statistics_text.h"

#include <gmock/gmock.h>
#include <google/protobuf/struct.pb.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <sstream>

#include "client/shared/number_text.h"
#include "protocol/quantity/statistic.h"
#include "protocol/scene/json.h"
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

}  // namespace
}  // namespace mote::client
