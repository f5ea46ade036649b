// SPDX-License-Identifier: GPL-3.0-or-later
#include "protocol/scene/figure_style.h"

#include <gtest/gtest.h>

#include <limits>
#include <string>

namespace mote {
namespace {

proto::FigureQuery plain() {
    proto::FigureQuery query;
    query.set_format(proto::FigureQuery::SVG);
    query.mutable_histogram()->add_axes()->set_column("x");
    return query;
}

std::string fieldOf(const proto::FigureQuery& query) {
    const auto parsed = parseFigureStyle(query);
    return parsed.ok() ? std::string() : parsed.error().where;
}

TEST(FigureStyle, fillsEveryDefault) {
    const auto style = parseFigureStyle(plain());
    ASSERT_TRUE(style.ok());
    EXPECT_EQ(style->width, 85.0);
    EXPECT_EQ(style->height, 63.75);
    EXPECT_EQ(style->fontPoints, 8.0);
    EXPECT_EQ(style->colorMap.name(), "viridis");
    EXPECT_EQ(style->pixelWidth(), 669u);
    auto small = plain();
    small.set_width(12.0);
    EXPECT_TRUE(parseFigureStyle(small).ok());
}

TEST(FigureStyle, whatIsWrongIsSaidWithItsField) {
    const double nan = std::numeric_limits<double>::quiet_NaN();
    auto query = plain();
    query.clear_format();
    EXPECT_EQ(fieldOf(query), "format");
    query = plain();
    query.add_statistics("sigma_x");
    EXPECT_EQ(fieldOf(query), "histogram");
    query.clear_histogram();
    EXPECT_EQ(fieldOf(query), "");
    query.set_log_scale(true);
    EXPECT_EQ(fieldOf(query), "logScale");
    query.set_log_scale(false);
    for (int i = 0; i < 16; ++i) query.add_statistics("sigma_x");
    EXPECT_EQ(fieldOf(query), "statistics");
    query = plain();
    query.mutable_histogram()->clear_axes();
    EXPECT_EQ(fieldOf(query), "histogram.axes");
    for (const double value : {nan, 0.0, -1.0, 1e9}) {
        query = plain();
        query.set_width(value);
        EXPECT_EQ(fieldOf(query), "width");
        query = plain();
        query.set_height(value);
        EXPECT_EQ(fieldOf(query), "height");
        query = plain();
        query.set_font_points(value);
        EXPECT_EQ(fieldOf(query), "fontPoints");
        query = plain();
        query.set_dots_per_inch(value);
        EXPECT_EQ(fieldOf(query), "dotsPerInch");
    }
    query = plain();
    query.set_font_points(30.0);
    EXPECT_EQ(fieldOf(query), "fontPoints");
    query = plain();
    query.set_format(proto::FigureQuery::PNG);
    query.set_width(2000.0);
    query.set_dots_per_inch(4800.0);
    EXPECT_EQ(fieldOf(query), "dotsPerInch");
    query = plain();
    query.set_marginals(true);
    EXPECT_EQ(fieldOf(query), "marginals");
    query = plain();
    query.set_ellipse(true);
    EXPECT_EQ(fieldOf(query), "ellipse");
    query = plain();
    query.set_color_map("no such map");
    EXPECT_EQ(fieldOf(query), "colorMap");
    for (const std::string& title :
         {std::string("two\nlines"), std::string(10000, 'a'), std::string("\0", 1)}) {
        query = plain();
        query.set_title(title);
        EXPECT_EQ(fieldOf(query), "title");
    }
}

}  // namespace
}  // namespace mote
