// SPDX-License-Identifier: GPL-3.0-or-later
//
// Answers of a server that tells the truth become values; of one that does not, errors.
#include <gtest/gtest.h>
#include <bit>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <limits>

#include "client/shared/numbers.h"
#include "protocol/base/json.h"
#include "protocol/base/json_string.h"
#include "protocol/base/utf8.h"
#include "protocol/mote.pb.h"
#include "tests/support/random.h"

namespace mote::client {
namespace {

using test::Random;

std::vector<std::uint8_t> payloadOf(const std::vector<double>& values) {
    std::vector<std::uint8_t> bytes(values.size() * sizeof(double));
    if (!bytes.empty()) std::memcpy(bytes.data(), values.data(), bytes.size());
    return bytes;
}

std::vector<double> anyNumbers(Random& random, std::size_t count) {
    std::vector<double> numbers(count);
    for (auto& number : numbers) number = random.sign() * random.magnitude(-30, 30);
    return numbers;
}

// -------------------------------------------------------------------------------------- statistics

QueryAnswer statisticsAnswer(Random& random) {
    QueryAnswer answer;
    auto& message = answer.message;
    message.set_step(static_cast<std::uint32_t>(random.below(100)));
    message.set_iteration(-5);
    message.set_time(0.25);
    auto& statistics = *message.mutable_statistics();
    const auto names = 1 + random.below(5), slices = random.below(4);
    for (std::uint64_t i = 0; i < names; ++i) {
        statistics.add_names("number_" + std::to_string(i));
        statistics.add_values(random.chance(0.2) ? std::numeric_limits<double>::quiet_NaN() : random.unit());
    }
    for (std::uint64_t i = 0; i < slices; ++i) {
        if (i == 0) statistics.add_slice_edges(0.0);
        statistics.add_slice_edges(static_cast<double>(i + 1));
        auto& slice = *statistics.add_slices();
        for (const double value : anyNumbers(random, names)) slice.add_values(value);
    }
    return answer;
}

TEST(Numbers, StatisticsAreTakenAsTheyAre) {
    Random random(1);
    for (int i = 0; i < 200; ++i) {
        const auto answer = statisticsAnswer(random);
        const auto taken = statisticsOf(answer);
        ASSERT_TRUE(taken.ok()) << taken.error().toString();
        EXPECT_EQ(taken->step, answer.message.step());
        EXPECT_EQ(taken->iteration, -5);
        ASSERT_EQ(taken->names.size(), taken->values.size());
        for (std::size_t j = 0; j < taken->names.size(); ++j)
            EXPECT_EQ(taken->names[j], "number_" + std::to_string(j));
        EXPECT_EQ(taken->slices.size(), static_cast<std::size_t>(answer.message.statistics().slices_size()));
    }
}

TEST(Numbers, StatisticsThatDoNotBelongTogetherAreRefused) {
    Random random(2);
    for (int i = 0; i < 200; ++i) {
        auto answer = statisticsAnswer(random);
        auto& statistics = *answer.message.mutable_statistics();
        switch (random.below(4)) {
            case 0:
                statistics.add_values(1.0);
                break;
            case 1:
                statistics.add_names("more");
                break;
            case 2:
                statistics.add_slice_edges(1.0);
                if (statistics.slice_edges_size() == 1) statistics.add_slices();
                break;
            default:
                answer.message.mutable_histogram();
                answer.message.clear_statistics();
        }
        const auto taken = statisticsOf(answer);
        ASSERT_FALSE(taken.ok());
        EXPECT_EQ(taken.error().code, ErrorCode::corrupt);
    }
}

TEST(Numbers, WholeStepsAreInTheManifestOrItIsSaidHowTheyGetThere) {
    proto::ParticlesManifest manifest;
    for (int i = 0; i < 3; ++i) manifest.add_steps()->set_iteration(10 * i);
    const auto without = statisticsOf(manifest, {0, 1});
    ASSERT_FALSE(without.ok());
    EXPECT_EQ(without.error().code, ErrorCode::notFound);
    EXPECT_NE(without.error().message.find("mote-prep"), std::string::npos);
    manifest.add_statistic_names("n_particle");
    for (int i = 0; i < 3; ++i) manifest.mutable_steps(i)->add_statistics(i);
    const auto steps = statisticsOf(manifest, {0, 2});
    ASSERT_TRUE(steps.ok());
    ASSERT_EQ(steps->size(), 2U);
    EXPECT_EQ((*steps)[1].step, 2U);
    EXPECT_EQ((*steps)[1].iteration, 20);
    EXPECT_EQ((*steps)[1].values.front(), 2.0);
    manifest.mutable_steps(2)->add_statistics(9.0);
    EXPECT_EQ(statisticsOf(manifest, {2}).error().code, ErrorCode::corrupt);
}

// -------------------------------------------------------------------------------------- histograms

struct AskedHistogram {
    proto::HistogramQuery query;
    QueryAnswer answer;
};

AskedHistogram histogramAnswer(Random& random) {
    AskedHistogram asked;
    std::size_t bins = 1;
    const auto axes = 1 + random.below(2);
    for (std::uint64_t i = 0; i < axes; ++i) {
        auto& axis = *asked.query.add_axes();
        axis.set_column(i == 0 ? "x" : "px");
        const auto count = 1 + random.below(9);
        axis.set_bins(static_cast<std::uint32_t>(count));
        auto& edges = *asked.answer.message.mutable_histogram()->add_axes();
        double edge = -random.unit();
        for (std::uint64_t j = 0; j <= count; ++j) edges.add_values(edge += 0.01 + random.unit());
        bins *= count;
    }
    asked.answer.message.mutable_histogram()->set_particles(7);
    asked.answer.payload = payloadOf(anyNumbers(random, bins));
    return asked;
}

TEST(Numbers, HistogramsAreTakenAsTheyAre) {
    Random random(3);
    for (int i = 0; i < 200; ++i) {
        const auto asked = histogramAnswer(random);
        const auto taken = histogramOf(asked.answer, asked.query);
        ASSERT_TRUE(taken.ok()) << taken.error().toString();
        EXPECT_EQ(taken->columns.size(), static_cast<std::size_t>(asked.query.axes_size()));
        EXPECT_EQ(payloadOf(taken->counts), asked.answer.payload);
        EXPECT_EQ(taken->particles, 7U);
    }
}

TEST(Numbers, HistogramsOfAnythingElseAreRefused) {
    Random random(4);
    for (int i = 0; i < 300; ++i) {
        auto asked = histogramAnswer(random);
        auto& histogram = *asked.answer.message.mutable_histogram();
        auto& edges = *histogram.mutable_axes(0);
        switch (i % 7) {
            case 0:
                asked.answer.payload.pop_back();
                break;
            case 1:
                asked.answer.payload.resize(asked.answer.payload.size() + 8);
                break;
            case 2:
                edges.set_values(0, std::numeric_limits<double>::quiet_NaN());
                break;
            case 3:
                edges.set_values(1, edges.values(0));
                break;
            case 4:
                edges.add_values(1e9);
                break;
            case 5:
                histogram.add_axes();
                break;
            default:
                asked.query.mutable_axes(0)->set_bins(1U << 31);
        }
        const auto taken = histogramOf(asked.answer, asked.query);
        ASSERT_FALSE(taken.ok()) << i % 7;
        EXPECT_EQ(taken.error().code, ErrorCode::corrupt);
    }
}

// ----------------------------------------------------------------------------------------- columns

TEST(Numbers, ColumnsStandOneAfterTheOther) {
    Random random(5);
    for (int i = 0; i < 200; ++i) {
        proto::ColumnsQuery query;
        const auto names = 1 + random.below(4), rows = random.below(6);
        for (std::uint64_t j = 0; j < names; ++j) query.add_names("column" + std::to_string(j));
        QueryAnswer answer;
        auto& columns = *answer.message.mutable_columns();
        *columns.mutable_names() = query.names();
        columns.set_count(rows);
        columns.set_next(1);
        const auto values = anyNumbers(random, names * rows);
        answer.payload = payloadOf(values);
        const auto taken = columnsOf(answer, query);
        ASSERT_TRUE(taken.ok()) << taken.error().toString();
        ASSERT_EQ(taken->words.size(), names);
        for (std::uint64_t j = 0; j < names; ++j) {
            ASSERT_EQ(taken->words[j].size(), rows);
            for (std::uint64_t row = 0; row < rows; ++row)
                EXPECT_EQ(std::bit_cast<double>(taken->words[j][row]), values[j * rows + row]);
        }
        auto wrong = answer;
        switch (i % 5) {
            case 0:
                wrong.message.mutable_columns()->set_count(rows + 1);
                break;
            case 1:
                // As many bytes as wrap around to none.
                wrong.message.mutable_columns()->set_count(std::uint64_t{1} << 61);
                break;
            case 2:
                wrong.message.mutable_columns()->set_next(0);
                break;
            case 3:
                wrong.message.mutable_columns()->set_names(0, "other");
                break;
            default:
                wrong.payload.push_back(0);
        }
        const auto refused = columnsOf(wrong, query);
        ASSERT_FALSE(refused.ok()) << i % 5;
        EXPECT_EQ(refused.error().code, ErrorCode::corrupt);
    }
}

TEST(NumberText, ExactNumbersAreReadAgain) {
    Random random(1);
    for (int i = 0; i < 20000; ++i) {
        const auto value = std::bit_cast<double>(random.next());
        const auto text = exactNumber(value, "null");
        if (std::isfinite(value))
            EXPECT_EQ(std::bit_cast<std::uint64_t>(std::strtod(text.c_str(), nullptr)),
                      std::bit_cast<std::uint64_t>(value))
                << text;
        else
            EXPECT_EQ(text, "null");
    }
    EXPECT_EQ(exactNumber(1e6, ""), "1000000");
    EXPECT_EQ(exactNumber(0.1, ""), "0.1");
}

/// A text of letters, quotes, control characters and bytes that are no letters.
std::string anyText(Random& random) {
    std::string text;
    for (auto left = random.below(20); left > 0; --left) {
        const auto letter = random.below(8);
        if (letter < 4) text += static_cast<char>(random.below(256));
        if (letter == 4) text += "\"\\/,\n";
        if (letter == 5) text += "\u00b5\u0085";
        if (letter > 5) text += static_cast<char>('a' + random.below(26));
    }
    return text;
}

TEST(NumberText, JsonStringsAreReadAgainAndHoldNothingThatATerminalObeys) {
    Random random(2);
    for (int i = 0; i < 2000; ++i) {
        const auto text = anyText(random);
        const auto json = jsonString(text);
        proto::JobRequest read;
        ASSERT_TRUE(parseJson("{\"title\": " + json + "}", read, "test").ok()) << json;
        EXPECT_EQ(read.title(), toUtf8(text));
        EXPECT_EQ(json, toTerminalText(json));
    }
}

/// The first field of a line, as RFC 4180 has it.
std::string readCsvField(const std::string& line) {
    if (!line.starts_with('"')) return line.substr(0, line.find(','));
    std::string field;
    for (std::size_t i = 1; i < line.size(); ++i) {
        if (line[i] == '"' && line[++i] != '"') break;
        field += line[i];
    }
    return field;
}

TEST(NumberText, CsvFieldsAreReadAgain) {
    Random random(3);
    for (int i = 0; i < 2000; ++i) {
        const auto text = anyText(random);
        EXPECT_EQ(readCsvField(csvField(text) + ",next"), text);
    }
}

TEST(NumberText, PrefixesLeaveOneToAThousand) {
    Random random(4);
    for (int i = 0; i < 20000; ++i) {
        const double value = random.sign() * std::exp(random.between(std::log(1e-17), std::log(1e17)));
        const auto unit = scaledUnit(value, "m");
        const auto text = shortNumber(value, unit);
        const double shown = std::stod(text);
        EXPECT_GE(std::abs(shown), 1.0) << text << unit.name;
        EXPECT_LT(std::abs(shown), 1000.0) << text << unit.name;
        // Five digits: half of the fifth, of a number whose first is 1.
        EXPECT_NEAR(shown * unit.scale, value, 0.5e-4 * std::abs(value) * (1 + 1e-9)) << text << unit.name;
    }
    EXPECT_EQ(scaledUnit(1e-3, "m").name, "mm");
    EXPECT_EQ(scaledUnit(0.9999999, "m").name, "m");
    EXPECT_EQ(scaledUnit(-3e-6, "eV/c").name, "\u00b5eV/c");
    EXPECT_EQ(scaledUnit(3e6, "eV/c").name, "MeV/c");
}

TEST(NumberText, UnitsThatArePowersHaveNoPrefix) {
    for (const char* unit : {"m^2", "1/m", "m eV/c", "1", ""}) {
        EXPECT_EQ(scaledUnit(1e-7, unit).scale, 1.0) << unit;
        EXPECT_EQ(scaledUnit(1e-7, unit).name, std::string(unit) == "1" ? "" : unit);
    }
    EXPECT_EQ(scaledUnit(0.0, "m").name, "m");
    EXPECT_EQ(scaledUnit(std::numeric_limits<double>::quiet_NaN(), "m").name, "m");
    EXPECT_EQ(shortNumber(std::numeric_limits<double>::infinity(), {}), "-");
    EXPECT_EQ(shortNumber(0.0, {}), "0");
    EXPECT_EQ(shortNumber(20000.0, {}), "20000");
}

TEST(NumberText, PaddingCountsLetters) {
    EXPECT_EQ(padLeft("\u00b5m", 4), "  \u00b5m");
    EXPECT_EQ(padRight("\u00b5m", 4), "\u00b5m  ");
    EXPECT_EQ(padLeft("longer", 2), "longer");
}

}  // namespace
}  // namespace mote::client
