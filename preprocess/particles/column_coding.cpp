// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/particles/column_coding.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>

namespace mote::prep {
namespace {

constexpr std::size_t together = 8;  // values that are a bunch of their own
constexpr double ofWindow =
    4e-3;  // of the width of a hundredth of the values, .025 sigma in a Gaussian's core
constexpr double apartFrom = 1e4, narrow = 1e3;  // steps

double nearestQuantile(const std::vector<double>& sorted, double share) {
    return sorted[static_cast<std::size_t>(share * static_cast<double>(sorted.size() - 1) + 0.5)];
}

float stored(double value, double offset) {
    return static_cast<float>(value - offset);
}

bool isExact(double value, double offset) {
    return offset + static_cast<double>(stored(value, offset)) == value;
}

/// The step from a float of this magnitude to the next.
double stepAt(double magnitude) {
    const float value = static_cast<float>(magnitude);
    if (!std::isfinite(value)) return std::numeric_limits<double>::infinity();
    // Of a float that is not negative the next is that of the next bits.
    const float next = std::bit_cast<float>(std::bit_cast<std::uint32_t>(value) + 1U);
    return static_cast<double>(next) - static_cast<double>(value);
}

/// What is known of different values, ascending, as floats about an offset.
class Floats {
  public:
    Floats(const std::vector<double>& values, double offset) : values_(values), offset_(offset) {
        for (const double value : values)
            inexact_.push_back(inexact_.back() + (isExact(value, offset) ? 0 : 1));
    }

    bool exact() const { return inexact_.back() == 0; }
    bool fineEnough() const { return exact() || (windowsAreFine() && bunchesAreFine()); }

  private:
    double stepIn(std::size_t first, std::size_t last) const {
        return stepAt(std::max(std::abs(values_[first] - offset_), std::abs(values_[last] - offset_)));
    }
    bool exact(std::size_t first, std::size_t last) const { return inexact_[last + 1] == inexact_[first]; }

    /// Wherever a hundredth of the values lies closest.
    bool windowsAreFine() const {
        const std::size_t reach = std::min(std::max(together, values_.size() / 100), values_.size() - 1);
        for (std::size_t i = 0; i + reach < values_.size(); ++i) {
            const double width = values_[i + reach] - values_[i];
            if (stepIn(i, i + reach) > ofWindow * width && !exact(i, i + reach)) return false;
        }
        return true;
    }

    /// Fewer, but by themselves.
    bool bunchesAreFine() const {
        for (std::size_t first = 0, i = 0; i < values_.size(); ++i) {
            const bool last =
                i + 1 == values_.size() || values_[i + 1] - values_[i] > apartFrom * stepIn(i, i);
            if (!last) continue;
            const bool bunch =
                i - first + 1 >= together && values_[i] - values_[first] < narrow * stepIn(first, i);
            if (bunch && !exact(first, i)) return false;
            first = i + 1;
        }
        return true;
    }

    const std::vector<double>& values_;
    const double offset_;
    std::vector<std::size_t> inexact_{0};  ///< by value: how many before it
};

}  // namespace

ColumnCoding codingOf(std::vector<double> sample) {
    std::erase_if(sample, [](double value) { return !std::isfinite(value); });
    if (sample.empty()) return {};
    std::sort(sample.begin(), sample.end());
    const double middle = nearestQuantile(sample, 0.5);
    const bool far = std::abs(middle) > nearestQuantile(sample, 0.99) - nearestQuantile(sample, 0.01);
    sample.erase(std::unique(sample.begin(), sample.end()), sample.end());
    // Numbers of turns, elements and states stay exact, also those a few times as far as the sample's.
    if (std::ranges::all_of(sample, [](double value) { return value == std::floor(value); })) {
        const auto near = [&](double offset) {
            return std::max(std::abs(sample.front() - offset), std::abs(sample.back() - offset)) <= 0x1p22;
        };
        return near(0.0)      ? ColumnCoding{}
               : near(middle) ? ColumnCoding{middle, false}
                              : ColumnCoding{0.0, true};
    }
    const Floats asTheyAre(sample, 0.0);
    if (asTheyAre.exact() || (!far && asTheyAre.fineEnough())) return {};
    if (Floats(sample, middle).fineEnough()) return {middle, false};
    return {0.0, true};
}

ColumnCoding weightCodingOf(const std::vector<double>& sample, double least, double greatest) {
    const auto exact = [](double value) { return !std::isfinite(value) || isExact(value, 0.0); };
    if (least == greatest) return {exact(least) ? 0.0 : least, false};
    return {0.0, !std::ranges::all_of(sample, exact)};
}

double resolutionOf(const ColumnCoding& coding, double greatestStored) {
    const double most = std::abs(coding.offset) + greatestStored;
    if (most == 0.0) return 0.0;  // all are 0
    const double ofDoubles = std::nextafter(most, std::numeric_limits<double>::infinity()) - most;
    if (coding.doubles || greatestStored == 0.0) return std::isfinite(ofDoubles) ? ofDoubles : 0.0;
    const double step = std::max(stepAt(greatestStored), ofDoubles);
    return std::isfinite(step) ? step : 0.0;
}

}  // namespace mote::prep
