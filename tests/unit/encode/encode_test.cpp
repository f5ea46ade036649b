// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/encode/encode.h"

#include <gtest/gtest.h>
#include <turbojpeg.h>
#include <zstd.h>

#include <cmath>
#include <cstring>
#include <random>

#include "protocol/wire/framing.h"
#include "protocol/wire/row_filter.h"

namespace mote::server {
namespace {

using render::Picture;
using render::PixelFormat;

void setHalf(std::uint8_t* bytes, std::uint16_t bits) {
    std::memcpy(bytes, &bits, sizeof bits);
}

/// Any colours; alpha is 1, as a picture's is.
Picture noise(std::uint32_t width, std::uint32_t height, PixelFormat format, unsigned seed) {
    Picture picture{width, height, format, {}, 0};
    picture.pixels.resize(std::size_t{width} * height * render::bytesPerPixel(format));
    std::mt19937 random(seed);
    for (auto& byte : picture.pixels) byte = static_cast<std::uint8_t>(random());
    for (std::size_t i = 0; i < std::size_t{width} * height; ++i) {
        if (format == PixelFormat::srgb8) {
            picture.pixels[4 * i + 3] = 255;
        } else {
            setHalf(&picture.pixels[8 * i + 6], 0x3c00);
        }
    }
    return picture;
}

Picture gradient(std::uint32_t width, std::uint32_t height) {
    Picture picture{width, height, PixelFormat::srgb8, {}, 0};
    for (std::uint32_t y = 0; y < height; ++y) {
        for (std::uint32_t x = 0; x < width; ++x) {
            const std::uint8_t rgba[] = {static_cast<std::uint8_t>(x * 255 / width),
                                         static_cast<std::uint8_t>(y * 255 / height), 90, 255};
            picture.pixels.insert(picture.pixels.end(), std::begin(rgba), std::end(rgba));
        }
    }
    return picture;
}

std::vector<std::uint8_t> unpack(const Picture& picture, const std::vector<std::uint8_t>& payload) {
    const auto format = wireFormat(picture.format);
    std::vector<std::uint8_t> filtered(std::size_t{picture.width} * picture.height *
                                       wire::filteredPixelSize(format));
    EXPECT_EQ(ZSTD_getFrameContentSize(payload.data(), payload.size()), filtered.size());
    const auto size = ZSTD_decompress(filtered.data(), filtered.size(), payload.data(), payload.size());
    EXPECT_EQ(size, filtered.size());
    std::vector<std::uint8_t> pixels(picture.pixels.size());
    wire::unfilterRows(format, picture.width, filtered, pixels);
    return pixels;
}

double psnr(const std::vector<std::uint8_t>& a, const std::vector<std::uint8_t>& b) {
    double sum = 0.0;
    for (std::size_t i = 0; i < a.size(); ++i) sum += std::pow(double{1.0} * a[i] - b[i], 2);
    return 10.0 * std::log10(255.0 * 255.0 * static_cast<double>(a.size()) / sum);
}

std::vector<std::uint8_t> decodeJpeg(const std::vector<std::uint8_t>& payload, int& width, int& height,
                                     int& subsampling) {
    tjhandle handle = tjInitDecompress();
    int colorspace = 0;
    EXPECT_EQ(tjDecompressHeader3(handle, payload.data(), payload.size(), &width, &height, &subsampling,
                                  &colorspace),
              0);
    std::vector<std::uint8_t> pixels(std::size_t{4} * static_cast<unsigned>(width * height));
    EXPECT_EQ(
        tjDecompress2(handle, payload.data(), payload.size(), pixels.data(), width, 0, height, TJPF_RGBA, 0),
        0);
    tjDestroy(handle);
    return pixels;
}

TEST(Lossless, EveryBitComesBack) {
    for (const auto format : {PixelFormat::srgb8, PixelFormat::linearHalf}) {
        for (const auto& [width, height] : {std::pair{1u, 1u}, {1u, 7u}, {7u, 1u}, {33u, 17u}, {640u, 3u}}) {
            const Picture picture = noise(width, height, format, width * height);
            const auto payload = LosslessEncoder().encode(picture);
            ASSERT_TRUE(payload.ok());
            EXPECT_EQ(unpack(picture, *payload), picture.pixels) << width << " x " << height;
        }
    }
}

TEST(Lossless, GradientGetsSmall) {
    const Picture picture = gradient(512, 256);
    const auto payload = LosslessEncoder().encode(picture);
    ASSERT_TRUE(payload.ok());
    EXPECT_EQ(unpack(picture, *payload), picture.pixels);
    // Differences along a row are 0 or 1: without the filter this takes far more than a tenth.
    EXPECT_LT(payload->size(), picture.pixels.size() / 50);
}

TEST(Lossless, WorstPictureFitsTheLimitOfAFrame) {
    // zstd adds at most size / 256 + 128 KiB to bytes that it cannot compress (ZSTD_COMPRESSBOUND).
    const std::uint64_t greatest = View::maxPixels * wire::filteredPixelSize(proto::LINEAR_HALF);
    EXPECT_LT(ZSTD_compressBound(greatest), wire::serverLimits.payload);
}

TEST(Lossless, DamageIsNoticed) {
    const Picture picture = noise(64, 64, PixelFormat::srgb8, 5);
    auto payload = LosslessEncoder().encode(picture);
    ASSERT_TRUE(payload.ok());
    (*payload)[payload->size() / 2] ^= 0x10;
    std::vector<std::uint8_t> filtered(64 * 64 * 3);
    const auto size = ZSTD_decompress(filtered.data(), filtered.size(), payload->data(), payload->size());
    EXPECT_TRUE(ZSTD_isError(size));
}

TEST(Jpeg, KeepsSizeAndFullColour) {
    const Picture picture = gradient(317, 201);
    const auto payload = encodeJpeg(picture);
    ASSERT_TRUE(payload.ok());
    int width = 0, height = 0, subsampling = -1;
    const auto pixels = decodeJpeg(*payload, width, height, subsampling);
    EXPECT_EQ(width, 317);
    EXPECT_EQ(height, 201);
    EXPECT_EQ(subsampling, TJSAMP_444);
    // Quality 80 quantises low frequencies in steps of about 6: an error of 2 at most here, 40 dB.
    EXPECT_GT(psnr(pixels, picture.pixels), 38.0);
}

TEST(Jpeg, SinglePixelsKeepTheirColour) {
    Picture picture{32, 32, PixelFormat::srgb8, std::vector<std::uint8_t>(32 * 32 * 4, 0), 0};
    for (std::size_t i = 0; i < 32 * 32; ++i) picture.pixels[4 * i + 3] = 255;
    const std::size_t at = 4 * (10 * 32 + 13);
    picture.pixels[at] = 255;
    const auto payload = encodeJpeg(picture);
    ASSERT_TRUE(payload.ok());
    int width = 0, height = 0, subsampling = -1;
    const auto pixels = decodeJpeg(*payload, width, height, subsampling);
    // 4:2:0 averages chroma over four pixels: red would fall to about 110 with grey beside it.
    EXPECT_GT(pixels[at], 200);
    EXPECT_LT(pixels[at + 1], 60);
    EXPECT_LT(pixels[at + 2], 60);
}

}  // namespace
}  // namespace mote::server
