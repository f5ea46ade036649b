// SPDX-License-Identifier: GPL-3.0-or-later
//
// Layers that fade, from a view to its picture: what is read for them, and that pictures change little by
// little between those without a layer and with all of it (docs/PICTURE.md, "Layers that fade").
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>

#include "server/frames/picture_maker.h"
#include "server/render/cpu/cpu_device.h"
#include "tests/support/ball_surface.h"
#include "tests/support/temp_dir.h"
#include "tests/support/view_text.h"
#include "tests/unit/frames/gated_source.h"
#include "tests/unit/stipple/small_hierarchy.h"

namespace mote::server {
namespace {

using Pixels = std::vector<std::uint8_t>;

class FadingLayers : public testing::Test {
  protected:
    FadingLayers() {
        test::writeBall(data_ / "ball.mote", 3000);
        test::writeBallMesh(data_ / "solid.mote");
        const auto plane = test::jitteredGrid(40);
        test::writeDataset(data_ / "plane.mote", plane, test::manifestOf(plane));
        source_.open();
    }
    Result<Making> make(const std::string& layers, const std::string& camera) {
        auto task = std::make_shared<ViewTask>();
        task->view = test::viewOf("{'width': 60, 'height': 40, 'background': [1, 1, 1], " + camera +
                                  "'layers': [" + layers + "]}");
        PictureHistory history{QualityController(30.0)};
        return maker_.make({.session = 1, .task = task, .stage = Stage::exact, .stop = {}}, history);
    }
    /// When all data are there.
    Pixels drawn(const std::string& layers, const std::string& camera = "") {
        for (int tries = 0; tries < 4; ++tries) {
            const auto made = make(layers, camera);
            EXPECT_TRUE(made.ok()) << made.error().toString();
            if (!made.ok()) return {};
            if (made->picture) return made->picture->picture.pixels;
            source_.awaitRest();
        }
        ADD_FAILURE() << layers << " is never there";
        return {};
    }

    test::TempDir folder_;
    const std::filesystem::path data_ = folder_ / "data";
    const bool made_ = std::filesystem::create_directory(data_);
    GatedSource source_{data_};
    PictureMaker maker_{[] { return std::make_unique<render::CpuDevice>(render::CpuOptions{.threads = 1}); },
                        source_, render::DeviceCosts{}};
};

int greatestDifference(const Pixels& one, const Pixels& other) {
    EXPECT_EQ(one.size(), other.size());
    int most = 0;
    for (std::size_t i = 0; i < std::min(one.size(), other.size()); ++i)
        most = std::max(most, std::abs(one[i] - other[i]));
    return most;
}

std::string withOpacity(const std::string& layer, double opacity) {
    return "{'opacity': " + std::to_string(opacity) + "," + layer.substr(1);
}

const std::string fadingBall = "{'dataset': 'ball', 'stipple': {'spacingPixels': 3}}";
const std::string solid = "{'dataset': 'solid', 'mesh': {'color': [0.8, 0.2, 0.1]}}";
const std::string ink = "{'dataset': 'solid', 'ink': {'ink': {'strength': 0.5}}}";
const std::string grey = "{'dataset': 'solid', 'ink': {'show': 'grey'}}";
const std::string dots = "{'dataset': 'plane', 'stipple': {'source': 'layers', 'spacingPixels': 2}}";

TEST_F(FadingLayers, OfNothingNothingIsRead) {
    std::string layers;
    for (const auto& layer : {fadingBall, solid, ink, grey}) layers += withOpacity(layer, 0.0) + ",";
    const auto made = make(layers + withOpacity(dots, 0.0), "");
    ASSERT_TRUE(made.ok()) << made.error().toString();
    ASSERT_TRUE(made->picture) << "it waits for nothing";
    EXPECT_TRUE(source_.threads().empty());
    const auto& pixels = made->picture->picture.pixels;
    EXPECT_TRUE(std::all_of(pixels.begin(), pixels.end(), [](std::uint8_t byte) { return byte == 255; }));
}

TEST_F(FadingLayers, WhatIsNotThereIsAnErrorAllTheSame) {
    const auto none = make(fadingBall + ", {'opacity': 0, 'dataset': 'none', 'mesh': {}}", "");
    ASSERT_FALSE(none.ok());
    EXPECT_EQ(none.error().code, ErrorCode::notFound);
    EXPECT_EQ(none.error().where, "layers[1].dataset");
    const auto image = make("{'opacity': 0, 'dataset': 'plane', 'stipple': {'image': 'none'}}", "");
    ASSERT_FALSE(image.ok());
    EXPECT_EQ(image.error().where, "layers[0].stipple.image");
}

TEST_F(FadingLayers, BetweenThePicturesWithoutAndWithAllOfItThereIsNoJump) {
    for (const auto& layer : {fadingBall, solid, ink, grey}) {
        const std::string behind = "{'transform': [3,0,0,0, 0,3,0,0, 0,0,3,0, 0,0,0,1]," + solid.substr(1);
        for (const std::string& before : {std::string(), withOpacity(behind, 0.5) + ", "}) {
            const std::string camera = "'camera': {'eye': [0, 1, 6], 'target': [0, 0, 0]},";
            const auto without = drawn(before.substr(0, before.size() - (before.empty() ? 0 : 2)), camera);
            const auto whole = drawn(before + layer, camera);
            EXPECT_EQ(drawn(before + withOpacity(layer, 0.0), camera), without) << layer;
            EXPECT_EQ(drawn(before + withOpacity(layer, 1.0), camera), whole) << layer;
            EXPECT_GT(greatestDifference(without, whole), 40) << layer;
            EXPECT_LE(greatestDifference(drawn(before + withOpacity(layer, 0.0005), camera), without), 2)
                << layer;
            EXPECT_LE(greatestDifference(drawn(before + withOpacity(layer, 0.9995), camera), whole), 2)
                << layer;
            auto last = without;
            for (int percent = 5; percent <= 100; percent += 5) {
                auto next = drawn(before + withOpacity(layer, percent / 100.0), camera);
                EXPECT_LE(greatestDifference(next, last), 70) << layer << ' ' << percent;
                last = std::move(next);
            }
        }
    }
}

TEST_F(FadingLayers, DotsOfADrawingComeAsTheDrawingGoes) {
    const std::string after = ", " + withOpacity(fadingBall, 0.7);
    for (const auto& seen : {solid, fadingBall, withOpacity(solid, 0.6) + ", " + ink}) {
        const auto without = drawn(seen + after), whole = drawn(seen + ", " + dots + after);
        EXPECT_EQ(drawn(seen + ", " + withOpacity(dots, 0.0) + after), without) << seen;
        EXPECT_EQ(drawn(seen + ", " + withOpacity(dots, 1.0) + after), whole) << seen;
        EXPECT_GT(greatestDifference(without, whole), 40) << seen;
        EXPECT_LE(greatestDifference(drawn(seen + ", " + withOpacity(dots, 0.0005) + after), without), 2)
            << seen;
        EXPECT_LE(greatestDifference(drawn(seen + ", " + withOpacity(dots, 0.9995) + after), whole), 4)
            << seen;
    }
}

TEST_F(FadingLayers, ACameraIsNotFittedToWhatIsNotThere) {
    const std::string away =
        "{'dataset': 'solid', 'transform': [1,0,0,50, 0,1,0,0, 0,0,1,0, 0,0,0,1], 'mesh': {}}";
    EXPECT_EQ(drawn(solid + ", " + withOpacity(away, 0.0)), drawn(solid));
    EXPECT_GT(greatestDifference(drawn(solid + ", " + withOpacity(away, 0.01)), drawn(solid)), 40);
}

}  // namespace
}  // namespace mote::server
