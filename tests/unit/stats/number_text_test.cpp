// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/shared/number_text.h"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstdlib>
#include <limits>

#include "protocol/mote.pb.h"
#include "protocol/scene/json.h"
#include "protocol/scene/json_string.h"
#include "protocol/scene/utf8.h"
#include "tests/support/random.h"

namespace mote::client {
namespace {

using test::Random;

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
