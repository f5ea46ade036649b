// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/figures/ticks.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "server/figures/quantity_text.h"

namespace mote::server {
namespace {

constexpr int mostDigits = 5;       // of a label, before an offset is taken
constexpr double mostSteps = 4e15;  // from zero that a double tells apart

Error notFinite() {
    return {ErrorCode::invalidArgument, "range", "an axis has two finite ends"};
}

/// 10^power, exact for what doubles hold exactly.
double scaled(double value, int power) {
    // In two parts beyond what is a double itself.
    if (power < -300) return value / 1e300 / std::pow(10.0, -power - 300);
    return power < 0 ? value / std::pow(10.0, -power) : value * std::pow(10.0, power);
}

/// A distance of ticks: 1, 2 or 5 times a power of ten.
struct Step {
    std::int64_t digit = 1;
    int power = 0;

    double size() const { return scaled(static_cast<double>(digit), power); }
    double at(std::int64_t count) const {
        return count == 0 ? 0.0 : scaled(static_cast<double>(count * digit), power);
    }
    Step next() const {
        if (digit == 1) return {2, power};
        return digit == 2 ? Step{5, power} : Step{1, power + 1};
    }
    int parts() const { return digit == 2 ? 4 : 5; }  ///< that minor ticks make of it
};

struct Range {
    double low, high;
    double magnitude() const { return std::max(std::abs(low), std::abs(high)); }
    /// In steps, the ends themselves included if only rounding keeps them out.
    std::pair<std::int64_t, std::int64_t> countsOf(double step) const {
        const double slack = 1e-9;
        return {static_cast<std::int64_t>(std::ceil(low / step - slack)),
                static_cast<std::int64_t>(std::floor(high / step + slack))};
    }
    bool holds(double value) const { return value >= low && value <= high; }
};

/// The smallest step that makes at most so many ticks.
Step stepFor(const Range& range, int most) {
    const double span = range.high / 2.0 - range.low / 2.0;  // half of it: no overflow
    const double wanted = std::max(span / std::max(1, most) * 2.0, range.magnitude() / mostSteps);
    const double least = std::clamp(wanted, 1e-300, 1e307);
    Step step{1, static_cast<int>(std::floor(std::log10(least))) - 1};
    while (true) {
        const bool tellable = range.magnitude() / step.size() <= mostSteps;
        if (tellable) {
            const auto [first, last] = range.countsOf(step.size());
            if (last - first + 1 <= most) return step;
        }
        step = step.next();
    }
}

/// A whole number of 10^power as a decimal number, without a point if none is needed.
std::string decimal(std::int64_t number, int power, int decimals) {
    const bool negative = number < 0;
    std::string digits = fmt::to_string(negative ? -number : number);
    if (power > 0) digits.append(number == 0 ? 0 : static_cast<std::size_t>(power), '0');
    const auto fraction = static_cast<std::size_t>(std::max(0, -power));
    if (digits.size() <= fraction) digits.insert(0, fraction + 1 - digits.size(), '0');
    std::string text = digits.substr(0, digits.size() - fraction);
    std::string after = digits.substr(digits.size() - fraction);
    after.resize(static_cast<std::size_t>(decimals), '0');
    if (decimals > 0) text += "." + after;
    return withMinusSign(negative ? "-" + text : text);
}

int digitsOf(std::int64_t number) {
    return static_cast<int>(fmt::to_string(std::abs(number)).size());
}

/// How many digits the longest label has, before and after the point.
int labelDigits(const Range& range, const Step& step, int power) {
    const double greatest = scaled(range.magnitude(), -power);
    const int before = greatest < 1.0 ? 1 : static_cast<int>(std::floor(std::log10(greatest))) + 1;
    return std::max(before, 1) + std::max(0, power - step.power);
}

/// The prefix of the unit, and the power if the prefix does not bring the labels near 1.
void choosePower(Ticks& ticks, double magnitude) {
    ticks.prefix = prefixPower(ticks.unit, magnitude);
    ticks.power = ticks.prefix;
    if (!(magnitude > 0.0)) return;
    const double shown = scaled(magnitude, -ticks.prefix);
    if (shown >= 1e5 || shown < 0.0999)
        ticks.power += 3 * static_cast<int>(std::floor((std::log10(shown) + 1e-9) / 3.0));
}

/// Where the labels count from, in steps: the next power of ten's multiple below the range.
std::int64_t offsetSteps(std::int64_t first, const Step& step) {
    const std::int64_t ten = 10 / step.digit;
    const std::int64_t down = first / ten * ten;
    return down > first ? down - ten : down;
}

void describeOffset(Ticks& ticks, const Step& step, std::int64_t steps) {
    ticks.offset = step.at(steps);
    const int prefix = prefixPower(ticks.unit, std::abs(ticks.offset));
    std::int64_t number = std::abs(steps) * step.digit;
    int power = step.power;
    while (number != 0 && number % 10 == 0) {
        number /= 10;
        ++power;
    }
    const int beyond = digitsOf(number) + power - prefix;  // digits before the point
    RichText written;
    if (beyond > 6 || beyond < -2) {
        const int exponent = digitsOf(number) + power - 1;
        written =
            upright(decimal(number, power - exponent, std::max(0, exponent - power)) + "\u2009\u00d7\u2009") +
            powerOfTen(exponent - prefix);
    } else {
        written = upright(decimal(number, power - prefix, std::max(0, prefix - power)));
    }
    const RichText unit = unitText(ticks.unit, prefix);
    ticks.offsetText = unit.empty() ? written : written + upright("\u2009") + unit;
}

void addMinor(Ticks& ticks, const Range& range, const Step& step) {
    const auto [first, last] = range.countsOf(step.size());
    for (std::int64_t i = first - 1; i <= last; ++i) {
        const double from = step.at(i);
        for (int part = 1; part < step.parts(); ++part) {
            const double value = from + step.size() * part / step.parts();
            if (range.holds(value)) ticks.minor.push_back(value);
        }
    }
}

Ticks oneTick(double value, std::string_view unit) {
    Ticks ticks;
    ticks.unit = unit;
    choosePower(ticks, std::abs(value));
    const double shown = scaled(value, -ticks.power);
    ticks.major.push_back({value, upright(withMinusSign(fmt::format("{:.6g}", shown == 0.0 ? 0.0 : shown)))});
    return ticks;
}

}  // namespace

RichText Ticks::title(const RichText& name) const {
    RichText text = name;
    if (!offsetText.empty()) text = text + upright(offset < 0.0 ? " + " : " \u2212 ") + offsetText;
    return withUnit(std::move(text), unit, prefix, power);
}

Result<Ticks> linearTicks(double low, double high, std::string_view unit, int most) {
    if (!std::isfinite(low) || !std::isfinite(high)) return notFinite();
    if (low == high) return oneTick(low, unit);
    const Range range{std::min(low, high), std::max(low, high)};
    const Step step = stepFor(range, std::max(1, most));
    const auto [first, last] = range.countsOf(step.size());
    Ticks ticks;
    ticks.unit = unit;
    choosePower(ticks, range.magnitude());
    std::int64_t from = 0;
    if (labelDigits(range, step, ticks.power) > mostDigits && first <= last && (first > 0 || last < 0)) {
        from = offsetSteps(first, step);
        choosePower(ticks,
                    std::max(std::abs(static_cast<double>(first - from)), static_cast<double>(last - from)) *
                        step.size());
        if (first == last) choosePower(ticks, step.size());
        describeOffset(ticks, step, from);
    }
    const int decimals = std::max(0, ticks.power - step.power);
    for (std::int64_t i = first; i <= last; ++i) {
        const double value = std::clamp(step.at(i), range.low, range.high);
        ticks.major.push_back(
            {value, upright(decimal((i - from) * step.digit, step.power - ticks.power, decimals))});
    }
    addMinor(ticks, range, step);
    if (low > high) {
        std::reverse(ticks.major.begin(), ticks.major.end());
        std::reverse(ticks.minor.begin(), ticks.minor.end());
    }
    return ticks;
}

Result<Ticks> logTicks(double low, double high, std::string_view unit, int most) {
    if (!std::isfinite(low) || !std::isfinite(high)) return notFinite();
    if (!(low > 0.0) || !(high > 0.0))
        return Error{ErrorCode::invalidArgument, "range", "a logarithmic axis has ends above 0"};
    const Range range{std::min(low, high), std::max(low, high)};
    const auto exponents = [](double value) { return std::log10(value); };
    const int first = static_cast<int>(std::ceil(exponents(range.low) - 1e-9));
    const int last = static_cast<int>(std::floor(exponents(range.high) + 1e-9));
    if (last - first < 1) return linearTicks(low, high, unit, most);
    Ticks ticks;
    ticks.unit = unit;
    int stride = 1;
    while ((last - first) / stride + 1 > std::max(1, most)) ++stride;
    // Round exponents, so that neighbouring figures have the same.
    for (int exponent = first; exponent <= last; ++exponent) {
        const double value = std::clamp(scaled(1.0, exponent), range.low, range.high);
        if (((exponent % stride) + stride) % stride == 0)
            ticks.major.push_back({value, powerOfTen(exponent)});
        else
            ticks.minor.push_back(value);
    }
    for (int exponent = first - 1; stride == 1 && exponent <= last; ++exponent) {
        for (int digit = 2; digit < 10; ++digit) {
            const double value = scaled(digit, exponent);
            if (range.holds(value)) ticks.minor.push_back(value);
        }
    }
    if (low > high) {
        std::reverse(ticks.major.begin(), ticks.major.end());
        std::reverse(ticks.minor.begin(), ticks.minor.end());
    }
    return ticks;
}

}  // namespace mote::server
