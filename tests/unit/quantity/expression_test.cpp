// SPDX-License-Identifier: GPL-3.0-or-later
//
// What an expression may be, what is said of one that is none, and its values at the edges; random ones are
// held against numpy in tests/python/quantities_test.py.
#include "protocol/quantity/expression.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "protocol/quantity/quantity.h"

namespace mote {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

constexpr double infinite = std::numeric_limits<double>::infinity();
constexpr double nan = std::numeric_limits<double>::quiet_NaN();

/// The value with x, y and z, in rows enough for more than one piece.
double valueOf(const std::string& text, double x, double y = 2.0, double z = 3.0) {
    const auto parsed = Expression::parse(text);
    EXPECT_TRUE(parsed.ok()) << text;
    if (!parsed.ok()) return nan;
    constexpr std::size_t rows = 2500;
    const std::vector<double> xs(rows, x), ys(rows, y), zs(rows, z);
    std::vector<std::span<const double>> columns;
    for (const auto& name : parsed->names()) {
        columns.emplace_back(name.text == "x" ? xs : name.text == "y" ? ys : zs);
    }
    std::vector<double> out(rows, -1.0);
    Expression::Scratch scratch;
    parsed->evaluate(columns, scratch, out);
    for (const double value : out) EXPECT_TRUE(value == out[0] || std::isnan(out[0])) << text;
    return out.back();
}

TEST(Expression, BindsAsPythonDoes) {
    EXPECT_EQ(valueOf("x + y * z", 1.0), 7.0);
    EXPECT_EQ(valueOf("(x + y) * z", 1.0), 9.0);
    EXPECT_EQ(valueOf("-x ^ 2", 3.0), -9.0);
    EXPECT_EQ(valueOf("2 ** -x", 1.0), 0.5);
    EXPECT_EQ(valueOf("y ^ z ^ x", 2.0), 512.0);
    EXPECT_EQ(valueOf("x - y - z", 1.0), -4.0);
    EXPECT_EQ(valueOf("x / y / z", 12.0), 2.0);
    EXPECT_EQ(valueOf("x < y and not y < x or z > 100", 1.0), 1.0);
    EXPECT_EQ(valueOf("x % y", -1.5), 0.5);
    EXPECT_EQ(valueOf("where(x > 0, y, -z)", 1.0), 2.0);
    EXPECT_EQ(valueOf("where(x > 0, y, -z)", -1.0), -3.0);
    EXPECT_EQ(valueOf("1e-3*x", 2.0), 2e-3);
    EXPECT_EQ(valueOf("'x'", 5.0), 5.0);
    EXPECT_NEAR(valueOf("sin(pi * x)", 0.5), 1.0, 1e-15);
}

TEST(Expression, HoldsAtTheEdges) {
    EXPECT_DOUBLE_EQ(valueOf("hypot(x, y)", 3e200, 4e200), 5e200);
    EXPECT_DOUBLE_EQ(valueOf("hypot(x, y)", 3e-200, 4e-200), 5e-200);
    EXPECT_EQ(valueOf("hypot(x, y)", 0.0, 0.0), 0.0);
    EXPECT_EQ(valueOf("hypot(x, y)", infinite, nan), infinite);
    EXPECT_TRUE(std::isnan(valueOf("min(x, y)", nan)));
    EXPECT_TRUE(std::isnan(valueOf("max(y, x)", nan)));
    EXPECT_EQ(valueOf("x / (y - 2)", 1.0), infinite);
    EXPECT_TRUE(std::isnan(valueOf("sqrt(x)", -1.0)));
    EXPECT_EQ(valueOf("x == x", nan), 0.0);
    EXPECT_EQ(valueOf("sign(x)", -7.0), -1.0);
    EXPECT_EQ(valueOf("round(x)", 2.5), 2.0);
}

TEST(Expression, SaysWhereAndWhatIsWrong) {
    const auto error = [](const std::string& text) {
        const auto parsed = Expression::parse(text);
        return parsed.ok() ? std::string("accepted") : parsed.error().message;
    };
    EXPECT_EQ(error("x +"), "at 4: something is missing");
    EXPECT_EQ(error("x + * y"), "at 5: \"*\" does not belong there");
    EXPECT_EQ(error("(x + y"), "at 1: this parenthesis is not closed");
    EXPECT_EQ(error("x + y)"), "at 6: \")\" does not belong there");
    EXPECT_EQ(error("sqr(x)"), "at 1: there is no function \"sqr\"; near it: sqrt");
    EXPECT_EQ(error("hypot(x)"), "at 8: hypot is of 2 values and ends with \")\"");
    EXPECT_EQ(error("sqrt(x, y)"), "at 7: sqrt is of 1 value and ends with \")\"");
    EXPECT_EQ(error("x < y < z"), "at 7: comparisons make no chain; write a < b and b < c");
    EXPECT_EQ(error("2x"), "at 2: a sign is missing after the number");
    EXPECT_EQ(error("1 + 2"), "at 1: no column is named");
    EXPECT_EQ(error("'x + 1"), "at 1: this quote is not closed");
    // Nothing that assigns, loops or reads.
    for (const char* text : {"x = 3", "x; y", "x := y", "for(x)", "system('ls')", "x[0]", "{x}", "x ? y : z",
                             "x\ny", "\"a\" + ", "x & y", "x!", "@x", "x.y", ".", "1e", "''+x"})
        EXPECT_NE(error(text), "accepted") << text;
}

TEST(Expression, IsBounded) {
    const auto nested = [](std::size_t depth, const char* open) {
        std::string text;
        for (std::size_t i = 0; i < depth; ++i) text += open;
        return text + "x";
    };
    EXPECT_THAT(Expression::parse(nested(Expression::deepest, "(")).error().message,
                HasSubstr("too much lies within each other"));
    for (const char* open : {"-", "not ", "x^", "sin("})
        EXPECT_FALSE(Expression::parse(nested(Expression::longest / 5, open)).ok()) << open;
    std::string sum = "x";
    while (sum.size() + 2 <= Expression::longest) sum += "+y";
    EXPECT_TRUE(Expression::parse(sum).ok());
    EXPECT_THAT(Expression::parse(sum + "+x").error().message, HasSubstr("longer than 512 bytes"));
    std::string names = "a0";
    for (std::size_t i = 1; i <= Expression::mostNames; ++i) names += "+a" + std::to_string(i);
    EXPECT_THAT(Expression::parse(names).error().message, HasSubstr("more than 16 columns are named"));
}

TEST(Expression, KnowsItsUnitWhereItCan) {
    const auto unit = [](const std::string& text) {
        const auto parsed = Expression::parse(text);
        std::vector<std::string> units;
        for (const auto& name : parsed->names()) units.emplace_back(name.text == "energy" ? "eV" : "m");
        return parsed->unit(units);
    };
    for (const char* text :
         {"hypot(x, y)", "x - y", "-abs(x)", "min(x, 1e-3)", "where(energy > 1, x, y)", "x % 0.1"})
        EXPECT_EQ(unit(text), "m") << text;
    for (const char* text : {"x / y", "x > y", "sin(x)", "x / y * 2", "sqrt(x / y)"})
        EXPECT_EQ(unit(text), "1") << text;
    EXPECT_EQ(unit("atan2(y, x)"), "rad");
    for (const char* text : {"energy * 1e-9", "x * y", "x ^ 2", "x + energy", "sqrt(x)"})
        EXPECT_EQ(unit(text), "") << text;
}

TEST(Names, AreSplitBetweenCommasOfTheirOwn) {
    EXPECT_THAT(splitNames("x,hypot(x,y),'a,b'+1,z"), ElementsAre("x", "hypot(x,y)", "'a,b'+1", "z"));
    EXPECT_THAT(splitNames(""), ElementsAre(""));
    EXPECT_THAT(splitNames("x,"), ElementsAre("x", ""));
}

}  // namespace
}  // namespace mote
