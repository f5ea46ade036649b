// SPDX-License-Identifier: GPL-3.0-or-later
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <zstd.h>
#include <cmath>
#include <random>

#include "client/frames/exposure.h"
#include "client/shared/decode.h"
#include "protocol/scene/srgb.h"
#include "tests/unit/client/fake_server.h"

namespace mote::client {
namespace {

using test::frameMessage;
using test::samplePixels;

Result<FramePixels> decode(const proto::Frame& message, const std::string& payload) {
    return decodeFrame(message, {reinterpret_cast<const std::uint8_t*>(payload.data()), payload.size()});
}

class Lossless : public testing::TestWithParam<proto::PixelFormat> {};

TEST_P(Lossless, PixelsComeBackBitByBit) {
    for (const auto& [width, height] : {std::pair{1U, 1U}, {1U, 7U}, {7U, 1U}, {64U, 48U}, {641U, 3U}}) {
        const auto pixels = samplePixels(width, height, GetParam());
        const auto decoded = decode(frameMessage(width, height, GetParam(), proto::Frame::ZSTD),
                                    test::zstdPayload(pixels, width, GetParam()));
        ASSERT_TRUE(decoded.ok()) << decoded.error().toString();
        EXPECT_EQ(decoded->width, width);
        EXPECT_EQ(decoded->height, height);
        EXPECT_EQ(decoded->format, GetParam());
        EXPECT_EQ(decoded->bytes, pixels);
    }
}

TEST_P(Lossless, EveryTruncationIsDamage) {
    const auto message = frameMessage(16, 8, GetParam(), proto::Frame::ZSTD);
    const auto payload = test::zstdPayload(samplePixels(16, 8, GetParam()), 16, GetParam());
    for (std::size_t size = 0; size < payload.size(); ++size) {
        const auto decoded = decode(message, payload.substr(0, size));
        ASSERT_FALSE(decoded.ok()) << size << " of " << payload.size();
        EXPECT_EQ(decoded.error().code, ErrorCode::corrupt);
    }
}

INSTANTIATE_TEST_SUITE_P(Formats, Lossless, testing::Values(proto::SRGB8, proto::LINEAR_HALF));

TEST(Decode, JpegIsCloseToThePicture) {
    const auto pixels = samplePixels(64, 48, proto::SRGB8);
    const auto decoded =
        decode(frameMessage(64, 48, proto::SRGB8, proto::Frame::JPEG), test::jpegPayload(pixels, 64));
    ASSERT_TRUE(decoded.ok()) << decoded.error().toString();
    ASSERT_EQ(decoded->bytes.size(), pixels.size());
    for (std::size_t i = 0; i < pixels.size(); ++i) {
        // At quality 100 every coefficient is rounded to a whole number (error 1/2 each, 64 a block, two
        // transforms and a change of colour space): a few steps, never as many as 16.
        ASSERT_NEAR(decoded->bytes[i], pixels[i], 16) << i;
        if (i % 4 == 3) {
            ASSERT_EQ(decoded->bytes[i], 255);
        }
    }
}

TEST(Decode, ATruncatedJpegIsDamage) {
    const auto message = frameMessage(64, 48, proto::SRGB8, proto::Frame::JPEG);
    const auto payload = test::jpegPayload(samplePixels(64, 48, proto::SRGB8), 64);
    for (const std::size_t size :
         {std::size_t{0}, std::size_t{10}, payload.size() / 2, payload.size() - 40}) {
        const auto decoded = decode(message, payload.substr(0, size));
        ASSERT_FALSE(decoded.ok()) << size;
        EXPECT_EQ(decoded.error().code, ErrorCode::corrupt);
    }
}

TEST(Decode, SizesThatDifferFromTheMessageAreDamage) {
    const auto pixels = samplePixels(64, 48, proto::SRGB8);
    const auto zstd = test::zstdPayload(pixels, 64, proto::SRGB8);
    const auto jpeg = test::jpegPayload(pixels, 64);
    for (const auto& [width, height] : {std::pair{64U, 47U}, {64U, 49U}, {48U, 64U + 1}, {16384U, 2048U}}) {
        EXPECT_FALSE(decode(frameMessage(width, height, proto::SRGB8, proto::Frame::ZSTD), zstd).ok());
        EXPECT_FALSE(decode(frameMessage(width, height, proto::SRGB8, proto::Frame::JPEG), jpeg).ok());
    }
    EXPECT_FALSE(decode(frameMessage(64, 48, proto::LINEAR_HALF, proto::Frame::ZSTD), zstd).ok());
    EXPECT_FALSE(decode(frameMessage(64, 48, proto::LINEAR_HALF, proto::Frame::JPEG), jpeg).ok());
}

TEST(Decode, APayloadThatHidesItsSizeIsMeasured) {
    const std::vector<std::uint8_t> rows(64 * 48 * 3);
    const auto packed = [&](std::size_t size) {
        ZSTD_CCtx* context = ZSTD_createCCtx();
        ZSTD_CCtx_setParameter(context, ZSTD_c_contentSizeFlag, 0);
        std::string bytes(ZSTD_compressBound(rows.size()), '\0');
        bytes.resize(ZSTD_compress2(context, bytes.data(), bytes.size(), rows.data(), size));
        ZSTD_freeCCtx(context);
        return bytes;
    };
    const auto message = frameMessage(64, 48, proto::SRGB8, proto::Frame::ZSTD);
    EXPECT_TRUE(decode(message, packed(rows.size())).ok());
    EXPECT_EQ(decode(message, packed(rows.size() - 1)).error().code, ErrorCode::corrupt);
    auto shorter = message;
    shorter.set_height(47);
    EXPECT_EQ(decode(shorter, packed(rows.size())).error().code, ErrorCode::corrupt);
}

TEST(Decode, SizesOutOfRangeAreRefusedBeforeMemoryIsTaken) {
    for (const auto& [width, height] :
         {std::pair{0U, 48U}, {64U, 0U}, {16385U, 1U}, {1U, 16385U}, {16384U, 16384U}, {~0U, ~0U}}) {
        const auto decoded = decode(frameMessage(width, height, proto::SRGB8, proto::Frame::ZSTD), "");
        ASSERT_FALSE(decoded.ok());
        EXPECT_EQ(decoded.error().code, ErrorCode::corrupt);
        EXPECT_THAT(decoded.error().message, testing::HasSubstr("pixels"));
    }
}

TEST(Decode, WhatANewerServerSendsIsUnsupported) {
    auto message = frameMessage(4, 4, proto::SRGB8, proto::Frame::ENCODING_UNSPECIFIED);
    EXPECT_EQ(decode(message, "").error().code, ErrorCode::unsupported);
    message.set_encoding(static_cast<proto::Frame::Encoding>(77));
    EXPECT_EQ(decode(message, "").error().code, ErrorCode::unsupported);
    message.set_encoding(proto::Frame::ZSTD);
    message.set_format(static_cast<proto::PixelFormat>(77));
    EXPECT_EQ(decode(message, "").error().code, ErrorCode::unsupported);
}

TEST(Decode, RandomBytesNeverCrash) {
    std::mt19937 random(7);
    for (int round = 0; round < 2000; ++round) {
        std::string payload(random() % 200, '\0');
        for (auto& byte : payload) byte = static_cast<char>(random());
        const auto encoding = round % 2 == 0 ? proto::Frame::ZSTD : proto::Frame::JPEG;
        EXPECT_FALSE(decode(frameMessage(16, 16, proto::SRGB8, encoding), payload).ok());
    }
}

TEST(Decode, FlippedBitsNeverCrash) {
    std::mt19937 random(8);
    const auto pixels = samplePixels(32, 32, proto::SRGB8);
    const std::string payloads[] = {test::zstdPayload(pixels, 32, proto::SRGB8),
                                    test::jpegPayload(pixels, 32)};
    for (int round = 0; round < 2000; ++round) {
        auto payload = payloads[round % 2];
        payload[random() % payload.size()] ^= static_cast<char>(1 << random() % 8);
        const auto encoding = round % 2 == 0 ? proto::Frame::ZSTD : proto::Frame::JPEG;
        const auto decoded = decode(frameMessage(32, 32, proto::SRGB8, encoding), payload);
        if (decoded.ok()) {
            EXPECT_EQ(decoded->bytes.size(), pixels.size());
        }
    }
}

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
