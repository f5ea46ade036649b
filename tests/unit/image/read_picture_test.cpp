// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/image/read_picture.h"

#include <OpenImageIO/imageio.h>
#include <gtest/gtest.h>
#ifdef __SANITIZE_ADDRESS__
#include <sanitizer/lsan_interface.h>
#endif

#include <fstream>
#include <limits>

#include "protocol/scene/srgb.h"
#include "tests/support/temp_dir.h"
#include "tests/unit/particles/quiet_progress.h"

namespace mote::test {
namespace {

namespace fs = std::filesystem;

struct Stored {
    int width = 2, height = 2, channels = 3;
    OIIO::TypeDesc type = OIIO::TypeDesc::UINT8;
    int alpha = -1;
    std::string colorSpace = {};
    int tile = 0;
};

fs::path write(const fs::path& path, const Stored& stored, const std::vector<float>& values) {
    OIIO::ImageSpec spec(stored.width, stored.height, stored.channels, stored.type);
    spec.alpha_channel = stored.alpha;
    spec.attribute("oiio:UnassociatedAlpha", 1);  // what is written is what is given
    if (!stored.colorSpace.empty()) spec.attribute("oiio:ColorSpace", stored.colorSpace);
    spec.tile_width = spec.tile_height = stored.tile;
    auto output = OIIO::ImageOutput::create(path.string());
    EXPECT_TRUE(output && output->open(path.string(), spec)) << OIIO::geterror();
    EXPECT_TRUE(output->write_image(OIIO::TypeDesc::FLOAT, values.data())) << output->geterror();
    EXPECT_TRUE(output->close());
    return path;
}

Result<prep::Picture> read(const fs::path& path, std::uint64_t memory = 0) {
    QuietProgress progress;
    return prep::readPicture(path, memory, progress);
}

prep::Picture readGood(const fs::path& path) {
    auto picture = read(path);
    EXPECT_TRUE(picture.ok()) << (picture.ok() ? "" : picture.error().toString());
    return picture.ok() ? *std::move(picture) : prep::Picture{};
}

class ReadPicture : public ::testing::Test {
  protected:
    TempDir folder_;
};

TEST_F(ReadPicture, eightAndSixteenBitsOfSrgb) {
    for (const auto type : {OIIO::TypeDesc::UINT8, OIIO::TypeDesc::UINT16}) {
        for (const char* name : {"a.png", "a.tif"}) {
            const auto path = write(folder_ / name, {2, 1, 3, type}, {1, 0, 0, 0, 102 / 255.0F, 1});
            const auto picture = readGood(path);
            EXPECT_EQ(picture.colorSpace, "sRGB");
            EXPECT_TRUE(picture.color);
            ASSERT_EQ(picture.luminance.values.size(), 2u);
            // 102/255 is a value of both depths; what is left is the rounding of floats.
            EXPECT_NEAR(picture.luminance.at(0, 0), 0.2126, 1e-6);
            EXPECT_NEAR(picture.luminance.at(1, 0), 0.7152 * srgbToLinear(0.4) + 0.0722, 1e-6);
        }
    }
}

// OpenEXR stores a part of the picture, or more than is shown of it.
TEST_F(ReadPicture, theDisplayWindowIsThePicture) {
    OIIO::ImageSpec spec(3, 2, 1, OIIO::TypeDesc::FLOAT);
    spec.x = 1, spec.y = -1;  // pixels (1, -1) to (3, 0) of a picture of 4 x 3
    spec.full_width = 4, spec.full_height = 3;
    const std::vector<float> values{0.1F, 0.2F, 0.3F, 0.4F, 0.5F, 0.6F};
    const auto path = folder_ / "a.exr";
    const auto output = OIIO::ImageOutput::create(path.string());
    ASSERT_TRUE(output->open(path.string(), spec) &&
                output->write_image(OIIO::TypeDesc::FLOAT, values.data()));
    ASSERT_TRUE(output->close());
    const auto picture = readGood(path).luminance;
    EXPECT_EQ(picture.width, 4U);
    EXPECT_EQ(picture.height, 3U);
    EXPECT_EQ(picture.values, (std::vector<float>{0, 0.4F, 0.5F, 0.6F, 0, 0, 0, 0, 0, 0, 0, 0}));
}

// TIFF 6.0: a sample has one bit where none are told.
TEST_F(ReadPicture, bitsThatAreNotToldAreOne) {
    const auto tag = [](int number, int type, int value) {
        std::string entry;
        for (const int part : {number & 255, number >> 8, type, 0, 1, 0, 0, 0, value, 0, 0, 0}) {
            entry += static_cast<char>(part);
        }
        return entry;
    };
    for (const int white : {0, 1}) {
        std::string tiff("II*\0\x0c\0\0\0\xa0\x40\0\0", 12);  // rows of three bits: 101 and 010
        tiff +=
            std::string("\x07\0", 2) + tag(256, 4, 3) + tag(257, 4, 2) + tag(259, 3, 1) + tag(262, 3, white);
        tiff += tag(273, 4, 8) + tag(278, 4, 2) + tag(279, 4, 2) + std::string(4, '\0');
        std::ofstream(folder_ / "a.tif", std::ios::binary) << tiff;
        const auto picture = readGood(folder_ / "a.tif").luminance;
        const auto one = static_cast<float>(white), other = 1.0F - one;
        EXPECT_EQ(picture.values, (std::vector<float>{one, other, one, other, one, other}));
    }
}

TEST_F(ReadPicture, greyFloatsAreLinearAndMayBeBrighterThanWhite) {
    const auto path = write(folder_ / "a.exr", {2, 1, 1, OIIO::TypeDesc::FLOAT}, {0.25F, 3.0F});
    const auto picture = readGood(path);
    EXPECT_EQ(picture.colorSpace, "linear");
    EXPECT_FALSE(picture.color);
    EXPECT_EQ(picture.luminance.values, (std::vector<float>{0.25F, 3.0F}));
}

TEST_F(ReadPicture, tilesAndStripsGiveTheSame) {
    std::vector<float> values(200 * 150);
    for (std::size_t i = 0; i < values.size(); ++i) values[i] = static_cast<float>(i % 251) / 250.0F;
    const Stored stored{200, 150, 1, OIIO::TypeDesc::FLOAT};
    Stored tiled = stored;
    tiled.tile = 64;
    const auto rows = readGood(write(folder_ / "rows.tif", stored, values));
    const auto tiles = readGood(write(folder_ / "tiles.tif", tiled, values));
    EXPECT_EQ(rows.luminance.values, values);
    EXPECT_EQ(tiles.luminance, rows.luminance);
}

TEST_F(ReadPicture, transparentIsLaidOnWhiteAsLightMixes) {
    const Stored stored{3, 1, 4, OIIO::TypeDesc::UINT8, 3};
    const float grey = 102 / 255.0F;
    const auto picture = readGood(write(folder_ / "a.png", stored,
                                        {0, 0, 0, 0, grey, grey, grey, 51 / 255.0F, 0.0F, 0.0F, 0.0F, 1.0F}));
    EXPECT_TRUE(picture.transparent);
    EXPECT_NEAR(picture.luminance.at(0, 0), 1.0, 1e-6);
    EXPECT_NEAR(picture.luminance.at(1, 0), 0.2 * srgbToLinear(0.4) + 0.8, 1e-6);
    EXPECT_NEAR(picture.luminance.at(2, 0), 0.0, 1e-6);
}

TEST_F(ReadPicture, premultipliedExr) {
    OIIO::ImageSpec spec(1, 1, 4, OIIO::TypeDesc::FLOAT);
    const auto path = (folder_ / "a.exr").string();
    auto output = OIIO::ImageOutput::create(path);
    ASSERT_TRUE(output->open(path, spec));
    const float pixel[] = {0.2F, 0.2F, 0.2F, 0.5F};  // of colour 0.4
    ASSERT_TRUE(output->write_image(OIIO::TypeDesc::FLOAT, pixel) && output->close());
    EXPECT_NEAR(readGood(path).luminance.at(0, 0), 0.2 + 0.5, 1e-6);
}

TEST_F(ReadPicture, notFiniteIsCountedAndWhite) {
    const float nan = std::numeric_limits<float>::quiet_NaN();
    const float infinite = std::numeric_limits<float>::infinity();
    const auto picture =
        readGood(write(folder_ / "a.exr", {4, 1, 1, OIIO::TypeDesc::FLOAT}, {nan, infinite, -0.5F, 0.5F}));
    EXPECT_EQ(picture.invalid, 2u);
    EXPECT_EQ(picture.luminance.values, (std::vector<float>{1.0F, 1.0F, 0.0F, 0.5F}));
}

TEST_F(ReadPicture, upright) {
    OIIO::ImageSpec spec(3, 1, 1, OIIO::TypeDesc::UINT8);
    spec.attribute("Orientation", 6);
    const auto path = (folder_ / "a.tif").string();
    auto output = OIIO::ImageOutput::create(path);
    ASSERT_TRUE(output->open(path, spec));
    const float pixels[] = {0.0F, 1.0F, 1.0F};
    ASSERT_TRUE(output->write_image(OIIO::TypeDesc::FLOAT, pixels) && output->close());
    const auto picture = readGood(path);
    EXPECT_EQ(picture.luminance, (storage::Luminance{1, 3, {0.0F, 1.0F, 1.0F}}));
}

/// The format is what the bytes are, whatever the name says.
TEST_F(ReadPicture, byItsBytesAndNotItsName) {
    const auto path = write(folder_ / "a.png", {2, 2, 1}, {0, 0, 1, 1});
    fs::rename(path, folder_ / "a.jpg");
    EXPECT_EQ(readGood(folder_ / "a.jpg").luminance.values, (std::vector<float>{0, 0, 1, 1}));
}

void expectError(const fs::path& path, ErrorCode code, const std::string& part, std::uint64_t memory = 0) {
    const auto picture = read(path, memory);
    ASSERT_FALSE(picture.ok()) << path;
    EXPECT_EQ(picture.error().code, code) << picture.error().toString();
    EXPECT_NE(picture.error().toString().find(part), std::string::npos) << picture.error().toString();
}

TEST_F(ReadPicture, whatIsNoPicture) {
    std::ofstream(folder_ / "empty.png").close();
    std::ofstream(folder_ / "text.png") << "This is not a picture";
    expectError(folder_ / "none.png", ErrorCode::notFound, "none.png");
    expectError(folder_ / "empty.png", ErrorCode::corrupt, "is empty");
    expectError(folder_ / "text.png", ErrorCode::unsupported, "PNG, JPEG, TIFF or OpenEXR");
    expectError(folder_.path(), ErrorCode::corrupt, "regular file");
}

/// Every file cut short anywhere is an error or, where only what follows the pixels is gone, the picture.
TEST_F(ReadPicture, cutShort) {
#ifdef __SANITIZE_ADDRESS__
    const __lsan::ScopedDisabler libpngJumps;  // past the ends of OpenImageIO's strings
#endif
    std::vector<float> values(64 * 64 * 3);
    for (std::size_t i = 0; i < values.size(); ++i) values[i] = static_cast<float>(i * 7919 % 256) / 255.0F;
    for (const char* name : {"a.png", "a.jpg", "a.tif", "a.exr"}) {
        const bool exr = std::string(name) == "a.exr";
        const auto path =
            write(folder_ / name, {64, 64, 3, exr ? OIIO::TypeDesc::HALF : OIIO::TypeDesc::UINT8}, values);
        const auto whole = readGood(path);
        const auto size = fs::file_size(path);
        for (const double part : {0.001, 0.01, 0.1, 0.3, 0.5, 0.7, 0.9, 0.99}) {
            const auto cut = folder_ / (std::string("cut-") + name);
            fs::copy_file(path, cut, fs::copy_options::overwrite_existing);
            fs::resize_file(cut, static_cast<std::uintmax_t>(static_cast<double>(size) * part));
            const auto picture = read(cut);
            if (picture.ok()) {
                EXPECT_EQ(picture->luminance, whole.luminance) << name << " " << part;
            }
            EXPECT_TRUE(!picture.ok() || part >= 0.7) << name << " " << part;
        }
    }
}

/// A header that promises 2^31 pixels and a file of 60 bytes: refused before memory is taken.
TEST_F(ReadPicture, hugeAndZeroSized) {
    const auto path = write(folder_ / "a.png", {2, 2, 1}, {0, 0, 1, 1});
    std::fstream file(path, std::ios::in | std::ios::out | std::ios::binary);
    file.seekp(16);  // of the width in IHDR; its checksum is then wrong, too, and either error will do
    file.write("\0\0\xff\xff\0\0\xff\xff", 8);
    file.close();
    EXPECT_FALSE(read(path).ok());

    OIIO::ImageSpec spec(60000, 5000, 1, OIIO::TypeDesc::UINT8);
    const auto wide = (folder_ / "wide.tif").string();
    auto output = OIIO::ImageOutput::create(wide);
    ASSERT_TRUE(output->open(wide, spec) && output->close());  // no pixels are ever written
    expectError(wide, ErrorCode::resourceExhausted, "60000 x 5000");
    const auto large = write(folder_ / "large.tif", {1000, 1000, 1}, std::vector<float>(1000000, 0.5F));
    expectError(large, ErrorCode::resourceExhausted, "the limit is 1 MiB", 1 << 20);
}

TEST_F(ReadPicture, canBeCancelled) {
    const auto path = write(folder_ / "a.tif", {10, 1000, 1}, std::vector<float>(10000, 0.5F));
    QuietProgress progress(3);
    const auto picture = prep::readPicture(path, 0, progress);
    ASSERT_FALSE(picture.ok());
    EXPECT_EQ(picture.error().code, ErrorCode::cancelled);
}

}  // namespace
}  // namespace mote::test
