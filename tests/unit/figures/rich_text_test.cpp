// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/figures/rich_text.h"

#include <gtest/gtest.h>

#include <random>
#include <string>

#include "server/figures/annotation_words.h"
#include "server/figures/plot_axis.h"
#include "server/figures/quad.h"
#include "server/figures/quantity_text.h"
#include "server/figures/svg_marks.h"
#include "server/figures/typeface.h"

namespace mote::server {
namespace {

TEST(RichText, namesOfColumnsAndStatisticsAreSymbols) {
    EXPECT_EQ(toPlain(quantityText("x")), "x");
    EXPECT_EQ(toPlain(quantityText("px")), "p_x");
    EXPECT_EQ(toPlain(quantityText("xp")), "x\u2032");
    EXPECT_EQ(toPlain(quantityText("delta")), "\u03b4");
    EXPECT_EQ(toPlain(quantityText("energy")), "E_kin");
    EXPECT_EQ(toPlain(quantityText("my column")), "my column");
    EXPECT_EQ(toPlain(statisticText("norm_emit_x")), "\u03b5_n,\u200ax");
    EXPECT_EQ(toPlain(statisticText("emit90_action_x")), "\u03b5_n,\u200a90%,\u200ax");
    EXPECT_EQ(toPlain(statisticText("norm_emit_4d")), "\u03b5_n,\u200a4D");
    EXPECT_EQ(toPlain(statisticText("twiss_beta_x_no_dispersion")), "\u03b2_x,\u200a\u03b2");
    EXPECT_EQ(toPlain(statisticText("sigma_px")), "\u03c3_px");
    EXPECT_EQ(toPlain(statisticText("cov_x__px")), "cov(x,\u2009p_x)");
    EXPECT_EQ(toPlain(statisticText("something_new")), "something_new");
}

TEST(RichText, anyBytesAreLaidOut) {
    const Typeface typeface;
    std::mt19937 random(5);
    std::uniform_int_distribution<int> byte(0, 255), length(0, 300);
    for (int trial = 0; trial < 300; ++trial) {
        std::string text(static_cast<std::size_t>(length(random)), ' ');
        for (auto& c : text) c = static_cast<char>(byte(random));
        const auto line = typeface.layOut(upright(text), 10.0);
        EXPECT_GE(line.width, 0.0);
        for (const auto& glyph : line.glyphs) typeface.outline(glyph);
        const auto cut = shortened(upright(text), 10.0, 100.0, typeface);
        EXPECT_LE(typeface.layOut(cut, 10.0).width, 100.0);
    }
}

TEST(RichText, whatOnlySteersIsNothingAndScriptsAreSmall) {
    const Typeface typeface;
    EXPECT_EQ(typeface.layOut(upright("\u202Ea\u200Bb\u0007"), 10.0).glyphs.size(), 2u);
    EXPECT_EQ(typeface.layOut({}, 10.0).width, 0.0);
    const auto line = typeface.layOut({{"10"}, {"2", false, Script::above}}, 10.0);
    ASSERT_EQ(line.glyphs.size(), 3u);
    EXPECT_LT(line.glyphs[2].size, line.glyphs[0].size);
    EXPECT_LT(line.glyphs[2].place.y, 0.0);
    EXPECT_FALSE(typeface.outline(line.glyphs[0]).contours.empty());
}

TEST(RichText, whatXmlObeysIsEscaped) {
    EXPECT_EQ(escapedXml("a<b>&\"c\""), "a&lt;b&gt;&amp;&quot;c&quot;");
    EXPECT_EQ(escapedXml(std::string("\0\x1b", 2)), "??");
    EXPECT_EQ(escapedXml("\xff\u05d0"), "?\u05d0");
}

TEST(RichText, numbersOfParticlesAreGrouped) {
    EXPECT_EQ(groupedNumber(0), "0");
    EXPECT_EQ(groupedNumber(9999), "9999");
    EXPECT_EQ(groupedNumber(10000), "10\u2009000");
    EXPECT_EQ(groupedNumber(123456), "123\u2009456");
    EXPECT_EQ(groupedNumber(1234567), "1\u2009234\u2009567");
    EXPECT_EQ(groupedNumber(18446744073709551615U),
              "18\u2009446\u2009744\u2009073\u2009709\u2009551\u2009615");
}

/// Against points of a fine grid: both have one in common where they meet.
TEST(Quad, turnedTextsMeetWhereTheyHaveAnAreaInCommon) {
    std::mt19937 random(11);
    std::uniform_real_distribution<double> place(0.0, 60.0), angle(0.0, 6.3), side(4.0, 30.0);
    const auto any = [&] {
        const double a = angle(random);
        const glm::dvec2 at(place(random), place(random)), right(std::cos(a), std::sin(a)),
            down(-right.y, right.x);
        const double w = side(random), h = side(random);
        return Quad{at, at + w * right, at + w * right + h * down, at + h * down};
    };
    const auto holds = [](const Quad& quad, const glm::dvec2& point) {
        for (std::size_t i = 0; i < 4; ++i) {
            const glm::dvec2 along = quad[(i + 1) % 4] - quad[i], to = point - quad[i];
            if (along.x * to.y - along.y * to.x < 0.0) return false;
        }
        return true;
    };
    int met = 0;
    for (int trial = 0; trial < 400; ++trial) {
        const Quad a = any(), b = any();
        bool common = false;
        for (double x = -40.0; x < 100.0 && !common; x += 0.5) {
            for (double y = -40.0; y < 100.0 && !common; y += 0.5)
                common = holds(a, {x, y}) && holds(b, {x, y});
        }
        EXPECT_TRUE(!common || meet(a, b));
        met += meet(a, b) ? 1 : 0;
    }
    EXPECT_GT(met, 20);
    EXPECT_LT(met, 380);
}

}  // namespace
}  // namespace mote::server
