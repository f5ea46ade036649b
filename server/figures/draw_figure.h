// SPDX-License-Identifier: GPL-3.0-or-later
//
// Figures of numbers, fit for a paper: histograms in one and two dimensions, waterfalls and statistics over
// the steps of a run, as PNG, SVG or PDF (docs/NUMBERS.md, "Figures"). Pure functions, any thread: the same
// numbers give the same bytes.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "protocol/base/error.h"
#include "protocol/scene/figure_style.h"

namespace mote::server {

/// An axis of a histogram.
struct FigureAxis {
    std::string quantity;       ///< a column or derived quantity
    std::string unit;           ///< its unit: "m", "eV/c", ...
    std::vector<double> edges;  ///< ascending, one more than bins, at least two
};

/// The means and the second moments about them of two quantities.
struct RmsEllipse {
    double meanX = 0.0, meanY = 0.0;
    double xx = 0.0, xy = 0.0, yy = 0.0;
};

/// What counts are of.
struct CountUnit {
    bool weighted = true;    ///< each particle counts its weight
    std::string weightUnit;  ///< "1": real particles, "C", "": not known
};

struct HistogramFigure {
    std::vector<FigureAxis> axes;  ///< one or two
    std::vector<double> counts;    ///< of the second axis fastest
    CountUnit unit;
    std::optional<RmsEllipse> ellipse = {};  ///< drawn if the style says so
};

/// A histogram of one axis over all steps.
struct WaterfallFigure {
    FigureAxis axis;
    std::vector<double> times;   ///< s, of each step
    std::vector<double> counts;  ///< step after step
    CountUnit unit;
};

struct StatisticsFigure {
    struct Series {
        std::string name;  ///< of docs/NUMBERS.md
        std::string unit;
        std::vector<double> values;  ///< one a step; what is not finite leaves a gap
    };
    std::vector<double> times;   ///< s, of each step
    std::vector<Series> series;  ///< those of one unit share a panel
};

struct FigureDocument {
    std::vector<std::uint8_t> bytes;
    std::uint32_t width = 0, height = 0;  ///< pixels of a PNG, else 0
};

/// Counts that are not finite are left white, as empty bins are. Errors: resourceExhausted (memory),
/// internal; invalidArgument (edges that are not finite).
Result<FigureDocument> drawHistogram(const HistogramFigure& figure, const FigureStyle& style);
/// If times do not ascend or are not finite, the number of the step stands in their place.
Result<FigureDocument> drawWaterfall(const WaterfallFigure& figure, const FigureStyle& style);
/// Likewise.
Result<FigureDocument> drawStatistics(const StatisticsFigure& figure, const FigureStyle& style);

}  // namespace mote::server
