// SPDX-License-Identifier: GPL-3.0-or-later
//
// MP4 and WebM films, decoded and held against their frames.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sched.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>
#include <algorithm>
#include <cmath>
#include <cstring>
#include <fstream>
#include <limits>

#include "client/frames/video/video_writer.h"
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

// What no film is made of, and what is left where one ends early.

using testing::HasSubstr;

constexpr VideoFormat formats[] = {VideoFormat::mp4, VideoFormat::webm, VideoFormat::gif};

std::string refusal(const VideoSettings& settings) {
    const auto status = checkVideo(settings);
    EXPECT_FALSE(status.ok());
    if (status.ok()) return "";
    EXPECT_EQ(status.error().code, ErrorCode::invalidArgument);
    return status.error().toString();
}

VideoSettings settings(VideoFormat format, std::uint32_t width = 64, std::uint32_t height = 48) {
    return {format, width, height, 30, {}, {}};
}

GifPalette greys() {
    GifPalette palette;
    for (int i = 0; i < 255; ++i)
        palette.colors.push_back({std::uint8_t(i), std::uint8_t(i), std::uint8_t(i)});
    return palette;
}

TEST(VideoCheck, KnowsItsExtensions) {
    EXPECT_EQ(videoFormat("mp4"), VideoFormat::mp4);
    EXPECT_EQ(videoFormat(".MP4"), VideoFormat::mp4);
    EXPECT_EQ(videoFormat(".webm"), VideoFormat::webm);
    EXPECT_EQ(videoFormat("gif"), VideoFormat::gif);
    for (const char* other : {"", ".", "mkv", "mp4 ", "..mp4", "gi"})
        EXPECT_FALSE(videoFormat(other).has_value()) << other;
}

TEST(VideoCheck, RefusesSizes) {
    EXPECT_EQ(refusal(settings(VideoFormat::mp4, 641, 480)),
              "a film of 641 x 480 pixels cannot be MP4: both sides must be even");
    EXPECT_THAT(refusal(settings(VideoFormat::webm, 640, 481)), HasSubstr("both sides must be even"));
    EXPECT_THAT(refusal(settings(VideoFormat::mp4, 16386, 480)),
                HasSubstr("each side has 16384 pixels at most"));
    EXPECT_THAT(refusal(settings(VideoFormat::webm, 8192, 8192)), HasSubstr("pixels at most"));
    for (const auto format : formats) {
        EXPECT_THAT(refusal(settings(format, 0, 480)), HasSubstr("at least"));
        EXPECT_THAT(refusal(settings(format, ~0U, ~0U)), HasSubstr("at most"));
        EXPECT_TRUE(checkVideo(settings(format, 1920, 1080)).ok());
    }
    EXPECT_TRUE(checkVideo(settings(VideoFormat::gif, 641, 481)).ok());
}

TEST(VideoCheck, RefusesRates) {
    for (const auto format : formats) {
        auto asked = settings(format);
        for (const double fps : {0.0, -1.0, 1e-3, 1001.0, 1e300, std::numeric_limits<double>::infinity(),
                                 std::numeric_limits<double>::quiet_NaN()}) {
            asked.fps = fps;
            EXPECT_THAT(refusal(asked), HasSubstr("frames a second")) << fps;
        }
    }
    auto asked = settings(VideoFormat::gif);
    asked.fps = 60;
    EXPECT_EQ(refusal(asked), "GIF has 0.01 to 50 frames a second, not 60");
}

TEST(VideoCheck, RefusesQualities) {
    auto asked = settings(VideoFormat::mp4);
    asked.quality = 51;
    EXPECT_TRUE(checkVideo(asked).ok());
    asked.quality = 52;
    EXPECT_EQ(refusal(asked), "MP4 takes a crf of 0 to 51, not 52");
    asked = settings(VideoFormat::webm);
    asked.quality = 63;
    EXPECT_TRUE(checkVideo(asked).ok());
    asked.quality = 64;
    EXPECT_THAT(refusal(asked), HasSubstr("0 to 63"));
    asked = settings(VideoFormat::gif);
    asked.quality = 0;
    EXPECT_EQ(refusal(asked), "GIF takes no crf");
}

class VideoFile : public testing::TestWithParam<VideoFormat> {
  protected:
    static constexpr std::uint32_t width = 320, height = 192;

    auto create(const std::filesystem::path& path) const {
        return VideoWriter::create(path, settings(GetParam(), width, height), greys());
    }
    Error errorOf(const std::filesystem::path& path) const {
        const auto writer = create(path);
        EXPECT_FALSE(writer.ok());
        return writer.ok() ? Error{} : writer.error();
    }
    const std::vector<Rgba> frames_ = test::particleFrames(width, height, 6, 1);
    test::TempDir folder_;
};

TEST_P(VideoFile, PathsThatCannotBe) {
    const auto missing = errorOf(folder_ / "none" / "a.film");
    EXPECT_EQ(missing.code, ErrorCode::notFound);
    EXPECT_THAT(missing.toString(), HasSubstr("a.film: cannot be written: No such file or directory"));
    std::filesystem::create_directory(folder_ / "b.film");
    EXPECT_THAT(errorOf(folder_ / "b.film").toString(), HasSubstr("b.film: is a folder"));
    std::ofstream(folder_ / "file") << "1";
    EXPECT_EQ(errorOf(folder_ / "file" / "a.film").code, ErrorCode::notFound);
    EXPECT_EQ(errorOf(folder_ / std::string(300, 'a')).where, (folder_ / std::string(300, 'a')).string());
    EXPECT_FALSE(create("").ok());
    EXPECT_EQ(test::entriesOf(folder_.path()), 2U);
}

TEST_P(VideoFile, FoldersThatMayNotBeWritten) {
    ::chmod(folder_.path().c_str(), 0555);
    const bool root = ::geteuid() == 0;
    if (root && ::seteuid(65534) != 0) GTEST_SKIP() << "may write everything";
    const auto error = errorOf(folder_ / "a.film");
    ASSERT_TRUE(!root || ::seteuid(0) == 0);
    ::chmod(folder_.path().c_str(), 0755);
    EXPECT_EQ(error.code, ErrorCode::permissionDenied);
    EXPECT_THAT(error.toString(), HasSubstr("a.film: cannot be written: Permission denied"));
    EXPECT_EQ(test::entriesOf(folder_.path()), 0U);
}

TEST_P(VideoFile, AnEarlyEndLeavesNothing) {
    std::ofstream(folder_ / "a.film") << "before";
    {
        auto writer = create(folder_ / "a.film");
        ASSERT_TRUE(writer.ok());
        for (const auto& frame : frames_) ASSERT_TRUE((*writer)->add(frame).ok());
        EXPECT_EQ(test::entriesOf(folder_.path()), 2U);
    }
    EXPECT_EQ(test::entriesOf(folder_.path()), 1U);
    EXPECT_EQ(test::bytesOf(folder_ / "a.film").size(), 6U);
    auto writer = create(folder_ / "b.film");
    ASSERT_TRUE(writer.ok());
    const auto empty = (*writer)->finish();
    ASSERT_FALSE(empty.ok());
    EXPECT_THAT(empty.error().toString(), HasSubstr("b.film: a film needs a frame"));
    EXPECT_EQ(test::entriesOf(folder_.path()), 1U);
}

TEST_P(VideoFile, AFinishedFilmReplacesTheOneBefore) {
    std::ofstream(folder_ / "a b:c'%d.film") << "before";
    auto writer = create(folder_ / "a b:c'%d.film");
    ASSERT_TRUE(writer.ok());
    for (const auto& frame : frames_) ASSERT_TRUE((*writer)->add(frame).ok());
    EXPECT_EQ(test::bytesOf(folder_ / "a b:c'%d.film").size(), 6U);
    ASSERT_TRUE((*writer)->finish().ok());
    EXPECT_EQ(test::entriesOf(folder_.path()), 1U);
    EXPECT_EQ(test::readFilm(folder_ / "a b:c'%d.film").frames.size(), frames_.size());
}

TEST_P(VideoFile, TwoDoNotWriteTheSameFilm) {
    auto first = create(folder_ / "a.film");
    ASSERT_TRUE(first.ok());
    EXPECT_THAT(errorOf(folder_ / "a.film").toString(),
                HasSubstr("a.film: is being written by another process"));
    ASSERT_TRUE((*first)->add(frames_[0]).ok());
    ASSERT_TRUE((*first)->finish().ok());
    EXPECT_TRUE(create(folder_ / "a.film").ok());
    EXPECT_EQ(test::entriesOf(folder_.path()), 1U);
}

TEST_P(VideoFile, WhatAKilledProcessLeftIsTakenOver) {
    const pid_t child = ::fork();
    ASSERT_GE(child, 0);
    if (child == 0) {
        auto writer = create(folder_ / "a.film");
        if (writer.ok()) {
            for (const auto& frame : frames_) (void)(*writer)->add(frame);
            ::kill(::getpid(), SIGKILL);
        }
        ::_exit(1);
    }
    int status = 0;
    ASSERT_EQ(::waitpid(child, &status, 0), child);
    ASSERT_TRUE(WIFSIGNALED(status));
    ASSERT_EQ(test::entriesOf(folder_.path()), 1U);
    auto writer = create(folder_ / "a.film");
    ASSERT_TRUE(writer.ok()) << writer.error().toString();
    ASSERT_TRUE((*writer)->add(frames_[0]).ok());
    ASSERT_TRUE((*writer)->finish().ok());
    EXPECT_EQ(test::entriesOf(folder_.path()), 1U);
    EXPECT_EQ(test::readFilm(folder_ / "a.film").frames.size(), 1U);
}

/// The kernel refuses files longer than `bytes` while this lives, as on a full disk.
class SmallDisk {
  public:
    explicit SmallDisk(rlim_t bytes) {
        ::getrlimit(RLIMIT_FSIZE, &before_);
        handler_ = ::signal(SIGXFSZ, SIG_IGN);
        const rlimit small{bytes, before_.rlim_max};
        ::setrlimit(RLIMIT_FSIZE, &small);
    }
    ~SmallDisk() {
        ::setrlimit(RLIMIT_FSIZE, &before_);
        ::signal(SIGXFSZ, handler_);
    }
    SmallDisk(const SmallDisk&) = delete;
    SmallDisk& operator=(const SmallDisk&) = delete;

  private:
    rlimit before_{};
    void (*handler_)(int) = nullptr;
};

Status writeAll(VideoWriter& writer, const std::vector<Rgba>& frames) {
    for (const auto& frame : frames) MOTE_RETURN_IF_ERROR(writer.add(frame));
    return writer.finish();
}

TEST_P(VideoFile, AFullDiskIsOneErrorAndLeavesNothing) {
    auto writer = create(folder_ / "a.film");
    ASSERT_TRUE(writer.ok());
    ASSERT_TRUE(writeAll(**writer, frames_).ok());
    const auto size = std::filesystem::file_size(folder_ / "a.film");
    std::filesystem::remove(folder_ / "a.film");
    // At the beginning, in the midst, in the last bytes.
    for (const std::uintmax_t limit :
         {std::uintmax_t{0}, std::uintmax_t{100}, size / 2, size - 200, size - 1}) {
        const SmallDisk disk(limit);
        auto again = create(folder_ / "a.film");
        const auto status = again.ok() ? writeAll(**again, frames_) : Status(again.error());
        ASSERT_FALSE(status.ok()) << limit << " of " << size;
        EXPECT_EQ(status.error().code, ErrorCode::resourceExhausted) << limit;
        EXPECT_THAT(status.error().toString(), HasSubstr("a.film: cannot be written: File too large"));
        if (again.ok()) {
            const auto later = (*again)->add(frames_[0]);
            ASSERT_FALSE(later.ok());
            EXPECT_EQ(later.error().toString(), status.error().toString());
        }
        EXPECT_EQ(test::entriesOf(folder_.path()), 0U) << limit;
    }
}

TEST_P(VideoFile, SettingsAreCheckedOnceMore) {
    auto odd = settings(GetParam(), 0, 7);
    const auto writer = VideoWriter::create(folder_ / "a.film", odd, greys());
    ASSERT_FALSE(writer.ok());
    EXPECT_THAT(writer.error().toString(), HasSubstr("a.film: a film of 0 x 7"));
    if (GetParam() == VideoFormat::gif) {
        EXPECT_FALSE(VideoWriter::create(folder_ / "a.film", settings(GetParam())).ok());
        EXPECT_FALSE(VideoWriter::create(folder_ / "a.film", settings(GetParam()), GifPalette{}).ok());
    }
    EXPECT_EQ(test::entriesOf(folder_.path()), 0U);
}

INSTANTIATE_TEST_SUITE_P(Formats, VideoFile, testing::ValuesIn(formats),
                         [](const auto& each) { return std::string(name(each.param)); });

}  // namespace
}  // namespace mote::client
