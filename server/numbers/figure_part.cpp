// SPDX-License-Identifier: GPL-3.0-or-later
//
// Figures: the numbers of a HistogramPart or a StatisticsPart, drawn.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "protocol/quantity/manifest_columns.h"
#include "protocol/quantity/statistic.h"
#include "server/figures/draw_figure.h"
#include "server/numbers/query_parts.h"

namespace mote::server {
namespace {

constexpr std::size_t mostCells = std::size_t{1} << 24;  // of a waterfall

/// Means and moments of what lies in the bins, each bin's in its middle, with Sheppard's correction for the
/// bins' width.
RmsEllipse ellipseOf(const HistogramFigure& figure) {
    const auto &x = figure.axes[0].edges, &y = figure.axes[1].edges;
    const std::size_t rows = y.size() - 1;
    const auto middle = [](const std::vector<double>& edges, std::size_t i) {
        return 0.5 * (edges[i] + edges[i + 1]);
    };
    const auto sum = [&](const auto& of) {
        double total = 0.0;
        for (std::size_t i = 0; i + 1 < x.size(); ++i) {
            for (std::size_t j = 0; j < rows; ++j)
                total += figure.counts[i * rows + j] * of(middle(x, i), middle(y, j));
        }
        return total;
    };
    const double all = sum([](double, double) { return 1.0; });
    RmsEllipse ellipse;
    ellipse.meanX = sum([](double a, double) { return a; }) / all;
    ellipse.meanY = sum([](double, double b) { return b; }) / all;
    const double wideX = x[1] - x[0], wideY = y[1] - y[0];
    ellipse.xx = sum([&](double a, double) { return (a - ellipse.meanX) * (a - ellipse.meanX); }) / all -
                 wideX * wideX / 12.0;
    ellipse.yy = sum([&](double, double b) { return (b - ellipse.meanY) * (b - ellipse.meanY); }) / all -
                 wideY * wideY / 12.0;
    ellipse.xy = sum([&](double a, double b) { return (a - ellipse.meanX) * (b - ellipse.meanY); }) / all;
    return ellipse;
}

/// Of the particles themselves, if there are such statistics.
Result<std::optional<RmsEllipse>> ellipseOf(const HistogramPart::Axis& x, const HistogramPart::Axis& y,
                                            const StepQuestion& question) {
    proto::StatisticsQuery query;
    for (const auto& name : {"mean_" + x.column, "mean_" + y.column, "sigma_" + x.column, "sigma_" + y.column,
                             "cov_" + x.column + "__" + y.column}) {
        if (!findStatistic(name)) return std::optional<RmsEllipse>();
        query.add_names(name);
    }
    MOTE_ASSIGN_OR_RETURN(const auto part, statisticsPart(query));
    QueryAnswer answer;
    MOTE_RETURN_IF_ERROR(part->answer(question, answer));
    const auto& values = answer.message.statistics().values();
    return std::optional(
        RmsEllipse{values[0], values[1], values[2] * values[2], values[4], values[3] * values[3]});
}

std::string unitOfFurther(const std::string& statistic, const proto::ParticlesManifest& manifest) {
    const auto parsed = *parseQuantityStatistic(statistic);
    std::vector<std::string> units;
    for (const auto& quantity : parsed.quantities)
        units.push_back(unitOfQuantity(quantity, mote::columnsOf(manifest)));
    return parsed.unit(units);
}

void put(FigureDocument document, const FigureStyle& style, QueryAnswer& answer) {
    auto& message = *answer.message.mutable_figure();
    message.set_format(style.format);
    message.set_width(document.width);
    message.set_height(document.height);
    answer.payload = std::move(document.bytes);
}

/// What a drawing takes: pixels, and the document.
std::uint64_t drawingBytes(const FigureStyle& style, std::uint64_t cells) {
    const bool pixels = style.format == proto::FigureQuery::PNG;
    return 16 * cells + (pixels ? std::uint64_t{8} * style.pixelWidth() * style.pixelHeight() : 0) +
           (1 << 20);
}

/// The notes of all steps of a figure so far, each sentence once.
class FigureNotes {
  public:
    /// Takes those of one step, and says all of them in the answer.
    void pass(const proto::Answer& from, proto::Answer& to) {
        constexpr std::size_t most = 16;
        for (const auto& note : from.notes()) {
            if (notes_.size() < most && std::ranges::find(notes_, note) == notes_.end())
                notes_.push_back(note);
        }
        to.mutable_notes()->Assign(notes_.begin(), notes_.end());
    }

  private:
    std::vector<std::string> notes_;
};

/// Of two axes one figure a step; of one axis one of all steps.
class HistogramFigurePart final : public QueryPart {
  public:
    HistogramFigurePart(FigureStyle style, std::unique_ptr<HistogramPart> histogram, bool unweighted)
        : style_(std::move(style)), histogram_(std::move(histogram)), unweighted_(unweighted) {}

    bool ofAllSteps() const override { return histogram_->axes().size() == 1; }

    Status answer(const StepQuestion& question, QueryAnswer& answer) override {
        auto found = histogram_->count(question, answer.message);
        MOTE_RETURN_IF_ERROR(found, "histogram");
        if (ofAllSteps()) notes_.pass(answer.message, answer.message);
        auto counted = *std::move(found);
        const auto& manifest = question.manifest();
        const CountUnit unit{!unweighted_, manifest.weight_unit()};
        HistogramFigure figure{{}, std::move(counted.counts), unit};
        for (std::size_t i = 0; i < counted.edges.size(); ++i) {
            const auto& column = histogram_->axes()[i].column;
            figure.axes.push_back(
                {column, unitOfQuantity(column, mote::columnsOf(manifest)), std::move(counted.edges[i])});
        }
        const bool alone = times_.empty() && answer.message.last();
        if (ofAllSteps() && !alone) return addStep(std::move(figure), question, answer);
        if (style_.ellipse) {
            MOTE_ASSIGN_OR_RETURN(figure.ellipse,
                                  ellipseOf(histogram_->axes()[0], histogram_->axes()[1], question));
            if (!figure.ellipse) figure.ellipse = ellipseOf(figure);
        }
        MOTE_ASSIGN_OR_RETURN(answer.memory, question.take(drawingBytes(style_, figure.counts.size())));
        MOTE_ASSIGN_OR_RETURN(auto document, drawHistogram(figure, style_));
        put(std::move(document), style_, answer);
        return success();
    }

  private:
    Status addStep(HistogramFigure figure, const StepQuestion& question, QueryAnswer& answer) {
        if (counts_.size() + figure.counts.size() > mostCells) {
            return Error{ErrorCode::resourceExhausted, "histogram.axes[0].bins",
                         fmt::format("a waterfall has at most {} bins in all steps together", mostCells)};
        }
        times_.push_back(answer.message.time());
        counts_.insert(counts_.end(), figure.counts.begin(), figure.counts.end());
        if (!answer.message.last()) return success();
        MOTE_ASSIGN_OR_RETURN(answer.memory, question.take(drawingBytes(style_, counts_.size())));
        const WaterfallFigure waterfall{std::move(figure.axes[0]), std::move(times_), std::move(counts_),
                                        figure.unit};
        MOTE_ASSIGN_OR_RETURN(auto document, drawWaterfall(waterfall, style_));
        put(std::move(document), style_, answer);
        return success();
    }

    const FigureStyle style_;
    const std::unique_ptr<HistogramPart> histogram_;
    const bool unweighted_;
    std::vector<double> times_, counts_;  // of a waterfall, so far
    FigureNotes notes_;                   // of a waterfall
};

class StatisticsFigurePart final : public QueryPart {
  public:
    StatisticsFigurePart(FigureStyle style, std::unique_ptr<QueryPart> statistics, StatisticsFigure figure)
        : style_(std::move(style)), statistics_(std::move(statistics)), figure_(std::move(figure)) {}

    bool ofAllSteps() const override { return true; }

    Status answer(const StepQuestion& question, QueryAnswer& answer) override {
        QueryAnswer numbers;
        MOTE_RETURN_IF_ERROR(statistics_->answer(question, numbers), "statistics");
        notes_.pass(numbers.message, answer.message);
        figure_.times.push_back(answer.message.time());
        for (auto& series : figure_.series) {
            if (!findStatistic(series.name)) series.unit = unitOfFurther(series.name, question.manifest());
        }
        for (std::size_t i = 0; i < figure_.series.size(); ++i)
            figure_.series[i].values.push_back(numbers.message.statistics().values(static_cast<int>(i)));
        if (!answer.message.last()) return success();
        MOTE_ASSIGN_OR_RETURN(answer.memory, question.take(drawingBytes(style_, figure_.times.size())));
        MOTE_ASSIGN_OR_RETURN(auto document, drawStatistics(figure_, style_));
        put(std::move(document), style_, answer);
        return success();
    }

  private:
    const FigureStyle style_;
    const std::unique_ptr<QueryPart> statistics_;
    StatisticsFigure figure_;  // of the steps so far
    FigureNotes notes_;
};

MadePart statisticsFigurePart(const proto::FigureQuery& query, FigureStyle style) {
    proto::StatisticsQuery asked;
    StatisticsFigure figure;
    for (int i = 0; i < query.statistics_size(); ++i) {
        const auto& name = query.statistics(i);
        const auto found = findStatistic(name);
        if (!found && !parseQuantityStatistic(name)) {
            return Error{
                ErrorCode::notFound, fmt::format("statistics[{}]", i),
                fmt::format("there is no statistic \"{}\"; docs/NUMBERS.md lists them", name.substr(0, 64))};
        }
        asked.add_names(name);
        figure.series.push_back({name, found ? statistics()[*found].unit : "", {}});
    }
    MOTE_ASSIGN_OR_RETURN(auto part, statisticsPart(asked));
    return MadePart(
        std::make_unique<StatisticsFigurePart>(std::move(style), std::move(part), std::move(figure)));
}

}  // namespace

MadePart figurePart(const proto::FigureQuery& query) {
    MOTE_ASSIGN_OR_RETURN(auto style, parseFigureStyle(query));
    if (!query.has_histogram()) return statisticsFigurePart(query, std::move(style));
    auto histogram = HistogramPart::make(query.histogram());
    MOTE_RETURN_IF_ERROR(histogram, "histogram");
    return MadePart(std::make_unique<HistogramFigurePart>(std::move(style), *std::move(histogram),
                                                          query.histogram().unweighted()));
}

}  // namespace mote::server
