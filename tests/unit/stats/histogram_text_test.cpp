// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/stats/histogram_text.h"

#include <gmock/gmock.h>
#include <google/protobuf/struct.pb.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numeric>
#include <sstream>

#include "protocol/scene/json.h"
#include "tests/support/random.h"

namespace mote::client {
namespace {

using test::Random;
using testing::HasSubstr;

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
