// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/frames/picture_file.h"

#include <OpenImageIO/imageio.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>

#include "tests/support/temp_dir.h"
#include "tests/unit/client/frames.h"

namespace mote::client {
namespace {

constexpr std::uint32_t width = 40, height = 30;

FramePixels sample(PictureFormat format) {
    return {width, height, pixelFormat(format), test::samplePixels(width, height, pixelFormat(format))};
}

std::vector<std::uint8_t> bytesOf(const std::filesystem::path& path) {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
}

std::size_t entries(const std::filesystem::path& folder) {
    return static_cast<std::size_t>(
        std::distance(std::filesystem::directory_iterator(folder), std::filesystem::directory_iterator{}));
}

class PictureFile : public testing::TestWithParam<PictureFormat> {
  protected:
    std::vector<std::uint8_t> encoded(const std::string& key = "00ff") const {
        auto bytes = encodePicture(sample(GetParam()), GetParam(), key);
        EXPECT_TRUE(bytes.ok()) << bytes.error().toString();
        return bytes.ok() ? *bytes : std::vector<std::uint8_t>{};
    }

    std::filesystem::path file() const { return folder_ / ("a." + std::string(name(GetParam()))); }

    test::TempDir folder_;
};

/// What a server made of a document, and after it the key.
TEST(Document, KeepsItsBytesAndItsKey) {
    const test::TempDir folder;
    const std::string key = "0123456789abcdef0123456789abcdef";
    for (const auto format : {PictureFormat::svg, PictureFormat::eps, PictureFormat::pdf}) {
        const FramePixels document{width, height, proto::PIXEL_FORMAT_UNSPECIFIED, {'a', 'b', 'c', '\n'}};
        const auto bytes = encodePicture(document, format, key);
        ASSERT_TRUE(bytes.ok());
        EXPECT_TRUE(std::equal(document.bytes.begin(), document.bytes.end(), bytes->begin()));
        const auto path = folder / "a";
        ASSERT_TRUE(writeFile(path, *bytes).ok());
        EXPECT_EQ(readPictureKey(path, format, width, height), key);
        std::filesystem::resize_file(path, bytes->size() - 1);
        EXPECT_FALSE(readPictureKey(path, format, width, height).has_value());
        std::filesystem::resize_file(path, 2);
        EXPECT_FALSE(readPictureKey(path, format, width, height).has_value());
        // Pixels, from a server that knows no pages.
        EXPECT_FALSE(encodePicture(sample(PictureFormat::png), format, key).ok());
    }
}

TEST_P(PictureFile, HoldsThePixels) {
    ASSERT_TRUE(writeFile(file(), encoded()).ok());
    const auto input = OIIO::ImageInput::open(file().string());
    ASSERT_TRUE(input) << OIIO::geterror();
    const auto& spec = input->spec();
    EXPECT_EQ(spec.width, static_cast<int>(width));
    EXPECT_EQ(spec.height, static_cast<int>(height));
    EXPECT_EQ(spec.nchannels, 3);
    const bool half = GetParam() == PictureFormat::exr;
    EXPECT_EQ(spec.format, half ? OIIO::TypeDesc::HALF : OIIO::TypeDesc::UINT8);
    EXPECT_EQ(spec.get_string_attribute("oiio:ColorSpace"), half ? "Linear" : "sRGB");
    std::vector<std::uint8_t> read(spec.image_bytes(true));
    ASSERT_TRUE(input->read_image(0, 0, 0, 3, spec.format, read.data()));
    const auto pixels = sample(GetParam()).bytes;
    const std::size_t channel = half ? 2 : 1;
    for (std::size_t i = 0; i < read.size(); ++i) {
        const auto wanted = pixels[i / (3 * channel) * (4 * channel) + i % (3 * channel)];
        if (GetParam() == PictureFormat::jpg) {
            // Quality 95 divides the finest coefficients by at most 12: 64 of them, each off by 6, square sum
            // over a block of 64 samples: 6 on average; a single sample may be off several times that.
            ASSERT_NEAR(read[i], wanted, 40) << i;
        } else {
            ASSERT_EQ(read[i], wanted) << i;
        }
    }
}

TEST_P(PictureFile, TheSamePictureHasTheSameBytesAtAnyTime) {
    const auto bytes = encoded();
    EXPECT_EQ(encoded(), bytes);
    EXPECT_NE(encoded("other"), bytes);
    // A date of today's or a host's name in the file would break this on another day or machine.
    const std::string text(bytes.begin(), bytes.end());
    for (const char* year : {"202", "203"}) {
        for (const char* separator : {"-", ":", "/"}) {
            for (char digit = '0'; digit <= '9'; ++digit) {
                EXPECT_EQ(text.find(std::string(year) + digit + separator), std::string::npos);
            }
        }
    }
    std::string host(256, '\0');
    ::gethostname(host.data(), host.size());
    host.resize(host.find('\0'));
    if (host.size() > 3) {
        EXPECT_EQ(text.find(host), std::string::npos);
    }
}

TEST_P(PictureFile, ItsKeyIsFoundWhileItIsWhole) {
    // Large enough that readers take it in pieces: of a small JPEG file even its end is missed at once.
    constexpr std::uint32_t columns = 640, rows = 480;
    const auto samples = pixelFormat(GetParam());
    const FramePixels pixels{columns, rows, samples, test::samplePixels(columns, rows, samples)};
    const auto encodedPixels = encodePicture(pixels, GetParam(), "0123456789abcdef");
    ASSERT_TRUE(encodedPixels.ok());
    const auto& bytes = *encodedPixels;
    ASSERT_TRUE(writeFile(file(), bytes).ok());
    EXPECT_EQ(readPictureKey(file(), GetParam(), columns, rows), "0123456789abcdef");
    EXPECT_FALSE(readPictureKey(file(), GetParam(), columns + 1, rows));
    EXPECT_FALSE(readPictureKey(folder_ / "none", GetParam(), columns, rows));
    for (const std::size_t size :
         {bytes.size() - 3, bytes.size() - 100, bytes.size() / 2, std::size_t{9}, std::size_t{0}}) {
        std::filesystem::resize_file(file(), size);
        EXPECT_FALSE(readPictureKey(file(), GetParam(), columns, rows)) << size << " of " << bytes.size();
    }
}

TEST_P(PictureFile, PixelsOfAnotherFormatAreRefused) {
    auto pixels = sample(GetParam());
    pixels.format = pixels.format == proto::SRGB8 ? proto::LINEAR_HALF : proto::SRGB8;
    EXPECT_EQ(encodePicture(pixels, GetParam(), "").error().code, ErrorCode::unsupported);
}

INSTANTIATE_TEST_SUITE_P(Formats, PictureFile,
                         testing::Values(PictureFormat::png, PictureFormat::exr, PictureFormat::jpg),
                         [](const auto& each) { return std::string(name(each.param)); });

TEST(WriteFile, ReplacesWholeFilesAndLeavesNothingElse) {
    const test::TempDir folder;
    ASSERT_TRUE(writeFile(folder / "a", {1, 2, 3}).ok());
    std::ofstream(folder / ".a.part") << "of a killed process";
    ASSERT_TRUE(writeFile(folder / "a", {4}).ok());
    EXPECT_EQ(bytesOf(folder / "a"), std::vector<std::uint8_t>{4});
    EXPECT_EQ(entries(folder.path()), 1U);
}

TEST(WriteFile, FailureNamesTheFileAndLeavesNothing) {
    const test::TempDir folder;
    EXPECT_EQ(writeFile(folder / "none" / "a", {1}).error().code, ErrorCode::notFound);
    std::filesystem::create_directory(folder / "a");
    const auto error = writeFile(folder / "a", {1}).error();  // a folder cannot be replaced by a file
    EXPECT_THAT(error.where, testing::HasSubstr((folder / "a").string()));
    EXPECT_EQ(entries(folder.path()), 1U);
}

}  // namespace
}  // namespace mote::client
