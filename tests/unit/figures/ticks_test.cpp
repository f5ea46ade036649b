// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/figures/ticks.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <set>
#include <string>

#include "server/figures/quantity_text.h"

namespace mote::server {
namespace {

constexpr const char* units[] = {"m", "eV/c", "s", "1", "C", "rad", "1/m", "m eV/c", "furlong", ""};

/// The number that a label shows; its minus sign is the typographic one, and no other.
long double numberOf(const RichText& label) {
    std::string text = toPlain(label);
    EXPECT_EQ(text.find('-'), std::string::npos) << text;
    const std::string minus = "\u2212";
    if (const auto at = text.find(minus); at != std::string::npos) text.replace(at, minus.size(), "-");
    if (text.rfind("10^", 0) == 0) return std::pow(10.0L, std::stold(text.substr(3)));
    std::size_t read = 0;
    const long double number = std::stold(text, &read);
    EXPECT_EQ(read, text.size()) << text;
    return number;
}

std::size_t decimalsOf(const RichText& label) {
    const auto text = toPlain(label);
    const auto point = text.find('.');
    return point == std::string::npos ? 0 : text.size() - point - 1;
}

struct Range {
    double low, high;
};

/// Ranges of all magnitudes, around zero and far from it, either way around.
Range anyRange(std::mt19937_64& random) {
    std::uniform_real_distribution<double> power(-12.0, 15.0), share(-1.0, 1.0), narrow(0.0, 13.0);
    std::uniform_int_distribution<int> kind(0, 3);
    const double size = std::pow(10.0, power(random));
    switch (kind(random)) {
        case 0:
            return {0.0, size};
        case 1:
            return {size * share(random), size * share(random)};
        case 2: {  // tiny about a large offset
            const double middle = size * share(random),
                         half = std::abs(middle) * std::pow(10.0, -narrow(random));
            return {middle - half, middle + half};
        }
        default:
            return {size * share(random), size};
    }
}

TEST(Ticks, sayTheirValuesWithRoundNumbersAndNoMoreDigitsThanNeeded) {
    std::mt19937_64 random(20261124);
    for (int trial = 0; trial < 20000; ++trial) {
        auto [low, high] = anyRange(random);
        if (low == high) continue;
        if (trial % 3 == 0) std::swap(low, high);
        const int most = 2 + trial % 9;
        const auto ticks = linearTicks(low, high, units[trial % std::size(units)], most);
        ASSERT_TRUE(ticks.ok());
        SCOPED_TRACE(testing::Message() << low << " to " << high << ", most " << most);
        const double least = std::min(low, high), greatest = std::max(low, high);
        ASSERT_LE(ticks->major.size(), static_cast<std::size_t>(most));
        const double magnitude = std::max(std::abs(low), std::abs(high));
        std::set<std::string> labels;
        bool needed = false;
        for (const auto& tick : ticks->major) {
            EXPECT_GE(tick.value, least);
            EXPECT_LE(tick.value, greatest);
            // Half a unit in the last place of the magnitude, thrice: of the tick, the offset and their sum.
            const long double said = numberOf(tick.label) * std::pow(10.0L, ticks->power) +
                                     static_cast<long double>(ticks->offset);
            EXPECT_NEAR(static_cast<double>(said), tick.value, 4e-16 * magnitude);
            EXPECT_TRUE(labels.insert(toPlain(tick.label)).second) << toPlain(tick.label);
            EXPECT_EQ(decimalsOf(tick.label), decimalsOf(ticks->major[0].label));
            const auto text = toPlain(tick.label);
            needed = needed || decimalsOf(tick.label) == 0 || text.back() != '0';
            EXPECT_LE(text.size(), 12u);
        }
        // Two ticks are never both whole in the last decimal; one alone may be.
        EXPECT_TRUE(needed || ticks->major.size() <= 2);
        const bool ascends = low < high;
        for (std::size_t i = 1; i < ticks->major.size(); ++i)
            EXPECT_EQ(ticks->major[i - 1].value < ticks->major[i].value, ascends);
        for (const double minor : ticks->minor) {
            EXPECT_GE(minor, least);
            EXPECT_LE(minor, greatest);
        }
    }
}

/// A range that a double tells apart from its ends has at least two ticks where five may be there.
TEST(Ticks, areThereInEveryRange) {
    std::mt19937_64 random(7);
    for (int trial = 0; trial < 5000; ++trial) {
        const auto [low, high] = anyRange(random);
        if (std::abs(high - low) < 1e-12 * std::max(std::abs(low), std::abs(high))) continue;
        const auto ticks = linearTicks(low, high, "m", 5);
        ASSERT_TRUE(ticks.ok());
        EXPECT_GE(ticks->major.size(), 2u) << low << " to " << high;
    }
}

TEST(Ticks, equalEndsHaveOneAndEndsThatAreNotFiniteAreRefused) {
    const double infinity = std::numeric_limits<double>::infinity();
    for (const double value : {0.0, 1.0, -3e-9, 1e15, 1e300}) {
        const auto ticks = linearTicks(value, value, "m", 5);
        ASSERT_TRUE(ticks.ok());
        ASSERT_EQ(ticks->major.size(), 1u);
        EXPECT_EQ(ticks->major[0].value, value);
    }
    for (const double value : {infinity, -infinity, std::nan("")}) {
        EXPECT_EQ(linearTicks(value, 1.0, "m", 5).error().code, ErrorCode::invalidArgument);
        EXPECT_EQ(linearTicks(0.0, value, "m", 5).error().code, ErrorCode::invalidArgument);
        EXPECT_EQ(logTicks(1.0, value, "m", 5).error().code, ErrorCode::invalidArgument);
    }
    EXPECT_EQ(logTicks(0.0, 1.0, "m", 5).error().code, ErrorCode::invalidArgument);
    EXPECT_EQ(logTicks(-1.0, 1.0, "m", 5).error().code, ErrorCode::invalidArgument);
}

TEST(Ticks, theExtremesOfDoublesEnd) {
    const double greatest = std::numeric_limits<double>::max(),
                 least = std::numeric_limits<double>::denorm_min();
    for (const auto& [low, high] : {Range{-greatest, greatest}, Range{0.0, greatest}, Range{0.0, least},
                                    Range{1.0, std::nextafter(1.0, 2.0)}, Range{-least, greatest}}) {
        for (int most = 1; most < 10; ++most) {
            const auto ticks = linearTicks(low, high, "eV", most);
            ASSERT_TRUE(ticks.ok());
            for (const auto& tick : ticks->major) EXPECT_TRUE(tick.value >= low && tick.value <= high);
        }
    }
}

TEST(Ticks, logarithmicOnesArePowersOfTen) {
    std::mt19937_64 random(3);
    std::uniform_real_distribution<double> power(-20.0, 20.0);
    for (int trial = 0; trial < 5000; ++trial) {
        const double a = power(random), b = power(random);
        const double low = std::pow(10.0, std::min(a, b)), high = std::pow(10.0, std::max(a, b));
        const int most = 2 + trial % 8;
        const auto ticks = logTicks(low, high, "m", most);
        ASSERT_TRUE(ticks.ok());
        EXPECT_LE(ticks->major.size(), static_cast<std::size_t>(most));
        for (const auto& tick : ticks->major) {
            EXPECT_GE(tick.value, low);
            EXPECT_LE(tick.value, high);
            const long double said = numberOf(tick.label) * std::pow(10.0L, ticks->power) +
                                     static_cast<long double>(ticks->offset);
            EXPECT_NEAR(static_cast<double>(said / tick.value), 1.0, 1e-8);
        }
        for (const double minor : ticks->minor) EXPECT_TRUE(minor >= low && minor <= high);
    }
}

TEST(Ticks, sayTheirUnitAsPapersDo) {
    const auto said = [](double low, double high, const char* unit, const char* name) {
        return toPlain(linearTicks(low, high, unit, 6)->title(italic(name)));
    };
    EXPECT_EQ(said(-4e5, 4e5, "eV/c", "p"), "p (keV/c)");
    EXPECT_EQ(said(0, 4e7, "eV/c", "p"), "p (MeV/c)");
    EXPECT_EQ(said(-2e-3, 2e-3, "m", "x"), "x (mm)");
    EXPECT_EQ(said(0, 5e-6, "m", "x"), "x (\u00b5m)");
    EXPECT_EQ(said(0, 3, "1", "N"), "N");
    EXPECT_EQ(said(-4e-3, 4e-3, "1", "d"), "d (10^\u22123)");
    EXPECT_EQ(said(0, 7, "1/m", "g"), "g (m^\u22121)");
    EXPECT_EQ(said(12.3451, 12.3459, "m", "z"), "z \u2212 12.345\u2009m (\u00b5m)");
    EXPECT_EQ(said(-12.3459, -12.3451, "m", "z"), "z + 12.346\u2009m (\u00b5m)");
}

TEST(UnitText, aPrefixBringsTheNumberNearOneWhereTheUnitTakesIt) {
    EXPECT_EQ(prefixPower("m", 0.02), -3);
    EXPECT_EQ(prefixPower("eV", 2.5e9), 9);
    EXPECT_EQ(prefixPower("s", 1e5), 0);
    EXPECT_EQ(prefixPower("1", 1e5), 0);
    EXPECT_EQ(prefixPower("m", 0.0), 0);
    EXPECT_EQ(prefixPower("m", 999.9999999999), 3);
    EXPECT_EQ(toPlain(unitText("m^2", 0)), "m^2");
    EXPECT_EQ(toPlain(unitText("1/m^2", 0)), "m^\u22122");
    EXPECT_EQ(toPlain(unitText("eV/c", 3)), "keV/c");
    EXPECT_EQ(toPlain(unitText("1", 0)), "");
}

}  // namespace
}  // namespace mote::server
