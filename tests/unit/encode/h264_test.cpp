// SPDX-License-Identifier: GPL-3.0-or-later
//
// H.264 from the server's encoder to the client's decoder, and what damage does.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "client/shared/decode.h"
#include "server/encode/frame_encoder.h"

namespace mote::server {
namespace {

using render::Picture;

/// Smooth, and it moves with `shift`.
Picture waves(std::uint32_t width, std::uint32_t height, double shift) {
    Picture picture{width, height, render::PixelFormat::srgb8, {}, 0};
    for (std::uint32_t y = 0; y < height; ++y) {
        for (std::uint32_t x = 0; x < width; ++x) {
            const double value = 0.5 + 0.5 * std::sin(0.05 * x + 0.03 * y + shift);
            picture.pixels.push_back(static_cast<std::uint8_t>(255.0 * value));
            picture.pixels.push_back(static_cast<std::uint8_t>(200.0 * value));
            picture.pixels.push_back(static_cast<std::uint8_t>(60.0 + 90.0 * value));
            picture.pixels.push_back(255);
        }
    }
    return picture;
}

Picture noise(std::uint32_t width, std::uint32_t height, unsigned seed) {
    Picture picture{width, height, render::PixelFormat::srgb8, {}, 0};
    std::minstd_rand random(seed);
    picture.pixels.resize(std::size_t{4} * width * height);
    for (auto& byte : picture.pixels) byte = static_cast<std::uint8_t>(random() >> 8);
    return picture;
}

double h264Psnr(const std::vector<std::uint8_t>& a, const std::vector<std::uint8_t>& b) {
    double sum = 0.0;
    for (std::size_t i = 0; i < a.size(); ++i)
        sum += i % 4 == 3 ? 0.0 : std::pow(double{1.0} * a[i] - b[i], 2);
    return 10.0 * std::log10(255.0 * 255.0 * 0.75 * static_cast<double>(a.size()) / sum);
}

class H264 : public testing::Test {
  protected:
    void SetUp() override {
        const auto made = H264Encoder().encode(waves(64, 64, 0), 10000, false);
        if (!made.ok() && made.error().code == ErrorCode::unsupported)
            GTEST_SKIP() << made.error().toString();
    }

    H264Picture encode(const Picture& picture, std::size_t mostBytes = 200000, bool key = false) {
        auto made = encoder_.encode(picture, mostBytes, key);
        EXPECT_TRUE(made.ok()) << made.error().toString();
        return made.ok() ? *std::move(made) : H264Picture{};
    }
    static proto::Frame messageOf(const Picture& picture, const H264Picture& made) {
        proto::Frame message;
        message.set_width(picture.width);
        message.set_height(picture.height);
        message.set_encoding(proto::Frame::H264);
        message.set_format(proto::SRGB8);
        message.set_key(made.key);
        return message;
    }
    Result<client::FramePixels> decode(const Picture& picture, const H264Picture& made) {
        return decoder_.decode(messageOf(picture, made), made.payload);
    }

    H264Encoder encoder_;
    client::FrameDecoder decoder_;
};

TEST_F(H264, EachPictureIsThereAtOnceAndClose) {
    for (const auto& [width, height] :
         {std::pair{64u, 48u}, {317u, 201u}, {33u, 64u}, {2u, 2u}, {640u, 360u}}) {
        for (int i = 0; i < 4; ++i) {
            const auto picture = waves(width, height, 0.2 * i);
            const auto made = encode(picture);
            EXPECT_EQ(made.key, i == 0);
            const auto decoded = decode(picture, made);
            ASSERT_TRUE(decoded.ok()) << decoded.error().toString();
            EXPECT_EQ(decoded->width, width);
            EXPECT_EQ(decoded->height, height);
            // crf 18 quantises in steps of about 5 (1.5 each way), chroma is smooth here: 255 / 2.5 is 40 dB.
            EXPECT_GT(h264Psnr(decoded->bytes, picture.pixels), 38.0) << width << " x " << height;
        }
    }
}

TEST_F(H264, GreyAndRangeAreRight) {
    for (const std::uint8_t grey : {0, 16, 128, 235, 255}) {
        Picture picture{64, 64, render::PixelFormat::srgb8, std::vector<std::uint8_t>(64 * 64 * 4, grey), 0};
        const auto decoded = decode(picture, encode(picture, 200000, true));
        ASSERT_TRUE(decoded.ok());
        // A limited range would move 16 to 0 and 235 to 255.
        EXPECT_NEAR(decoded->bytes[4 * 64 * 30 + 120], grey, 2);
        EXPECT_EQ(decoded->bytes[3], 255);
    }
}

TEST_F(H264, NoPictureIsLargerThanItsShare) {
    for (const std::size_t most : {20000u, 60000u, 20000u}) {
        for (unsigned i = 0; i < 4; ++i) {
            // Noise, the worst there is; the encoder corrects itself row by row, and the last row is still to
            // come when it notices.
            EXPECT_LT(encode(noise(640, 360, i), most).payload.size(), 1.25 * static_cast<double>(most));
        }
    }
}

TEST_F(H264, AfterALossNothingIsDecodedUpToTheNextKeyFrame) {
    const auto picture = waves(64, 48, 0);
    ASSERT_TRUE(decode(picture, encode(picture)).ok());
    auto damaged = encode(waves(64, 48, 1));
    damaged.payload.resize(damaged.payload.size() / 2);
    EXPECT_EQ(decode(picture, damaged).error().code, ErrorCode::corrupt);
    EXPECT_TRUE(decoder_.wantsKey());
    EXPECT_EQ(decode(picture, encode(waves(64, 48, 2))).error().code, ErrorCode::cancelled);
    EXPECT_TRUE(decoder_.wantsKey());
    const auto key = encode(waves(64, 48, 3), 200000, true);
    EXPECT_TRUE(key.key);
    const auto decoded = decode(picture, key);
    ASSERT_TRUE(decoded.ok());
    EXPECT_GT(h264Psnr(decoded->bytes, waves(64, 48, 3).pixels), 38.0);
    EXPECT_FALSE(decoder_.wantsKey());
}

TEST_F(H264, GoesOnAfterAPictureThatIsNoneOfIt) {
    FrameEncoder encoder;
    const EncodingTarget thin{true, true, 20000};
    const auto picture = noise(320, 200, 1);
    for (const bool first : {true, false}) {
        const auto moving = encoder.encode(picture, false, thin);
        ASSERT_TRUE(moving.ok()) << moving.error().toString();
        EXPECT_EQ(moving->encoding, proto::Frame::H264);
        EXPECT_EQ(moving->key, first);
        EXPECT_TRUE(decode(picture, {moving->payload, moving->key}).ok());
        EXPECT_EQ(encoder.encode(picture, true, thin)->encoding, proto::Frame::ZSTD);
    }
}

TEST_F(H264, AnotherSizeThanTheMessageSaysIsDamage) {
    const auto made = encode(waves(64, 48, 0));
    for (const auto& [width, height] : {std::pair{64u, 64u}, {48u, 64u}, {66u, 48u}, {1u, 1u}}) {
        EXPECT_EQ(decode(waves(width, height, 0), made).error().code, ErrorCode::corrupt);
    }
    auto message = messageOf(waves(64, 48, 0), made);
    message.set_width(1u << 20);
    EXPECT_EQ(decoder_.decode(message, made.payload).error().code, ErrorCode::corrupt);
    EXPECT_EQ(client::decodeFrame(messageOf(waves(64, 48, 0), made), made.payload).error().code,
              ErrorCode::unsupported);
}

TEST_F(H264, AlteredBytesAreAPictureOrAnErrorNeverMore) {
    const auto picture = waves(96, 64, 0);
    const H264Picture good[] = {encode(picture), encode(noise(96, 64, 1), 8000)};
    std::mt19937 random(4711);
    for (int i = 0; i < 400; ++i) {
        client::FrameDecoder decoder;
        for (auto made : good) {
            for (unsigned flips = 1 + random() % 4; flips > 0; --flips) {
                made.payload[random() % made.payload.size()] = static_cast<std::uint8_t>(random());
            }
            if (i % 4 == 0) made.payload.resize(random() % made.payload.size());
            const auto decoded = decoder.decode(messageOf(picture, made), made.payload);
            if (decoded.ok()) {
                EXPECT_EQ(decoded->bytes.size(), picture.pixels.size());
            }
        }
    }
    client::FrameDecoder decoder;
    auto message = messageOf(picture, good[0]);
    EXPECT_EQ(decoder.decode(message, {}).error().code, ErrorCode::corrupt);
    message.set_format(proto::LINEAR_HALF);
    EXPECT_EQ(decoder.decode(message, good[0].payload).error().code, ErrorCode::corrupt);
}

TEST(EncodingChoice, FollowsTheLinkAndTheClient) {
    using F = proto::Frame;
    const EncodingTarget old, thin{true, true, 60000}, thinJpeg{true, false, 60000}, fresh{true, true, {}};
    // At rest everybody gets all.
    for (const auto& target : {old, thin, thinJpeg, fresh}) {
        EXPECT_EQ(chooseEncoding(target, {true, 1u << 30, false}), F::ZSTD);
    }
    EXPECT_EQ(chooseEncoding(old, {false, 10, false}), F::JPEG);
    EXPECT_EQ(chooseEncoding(fresh, {false, 10, false}), F::H264);
    EXPECT_EQ(chooseEncoding(thin, {false, 300000, false}), F::H264);
    EXPECT_EQ(chooseEncoding(thinJpeg, {false, 300000, false}), F::JPEG);
    EXPECT_EQ(chooseEncoding(thin, {false, 30000, false}), F::ZSTD);
    EXPECT_EQ(chooseEncoding(thinJpeg, {false, 30000, false}), F::ZSTD);
    // Between the two limits it stays as it is.
    EXPECT_EQ(chooseEncoding(thin, {false, 60000, false}), F::H264);
    EXPECT_EQ(chooseEncoding(thin, {false, 60000, true}), F::ZSTD);
    EXPECT_EQ(chooseEncoding(thin, {false, 70000, true}), F::H264);
}

TEST(FrameEncoder, LosslessWhereItFitsAndAtRest) {
    FrameEncoder encoder;
    const auto picture = noise(320, 200, 1);  // 192,000 bytes that do not pack
    const EncodingTarget thin{true, true, 20000}, wide{true, true, 300000}, widest{true, true, 300000000};
    EXPECT_NE(encoder.encode(picture, false, thin)->encoding, proto::Frame::ZSTD);
    EXPECT_EQ(encoder.encode(picture, false, wide)->encoding, proto::Frame::ZSTD);
    EXPECT_EQ(encoder.encode(picture, false, widest)->encoding, proto::Frame::ZSTD);
    EXPECT_EQ(encoder.encode(picture, true, thin)->encoding, proto::Frame::ZSTD);
    EXPECT_EQ(encoder.encode(picture, false, {})->encoding, proto::Frame::JPEG);
}

TEST(FrameEncoder, TheExpectedSizeIsNearTheRealOne) {
    LosslessEncoder encoder;
    for (const auto& picture : {noise(640, 360, 2), waves(640, 360, 0)}) {
        const auto expected = static_cast<double>(*encoder.expectedBytes(picture));
        const auto real = static_cast<double>(encoder.encode(picture)->size());
        // Rows far apart repeat less of each other: a smooth picture seems larger than it is.
        EXPECT_GT(expected, 0.9 * real);
        EXPECT_LT(expected, 4.0 * real + 4096);
    }
}

}  // namespace
}  // namespace mote::server
