// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/figures/draw_figure.h"

#include <OpenImageIO/imageio.h>
#include <expat.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <string>
#include <thread>

#include "tests/support/temp_dir.h"

namespace mote::server {
namespace {

using Format = proto::FigureQuery::Format;
using Bytes = std::vector<std::uint8_t>;

std::vector<double> evenEdges(double low, double high, std::size_t bins) {
    std::vector<double> edges;
    for (std::size_t i = 0; i <= bins; ++i)
        edges.push_back(low + (high - low) * static_cast<double>(i) / static_cast<double>(bins));
    return edges;
}

/// Counts of all kinds: none, small and large ones, less than none, no numbers.
std::vector<double> anyCounts(std::size_t size, std::mt19937& random) {
    std::uniform_int_distribution<int> kind(0, 20), all(0, 5);
    std::uniform_real_distribution<double> power(-15.0, 15.0);
    const int one = all(random);
    std::vector<double> counts(size);
    for (auto& count : counts) {
        const int of = one == 0 ? 0 : kind(random);
        count = of < 5 ? 0.0 : std::pow(10.0, power(random));
        if (one > 2 && of == 19) count = -count;
        if (one > 3 && of == 20) count = std::nan("");
        if (one > 4 && of == 18) count = std::numeric_limits<double>::infinity();
    }
    return counts;
}

/// Whether a document of the format opens.
void expectOpens(const FigureDocument& document, Format format) {
    ASSERT_GT(document.bytes.size(), 100u);
    const std::string text(document.bytes.begin(), document.bytes.end());
    if (format == proto::FigureQuery::PNG) {
        const test::TempDir folder;
        const auto path = (folder.path() / "figure.png").string();
        FILE* const file = std::fopen(path.c_str(), "wb");
        ASSERT_NE(file, nullptr);
        std::fwrite(document.bytes.data(), 1, document.bytes.size(), file);
        std::fclose(file);
        const auto input = OIIO::ImageInput::open(path);
        ASSERT_NE(input, nullptr) << OIIO::geterror();
        EXPECT_EQ(input->spec().width, static_cast<int>(document.width));
        EXPECT_EQ(input->spec().height, static_cast<int>(document.height));
        std::vector<std::uint8_t> pixels(std::size_t{4} * document.width * document.height);
        EXPECT_TRUE(
            input->read_image(0, 0, 0, input->spec().nchannels, OIIO::TypeDesc::UINT8, pixels.data()));
        return;
    }
    EXPECT_EQ(document.width, 0u);
    if (format == proto::FigureQuery::PDF) {
        EXPECT_EQ(text.rfind("%PDF-", 0), 0u);
        EXPECT_NE(text.rfind("%%EOF"), std::string::npos);
        return;
    }
    // Beside the letters of an image's bytes.
    std::string shapes = text;
    for (auto at = shapes.find("base64,"); at != std::string::npos; at = shapes.find("base64,", at + 1))
        shapes.erase(at + 7, shapes.find('"', at) - at - 7);
    for (const char before : {'"', 'M', 'L', ' ', '-'}) {
        EXPECT_EQ(shapes.find(before + std::string("nan")), std::string::npos);
        EXPECT_EQ(shapes.find(before + std::string("inf")), std::string::npos);
    }
    XML_Parser parser = XML_ParserCreate(nullptr);
    const auto status = XML_Parse(parser, text.data(), static_cast<int>(text.size()), 1);
    EXPECT_EQ(status, XML_STATUS_OK) << XML_ErrorString(XML_GetErrorCode(parser));
    XML_ParserFree(parser);
}

FigureStyle anyStyle(std::mt19937& random, int trial) {
    constexpr Format formats[] = {proto::FigureQuery::PNG, proto::FigureQuery::SVG, proto::FigureQuery::PDF};
    std::uniform_real_distribution<double> side(20.0, 200.0);
    std::bernoulli_distribution coin;
    FigureStyle style;
    style.format = formats[trial % 3];
    style.width = side(random);
    style.height = side(random);
    style.fontPoints = std::min({8.0, style.width * 0.28, style.height * 0.28});
    style.dotsPerInch = 60.0;
    style.dark = coin(random);
    style.logScale = coin(random);
    style.marginals = coin(random);
    style.ellipse = coin(random);
    if (coin(random)) style.title = "a<b> & \"c\" \u05d0\u202e\u4e2d \xff " + std::string(trial % 200, 'w');
    return style;
}

HistogramFigure anyHistogram(std::mt19937& random, std::size_t axes) {
    std::uniform_int_distribution<std::size_t> bins(1, 60);
    std::uniform_real_distribution<double> power(-12.0, 12.0), share(-1.0, 1.0);
    HistogramFigure figure;
    std::size_t cells = 1;
    for (std::size_t i = 0; i < axes; ++i) {
        const double size = std::pow(10.0, power(random)), low = size * share(random);
        const std::size_t count = bins(random);
        figure.axes.push_back(
            {i == 0 ? "x" : "px", i == 0 ? "m" : "eV/c", evenEdges(low, low + size, count)});
        cells *= count;
    }
    figure.counts = anyCounts(cells, random);
    figure.unit = {share(random) > 0.0, share(random) > 0.0 ? "C" : "1"};
    figure.ellipse = RmsEllipse{share(random), share(random), share(random), share(random), share(random)};
    return figure;
}

TEST(DrawFigure, everyHistogramGivesADocumentThatOpens) {
    std::mt19937 random(1);
    for (int trial = 0; trial < 120; ++trial) {
        SCOPED_TRACE(trial);
        const auto style = anyStyle(random, trial);
        const auto document = drawHistogram(anyHistogram(random, 1 + trial % 2), style);
        ASSERT_TRUE(document.ok()) << document.error().toString();
        expectOpens(*document, style.format);
    }
}

TEST(DrawFigure, everyWaterfallAndEverySeriesGivesADocumentThatOpens) {
    std::mt19937 random(2);
    std::uniform_int_distribution<std::size_t> steps(1, 40), bins(1, 30);
    constexpr const char* names[] = {"norm_emit_x", "norm_emit_y", "sigma_x", "mean_energy", "halo_h_x"};
    constexpr const char* units[] = {"m", "m", "m", "eV", "1"};
    for (int trial = 0; trial < 60; ++trial) {
        SCOPED_TRACE(trial);
        auto style = anyStyle(random, trial);
        style.height = std::max(style.height, 100.0);
        const std::size_t count = steps(random), cells = bins(random);
        std::vector<double> times = anyCounts(count, random);
        // Half of them ascend, unevenly.
        for (std::size_t i = 0; i < count && trial % 2 == 0; ++i)
            times[i] = static_cast<double>(i) * static_cast<double>(i + 1) * 1e-9;
        const WaterfallFigure waterfall{{"delta", "1", evenEdges(-1e-3, 1e-3, cells)},
                                        times,
                                        anyCounts(count * cells, random),
                                        {true, "1"}};
        const auto drawn = drawWaterfall(waterfall, style);
        ASSERT_TRUE(drawn.ok()) << drawn.error().toString();
        expectOpens(*drawn, style.format);
        StatisticsFigure statistics{times, {}};
        for (std::size_t i = 0; i <= static_cast<std::size_t>(trial % 5); ++i)
            statistics.series.push_back({names[i], units[i], anyCounts(count, random)});
        const auto lines = drawStatistics(statistics, style);
        ASSERT_TRUE(lines.ok()) << lines.error().toString();
        expectOpens(*lines, style.format);
    }
}

TEST(DrawFigure, theSameNumbersGiveTheSameBytesOnAnyThread) {
    for (const Format format : {proto::FigureQuery::PNG, proto::FigureQuery::SVG, proto::FigureQuery::PDF}) {
        const auto draw = [format] {
            std::mt19937 random(3);
            const auto figure = anyHistogram(random, 2);
            FigureStyle style;
            style.format = format;
            style.title = "Title";
            style.marginals = style.ellipse = true;
            return drawHistogram(figure, style)->bytes;
        };
        const Bytes first = draw();
        std::vector<Bytes> others(4);
        std::vector<std::thread> threads;
        for (auto& other : others) threads.emplace_back([&other, &draw] { other = draw(); });
        for (auto& thread : threads) thread.join();
        for (const auto& other : others) EXPECT_EQ(other, first);
    }
}

/// Pixels that are darker than half of a white PNG, by column.
std::vector<int> inkByColumn(const FigureDocument& document) {
    const test::TempDir folder;
    const auto path = (folder.path() / "figure.png").string();
    FILE* const file = std::fopen(path.c_str(), "wb");
    std::fwrite(document.bytes.data(), 1, document.bytes.size(), file);
    std::fclose(file);
    const auto input = OIIO::ImageInput::open(path);
    std::vector<std::uint8_t> pixels(std::size_t{3} * document.width * document.height);
    EXPECT_TRUE(input->read_image(0, 0, 0, 3, OIIO::TypeDesc::UINT8, pixels.data()));
    std::vector<int> ink(document.width, 0);
    for (std::size_t i = 0; i < pixels.size() / 3; ++i) {
        // Of the blue of the first series: red is gone.
        if (pixels[3 * i] < 90 && pixels[3 * i + 2] > 120) ++ink[i % document.width];
    }
    return ink;
}

TEST(DrawFigure, aNumberThatIsNotThereLeavesAGap) {
    FigureStyle style;
    style.format = proto::FigureQuery::PNG;
    StatisticsFigure figure;
    for (int i = 0; i < 100; ++i) figure.times.push_back(i * 1e-9);
    figure.series = {{"sigma_x", "m", std::vector<double>(100, 1e-3)}};
    const auto inked = [&] {
        int columns = 0;
        for (const int ink : inkByColumn(*drawStatistics(figure, style))) columns += ink > 0 ? 1 : 0;
        return columns;
    };
    const int whole = inked();
    for (std::size_t i = 40; i < 60; ++i) figure.series[0].values[i] = std::nan("");
    // A fifth of the steps is not there; the ends of the lines reach half a step further at most.
    EXPECT_NEAR(inked(), 0.79 * whole, 0.02 * whole);
    figure.series[0].values.assign(100, std::nan(""));
    EXPECT_EQ(inked(), 0);
}

TEST(DrawFigure, panelsThatHaveNoRoomAreRefused) {
    FigureStyle style;
    style.height = 30.0;
    StatisticsFigure figure{{0.0, 1.0}, {}};
    for (const char* name : {"sigma_x", "mean_x", "emit_x", "min_x", "max_x"})
        figure.series.push_back({name, "m", {1.0, 2.0}});
    const auto drawn = drawStatistics(figure, style);
    ASSERT_FALSE(drawn.ok());
    EXPECT_EQ(drawn.error().where, "height");
}

}  // namespace
}  // namespace mote::server
