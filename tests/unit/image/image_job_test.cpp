// SPDX-License-Identifier: GPL-3.0-or-later
//
// From a picture file to a dataset and back, and what becomes of damage.
#include <OpenImageIO/imageio.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <fstream>

#include "preprocess/image/image_job.h"
#include "preprocess/image/read_picture.h"
#include "protocol/scene/srgb.h"
#include "storage/dataset_writer.h"
#include "storage/files/dataset_file.h"
#include "storage/image/image_file.h"
#include "storage/manifest.h"
#include "storage/verify.h"
#include "tests/support/temp_dir.h"
#include "tests/unit/particles/quiet_progress.h"

namespace mote::test {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

class ImageJob : public ::testing::Test {
  protected:
    ImageJob() {
        OIIO::ImageSpec spec(300, 200, 3, OIIO::TypeDesc::UINT8);
        std::vector<float> values(300 * 200 * 3);
        for (std::size_t i = 0; i < values.size(); ++i) values[i] = static_cast<float>(i % 256) / 255.0F;
        auto output = OIIO::ImageOutput::create(input_.string());
        EXPECT_TRUE(output->open(input_.string(), spec));
        EXPECT_TRUE(output->write_image(OIIO::TypeDesc::FLOAT, values.data()) && output->close());
    }

    Result<proto::Manifest> make(const fs::path& output, long cancelAfter = -1) {
        proto::JobRequest request;
        request.set_output(output.string());
        request.mutable_image()->set_input(input_.string());
        QuietProgress progress(cancelAfter);
        return prep::runImageJob(request, input_, output, {}, progress);
    }

    TempDir folder_;
    fs::path input_ = folder_ / "photo.png";
};

TEST_F(ImageJob, readsBackWhatWasRead) {
    const auto made = make(folder_ / "a.mote");
    ASSERT_TRUE(made.ok()) << made.error().toString();
    const auto manifest = storage::readManifest(folder_ / "a.mote");
    ASSERT_TRUE(manifest.ok()) << manifest.error().toString();
    EXPECT_EQ(manifest->title(), "photo.png");
    EXPECT_EQ(manifest->request().image().input(), "photo.png");
    EXPECT_EQ(manifest->image().color_space(), "sRGB");
    const auto read = storage::readImage(folder_ / "a.mote", *manifest);
    ASSERT_TRUE(read.ok()) << read.error().toString();
    QuietProgress progress;
    const auto picture = prep::readPicture(input_, 0, progress);
    ASSERT_TRUE(picture.ok());
    EXPECT_EQ(*read, picture->luminance);
    EXPECT_TRUE(storage::verifyDataset(folder_ / "a.mote").empty());
}

/// The light of 8 bits comes back to the same bits.
TEST_F(ImageJob, keepsItsColours) {
    ASSERT_TRUE(make(folder_ / "a.mote").ok());
    const auto manifest = *storage::readManifest(folder_ / "a.mote");
    const auto colors = storage::readColors(folder_ / "a.mote", manifest);
    ASSERT_TRUE(colors.ok()) << colors.error().toString();
    ASSERT_EQ(colors->values.size(), 300U * 200U);
    EXPECT_EQ(colors->columns, 300.0);
    for (std::size_t i = 0; i < colors->values.size(); ++i) {
        for (int c = 0; c < 3; ++c) {
            const auto stored = static_cast<long>((3 * i + static_cast<std::size_t>(c)) % 256);
            ASSERT_EQ(std::lround(255.0 * linearToSrgb(double{colors->values[i][c]})), stored) << i;
        }
    }
    const auto few = storage::readColors(folder_ / "a.mote", manifest, 1000);  // by 8
    ASSERT_TRUE(few.ok());
    EXPECT_EQ(few->width, 38U);
    EXPECT_EQ(few->columns, 37.5);
    glm::dvec3 corner(0.0);  // 4 x 8 pixels are left at the right edge
    for (std::size_t y = 192; y < 200; ++y) {
        for (std::size_t x = 296; x < 300; ++x) corner += glm::dvec3(colors->at(x, y)) / 32.0;
    }
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(double{few->at(37, 24)[c]}, corner[c], 1e-6);
}

/// As datasets are that were made before there were colours.
TEST_F(ImageJob, withoutColoursItIsGrey) {
    ASSERT_TRUE(make(folder_ / "a.mote").ok());
    const storage::Luminance picture{2, 1, {0.25F, 3.0F}};
    auto manifest = *storage::readManifest(folder_ / "a.mote");
    manifest.clear_files();
    manifest.mutable_image()->set_width(2);
    manifest.mutable_image()->set_height(1);
    auto writer = storage::DatasetWriter::create(folder_ / "grey.mote");
    ASSERT_TRUE(writer.ok() && storage::writeImage(writer->directory(), picture).ok());
    ASSERT_TRUE(writer->add("image.h5").ok() && writer->add("image.digest").ok());
    ASSERT_TRUE(writer->publish(manifest).ok());
    const auto colors =
        storage::readColors(folder_ / "grey.mote", *storage::readManifest(folder_ / "grey.mote"));
    ASSERT_TRUE(colors.ok()) << colors.error().toString();
    EXPECT_EQ(colors->values, (std::vector{glm::vec3(0.25F), glm::vec3(3.0F)}));
}

TEST(HalfBits, AreTheNearestThatCanBeShown) {
    EXPECT_EQ(storage::halfBits(0.0F), 0);
    EXPECT_EQ(storage::halfBits(-1.0F), 0);
    EXPECT_EQ(storage::halfBits(1.0F), 0x3c00);
    EXPECT_EQ(storage::halfBits(0x1p-24F), 1);  // the least
    EXPECT_EQ(storage::halfBits(65504.0F), 0x7bff);
    EXPECT_EQ(storage::halfBits(1e30F), 0x7bff);
}

/// A mean of means is that of all, where the factor divides the sides: 300 x 200 by 2 is 15,000 pixels.
TEST_F(ImageJob, largeImagesAreAveragedDown) {
    ASSERT_TRUE(make(folder_ / "a.mote").ok());
    const auto manifest = *storage::readManifest(folder_ / "a.mote");
    const auto whole = storage::readImage(folder_ / "a.mote", manifest);
    const auto half = storage::readImage(folder_ / "a.mote", manifest, 15000);
    ASSERT_TRUE(whole.ok() && half.ok());
    ASSERT_EQ(half->width, 150u);
    ASSERT_EQ(half->height, 100u);
    EXPECT_NEAR(half->at(7, 9),
                (whole->at(14, 18) + whole->at(15, 18) + whole->at(14, 19) + whole->at(15, 19)) / 4.0F,
                1e-6F);
    const auto odd = storage::readImage(folder_ / "a.mote", manifest, 1000);  // by 8
    ASSERT_TRUE(odd.ok());
    EXPECT_EQ(odd->width, 38u);
    EXPECT_EQ(odd->height, 25u);
    double corner = 0.0;  // 4 x 8 pixels are left at the right edge
    for (std::size_t y = 192; y < 200; ++y) {
        for (std::size_t x = 296; x < 300; ++x) corner += whole->at(x, y) / 32.0;
    }
    EXPECT_NEAR(odd->at(37, 24), corner, 1e-6);
}

TEST_F(ImageJob, sameFileSameBytes) {
    ASSERT_TRUE(make(folder_ / "a.mote").ok());
    ASSERT_TRUE(make(folder_ / "b.mote").ok());
    for (const char* name : {"manifest.json", "image.h5", "image.digest"}) {
        const auto a = storage::readWhole(folder_ / "a.mote" / name, 1 << 24);
        const auto b = storage::readWhole(folder_ / "b.mote" / name, 1 << 24);
        ASSERT_TRUE(a.ok() && b.ok());
        EXPECT_TRUE(*a == *b) << name;
    }
}

void flipBit(const fs::path& path, std::streamoff fromEnd) {
    std::fstream file(path, std::ios::in | std::ios::out | std::ios::binary);
    file.seekg(-fromEnd, std::ios::end);
    const auto byte = static_cast<char>(file.peek() ^ 4);
    file.seekp(-fromEnd, std::ios::end);
    file.put(byte);
}

/// Colours come last, of 360,000 bytes; before them the luminance, of 240,000.
TEST_F(ImageJob, aFlippedBitIsFoundAndNamed) {
    ASSERT_TRUE(make(folder_ / "a.mote").ok());
    const auto manifest = *storage::readManifest(folder_ / "a.mote");
    flipBit(folder_ / "a.mote" / "image.h5", 1000);
    EXPECT_TRUE(storage::readImage(folder_ / "a.mote", manifest).ok());
    const auto colors = storage::readColors(folder_ / "a.mote", manifest);
    ASSERT_FALSE(colors.ok());
    EXPECT_EQ(colors.error().code, ErrorCode::corrupt);
    EXPECT_THAT(colors.error().toString(), HasSubstr("image.h5:/image/color"));
    EXPECT_FALSE(storage::verifyDataset(folder_ / "a.mote").empty());
    flipBit(folder_ / "a.mote" / "image.h5", 400'000);
    const auto read = storage::readImage(folder_ / "a.mote", manifest);
    ASSERT_FALSE(read.ok());
    EXPECT_EQ(read.error().code, ErrorCode::corrupt);
    EXPECT_THAT(read.error().toString(), HasSubstr("image.h5:/image/luminance"));
}

TEST_F(ImageJob, leavesNothingBehindWhenItFails) {
    for (long after = 0; after < 6; ++after) {
        const auto made = make(folder_ / "a.mote", after);
        if (made.ok()) fs::remove_all(folder_ / "a.mote");
        std::size_t files = 0;
        for ([[maybe_unused]] const auto& entry : fs::directory_iterator(folder_.path())) ++files;
        EXPECT_EQ(files, 1u) << after;
    }
    ASSERT_TRUE(make(folder_ / "a.mote").ok());
    const auto again = make(folder_ / "a.mote");
    ASSERT_FALSE(again.ok());
    EXPECT_EQ(again.error().code, ErrorCode::alreadyExists);
}

TEST_F(ImageJob, manifestsThatContradictThemselves) {
    ASSERT_TRUE(make(folder_ / "a.mote").ok());
    auto manifest = *storage::readManifest(folder_ / "a.mote");
    auto wrong = manifest;
    wrong.mutable_image()->set_width(0);
    EXPECT_FALSE(storage::checkManifest(wrong).ok());
    wrong.mutable_image()->set_width(1u << 30);
    EXPECT_FALSE(storage::checkManifest(wrong).ok());
    wrong = manifest;
    wrong.mutable_image()->set_width(299);
    ASSERT_TRUE(storage::checkManifest(wrong).ok());
    EXPECT_FALSE(storage::readImage(folder_ / "a.mote", wrong).ok());
    wrong = manifest;
    wrong.clear_files();
    EXPECT_FALSE(storage::checkManifest(wrong).ok());
}

}  // namespace
}  // namespace mote::test

#ifdef __SANITIZE_ADDRESS__
#include <sanitizer/lsan_interface.h>
#endif

#include <fstream>
#include <limits>

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
            EXPECT_EQ(picture.colors, (std::vector<std::uint16_t>{
                                          0x3c00, 0, 0, 0,
                                          storage::halfBits(static_cast<float>(srgbToLinear(0.4))), 0x3c00}));
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
    spec.nchannels = 3;
    std::vector<float> colored;
    for (const float value : values) colored.insert(colored.end(), {value, 0.0F, 2.0F * value});
    const auto other = OIIO::ImageOutput::create((folder_ / "b.exr").string());
    ASSERT_TRUE(other->open((folder_ / "b.exr").string(), spec) &&
                other->write_image(OIIO::TypeDesc::FLOAT, colored.data()));
    ASSERT_TRUE(other->close());
    const auto colors = readGood(folder_ / "b.exr").colors;
    ASSERT_EQ(colors.size(), 36U);
    for (std::size_t i = 0; i < 12; ++i) {
        EXPECT_EQ(colors[3 * i], storage::halfBits(picture.values[i])) << i;
        EXPECT_EQ(colors[3 * i + 2], storage::halfBits(2.0F * picture.values[i])) << i;
    }
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
    for (std::size_t i = 0; i < 9; ++i)
        EXPECT_EQ(picture.colors[i], storage::halfBits(picture.luminance.at(i / 3, 0))) << "it is grey";
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
    EXPECT_TRUE(picture.colors.empty());
    spec.nchannels = 3;
    spec.attribute("Orientation", 3);
    const auto turned = (folder_ / "b.tif").string();
    output = OIIO::ImageOutput::create(turned);
    ASSERT_TRUE(output->open(turned, spec));
    const float colors[] = {1.0F, 0.0F, 0.0F, 0.0F, 1.0F, 0.0F, 0.0F, 0.0F, 1.0F};
    ASSERT_TRUE(output->write_image(OIIO::TypeDesc::FLOAT, colors) && output->close());
    constexpr std::uint16_t one = 0x3c00;
    EXPECT_EQ(readGood(turned).colors, (std::vector<std::uint16_t>{0, 0, one, 0, one, 0, one, 0, 0}));
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

/// What a viewer shows of the stored rows "abc" / "def" (Exif 2.3, orientation), by letters.
std::string shown(int orientation) {
    const auto turned = prep::upright({3, 2, {'a', 'b', 'c', 'd', 'e', 'f'}}, orientation);
    std::string text;
    for (std::size_t i = 0; i < turned.values.size(); ++i) {
        if (i > 0 && i % turned.width == 0) text += '/';
        text += static_cast<char>(turned.values[i]);
    }
    return text;
}

TEST(Upright, allOrientations) {
    EXPECT_EQ(shown(1), "abc/def");
    EXPECT_EQ(shown(2), "cba/fed");
    EXPECT_EQ(shown(3), "fed/cba");
    EXPECT_EQ(shown(4), "def/abc");
    EXPECT_EQ(shown(5), "ad/be/cf");
    EXPECT_EQ(shown(6), "da/eb/fc");  // turned a quarter clockwise
    EXPECT_EQ(shown(7), "fc/eb/da");
    EXPECT_EQ(shown(8), "cf/be/ad");
    EXPECT_EQ(shown(0), "abc/def");
    EXPECT_EQ(shown(9), "abc/def");
}

}  // namespace
}  // namespace mote::test
