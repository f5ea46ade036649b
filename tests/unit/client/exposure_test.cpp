// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/frames/exposure.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "protocol/scene/srgb.h"

namespace mote::client {
namespace {

FramePixels noise(std::uint32_t width, std::uint32_t height, unsigned seed) {
    std::mt19937 random(seed);
    FramePixels pixels{width, height, proto::SRGB8, {}};
    pixels.bytes.resize(std::size_t{width} * height * 4, 255);
    for (std::size_t i = 0; i < pixels.bytes.size(); ++i) {
        if (i % 4 != 3) pixels.bytes[i] = static_cast<std::uint8_t>(random() % 256);
    }
    return pixels;
}

double light(const FramePixels& pixels, std::size_t x, std::size_t y, std::size_t channel) {
    return srgbToLinear(pixels.bytes[(y * pixels.width + x) * 4 + channel] / 255.0);
}

TEST(Exposure, OfOnePictureIsThePicture) {
    const auto picture = noise(7, 5, 1);
    Exposure exposure(1);
    exposure.add(picture);
    EXPECT_EQ(exposure.take().bytes, picture.bytes);
}

TEST(Exposure, IsTheMeanInLinearLight) {
    for (const unsigned side : {1U, 2U, 3U, 4U}) {
        for (const unsigned count : {1U, 2U, 5U}) {
            std::vector<FramePixels> pictures;
            Exposure exposure(side);
            for (unsigned i = 0; i < count; ++i) {
                pictures.push_back(noise(6 * side, 4 * side, 10 * side + i));
                exposure.add(pictures.back());
            }
            const auto mean = exposure.take();
            ASSERT_EQ(mean.width, 6U);
            ASSERT_EQ(mean.height, 4U);
            for (std::size_t place = 0; place < 24 * 3; ++place) {
                const std::size_t c = place % 3, x = place / 3 % 6, y = place / 18;
                double sum = 0.0;
                for (const auto& picture : pictures) {
                    for (unsigned k = 0; k < side * side; ++k)
                        sum += light(picture, x * side + k % side, y * side + k / side, c);
                }
                const double wanted = 255.0 * linearToSrgb(sum / (count * side * side));
                EXPECT_NEAR(mean.bytes[(y * 6 + x) * 4 + c], wanted, 0.56) << side << " " << count;
                EXPECT_EQ(mean.bytes[(y * 6 + x) * 4 + 3], 255);
            }
        }
    }
}

TEST(Exposure, OfEqualPicturesChangesNoByte) {
    const auto picture = noise(16, 16, 3);
    Exposure exposure(1);
    for (int i = 0; i < 8; ++i) exposure.add(picture);
    EXPECT_EQ(exposure.take().bytes, picture.bytes);
}

TEST(ExposureSettings, AreChecked) {
    EXPECT_TRUE(checkExposure({}).ok());
    EXPECT_TRUE(checkExposure({16, 180.0, 64}).ok());
    EXPECT_EQ(checkExposure({5, 0.0, 8}).error().where, "samples");
    EXPECT_EQ(checkExposure({1, -1.0, 8}).error().where, "shutter");
    EXPECT_EQ(checkExposure({1, std::nan(""), 8}).error().where, "shutter");
    EXPECT_EQ(checkExposure({1, 180.0, 0}).error().where, "subframes");
}

proto::Script turn() {
    proto::Script script;
    auto& view = *script.mutable_view();
    view.set_width(40);
    view.set_height(30);
    auto& camera = *view.mutable_camera();
    for (const double value : {0.0, 0.0, 4.0}) camera.add_eye(value);
    for (const double value : {0.0, 0.0, 0.0}) camera.add_target(value);
    auto& move = *script.add_moves();
    move.set_seconds(1.0);
    move.mutable_turn()->set_degrees(360.0);
    return script;
}

TEST(ViewsOfAFrame, LieWithinTheOpenShutter) {
    const auto film = Film::create(turn(), {});
    ASSERT_TRUE(film.ok()) << film.error().toString();
    const ExposureSettings half{1, 180.0, 4};
    const auto views = viewsOf(*film, 3, half);
    ASSERT_TRUE(views.ok());
    ASSERT_EQ(views->size(), 4U);
    // 12 degrees a frame: a quarter of 6 from one to the next.
    for (int i = 0; i < 4; ++i) {
        const auto& eye = views->at(static_cast<std::size_t>(i)).camera().eye();
        const double degrees = std::atan2(eye[0], eye[2]) * 180.0 / M_PI;
        EXPECT_NEAR(degrees, 36.0 + 1.5 * i, 1e-6);
    }
    EXPECT_EQ(views->front().SerializeAsString(), film->frame(3).SerializeAsString());
}

TEST(ViewsOfAFrame, HaveSamplesOfEachPixel) {
    const auto film = Film::create(turn(), {});
    ASSERT_TRUE(film.ok());
    const auto views = viewsOf(*film, 0, {9, 0.0, 8});
    ASSERT_TRUE(views.ok());
    EXPECT_EQ(views->front().width(), 120U);
    EXPECT_EQ(views->front().height(), 90U);
}

TEST(ViewsOfAFrame, OfSingleViewsAreNotBlurred) {
    proto::Script script;
    *script.add_views() = turn().view();
    const auto film = Film::create(script, {});
    ASSERT_TRUE(film.ok());
    EXPECT_EQ(viewsOf(*film, 0, {1, 180.0, 4}).error().code, ErrorCode::unsupported);
}

}  // namespace
}  // namespace mote::client
