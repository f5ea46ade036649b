// SPDX-License-Identifier: GPL-3.0-or-later
//
// Which pictures a view between steps is the mean of.
#include "protocol/scene/view_parts.h"

#include <gtest/gtest.h>

#include <map>
#include <vector>

#include "tests/support/random.h"
#include "tests/support/view_text.h"

namespace mote::test {
namespace {

/// Of a layer that goes from step 2 to step 5, unless another.
View viewOfShares(const std::vector<double>& shares) {
    View view;
    for (const double share : shares)
        view.layers.push_back(
            {.dataset = "a/b", .step = 2, .style = *parseHybridStyle({}), .towards = Towards{5, share}});
    return view;
}

std::vector<std::uint32_t> stepsOf(const View& view) {
    std::vector<std::uint32_t> steps;
    for (const auto& layer : view.layers) steps.push_back(layer.step);
    return steps;
}

TEST(ViewParts, OfWhatIsInOneStepIsOnlyOne) {
    const std::vector<ViewPart> all{{nearestPlace, 1.0}};
    EXPECT_EQ(viewParts(View()), all);
    EXPECT_EQ(viewParts(viewOf("{'width': 8, 'height': 8, 'layers': [{'dataset': 'a/b', 'particles': {}}]}")),
              all);
    for (const double share : {0.0, 1.0}) {
        const View view = viewOfShares({share});
        EXPECT_EQ(viewParts(view), all);
        const View shown = viewAt(view, nearestPlace);
        EXPECT_EQ(shown.layers[0].step, share == 0.0 ? 2U : 5U);
        EXPECT_FALSE(shown.layers[0].towards);
    }
    View still = viewOfShares({0.4});
    still.layers[0].towards->step = 2;
    EXPECT_EQ(viewParts(still), all);
    EXPECT_FALSE(viewAt(still, nearestPlace).layers[0].towards);
    View unseen = viewOfShares({0.4});
    unseen.layers[0].opacity = 0.0;
    EXPECT_EQ(viewParts(unseen), all) << "it costs nothing";
}

/// The definition, at many places.
TEST(ViewParts, AreThePicturesOfAllPlaces) {
    constexpr int places = 4000;
    Random random(31);
    for (int tries = 0; tries < 200; ++tries) {
        std::vector<double> shares;
        for (auto count = 1 + random.below(8); count > 0; --count)
            shares.push_back(static_cast<double>(random.below(11)) / 10.0);
        const View view = viewOfShares(shares);
        std::map<std::vector<std::uint32_t>, double> expected, actual;
        for (int i = 0; i < places; ++i) {
            std::vector<std::uint32_t> steps;
            for (const double share : shares) steps.push_back((i + 0.5) / places < share ? 5U : 2U);
            expected[steps] += 1.0 / places;
        }
        const auto parts = viewParts(view);
        for (const auto& [place, weight] : parts) actual[stepsOf(viewAt(view, place))] += weight;
        ASSERT_EQ(actual.size(), expected.size());
        EXPECT_EQ(parts.size(), expected.size()) << "no picture is drawn twice";
        for (const auto& [steps, weight] : expected) EXPECT_NEAR(actual[steps], weight, 1e-9);
    }
}

TEST(ViewParts, TellTheRestOfTheWay) {
    const View view = viewOfShares({0.25, 0.75});
    const View nearest = viewAt(view, nearestPlace);
    EXPECT_EQ(stepsOf(nearest), (std::vector<std::uint32_t>{2, 5}));
    EXPECT_EQ(nearest.layers[0].towards, (Towards{5, 0.25}));
    EXPECT_EQ(nearest.layers[1].towards, (Towards{2, 0.25}));
}

TEST(ViewParts, OfSharesThatAreHardToTellApart) {
    const double least = 0x1p-1074, last = 1.0 - 0x1p-53;
    double sum = 0.0;
    for (const auto& [place, weight] : viewParts(viewOfShares({least, 0.5, 0.5 + 0x1p-53, last}))) {
        EXPECT_GE(weight, 0.0);
        sum += weight;
    }
    EXPECT_EQ(sum, 1.0);
}

}  // namespace
}  // namespace mote::test
