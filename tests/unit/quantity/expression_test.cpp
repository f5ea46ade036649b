// SPDX-License-Identifier: GPL-3.0-or-later
//
// What an expression may be, what is said of one that is none, and its values at the edges; random ones are
// held against numpy in tests/python/quantities_test.py.
#include "protocol/quantity/expression.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <limits>

#include "protocol/quantity/expression_kernel.h"
#include "protocol/quantity/quantity.h"
#include "tests/support/random.h"

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

using Op = Expression::Operation;
using Exactly = long double (*)(long double, long double);

struct TestedFunction {
    const char* name;
    Op operation;
    Exactly exactly;  ///< in 64 bits
};
const std::vector<TestedFunction> testedFunctions{
    {"exp", Op::exp, [](long double a, long double) { return std::exp(a); }},
    {"log", Op::log, [](long double a, long double) { return std::log(a); }},
    {"log10", Op::log10, [](long double a, long double) { return std::log10(a); }},
    {"sin", Op::sin, [](long double a, long double) { return std::sin(a); }},
    {"cos", Op::cos, [](long double a, long double) { return std::cos(a); }},
    {"tan", Op::tan, [](long double a, long double) { return std::tan(a); }},
    {"asin", Op::asin, [](long double a, long double) { return std::asin(a); }},
    {"acos", Op::acos, [](long double a, long double) { return std::acos(a); }},
    {"atan", Op::atan, [](long double a, long double) { return std::atan(a); }},
    {"sinh", Op::sinh, [](long double a, long double) { return std::sinh(a); }},
    {"cosh", Op::cosh, [](long double a, long double) { return std::cosh(a); }},
    {"tanh", Op::tanh, [](long double a, long double) { return std::tanh(a); }},
    {"pow", Op::power, [](long double a, long double b) { return std::pow(a, b); }},
    {"atan2", Op::atan2, [](long double a, long double b) { return std::atan2(a, b); }}};

const std::vector<double> edgesOfDoubles{0.0,
                                         -0.0,
                                         infinite,
                                         -infinite,
                                         nan,
                                         5e-324,
                                         -5e-324,
                                         1e-310,
                                         2.2250738585072014e-308,
                                         1.0,
                                         -1.0,
                                         0.5,
                                         1.0000000000000002,
                                         -1.0000000000000002,
                                         2.0,
                                         -3.0,
                                         3.5,
                                         709.0,
                                         709.5,
                                         -710.4,
                                         710.5,
                                         -745.1,
                                         -745.2,
                                         1e15,
                                         1e22,
                                         1.7976931348623157e308,
                                         -1.7976931348623157e308};

/// Of all magnitudes; those at which functions turn; the edges.
double anyArgument(test::Random& random) {
    if (random.chance(0.1)) return edgesOfDoubles[random.below(edgesOfDoubles.size())];
    if (random.chance(0.2)) return std::bit_cast<double>(random.next());
    if (random.chance(0.3)) return random.between(-800.0, 800.0);
    return random.sign() * random.magnitude(-20, 3);
}

/// Units in the last place between what was made and the value in 64 bits; without end where only one of them
/// is a number, or a zero has the other sign.
double unitsApart(double made, long double exactly) {
    const auto value = static_cast<double>(exactly);
    if (std::isnan(value) || std::isnan(made)) return std::isnan(value) == std::isnan(made) ? 0.0 : infinite;
    if (made == value) return std::signbit(made) == std::signbit(value) ? 0.0 : infinite;
    if (std::isinf(made) || std::isinf(value)) return infinite;
    int exponent = 0;
    std::frexp(value, &exponent);
    const double unit = std::ldexp(1.0, std::max(exponent - 53, -1074));
    return std::abs(static_cast<double>((static_cast<long double>(made) - exactly) / unit));
}

std::vector<FunctionVectors> vectorsHere() {
    std::vector<FunctionVectors> all{FunctionVectors::none};
    if (functionVectorsHere() >= FunctionVectors::avx2) all.push_back(FunctionVectors::avx2);
    if (functionVectorsHere() == FunctionVectors::avx512) all.push_back(FunctionVectors::avx512);
    return all;
}

TEST(Expression, FunctionsAreWithinAUnitInTheLastPlace) {
    test::Random random(7, 32);
    std::vector<double> a, b;
    for (const double first : edgesOfDoubles) {
        for (const double second : edgesOfDoubles) a.push_back(first), b.push_back(second);
    }
    while (a.size() < 50'003) a.push_back(anyArgument(random)), b.push_back(anyArgument(random));
    std::vector<double> made(a.size());
    for (const auto& function : testedFunctions) {
        for (const auto vectors : vectorsHere()) {
            runOperation(function.operation, a.data(), b.data(), nullptr, made.data(), a.size(), vectors);
            // SLEEF says 1.0 of itself; glibc, whose sinh and cosh go on where SLEEF's end, 2 or 3 of these.
            const bool ends = function.operation == Op::sinh || function.operation == Op::cosh;
            const double least = vectors == FunctionVectors::none ? 3.0 : 1.01;
            for (std::size_t i = 0; i < a.size(); ++i) {
                const double allowed = ends && std::abs(a[i]) > 709.0 ? 3.0 : least;
                ASSERT_LE(unitsApart(made[i], function.exactly(a[i], b[i])), allowed)
                    << function.name << " of " << a[i] << ", " << b[i] << ": " << made[i];
            }
        }
    }
}

/// Of what is no number always the same.
std::uint64_t bitsOf(double value) {
    return std::bit_cast<std::uint64_t>(std::isnan(value) ? nan : value);
}

TEST(Expression, ARowHasTheSameValueAmongAnyOthersAndInAnyVectors) {
    test::Random random(8, 32);
    for (const auto& function : testedFunctions) {
        std::vector<double> a(random.below(40) + 1), b(a.size());
        for (auto& value : a) value = anyArgument(random);
        for (auto& value : b) value = anyArgument(random);
        std::vector<std::uint64_t> first;
        for (const auto vectors : vectorsHere()) {
            if (vectors == FunctionVectors::none) continue;
            auto made = a;  // in place
            runOperation(function.operation, made.data(), b.data(), nullptr, made.data(), made.size(),
                         vectors);
            std::vector<std::uint64_t> bits;
            for (std::size_t i = 0; i < a.size(); ++i) {
                double alone = 0.0;
                runOperation(function.operation, &a[i], &b[i], nullptr, &alone, 1, vectors);
                bits.push_back(bitsOf(made[i]));
                EXPECT_EQ(bits.back(), bitsOf(alone)) << function.name << " of " << a[i];
            }
            if (first.empty()) first = bits;
            EXPECT_EQ(bits, first) << function.name;
        }
    }
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
