// SPDX-License-Identifier: GPL-3.0-or-later
//
// GIF films and their palettes.
#include <gtest/gtest.h>
#include <algorithm>
#include <cmath>
#include <cstring>
#include <vector>

#include "client/frames/video/gif_palette.h"
#include "client/frames/video/video_colors.h"
#include "client/frames/video/video_writer.h"
#include "tests/support/random.h"
#include "tests/support/temp_dir.h"
#include "tests/unit/client/film_reader.h"

namespace mote::client {
namespace {

using test::Rgba;

class Gif : public testing::Test {
  protected:
    static GifPalette paletteOf(const std::vector<Rgba>& frames) {
        PaletteMaker maker;
        for (const auto& frame : frames) maker.add(frame);
        return maker.make();
    }

    void write(const std::string& name, std::uint32_t width, std::uint32_t height,
               const std::vector<Rgba>& frames, double fps = 25) const {
        auto writer = VideoWriter::create(folder_ / name, {VideoFormat::gif, width, height, fps, {}, {}},
                                          paletteOf(frames));
        ASSERT_TRUE(writer.ok()) << writer.error().toString();
        for (const auto& frame : frames) ASSERT_TRUE((*writer)->add(frame).ok());
        const auto done = (*writer)->finish();
        ASSERT_TRUE(done.ok()) << done.error().toString();
    }

    test::TempDir folder_;
};

/// Smooth in all three channels: far more than 255 colours.
Rgba gradient(std::uint32_t width, std::uint32_t height) {
    Rgba rgba;
    for (std::uint32_t y = 0; y < height; ++y) {
        for (std::uint32_t x = 0; x < width; ++x) {
            const double s = x / (width - 1.0), t = y / (height - 1.0);
            rgba.insert(rgba.end(),
                        {static_cast<std::uint8_t>(255 * s), static_cast<std::uint8_t>(200 * s * t),
                         static_cast<std::uint8_t>(120 * (1 - s) * t), 255});
        }
    }
    return rgba;
}

/// Mean of boxes of 8 x 8 pixels, as the eye has it from afar.
std::vector<double> boxes(const Rgba& rgba, std::uint32_t width, std::uint32_t height) {
    std::vector<double> sums(std::size_t{3} * (width / 8) * (height / 8));
    for (std::uint32_t y = 0; y < height; ++y) {
        for (std::uint32_t x = 0; x < width; ++x) {
            for (std::size_t c = 0; c < 3; ++c) {
                sums[3 * (y / 8 * (width / 8) + x / 8) + c] += rgba[4 * (y * width + x) + c] / 64.0;
            }
        }
    }
    return sums;
}

bool samePixel(const Rgba& a, const Rgba& b, std::size_t byte) {
    return std::memcmp(a.data() + byte, b.data() + byte, 4) == 0;
}

TEST_F(Gif, FewColoursAreExact) {
    test::Random random(5);
    std::vector<std::array<std::uint8_t, 3>> colors;
    for (int i = 0; i < 255; ++i) {
        colors.push_back({static_cast<std::uint8_t>(random.below(256)),
                          static_cast<std::uint8_t>(random.below(256)),
                          static_cast<std::uint8_t>(random.below(256))});
    }
    std::vector<Rgba> frames;
    for (int f = 0; f < 6; ++f) {
        Rgba rgba;
        for (int i = 0; i < 61 * 47; ++i) {
            const auto& [r, g, b] = colors[random.below(255)];
            rgba.insert(rgba.end(), {r, g, b, 255});
        }
        frames.push_back(std::move(rgba));
    }
    write("film.gif", 61, 47, frames);
    const auto film = test::readFilm(folder_ / "film.gif");
    EXPECT_EQ(film.codec, "gif");
    EXPECT_EQ(film.width, 61U);
    EXPECT_EQ(film.height, 47U);
    EXPECT_EQ(film.frames, frames);
}

TEST_F(Gif, ManyColoursAreMetOnAverage) {
    constexpr std::uint32_t width = 256, height = 128;
    write("film.gif", width, height, {gradient(width, height)});
    const auto film = test::readFilm(folder_ / "film.gif");
    ASSERT_EQ(film.frames.size(), 1U);
    EXPECT_GE(test::psnr(film.frames, {gradient(width, height)}), 32);
    const auto wanted = boxes(gradient(width, height), width, height),
               found = boxes(film.frames[0], width, height);
    double sum = 0;
    for (std::size_t i = 0; i < wanted.size(); ++i) sum += (wanted[i] - found[i]) * (wanted[i] - found[i]);
    // Dithered: the means are nearer than the pixels are.
    EXPECT_LE(std::sqrt(sum / static_cast<double>(wanted.size())), 2);
}

TEST_F(Gif, ParticlesAreClose) {
    const auto frames = test::particleFrames(320, 180, 5, 8);
    write("film.gif", 320, 180, frames);
    EXPECT_GE(test::psnr(test::readFilm(folder_ / "film.gif").frames, frames), 32);
}

TEST_F(Gif, WhatRestsKeepsItsPixelsAndCostsNothing) {
    constexpr std::uint32_t width = 200, height = 120;
    const auto still = gradient(width, height);
    std::vector<Rgba> frames(12, still);
    // A small thing moves over it.
    for (std::uint32_t f = 0; f < 12; ++f) {
        for (std::uint32_t y = 40; y < 50; ++y) {
            for (std::uint32_t x = 10 * f; x < 10 * f + 10; ++x) frames[f][4 * (y * width + x) + 2] = 255;
        }
    }
    write("film.gif", width, height, frames);
    const auto film = test::readFilm(folder_ / "film.gif");
    ASSERT_EQ(film.frames.size(), frames.size());
    for (std::size_t f = 1; f < frames.size(); ++f) {
        for (std::size_t i = 0; i < still.size(); i += 4) {
            if (!samePixel(frames[f], frames[f - 1], i)) continue;
            ASSERT_TRUE(samePixel(film.frames[f], film.frames[f - 1], i)) << f << " " << i;
        }
    }
    write("one.gif", width, height, {frames[0]});
    const auto one = test::bytesOf(folder_ / "one.gif").size(),
               all = test::bytesOf(folder_ / "film.gif").size();
    EXPECT_LT(all, one + 11 * 600);  // two patches of 100 pixels between them, and their frame's header
}

TEST_F(Gif, LoopsForEverAndKeepsTime) {
    for (const double fps : {50.0, 30.0, 25.0, 24.0, 29.97, 10.0, 0.5}) {
        std::vector<Rgba> frames;
        for (int f = 0; f < 40; ++f) frames.emplace_back(8 * 8 * 4, static_cast<std::uint8_t>(6 * f));
        write("film.gif", 8, 8, frames, fps);
        const auto bytes = test::bytesOf(folder_ / "film.gif");
        const std::string text(bytes.begin(), bytes.end()), loop("NETSCAPE2.0\x03\x01\x00\x00\x00", 16);
        EXPECT_NE(text.find(loop), std::string::npos);
        const auto film = test::readFilm(folder_ / "film.gif");
        ASSERT_EQ(film.frames.size(), frames.size());
        for (std::size_t i = 0; i < frames.size(); ++i) {
            EXPECT_NEAR(film.times[i], static_cast<double>(i) / fps, 0.00501) << fps;
        }
        EXPECT_NEAR(film.duration, 40 / fps, 0.00501) << fps;
    }
}

TEST_F(Gif, EqualFramesAreKept) {
    const std::vector<Rgba> frames(9, gradient(40, 30));
    write("film.gif", 40, 30, frames, 10);
    const auto film = test::readFilm(folder_ / "film.gif");
    ASSERT_FALSE(film.frames.empty());
    EXPECT_NEAR(film.duration, 0.9, 0.001);
}

TEST_F(Gif, TheSameFramesAreTheSameBytes) {
    const auto frames = test::particleFrames(160, 90, 6, 4);
    write("a.gif", 160, 90, frames);
    write("b.gif", 160, 90, frames);
    const auto bytes = test::bytesOf(folder_ / "a.gif");
    EXPECT_EQ(bytes, test::bytesOf(folder_ / "b.gif"));
    const std::string text(bytes.begin(), bytes.end());
    EXPECT_EQ(text.find("Lav"), std::string::npos);
}

TEST_F(Gif, AnySizeThatIsAllowedIsMade) {
    for (const auto& [width, height] : {std::pair{1U, 1U}, {1U, 7U}, {3U, 1U}, {65535U, 1U}, {1U, 65535U}}) {
        const auto frame = test::flatFields(width, height, 16, 1);
        write("film.gif", width, height, {frame, frame});
        const auto film = test::readFilm(folder_ / "film.gif");
        EXPECT_EQ(film.width, width);
        EXPECT_EQ(film.height, height);
    }
}

TEST(Palette, IsOfTheFilmsOwnColours) {
    EXPECT_EQ(PaletteMaker().make().colors, (std::vector<RgbColor>{{0, 0, 0}}));
    PaletteMaker maker;
    maker.add(Rgba{1, 2, 3, 255, 9, 8, 7, 255, 1, 2, 3, 0});
    EXPECT_EQ(maker.make().colors, (std::vector<RgbColor>{{1, 2, 3}, {9, 8, 7}}));
    // Reds alone, many of them: no palette entry strays from them.
    test::Random random(3);
    Rgba reds;
    for (int i = 0; i < 100000; ++i) {
        reds.insert(reds.end(), {static_cast<std::uint8_t>(100 + random.below(156)),
                                 static_cast<std::uint8_t>(random.below(30)), 0, 255});
    }
    PaletteMaker many;
    many.add(reds);
    const auto palette = many.make();
    EXPECT_GT(palette.colors.size(), 100U);
    EXPECT_LE(palette.colors.size(), GifPalette::mostColors);
    for (const auto& [r, g, b] : palette.colors) {
        EXPECT_GE(r, 100);
        EXPECT_LT(g, 30);
        EXPECT_EQ(b, 0);
    }
}

TEST(Palette, WhatIsRareAndFarApartHasItsColour) {
    // Many greys and forty pixels of green.
    test::Random random(7);
    Rgba rgba;
    for (int i = 0; i < 300000; ++i) {
        const auto grey = static_cast<std::uint8_t>(random.below(256)),
                   other = static_cast<std::uint8_t>(random.below(40));
        rgba.insert(rgba.end(), {grey, grey, other, 255});
    }
    for (int i = 0; i < 40; ++i) rgba.insert(rgba.end(), {0, 255, 0, 255});
    PaletteMaker maker;
    maker.add(rgba);
    const auto palette = maker.make();
    const auto green = seenColor(0, 255, 0);
    double least = 1e9;
    for (const auto& [r, g, b] : palette.colors)
        least = std::min(least, squareDistance(seenColor(r, g, b), green));
    EXPECT_LT(std::sqrt(least), 10);
}

using Bytes = std::vector<std::uint8_t>;

struct Planes {
    Planes(std::uint32_t width, std::uint32_t height, VideoChroma chroma)
        : half(chroma == VideoChroma::full ? 1 : 2),
          stride(width + 13),
          y(static_cast<std::size_t>(stride) * height, 7),
          u(y),
          v(y) {}
    VideoPlanes view() { return {{y.data(), u.data(), v.data()}, {stride, stride, stride}}; }

    std::ptrdiff_t half, stride;
    Bytes y, u, v;
};

Bytes noise(std::size_t pixels, unsigned seed) {
    test::Random random(seed);
    Bytes rgba;
    for (std::size_t i = 0; i < 4 * pixels; ++i) rgba.push_back(static_cast<std::uint8_t>(random.below(256)));
    return rgba;
}

double lumaOf(const std::uint8_t* p) {
    return 0.2126 * p[0] + 0.7152 * p[1] + 0.0722 * p[2];
}
double cbOf(const std::uint8_t* p) {
    return 128 + 224.0 / 255 * (p[2] - lumaOf(p)) / 1.8556;
}
double crOf(const std::uint8_t* p) {
    return 128 + 224.0 / 255 * (p[0] - lumaOf(p)) / 1.5748;
}

// Half a step, and what weights rounded to 2^-16 add: three of them, 255 times.
constexpr double nearest = 0.5 + 3 * 255.0 / 65536;

TEST(VideoColors, AreTheNearestOfTheStandard) {
    for (const std::uint32_t width : {1U, 15U, 16U, 200U}) {
        constexpr std::uint32_t height = 9;
        const auto rgba = noise(std::size_t{width} * height, width);
        Planes planes(width, height, VideoChroma::full);
        rgbaToVideo(width, rgba, VideoChroma::full, planes.view());
        for (std::uint32_t y = 0; y < height; ++y) {
            for (std::uint32_t x = 0; x < width; ++x) {
                const auto* pixel = rgba.data() + 4 * (y * width + x);
                const auto at = static_cast<std::size_t>(y * planes.stride + x);
                ASSERT_NEAR(planes.y[at], 16 + 219.0 / 255 * lumaOf(pixel), nearest);
                ASSERT_NEAR(planes.u[at], cbOf(pixel), nearest);
                ASSERT_NEAR(planes.v[at], crOf(pixel), nearest);
            }
            for (std::ptrdiff_t x = width; x < planes.stride; ++x) {
                ASSERT_EQ(planes.y[static_cast<std::size_t>(y * planes.stride + x)], 7)
                    << "padding was written";
            }
        }
    }
}

TEST(VideoColors, HalvedChromaLiesAtTheLeftColumn) {
    constexpr std::uint32_t width = 46, height = 8;
    const auto rgba = noise(std::size_t{width} * height, 3);
    Planes planes(width, height, VideoChroma::halved);
    rgbaToVideo(width, rgba, VideoChroma::halved, planes.view());
    const auto mean = [&](auto of, std::uint32_t x, std::uint32_t y) {
        const std::uint32_t left = x == 0 ? 0 : 2 * x - 1;
        double sum = 0;
        for (const std::uint32_t row : {2 * y, 2 * y + 1}) {
            const auto* p = rgba.data() + 4 * row * width;
            sum += of(p + 4 * left) + 2 * of(p + 8 * x) + of(p + 8 * x + 4);
        }
        return sum / 8;
    };
    for (std::uint32_t y = 0; y < height / 2; ++y) {
        for (std::uint32_t x = 0; x < width / 2; ++x) {
            const auto at = static_cast<std::size_t>(y * planes.stride + x);
            ASSERT_NEAR(planes.u[at], mean(cbOf, x, y), nearest);
            ASSERT_NEAR(planes.v[at], mean(crOf, x, y), nearest);
        }
    }
    for (std::uint32_t y = 0; y < height; ++y) {
        for (std::uint32_t x = 0; x < width; ++x) {
            ASSERT_NEAR(planes.y[static_cast<std::size_t>(y * planes.stride + x)],
                        16 + 219.0 / 255 * lumaOf(rgba.data() + 4 * (y * width + x)), nearest);
        }
    }
}

TEST(VideoColors, GreyHasNoColourAndEndsAreTheRanges) {
    for (int grey = 0; grey < 256; ++grey) {
        const auto byte = static_cast<std::uint8_t>(grey);
        const Bytes rgba{byte, byte, byte, 0};
        Planes planes(1, 1, VideoChroma::full);
        rgbaToVideo(1, rgba, VideoChroma::full, planes.view());
        EXPECT_EQ(planes.u[0], 128);
        EXPECT_EQ(planes.v[0], 128);
        EXPECT_EQ(planes.y[0], std::lround(16 + 219.0 / 255 * grey));
    }
    const Bytes blue{0, 0, 255, 0}, red{255, 0, 0, 0};
    Planes planes(1, 1, VideoChroma::full);
    rgbaToVideo(1, blue, VideoChroma::full, planes.view());
    EXPECT_EQ(planes.u[0], 240);
    rgbaToVideo(1, red, VideoChroma::full, planes.view());
    EXPECT_EQ(planes.v[0], 240);
}

}  // namespace
}  // namespace mote::client
