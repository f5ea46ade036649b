// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/view/panel_widgets.h"

#include <gtest/gtest.h>

#include <cstdio>
#include <limits>

namespace mote::client {
namespace {

std::string shown(double value, double span) {
    std::array<char, 64> text{};
    std::snprintf(text.data(), text.size(), formatFor(span, value).c_str(), value);
    return text.data();
}

TEST(FormatFor, TellsNumbersApartThatLieFarFromZero) {
    EXPECT_EQ(shown(0.5, 1.0), "0.5");
    EXPECT_EQ(shown(101325.001, 0.001), "101325.001");
    EXPECT_NE(shown(101325.0011, 0.001), shown(101325.0012, 0.001));
    EXPECT_EQ(shown(1234567.0, 1e9), "1.235e+06");
}

TEST(FormatFor, IsAFormatWhateverTheSpan) {
    for (const double span : {0.0, -1.0, 1e-300, 1e300, std::numeric_limits<double>::infinity()}) {
        EXPECT_NO_THROW(shown(7.0, span));
        EXPECT_FALSE(shown(0.0, span).empty());
    }
}

TEST(SliderValues, AFloatIsTheDecimalThatItShows) {
    EXPECT_EQ(decimal(0.1F), 0.1);
    EXPECT_EQ(decimal(3.0F), 3.0);
    EXPECT_EQ(share(0.3F), 0.3);
    EXPECT_EQ(share(1.5F), 1.0);
    EXPECT_EQ(decimal(1e-30F), 1e-30);
}

}  // namespace
}  // namespace mote::client
