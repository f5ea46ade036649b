// SPDX-License-Identifier: GPL-3.0-or-later
//
// HistogramView: which histogram of two columns is looked at, and which part of it. A value that is free of
// any window.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "client/shared/numbers.h"
#include "client/view/knot_curve.h"
#include "client/view/numbers/quantities.h"
#include "protocol/mote.pb.h"
#include "protocol/scene/color_map.h"

namespace mote::client {

struct HistogramView {
    static constexpr std::uint32_t bins = 256;  ///< of each column

    std::array<std::string, 2> columns;
    std::array<std::optional<Interval>, 2> ranges;  ///< none: of the column, over all steps
    bool ofSelection = false;                       ///< else of all particles
    bool logScale = true;
    std::string colorMap = "viridis";

    /// Looks at columns that there are: those it has, or else the first two.
    void fit(const std::vector<Quantity>& quantities) {
        for (std::size_t i = 0; i < 2 && i < quantities.size(); ++i) {
            if (findQuantity(quantities, columns[i]) == nullptr) setColumn(i, usual(quantities, i));
        }
    }
    void setColumn(std::size_t axis, const std::string& name) {
        columns[axis] = name;
        ranges[axis].reset();
    }
    /// Narrows or widens what is seen of `shown` about a place in it; `factor` below 1 narrows. Stops before
    /// neighbouring numbers are no longer told apart.
    void zoom(std::size_t axis, const Interval& shown, double at, double factor) {
        const Interval next{at + (shown.low - at) * factor, at + (shown.high - at) * factor};
        const double magnitude = std::max(std::abs(next.low), std::abs(next.high));
        if (next.high - next.low > 1e-9 * magnitude && next.high - next.low < 1e300) ranges[axis] = next;
    }
    void showAll() { ranges = {}; }

    proto::HistogramQuery query() const {
        proto::HistogramQuery query;
        for (std::size_t i = 0; i < 2; ++i) {
            auto& axis = *query.add_axes();
            axis.set_column(columns[i]);
            axis.set_bins(bins);
            if (!ranges[i]) continue;
            axis.add_range(ranges[i]->low);
            axis.add_range(ranges[i]->high);
        }
        return query;
    }

  private:
    /// x and px if there are such.
    static std::string usual(const std::vector<Quantity>& quantities, std::size_t axis) {
        const auto* wanted = findQuantity(quantities, axis == 0 ? "x" : "px");
        return wanted != nullptr ? wanted->name : quantities[axis].name;
    }
};

/// A histogram of two columns as colours, and its sums along both of them. Pure functions.
struct HistogramPicture {
    std::uint32_t width = 0;           ///< bins of the first column
    std::uint32_t height = 0;          ///< bins of the second
    std::vector<std::uint8_t> pixels;  ///< RGBA, sRGB-encoded; the second column's last bin on top
};

/// Bins without weight are transparent, the others have the map's colours up to that of the greatest: by the
/// logarithm between the least and the greatest, or in proportion. Below zero counts as nothing.
HistogramPicture pictureOf(const StepHistogram& histogram, const ColorMap& map, bool logScale);

/// The weight in each bin of one of the two columns.
std::vector<double> marginalOf(const StepHistogram& histogram, std::size_t column);

}  // namespace mote::client
