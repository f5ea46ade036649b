// SPDX-License-Identifier: GPL-3.0-or-later
//
// The shrinker: what it leaves still fails and has nothing that could be left out.
#include <gtest/gtest.h>

#include "protocol/base/json.h"
#include "protocol/scene/view.h"
#include "tests/views/shrinker.h"
#include "tests/views/view_generator.h"

namespace mote::test {
namespace {

bool hasDiscs(const proto::View& view) {
    for (const auto& layer : view.layers())
        if (layer.hybrid().point_shape() == "disc" && layer.hybrid().has_point_opacity()) return true;
    return false;
}

TEST(Shrinker, LeavesOnlyWhatFails) {
    int shrunkViews = 0;
    for (std::uint64_t i = 0; i < 300; ++i) {
        const auto view = generatedView(6, i);
        if (!hasDiscs(view)) continue;
        ++shrunkViews;
        const auto small = shrunk(view, hasDiscs);
        EXPECT_TRUE(hasDiscs(small));
        EXPECT_TRUE(parseView(small).ok()) << toJson(small);
        EXPECT_EQ(small.width(), 1U);
        EXPECT_EQ(small.height(), 1U);
        ASSERT_EQ(small.layers_size(), 1) << toJson(small);
        const auto& style = small.layers(0).hybrid();
        EXPECT_TRUE(style.curve().empty() && style.clip_planes().empty() && !style.has_light() &&
                    small.layers(0).transform().empty() && !small.has_camera())
            << toJson(small);
    }
    EXPECT_GE(shrunkViews, 10);
}

TEST(Shrinker, AViewThatDoesNotFailStaysAsItIs) {
    const auto view = generatedView(6, 1);
    const auto same = shrunk(view, [](const proto::View&) { return false; });
    EXPECT_EQ(same.SerializeAsString(), view.SerializeAsString());
}

TEST(Shrinker, RoundsNumbersThatMustStay) {
    auto view = generatedView(6, 1);
    view.mutable_background()->Resize(3, 0.0);
    view.set_background(1, 0.123456789);
    const auto small = shrunk(view, [](const proto::View& other) {
        return other.background_size() == 3 && other.background(1) > 0.05;
    });
    EXPECT_EQ(small.background(1), 0.1);
}

}  // namespace
}  // namespace mote::test
