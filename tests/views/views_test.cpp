// SPDX-License-Identifier: GPL-3.0-or-later
//
// A fixed part of the generated views, held to what any legal view owes: see view_check.h. More of them:
// tests/views/check --seed S --count N.
#include <gtest/gtest.h>

#include <algorithm>

#include "tests/views/view_check.h"
#include "tests/views/view_data.h"
#include "tests/views/view_drawer.h"
#include "tests/views/view_generator.h"
#include "tests/views/view_report.h"

namespace mote::test {
namespace {

using Kind = Verdict::Kind;

/// What the views of a fixed part come to now; what they must come to all together is ViewReport::good().
struct Fixed {
    std::string device;
    std::uint64_t count;
    double nearShare;  ///< least share of the decided views at 45 dB or more
    double least;      ///< dB, of all
};

class FixedViews : public testing::TestWithParam<Fixed> {};

TEST_P(FixedViews, AreLikeTheReference) {
    const auto& [device, count, nearShare, least] = GetParam();
    const auto check = viewCheckOf("difference", device);
    ViewReport report("difference");
    double decided = 0.0, close = 0.0;
    for (std::uint64_t i = 0; i < count; ++i) {
        const auto verdict = check->check(generatedView(1, i, {400}));
        report.add(std::to_string(i), verdict);
        ASSERT_NE(verdict.kind, Kind::broken) << i << ": " << verdict.text;
        if (verdict.kind != Kind::measured) continue;
        decided += 1.0;
        close += verdict.psnr >= 45.0 ? 1.0 : 0.0;
        EXPECT_GE(verdict.psnr, least) << i;
    }
    EXPECT_GE(close / decided, nearShare) << report.toString();
    RecordProperty("report", report.toString());
}

TEST_P(FixedViews, Survive) {
    const auto check = viewCheckOf("survival", GetParam().device);
    for (std::uint64_t i = 0; i < GetParam().count; ++i) {
        const auto verdict = check->check(generatedView(2, i, {65536}));
        EXPECT_EQ(verdict.kind, Kind::measured) << i << ": " << verdict.text;
    }
}

/// Layers of matter in place of which there are two that share their opacity.
TEST_P(FixedViews, StayWhatTheyAreWhereTheyDissolve) {
    const auto check = viewCheckOf("dissolve", GetParam().device);
    for (std::uint64_t i = 0; i < GetParam().count; ++i) {
        const auto verdict = check->check(generatedView(4, i, {400}));
        ASSERT_EQ(verdict.kind, Kind::measured) << i << ": " << verdict.text;
        EXPECT_GE(verdict.psnr, 45.0) << i;
    }
}

/// A layer that is hidden, or of which there is nothing, is as good as none.
TEST_P(FixedViews, AreTheSameWithoutWhatIsNotThere) {
    const auto drawer = drawerOf(GetParam().device);
    ViewData data;
    for (std::uint64_t i = 0; i < GetParam().count; ++i) {
        auto with = generatedView(8, i, {400}), without = with;
        if (with.layers().empty()) continue;
        const int index = static_cast<int>(i % static_cast<std::uint64_t>(with.layers_size()));
        i % 3 == 0 ? with.mutable_layers(index)->set_opacity(0.0)
                   : with.mutable_layers(index)->set_hidden(true);
        without.mutable_layers()->DeleteSubrange(index, 1);
        // Paper stays where all drawings on it are hidden; a view without layers has none.
        const bool seen = std::ranges::any_of(without.layers(), [](const proto::Layer& layer) {
            return !layer.hidden() && (!layer.has_opacity() || layer.opacity() > 0.0);
        });
        if (!seen && with.background().empty()) {
            for (auto* view : {&with, &without}) view->mutable_background()->Resize(3, 0.0);
        }
        const auto pixels = [&](const proto::View& view) {
            return drawer->draw(*data.scene(view), render::Quality::exact()).pixels;
        };
        EXPECT_EQ(pixels(with), pixels(without)) << i;
    }
}

INSTANTIATE_TEST_SUITE_P(All, FixedViews,
                         testing::Values(Fixed{"cpu", 100, 0.99, 40.0}, Fixed{"egl", 24, 0.95, 40.0},
                                         Fixed{"ranks", 20, 0.99, 40.0}),
                         [](const auto& fixed) { return fixed.param.device; });

TEST(FixedViewsByVectors, HaveTheSameBytes) {
    const auto check = viewCheckOf("bytes", "cpu");
    for (std::uint64_t i = 0; i < 100; ++i) {
        const auto verdict = check->check(generatedView(3, i, {400}));
        ASSERT_EQ(verdict.kind, Kind::measured) << i << ": " << verdict.text;
        EXPECT_LE(verdict.worst, 1) << i;
    }
}

}  // namespace
}  // namespace mote::test
