// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/encode/vector/vector_drawing.h"

#include <gmock/gmock.h>

#include <cmath>
#include <cstdio>
#include <fstream>
#include <limits>
#include <random>

#include "tests/support/temp_dir.h"

namespace mote::server {
namespace {

using testing::HasSubstr;
using testing::Not;
using testing::StartsWith;

constexpr double infinity = std::numeric_limits<double>::infinity();

std::string textOf(const Result<std::vector<std::uint8_t>>& bytes) {
    EXPECT_TRUE(bytes.ok()) << (bytes.ok() ? "" : bytes.error().toString());
    return bytes.ok() ? std::string(bytes->begin(), bytes->end()) : "";
}

std::size_t countOf(const std::string& text, const std::string& part) {
    std::size_t count = 0;
    for (auto at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++count;
    return count;
}

/// Black dots and red ones, of a radius of 2 pixels.
VectorDrawing someDots(std::size_t count) {
    std::mt19937_64 random(3);
    std::uniform_real_distribution<float> unit(0.0F, 200.0F);
    VectorDrawing drawing{200, 200, glm::vec3(1.0F), std::nullopt, {}};
    for (std::size_t i = 0; i < count; ++i) {
        const glm::vec3 color = i % 2 == 0 ? glm::vec3(0.0F) : glm::vec3(1.0F, 0.0F, 0.0F);
        const float x = unit(random);
        drawing.dots.push_back({x, unit(random), infinity, 2.0F, 1.0F, color});
    }
    return drawing;
}

VectorDrawing withRaster(VectorDrawing drawing) {
    drawing.raster = render::Picture{200, 200, render::PixelFormat::srgb8, {}, 0};
    drawing.raster->pixels.assign(200 * 200 * 4, 200);
    return drawing;
}

Page page(proto::Page::Format format) {
    Page made;
    made.format = format;
    made.width = 120.0;
    made.margin = 10.0;
    return made;
}

TEST(VectorDrawing, svgHoldsEachDotWhereItBelongsInMillimetres) {
    auto drawing = someDots(0);
    drawing.dots.push_back({100.0F, 50.0F, infinity, 2.0F, 1.0F, glm::vec3(0.0F)});
    const auto text = textOf(drawVector(drawing, page(proto::Page::SVG)));
    EXPECT_THAT(text, HasSubstr("width=\"120mm\" height=\"120mm\" viewBox=\"0 0 120 120\""));
    EXPECT_THAT(text, HasSubstr("<circle cx=\"60\" cy=\"35\" r=\"1\" fill=\"#000000\"/>"));
}

TEST(VectorDrawing, dotsHaveTheDiameterAskedFor) {
    auto drawing = someDots(0);
    drawing.dots.push_back({100.0F, 50.0F, infinity, 2.0F, 1.0F, glm::vec3(0.0F)});
    drawing.dots.push_back({20.0F, 50.0F, infinity, 1.0F, 0.5F, glm::vec3(0.0F)});
    auto sheet = page(proto::Page::SVG);
    sheet.dot = 0.3;
    const auto text = textOf(drawVector(drawing, sheet));
    EXPECT_THAT(text, HasSubstr("r=\"0.15\""));
    // Half the light of white, though the page mixes encoded colours.
    EXPECT_THAT(text, HasSubstr("r=\"0.075\" fill=\"#787878\" fill-opacity=\"0.5\""));
}

TEST(VectorDrawing, eachColourIsALayer) {
    const auto text = textOf(drawVector(someDots(1000), page(proto::Page::SVG)));
    EXPECT_THAT(text, HasSubstr("inkscape:groupmode=\"layer\" inkscape:label=\"dots #000000\""));
    EXPECT_THAT(text, HasSubstr("inkscape:groupmode=\"layer\" inkscape:label=\"dots #ff0000\""));
    EXPECT_EQ(countOf(text, "<g "), 2u);
    EXPECT_EQ(countOf(text, "<circle "), 1000u);
}

TEST(VectorDrawing, coloursThatHideEachOtherInEitherOrderShareALayer) {
    const glm::vec3 red(1.0F, 0.0F, 0.0F), blue(0.0F, 0.0F, 1.0F);
    auto drawing = someDots(0);
    drawing.dots = {{50.0F, 50.0F, 1.0, 4.0F, 1.0F, red}, {52.0F, 50.0F, 2.0, 4.0F, 1.0F, blue}};
    const auto apart = textOf(drawVector(drawing, page(proto::Page::SVG)));
    EXPECT_LT(apart.find("dots #0000ff"), apart.find("dots #ff0000")) << "those behind are drawn first";
    drawing.dots.push_back({54.0F, 50.0F, 3.0, 4.0F, 1.0F, red});
    const auto mixed = textOf(drawVector(drawing, page(proto::Page::SVG)));
    EXPECT_EQ(countOf(mixed, "<g "), 1U);
    const auto far = mixed.find("#ff0000"), middle = mixed.find("#0000ff"), near = mixed.rfind("#ff0000");
    EXPECT_TRUE(far < middle && middle < near);
}

TEST(VectorDrawing, manyColoursShareALayer) {
    auto drawing = someDots(100);
    for (std::size_t i = 0; i < 100; ++i) drawing.dots[i].color.x = static_cast<float>(i) / 100.0F;
    const auto placed = placeOnPage(drawing, page(proto::Page::SVG));
    ASSERT_EQ(placed.layers.size(), 1u);
    EXPECT_EQ(placed.layers[0].name, "dots");
    EXPECT_EQ(placed.layers[0].dots.size(), 100u);
}

/// Of equal depth, the earlier lies in front, so it is drawn last.
TEST(VectorDrawing, dotsBehindAreDrawnFirst) {
    VectorDrawing drawing{100, 100, glm::vec3(1.0F), std::nullopt, {}};
    for (const double depth : {1.0, 3.0, 2.0, 3.0}) {
        drawing.dots.push_back({static_cast<float>(drawing.dots.size()), 0.0F, depth, 1.0F, 1.0F, {}});
    }
    auto sheet = page(proto::Page::SVG);
    sheet.width = 120.0;  // a millimetre a pixel, from 10
    const auto placed = placeOnPage(drawing, sheet);
    std::vector<double> order;
    for (const auto& dot : placed.layers.at(0).dots) order.push_back(dot.x - 10.0);
    EXPECT_THAT(order, testing::ElementsAre(3.0, 1.0, 2.0, 0.0));
}

TEST(VectorDrawing, plotterGetsStrokesInAShortOrder) {
    auto sheet = page(proto::Page::SVG);
    const auto drawing = someDots(2000);
    const auto wayOf = [&] {
        double way = 0.0;
        for (const auto& layer : placeOnPage(drawing, sheet).layers) {
            for (std::size_t i = 1; i < layer.dots.size(); ++i) {
                way +=
                    std::hypot(layer.dots[i].x - layer.dots[i - 1].x, layer.dots[i].y - layer.dots[i - 1].y);
            }
        }
        return way;
    };
    const double unordered = wayOf();
    sheet.plotter = true;
    // Steps of random order are 52 mm long on a side of 100 mm, those of neighbours sqrt(A / 1000) = 3 mm.
    EXPECT_LT(wayOf(), 0.1 * unordered);
    const auto text = textOf(drawVector(drawing, sheet));
    EXPECT_EQ(countOf(text, "<path "), 2000u);
    EXPECT_THAT(text, HasSubstr("stroke-linecap=\"round\""));
    EXPECT_THAT(text, HasSubstr("h0.01\" stroke=\"#000000\" stroke-width=\"2\"/>"));
}

TEST(VectorDrawing, epsAndPdfAreWhatTheyShouldBe) {
    const auto eps = textOf(drawVector(someDots(500), page(proto::Page::EPS)));
    EXPECT_THAT(eps, StartsWith("%!PS-Adobe-3.0 EPSF-3.0"));
    EXPECT_THAT(eps, HasSubstr("%%EOF"));
    EXPECT_THAT(eps, Not(HasSubstr("CreationDate")));
    const auto pdf = textOf(drawVector(someDots(500), page(proto::Page::PDF)));
    EXPECT_THAT(pdf, StartsWith("%PDF-1."));
    // 120 mm are 340.157 points. Cairo 1.18 packs what says so: another reader is asked.
    const test::TempDir folder;
    const auto path = (folder / "dots.pdf").string();
    std::ofstream(path, std::ios::binary) << pdf;
    const std::unique_ptr<FILE, int (*)(FILE*)> pipe(popen(("pdfinfo " + path).c_str(), "r"), pclose);
    std::string said(4096, '\0');
    said.resize(pipe ? std::fread(said.data(), 1, said.size(), pipe.get()) : 0);
    EXPECT_THAT(said, HasSubstr("340.15"));
}

TEST(VectorDrawing, epsIsAsLargeAsItsSheet) {
    auto sheet = page(proto::Page::EPS);
    sheet.width = 86.0;
    sheet.height = 64.5;  // 243.78 x 182.83 points of 1/72 inch
    const auto eps = textOf(drawVector(someDots(3), sheet));
    EXPECT_THAT(eps, HasSubstr("\n%%BoundingBox: 0 0 244 183\n%%HiResBoundingBox: 0 0 243.7795 182.8346\n"));
    EXPECT_THAT(eps, HasSubstr("\n%%PageBoundingBox: 0 0 244 183\n"));
}

/// Paleness is mixed in for EPS: Cairo would make an image of the page otherwise, of megabytes.
TEST(VectorDrawing, epsStaysVectors) {
    auto drawing = someDots(500);
    for (auto& dot : drawing.dots) dot.opacity = 0.5F;
    EXPECT_LT(textOf(drawVector(drawing, page(proto::Page::EPS))).size(), 100000u);
}

TEST(VectorDrawing, theRasterLiesBeneath) {
    const auto drawing = withRaster(someDots(10));
    const auto svg = textOf(drawVector(drawing, page(proto::Page::SVG)));
    EXPECT_LT(svg.find("<image x=\"10\" y=\"10\" width=\"100\" height=\"100\""), svg.find("<circle "));
    EXPECT_THAT(svg, HasSubstr("data:image/png;base64,iVBORw0KGgo"));
    EXPECT_THAT(textOf(drawVector(drawing, page(proto::Page::PDF))), HasSubstr("/Subtype /Image"));
    EXPECT_THAT(textOf(drawVector(drawing, page(proto::Page::EPS))), HasSubstr("/ImageType 1"));
}

/// Cairo writes dates to the second, and counts its surfaces.
TEST(VectorDrawing, sameDrawingSameBytesAtAnotherTime) {
    const auto drawing = withRaster(someDots(100));
    for (const auto format : {proto::Page::SVG, proto::Page::EPS, proto::Page::PDF}) {
        const auto first = textOf(drawVector(drawing, page(format)));
        EXPECT_THAT(first, Not(HasSubstr("CreationDate")));
        EXPECT_THAT(first, Not(HasSubstr("D:20")));
        EXPECT_TRUE(first == textOf(drawVector(drawing, page(format)))) << format;
    }
}

using Points = std::vector<render::StrokePoint>;

/// A drawing of one pen, on 200 x 200 pixels; a page of it is half a millimetre a pixel, from 10.
VectorDrawing strokesOf(const std::vector<Points>& lines, const std::vector<Points>& areas = {}) {
    auto strokes = std::make_shared<render::Strokes>();
    const auto add = [&](const Points& points) {
        const auto begin = static_cast<std::uint32_t>(strokes->points.size());
        strokes->points.insert(strokes->points.end(), points.begin(), points.end());
        return render::Stroke{begin, static_cast<std::uint32_t>(strokes->points.size())};
    };
    for (const auto& line : lines) strokes->lines.push_back(add(line));
    for (const auto& area : areas) {
        const auto index = static_cast<std::uint32_t>(strokes->outlines.size());
        strokes->outlines.push_back(add(area));
        strokes->areas.push_back({index, index + 1});
    }
    strokes->color = {1.0F, 0.0F, 0.0F};
    VectorDrawing drawing{200, 200, glm::vec3(1.0F), std::nullopt, {}};
    drawing.strokes = {strokes};
    return drawing;
}

TEST(VectorDrawing, linesOfOneWidthAreOnePath) {
    const auto drawing = strokesOf({{{1.0F, 2.0F, 2.0F}, {4.5F, 1.0F, 2.0F}, {4.0F, 9.0F, 2.0F}},
                                    {{50.0F, 60.0F, 2.0F}, {50.25F, 60.0F, 2.0F}},
                                    {{70.0F, 80.0F, 4.0F}}});
    const auto text = textOf(drawVector(drawing, page(proto::Page::SVG)));
    EXPECT_THAT(text, HasSubstr("<path stroke-width=\"200\" d=\"M100 200l350-100-50 800M5000 6000l25 0\"/>"));
    EXPECT_THAT(text, HasSubstr("<path stroke-width=\"400\" d=\"M7000 8000l0 0\"/>"));
    EXPECT_THAT(text, HasSubstr("transform=\"translate(10 10) scale(0.005)\""));
    EXPECT_THAT(text, HasSubstr("inkscape:label=\"ink #ff0000\""));
    EXPECT_THAT(text, HasSubstr("stroke=\"#ff0000\" stroke-linecap=\"round\" stroke-linejoin=\"round\""));
    EXPECT_THAT(text,
                HasSubstr("<clipPath id=\"edge\"><rect x=\"10\" y=\"10\" width=\"100\" height=\"100\"/>"));
}

TEST(VectorDrawing, aLineOfChangingWidthIsAnOutline) {
    const auto drawing = strokesOf({{{10.0F, 20.0F, 1.0F}, {40.0F, 20.0F, 0.0F}}});
    const auto text = textOf(drawVector(drawing, page(proto::Page::SVG)));
    EXPECT_THAT(text, HasSubstr("<path fill-rule=\"nonzero\" d=\"M1000 1950l"));
    EXPECT_THAT(text, Not(HasSubstr("stroke-width")));
}

TEST(VectorDrawing, areasAreFilledByTheEvenOddRule) {
    const Points triangle{{1.0F, 1.0F}, {3.0F, 1.0F}, {1.0F, 3.0F}};
    const auto text = textOf(drawVector(strokesOf({}, {triangle, triangle}), page(proto::Page::SVG)));
    EXPECT_THAT(text, HasSubstr("<g fill=\"#ff0000\" fill-rule=\"evenodd\">"));
    EXPECT_EQ(countOf(text, "<path d=\"M100 100l200 0-200 200z\"/>"), 2U);
}

TEST(VectorDrawing, strokesOutsideThePictureAreLeftOut) {
    const auto drawing = strokesOf({{{-1e6F, -1e6F, 2.0F}, {-5.0F, -5.0F, 2.0F}},
                                    {{-5.0F, 100.0F, 12.0F}, {-5.0F, 110.0F, 12.0F}, {-90.0F, 1e6F, 12.0F}},
                                    {{10.0F, 10.0F, 0.0F}, {20.0F, 10.0F, 0.0F}}});
    const auto ink = placeOnPage(drawing, page(proto::Page::SVG)).inks.at(0);
    ASSERT_EQ(ink.lines.size(), 1U);
    EXPECT_EQ(ink.lines.begin()->second.size(), 1U);
}

TEST(VectorDrawing, aPlotterDrawsLinesInAShortOrder) {
    std::mt19937_64 random(4);
    std::uniform_real_distribution<float> unit(0.0F, 200.0F);
    std::vector<Points> lines;
    for (int i = 0; i < 2000; ++i) {
        const render::StrokePoint at{unit(random), unit(random), 1.0F};
        lines.push_back({at});
    }
    auto sheet = page(proto::Page::SVG);
    const auto drawing = strokesOf(lines, {{{1.0F, 1.0F}, {3.0F, 1.0F}, {1.0F, 3.0F}}});
    const auto wayOf = [&] {
        const auto ink = placeOnPage(drawing, sheet).inks.at(0);
        const auto& paths = ink.lines.at(1.0);
        double way = 0.0;
        for (std::size_t i = 1; i < paths.size(); ++i)
            way +=
                std::hypot(paths.of(i)[0].x - paths.of(i - 1)[0].x, paths.of(i)[0].y - paths.of(i - 1)[0].y);
        return way;
    };
    const double unordered = wayOf();
    sheet.plotter = true;
    EXPECT_LT(wayOf(), 0.1 * unordered);
    const auto ink = placeOnPage(drawing, sheet).inks.at(0);
    EXPECT_TRUE(ink.areas.empty());
    EXPECT_EQ(ink.lines.at(1.0).size(), 2001U);
    std::size_t closed = 0;  // all but the area's outline have a length
    for (std::size_t i = 0; i < 2001; ++i) {
        const auto path = ink.lines.at(1.0).of(i);
        if (path.front() == path.back()) ++closed;
    }
    EXPECT_EQ(closed, 1U);
}

TEST(VectorDrawing, manyStrokesMakeASmallFile) {
    std::mt19937_64 random(5);
    std::uniform_real_distribution<float> unit(0.0F, 1.0F);
    std::vector<Points> lines;
    for (int i = 0; i < 200000; ++i) {
        Points points{{1280.0F * unit(random), 960.0F * unit(random), 0.5F + 2.0F * unit(random)}};
        for (int j = 0; j < 3; ++j) {
            points.push_back(points.back());
            points.back().x += 6.0F * unit(random) - 3.0F;
            points.back().y += 6.0F * unit(random) - 3.0F;
        }
        lines.push_back(points);
    }
    auto drawing = strokesOf(lines);
    drawing.width = 1280;
    drawing.height = 960;
    for (const auto format : {proto::Page::SVG, proto::Page::PDF}) {
        const auto bytes = drawVector(drawing, page(format));
        ASSERT_TRUE(bytes.ok());
        EXPECT_LT(bytes.value().size(), 10'000'000U) << format;
    }
}

TEST(VectorDrawing, epsAndPdfHoldStrokesAsShapes) {
    const auto drawing = strokesOf({{{10.0F, 20.0F, 2.0F}, {42.0F, 30.0F, 2.0F}}},
                                   {{{1.0F, 1.0F}, {3.0F, 1.0F}, {1.0F, 3.0F}}});
    const auto eps = textOf(drawVector(drawing, page(proto::Page::EPS)));
    EXPECT_THAT(eps, HasSubstr("f*"));  // filled by the even-odd rule
    EXPECT_THAT(eps, Not(HasSubstr("/ImageType")));
    const auto pdf = textOf(drawVector(drawing, page(proto::Page::PDF)));
    EXPECT_THAT(pdf, Not(HasSubstr("/Subtype /Image")));
    EXPECT_GT(pdf.size(), textOf(drawVector(someDots(0), page(proto::Page::PDF))).size());
}

TEST(VectorDrawing, inkThatFadesIsPale) {
    auto drawing = strokesOf({{{10.0F, 20.0F, 2.0F}, {42.0F, 30.0F, 2.0F}}},
                             {{{1.0F, 1.0F}, {3.0F, 1.0F}, {1.0F, 3.0F}}});
    const auto whole = textOf(drawVector(drawing, page(proto::Page::SVG)));
    EXPECT_THAT(whole, Not(HasSubstr("opacity")));
    auto strokes = *drawing.strokes[0];
    strokes.opacity = 0.25F;
    drawing.strokes = {std::make_shared<const render::Strokes>(strokes)};
    const auto svg = textOf(drawVector(drawing, page(proto::Page::SVG)));
    EXPECT_THAT(svg, HasSubstr("inkscape:label=\"ink #ff0000\" opacity=\"0.25\" transform="));
    EXPECT_EQ(countOf(svg, "opacity"), 1U) << "of all together";
    // The light of a quarter of red over white, and no image of the page.
    const auto eps = textOf(drawVector(drawing, page(proto::Page::EPS)));
    EXPECT_THAT(eps, HasSubstr("1 0.880825 0.880825 rg"));
    EXPECT_THAT(eps, Not(HasSubstr("/ImageType")));
    const auto pdf = textOf(drawVector(drawing, page(proto::Page::PDF)));
    EXPECT_THAT(pdf, Not(HasSubstr("/Subtype /Image")));
    EXPECT_THAT(pdf, HasSubstr("/ca 0.25"));
}

TEST(VectorDrawing, noDotsIsAnEmptySheet) {
    for (const auto format : {proto::Page::SVG, proto::Page::EPS, proto::Page::PDF}) {
        EXPECT_TRUE(drawVector(someDots(0), page(format)).ok());
    }
}

}  // namespace
}  // namespace mote::server
