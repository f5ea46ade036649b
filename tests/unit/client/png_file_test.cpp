// SPDX-License-Identifier: GPL-3.0-or-later
#include <OpenImageIO/imageio.h>
#include <gtest/gtest.h>
#include <algorithm>
#include <cmath>
#include <fstream>
#include <functional>
#include <random>
#include <tuple>

#include "client/frames/picture_file.h"
#include "client/shared/png_file.h"
#include "tests/support/temp_dir.h"

namespace mote::client {
namespace {

using Bytes = std::vector<std::uint8_t>;

enum class Content { smooth, noise, dots, flat };

/// Samples of 8 or 16 bits, the high byte first.
Bytes contentOf(Content content, std::uint32_t width, std::uint32_t height, unsigned channels,
                unsigned bits) {
    std::mt19937 random(width * 7919 + height);
    Bytes bytes;
    for (std::size_t i = 0; i < std::size_t{width} * height * channels; ++i) {
        const double x = static_cast<double>(i / channels % width),
                     y = static_cast<double>(i / channels / width);
        double value = 0.25;
        if (content == Content::smooth)
            value = 0.5 + 0.2 * std::sin(x / 37 + i % channels) + 0.2 * std::sin(y / 23);
        if (content == Content::noise) value = random() / 4294967296.0;
        if (content == Content::dots) value = random() % 50 == 0 ? random() / 4294967296.0 : 0.0;
        const auto sample = static_cast<unsigned>(value * (bits == 8 ? 256 : 65536));
        if (bits == 16) bytes.push_back(static_cast<std::uint8_t>(sample >> 8));
        bytes.push_back(static_cast<std::uint8_t>(sample));
    }
    return bytes;
}

/// The same without the last of four channels.
Bytes colorsOf(const Bytes& bytes, unsigned channels, unsigned bits) {
    Bytes colors;
    for (std::size_t i = 0; i < bytes.size(); ++i) {
        if (i / (bits / 8) % channels < 3) colors.push_back(bytes[i]);
    }
    return colors;
}

void writeBytes(const std::filesystem::path& path, const Bytes& bytes) {
    std::ofstream(path, std::ios::binary)
        .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
}

/// Of OpenImageIO, which knows nothing of ours: R, G and B.
struct Read {
    int width = 0, height = 0;
    std::string description, colorSpace;
    Bytes bytes;
};

Read readByOthers(const std::filesystem::path& path, unsigned bits) {
    const auto input = OIIO::ImageInput::open(path.string());
    if (!input) throw std::runtime_error(OIIO::geterror());
    const auto& spec = input->spec();
    EXPECT_EQ(spec.nchannels, 3);
    EXPECT_EQ(spec.format, bits == 8 ? OIIO::TypeDesc::UINT8 : OIIO::TypeDesc::UINT16);
    Read read{spec.width, spec.height, std::string(spec.get_string_attribute("ImageDescription")),
              std::string(spec.get_string_attribute("oiio:ColorSpace")), Bytes(spec.image_bytes(true))};
    EXPECT_TRUE(input->read_image(0, 0, 0, 3, spec.format, read.bytes.data())) << input->geterror();
    for (std::size_t i = 0; bits == 16 && i < read.bytes.size(); i += 2)
        std::swap(read.bytes[i], read.bytes[i + 1]);
    return read;
}

class PngFile : public testing::TestWithParam<std::tuple<Content, unsigned, unsigned>> {
  protected:
    test::TempDir folder_;
};

TEST_P(PngFile, IsReadByOthersAndByUs) {
    const auto [content, channels, bits] = GetParam();
    for (const auto& [width, height] : {std::pair{1U, 1U}, {1U, 7U}, {9U, 1U}, {40U, 30U}, {211U, 301U}}) {
        const auto bytes = contentOf(content, width, height, channels, bits);
        const auto colors = colorsOf(bytes, channels, bits);
        const auto file = encodePng({width, height, bits, channels, bytes}, "what it shows");
        EXPECT_EQ(encodePng({width, height, bits, channels, bytes}, "what it shows"), file);
        writeBytes(folder_ / "a.png", file);
        const auto read = readByOthers(folder_ / "a.png", bits);
        EXPECT_EQ(read.width, static_cast<int>(width));
        EXPECT_EQ(read.height, static_cast<int>(height));
        EXPECT_EQ(read.description, "what it shows");
        EXPECT_EQ(read.colorSpace, "sRGB");
        EXPECT_EQ(read.bytes, colors);
        const auto ours = readPng(file);
        ASSERT_TRUE(ours.ok()) << ours.error().toString();
        EXPECT_EQ(ours->bytes, colors);
        EXPECT_EQ(ours->bits, bits);
        EXPECT_EQ(ours->description, "what it shows");
    }
}

INSTANTIATE_TEST_SUITE_P(Contents, PngFile,
                         testing::Combine(testing::Values(Content::smooth, Content::noise, Content::dots,
                                                          Content::flat),
                                          testing::Values(3U, 4U), testing::Values(8U, 16U)));

TEST(PngFileWithOpacity, IsReadByOthers) {
    const test::TempDir folder;
    for (const auto content : {Content::smooth, Content::noise, Content::flat}) {
        const auto bytes = contentOf(content, 211, 30, 4, 8);
        writeBytes(folder / "a.png", encodePng({211, 30, 8, 4, bytes, true}));
        OIIO::ImageSpec config;
        config["oiio:UnassociatedAlpha"] = 1;
        const auto input = OIIO::ImageInput::open((folder / "a.png").string(), &config);
        ASSERT_TRUE(input) << OIIO::geterror();
        ASSERT_EQ(input->spec().nchannels, 4);
        Bytes read(bytes.size());
        ASSERT_TRUE(input->read_image(0, 0, 0, 4, OIIO::TypeDesc::UINT8, read.data()));
        EXPECT_EQ(read, bytes);
    }
}

/// libpng's filters are all five; a file of an earlier version of ours was written by it.
TEST(ReadPng, TakesFilesThatOthersWrote) {
    const test::TempDir folder;
    const auto path = folder / "a.png";
    for (const auto content : {Content::smooth, Content::noise, Content::dots}) {
        const auto bytes = contentOf(content, 120, 90, 3, 8);
        const auto output = OIIO::ImageOutput::create(path.string());
        ASSERT_TRUE(output->open(path.string(), OIIO::ImageSpec(120, 90, 3, OIIO::TypeDesc::UINT8)));
        ASSERT_TRUE(output->write_image(OIIO::TypeDesc::UINT8, bytes.data()) && output->close());
        std::ifstream stream(path, std::ios::binary);
        const Bytes file{std::istreambuf_iterator<char>(stream), {}};
        const auto read = readPng(file);
        ASSERT_TRUE(read.ok()) << read.error().toString();
        EXPECT_EQ(read->bytes, bytes);
        EXPECT_EQ(readPictureFrame(path)->width, 120U);
    }
}

/// Every byte of a file changed, and every length of it.
TEST(ReadPng, TakesNoDamagedFile) {
    const auto file = encodePng({9, 5, 8, 3, contentOf(Content::smooth, 9, 5, 3, 8)}, "key");
    ASSERT_TRUE(readPng(file).ok());
    for (std::size_t size = 0; size < file.size(); ++size) {
        EXPECT_FALSE(readPng(std::span(file).first(size)).ok()) << size;
    }
    for (std::size_t place = 0; place < file.size(); ++place) {
        auto changed = file;
        changed[place] ^= 0x15;
        EXPECT_FALSE(readPng(changed).ok()) << place;
    }
    auto longer = file;
    longer.push_back(0);
    EXPECT_FALSE(readPng(longer).ok());
}

/// CRC-32 of ISO/IEC 15948, Annex D.
std::uint32_t sumOf(const Bytes& bytes, std::size_t begin, std::size_t end) {
    std::uint32_t sum = 0xffffffffU;
    for (std::size_t i = begin; i < end; ++i) {
        sum ^= bytes[i];
        for (int bit = 0; bit < 8; ++bit) sum = sum >> 1 ^ (sum & 1U) * 0xedb88320U;
    }
    return ~sum;
}

/// A header that says something else, and says it soundly.
Bytes withHeader(Bytes file, const std::function<void(std::uint8_t* header)>& change) {
    constexpr std::size_t type = 12, header = 16, end = 29;
    change(&file[header]);
    const auto sum = sumOf(file, type, end);
    for (std::size_t i = 0; i < 4; ++i) file[end + i] = static_cast<std::uint8_t>(sum >> (24 - 8 * i));
    return file;
}

TEST(ReadPng, LooksAtTheSizeBeforeItTakesMemory) {
    const auto file = encodePng({9, 5, 8, 3, contentOf(Content::flat, 9, 5, 3, 8)}, "");
    EXPECT_TRUE(readPng(withHeader(file, [](std::uint8_t*) {})).ok());
    const auto huge = readPng(withHeader(file, [](std::uint8_t* header) { header[0] = header[4] = 0x7f; }));
    EXPECT_EQ(huge.error().code, ErrorCode::corrupt);
    const auto taller = readPng(withHeader(file, [](std::uint8_t* header) { header[7] = 6; }));
    EXPECT_EQ(taller.error().code, ErrorCode::corrupt);
    const auto lower = readPng(withHeader(file, [](std::uint8_t* header) { header[7] = 4; }));
    EXPECT_EQ(lower.error().code, ErrorCode::corrupt);
    const auto grey = readPng(withHeader(file, [](std::uint8_t* header) { header[9] = 0; }));
    EXPECT_EQ(grey.error().code, ErrorCode::unsupported);
    const auto woven = readPng(withHeader(file, [](std::uint8_t* header) { header[12] = 1; }));
    EXPECT_EQ(woven.error().code, ErrorCode::unsupported);
}

/// Smooth pictures are stored as differences, in less than half of the bytes that OpenImageIO takes without
/// any; of points on black the colours stay, in fewer bytes than as differences.
TEST(EncodePng, ChoosesFiltersByContent) {
    const auto bytesOfOthers = [](const Bytes& bytes, int filter) {
        const test::TempDir folder;
        const auto path = folder / "a.png";
        const auto output = OIIO::ImageOutput::create(path.string());
        OIIO::ImageSpec spec(320, 200, 3, OIIO::TypeDesc::UINT8);
        spec.attribute("png:filter", filter);
        EXPECT_TRUE(output->open(path.string(), spec) &&
                    output->write_image(OIIO::TypeDesc::UINT8, bytes.data()) && output->close());
        return std::filesystem::file_size(path);
    };
    constexpr int none = 8, up = 32;  // libpng's
    const auto smooth = contentOf(Content::smooth, 320, 200, 3, 8),
               dots = contentOf(Content::dots, 320, 200, 3, 8);
    EXPECT_LT(encodePng({320, 200, 8, 3, smooth}).size(), bytesOfOthers(smooth, none) / 2);
    EXPECT_LT(encodePng({320, 200, 8, 3, dots}).size(), bytesOfOthers(dots, up));
}

/// IEC 61966-2-1.
double encodedSrgb(double linear) {
    return linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1 / 2.4) - 0.055;
}

/// Of IEEE 754, binary16; finite ones that are not negative.
double halfOf(unsigned bits) {
    const unsigned exponent = bits >> 10, fraction = bits & 1023U;
    return exponent == 0 ? std::ldexp(fraction, -24)
                         : std::ldexp(1024 + fraction, static_cast<int>(exponent) - 25);
}

TEST(DeepPng, HoldsLightAsSrgbOf16Bits) {
    const test::TempDir folder;
    FramePixels pixels{128, 121, proto::LINEAR_HALF, {}};
    std::vector<unsigned> halves;
    for (unsigned i = 0; i < 128 * 121; ++i) {
        halves.push_back(i);  // from 0 to a little above 1
        for (const unsigned half : {i, 0x8001U, 0x7c00U, 0x3c00U}) {
            pixels.bytes.push_back(static_cast<std::uint8_t>(half));
            pixels.bytes.push_back(static_cast<std::uint8_t>(half >> 8));
        }
    }
    const auto bytes = encodePicture(pixels, PictureFormat::png16, "00ff");
    ASSERT_TRUE(bytes.ok());
    writeBytes(folder / "a.png", *bytes);
    EXPECT_EQ(readPictureKey(folder / "a.png", PictureFormat::png16, 128, 121), "00ff");
    EXPECT_FALSE(readPictureKey(folder / "a.png", PictureFormat::png, 128, 121));
    const auto read = readByOthers(folder / "a.png", 16).bytes;
    const auto frame = readPictureFrame(folder / "a.png");
    ASSERT_TRUE(frame.ok());
    for (std::size_t i = 0; i < halves.size(); ++i) {
        const int sample = read[6 * i] << 8 | read[6 * i + 1];
        ASSERT_NEAR(sample, 65535 * encodedSrgb(std::min(1.0, halfOf(halves[i]))), 0.501) << i;
        ASSERT_EQ(read[6 * i + 2] << 8 | read[6 * i + 3], 0) << "less than nothing is black";
        ASSERT_EQ(read[6 * i + 4] << 8 | read[6 * i + 5], 0) << "what is not finite is black";
        ASSERT_NEAR(frame->bytes[4 * i], sample / 257.0, 0.501);
    }
}

}  // namespace
}  // namespace mote::client
