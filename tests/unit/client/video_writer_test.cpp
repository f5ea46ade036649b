// SPDX-License-Identifier: GPL-3.0-or-later
//
// MP4 and WebM films, decoded and held against their frames.
#include "client/frames/video/video_writer.h"

#include <gtest/gtest.h>
#include <sched.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "tests/support/temp_dir.h"
#include "tests/unit/client/film_reader.h"

namespace mote::client {
namespace {

using test::Film;
using test::Rgba;

void writeFilm(const std::filesystem::path& path, const VideoSettings& settings,
               const std::vector<Rgba>& frames) {
    auto writer = VideoWriter::create(path, settings);
    ASSERT_TRUE(writer.ok()) << writer.error().toString();
    for (const auto& frame : frames) {
        const auto added = (*writer)->add(frame);
        ASSERT_TRUE(added.ok()) << added.error().toString();
    }
    const auto done = (*writer)->finish();
    ASSERT_TRUE(done.ok()) << done.error().toString();
}

struct Kind {
    VideoFormat format;
    VideoChroma chroma;
};

class Video : public testing::TestWithParam<Kind> {
  protected:
    VideoSettings settings(std::uint32_t width, std::uint32_t height, double fps = 30) const {
        return {GetParam().format, width, height, fps, std::nullopt, GetParam().chroma};
    }
    bool full() const { return GetParam().chroma == VideoChroma::full; }
    std::filesystem::path file(const std::string& stem = "film") const {
        return folder_ / (stem + (GetParam().format == VideoFormat::mp4 ? ".mp4" : ".webm"));
    }

    test::TempDir folder_;
};

TEST_P(Video, SaysWhatItIs) {
    writeFilm(file(), settings(64, 48), {Rgba(64 * 48 * 4, 90)});
    const Film film = test::readFilm(file());
    const bool mp4 = GetParam().format == VideoFormat::mp4;
    EXPECT_EQ(film.codec, mp4 ? "h264" : "vp9");
    EXPECT_EQ(film.pixelFormat, full() ? "yuv444p" : "yuv420p");
    EXPECT_EQ(film.width, 64U);
    EXPECT_EQ(film.height, 48U);
    EXPECT_EQ(film.range, "tv");
    EXPECT_EQ(film.matrix, "bt709");
    EXPECT_EQ(film.streamRange, "tv");
    EXPECT_EQ(film.streamPrimaries, "bt709");
    EXPECT_EQ(film.streamTransfer, "bt709");
    EXPECT_EQ(film.streamMatrix, "bt709");
    if (mp4) {  // VP9's own stream names the matrix and the range alone
        EXPECT_EQ(film.primaries, "bt709");
        EXPECT_EQ(film.transfer, "bt709");
    }
}

TEST_P(Video, HasEachFrameAtItsTime) {
    constexpr std::size_t count = 70;  // beyond one group of pictures
    std::vector<Rgba> frames;
    for (std::size_t i = 0; i < count; ++i)
        frames.emplace_back(32 * 32 * 4, static_cast<std::uint8_t>(20 + 3 * i));
    for (const double fps : {30.0, 25.0, 24.0, 29.97, 30000.0 / 1001, 12.5, 0.01, 240.0, 1000.0}) {
        writeFilm(file(), settings(32, 32, fps), frames);
        const Film film = test::readFilm(file());
        ASSERT_EQ(film.frames.size(), count) << fps;
        // WebM's times are whole milliseconds.
        const double exact = GetParam().format == VideoFormat::mp4 ? 1e-9 : 0.5001e-3;
        for (std::size_t i = 0; i < count; ++i) {
            EXPECT_NEAR(film.times[i], static_cast<double>(i) / fps, exact + 1e-9 * film.times[i])
                << fps << " " << i;
            EXPECT_NEAR(film.frames[i][0], 20 + 3 * static_cast<int>(i), 2) << fps << " " << i;
        }
        EXPECT_NEAR(film.duration, static_cast<double>(count) / fps, 2 * exact) << fps;
    }
}

TEST_P(Video, KeepsPointsAsTheyWere) {
    const auto frames = test::particleFrames(480, 272, 12, 5);
    writeFilm(file(), settings(480, 272), frames);
    const double found = test::psnr(test::readFilm(file()).frames, frames);
    // The bar; what halved chroma leaves of points is a matter of points.
    EXPECT_GE(found, full() ? 40 : 25);
    EXPECT_TRUE(full() || found <= 40);
    RecordProperty("psnr", std::to_string(found));
}

/// Fields that change a little from frame to frame, as fades do. Codecs work in squares of 16 pixels: what is
/// flat has flat neighbours.
TEST_P(Video, KeepsFlatColours) {
    constexpr std::uint32_t side = 72, edge = 16, width = 12 * side, height = 8 * side;
    std::vector<Rgba> frames{test::flatFields(width, height, side, 7)};
    for (unsigned f = 1; f < 6; ++f) {
        const auto steps = test::flatFields(width, height, side, 100 * f);
        auto next = frames.back();
        for (std::size_t i = 0; i < next.size(); ++i) {
            next[i] = static_cast<std::uint8_t>(std::clamp(next[i] + steps[i] % 5 - 2, 0, 255));
        }
        frames.push_back(std::move(next));
    }
    writeFilm(file(), settings(width, height), frames);
    const Film film = test::readFilm(file());
    ASSERT_EQ(film.frames.size(), frames.size());
    int worst = 0;
    std::size_t beyond = 0, all = 0;
    for (std::size_t f = 0; f < frames.size(); ++f) {
        for (std::size_t i = 0; i < frames[f].size(); ++i) {
            const auto x = i / 4 % width % side, y = i / 4 / width % side;
            if (i % 4 == 3 || std::min(x, y) < edge || std::max(x, y) >= side - edge) continue;
            const int off = std::abs(film.frames[f][i] - frames[f][i]);
            worst = std::max(worst, off);
            beyond += off > 2;
            ++all;
        }
    }
    // Halved chroma: one in ten thousand may be off by one more.
    EXPECT_LE(worst, full() ? 2 : 3);
    EXPECT_LE(10000 * beyond, all);
}

/// The process may run on one core alone while this lives.
class OneCore {
  public:
    OneCore() {
        ::sched_getaffinity(0, sizeof before_, &before_);
        cpu_set_t one;
        CPU_ZERO(&one);
        for (int i = 0; i < CPU_SETSIZE && CPU_COUNT(&one) == 0; ++i) {
            if (CPU_ISSET(i, &before_)) CPU_SET(i, &one);
        }
        ::sched_setaffinity(0, sizeof one, &one);
    }
    ~OneCore() { ::sched_setaffinity(0, sizeof before_, &before_); }
    OneCore(const OneCore&) = delete;
    OneCore& operator=(const OneCore&) = delete;

  private:
    cpu_set_t before_{};
};

TEST_P(Video, TheSameFramesAreTheSameBytes) {
    const auto frames = test::particleFrames(320, 192, 20, 11);
    writeFilm(file(), settings(320, 192), frames);
    const auto bytes = test::bytesOf(file());
    ASSERT_GT(bytes.size(), 1000U);
    for (int i = 0; i < 3; ++i) {
        writeFilm(file("again"), settings(320, 192), frames);
        EXPECT_EQ(test::bytesOf(file("again")), bytes);
    }
    const OneCore alone;
    writeFilm(file("alone"), settings(320, 192), frames);
    EXPECT_EQ(test::bytesOf(file("alone")), bytes);
    // No version of libavformat, which changes with every update.
    const std::string text(bytes.begin(), bytes.end());
    EXPECT_EQ(text.find("Lavf5"), std::string::npos);
    EXPECT_EQ(text.find("Lavc5"), std::string::npos);
}

TEST_P(Video, QualityIsAsAsked) {
    const auto frames = test::particleFrames(160, 96, 4, 2);
    double before = 100;
    for (const unsigned quality : {1U, 15U, 30U, 45U}) {
        auto asked = settings(160, 96);
        asked.quality = quality;
        writeFilm(file(), asked, frames);
        const double found = test::psnr(test::readFilm(file()).frames, frames);
        EXPECT_LT(found, before);
        before = found;
    }
}

TEST_P(Video, AnySizeThatIsAllowedIsMade) {
    for (const auto& [width, height] :
         {std::pair{2U, 2U}, {4U, 2U}, {2U, 34U}, {16384U, 2U}, {2U, 16384U}, {102U, 58U}}) {
        ASSERT_TRUE(checkVideo(settings(width, height)).ok());
        const auto frame = test::flatFields(width, height, 64, 3);
        writeFilm(file(), settings(width, height), {frame, frame});
        const Film film = test::readFilm(file());
        EXPECT_EQ(film.width, width);
        EXPECT_EQ(film.height, height);
        EXPECT_EQ(film.frames.size(), 2U);
    }
}

TEST(Mp4, IsReadFromItsBeginning) {
    const test::TempDir folder;
    writeFilm(folder / "film.mp4", {VideoFormat::mp4, 64, 64, 30, {}, {}},
              std::vector<Rgba>(5, Rgba(64 * 64 * 4, 50)));
    const auto bytes = test::bytesOf(folder / "film.mp4");
    const std::string text(bytes.begin(), bytes.end());
    ASSERT_NE(text.find("moov"), std::string::npos);
    EXPECT_LT(text.find("moov"), text.find("mdat"));
}

INSTANTIATE_TEST_SUITE_P(Kinds, Video,
                         testing::Values(Kind{VideoFormat::mp4, VideoChroma::full},
                                         Kind{VideoFormat::mp4, VideoChroma::halved},
                                         Kind{VideoFormat::webm, VideoChroma::full},
                                         Kind{VideoFormat::webm, VideoChroma::halved}),
                         [](const auto& each) {
                             return std::string(each.param.format == VideoFormat::mp4 ? "Mp4" : "WebM") +
                                    (each.param.chroma == VideoChroma::full ? "Full" : "Halved");
                         });

}  // namespace
}  // namespace mote::client
