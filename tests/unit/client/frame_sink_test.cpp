// SPDX-License-Identifier: GPL-3.0-or-later
#include <OpenImageIO/imageio.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <algorithm>
#include <fstream>
#include <future>

#include "client/frames/frame_sink.h"
#include "client/frames/frame_store.h"
#include "client/frames/picture_file.h"
#include "tests/support/temp_dir.h"
#include "tests/unit/client/fake_server.h"

namespace mote::client {
namespace {

/// A sink on a full disk, whose first frame fails only after the second one has.
class LateFirst : public FrameSink {
  public:
    Status open(bool) override { return success(); }
    bool has(std::size_t, std::string_view, std::uint32_t, std::uint32_t) const override { return false; }
    Status put(DrawnFrame frame) override {
        if (frame.index == 0) second_.get_future().wait();
        if (frame.index == 1) second_.set_value();
        if (frame.index <= 1) return Error{ErrorCode::internal, std::to_string(frame.index), "no space left"};
        return success();
    }
    std::size_t backlog() const override { return 0; }
    Status finish(const std::function<bool(std::size_t)>&) override { return success(); }
    std::filesystem::path fileOf(std::size_t) const override { return {}; }

  private:
    std::promise<void> second_;
};

DrawnFrame frame(std::size_t index) {
    DrawnFrame drawn;
    drawn.index = index;
    return drawn;
}

/// Waits until a frame was finished or failed.
Result<std::vector<std::size_t>> takeSome(FinishingThreads& threads, std::promise<void>& woken) {
    woken.get_future().wait();
    return threads.take();
}

TEST(FinishingThreads, TellTheFirstFrameThatFailedWhicheverFailedFirst) {
    LateFirst sink;
    std::promise<void> woken;
    std::once_flag once;
    FinishingThreads threads(sink, 2, [&] { std::call_once(once, [&] { woken.set_value(); }); });
    threads.post(frame(0));
    threads.post(frame(1));
    const auto taken = takeSome(threads, woken);
    ASSERT_FALSE(taken.ok());
    EXPECT_EQ(taken.error().where, "0");
}

TEST(FinishingThreads, GiveEachFrameOnce) {
    LateFirst sink;
    std::promise<void> woken;
    FinishingThreads threads(sink, 1, [&] { woken.set_value(); });
    threads.post(frame(7));
    const auto taken = takeSome(threads, woken);
    ASSERT_TRUE(taken.ok());
    EXPECT_EQ(*taken, std::vector<std::size_t>{7});
    EXPECT_EQ(threads.open(), 0U);
    EXPECT_TRUE(threads.take()->empty());
}

constexpr const char* key = "0123456789abcdef0123456789abcdef";

class FrameStoreTest : public testing::Test {
  protected:
    FramePixels pixels(std::uint32_t width) const {
        return {width, 4, proto::SRGB8, test::samplePixels(width, 4, proto::SRGB8)};
    }

    test::TempDir folder_;
    FrameStore store_{folder_ / "film.mp4"};
};

TEST_F(FrameStoreTest, GivesBackWhatWasPut) {
    ASSERT_TRUE(store_.open(false).ok());
    EXPECT_FALSE(store_.has(0, key));
    ASSERT_TRUE(store_.put(0, key, pixels(8), {}).ok());
    const auto payload = test::zstdPayload(pixels(9).bytes, 9, proto::SRGB8);
    ASSERT_TRUE(store_.put(7, key, pixels(9), {payload.begin(), payload.end()}).ok());
    EXPECT_TRUE(store_.has(0, key));
    EXPECT_TRUE(store_.has(7, key));
    EXPECT_FALSE(store_.has(1, key));
    EXPECT_EQ(store_.read(0)->bytes, pixels(8).bytes);
    EXPECT_EQ(store_.read(7)->bytes, pixels(9).bytes);
    EXPECT_EQ(store_.read(1).error().code, ErrorCode::notFound);
}

TEST_F(FrameStoreTest, KnowsWhatAFrameShows) {
    ASSERT_TRUE(store_.open(false).ok());
    ASSERT_TRUE(store_.put(0, key, pixels(8), {}).ok());
    EXPECT_FALSE(store_.has(0, "another"));
    EXPECT_FALSE(store_.has(0, ""));
}

TEST_F(FrameStoreTest, KeepsFramesOnlyWhereAskedTo) {
    ASSERT_TRUE(store_.open(false).ok());
    ASSERT_TRUE(store_.put(0, key, pixels(8), {}).ok());
    ASSERT_TRUE(store_.open(true).ok());
    EXPECT_TRUE(store_.has(0, key));
    ASSERT_TRUE(store_.open(false).ok());
    EXPECT_FALSE(store_.has(0, key));
    store_.discard();
    EXPECT_FALSE(std::filesystem::exists(store_.folder()));
}

/// Every byte of a frame's file changed, and every length of it: never a wrong picture.
TEST_F(FrameStoreTest, DamageIsNoPicture) {
    ASSERT_TRUE(store_.open(false).ok());
    ASSERT_TRUE(store_.put(0, key, pixels(8), {}).ok());
    const auto path = store_.folder() / "frame-000000";
    std::ifstream file(path, std::ios::binary);
    const std::string whole{std::istreambuf_iterator<char>(file), {}};
    const auto write = [&](const std::string& bytes) { std::ofstream(path, std::ios::binary) << bytes; };
    for (std::size_t size = 0; size < whole.size(); ++size) {
        write(whole.substr(0, size));
        EXPECT_FALSE(store_.has(0, key)) << size;
        EXPECT_FALSE(store_.read(0).ok()) << size;
    }
    for (std::size_t place = 0; place < whole.size(); ++place) {
        auto changed = whole;
        changed[place] = static_cast<char>(changed[place] ^ 0x15);
        write(changed);
        const auto read = store_.read(0);
        // A byte of the heading that says nothing about the pixels may change, and zstd's checksum finds the
        // others.
        EXPECT_TRUE(!read.ok() || read->bytes == pixels(8).bytes) << place;
    }
}

TEST_F(FrameStoreTest, AFileInItsPlaceIsSaid) {
    std::ofstream(folder_ / ".film.mp4.frames") << "a file";
    const auto opened = store_.open(true);
    ASSERT_FALSE(opened.ok());
    EXPECT_NE(opened.error().toString().find(".film.mp4.frames"), std::string::npos);
}

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
