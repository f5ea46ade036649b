// SPDX-License-Identifier: GPL-3.0-or-later
#include "protocol/scene/page.h"

#include <gtest/gtest.h>

#include <limits>

#include "server/encode/vector/vector_drawing.h"

namespace mote::server {
namespace {

proto::Page message(double width, double height, double margin) {
    proto::Page page;
    page.set_format(proto::Page::PDF);
    page.set_width(width);
    page.set_height(height);
    page.set_margin(margin);
    return page;
}

PageLayout layoutOf(double width, double height, double margin) {
    const auto page = parsePage(message(width, height, margin));
    EXPECT_TRUE(page.ok());
    return layOut(*page, 400, 200);
}

TEST(Page, fitsThePictureBetweenItsMargins) {
    const auto wide = layoutOf(220, 300, 10);
    EXPECT_DOUBLE_EQ(wide.scale, 0.5);
    EXPECT_DOUBLE_EQ(wide.x(0), 10.0);
    EXPECT_DOUBLE_EQ(wide.x(400), 210.0);
    EXPECT_DOUBLE_EQ(wide.y(0), 100.0);
    EXPECT_DOUBLE_EQ(wide.y(200), 200.0);
    const auto high = layoutOf(1000, 120, 10);
    EXPECT_DOUBLE_EQ(high.scale, 0.5);
    EXPECT_DOUBLE_EQ(high.y(0), 10.0);
    EXPECT_DOUBLE_EQ(high.x(200), 500.0);
}

TEST(Page, aSideThatIsNotGivenFollowsFromThePicture) {
    EXPECT_DOUBLE_EQ(layoutOf(220, 0, 10).height, 120.0);
    EXPECT_DOUBLE_EQ(layoutOf(0, 120, 10).width, 220.0);
    EXPECT_DOUBLE_EQ(layoutOf(0, 0, 0).width, 400 * 25.4 / 96);
}

TEST(Page, whatIsNoSheetIsRefusedWithItsField) {
    const auto fieldOf = [](const proto::Page& page) {
        const auto parsed = parsePage(page);
        return parsed.ok() ? std::string() : parsed.error().where;
    };
    EXPECT_EQ(fieldOf(proto::Page()), "format");
    EXPECT_EQ(fieldOf(message(-1, 0, 0)), "width");
    EXPECT_EQ(fieldOf(message(0, 1e9, 0)), "height");
    EXPECT_EQ(fieldOf(message(100, 0, std::numeric_limits<double>::quiet_NaN())), "margin");
    EXPECT_EQ(fieldOf(message(100, 100, 50)), "margin");
    auto dot = message(100, 100, 5);
    dot.set_dot(1000);
    EXPECT_EQ(fieldOf(dot), "dot");
}

}  // namespace
}  // namespace mote::server
