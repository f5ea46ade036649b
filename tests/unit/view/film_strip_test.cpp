// SPDX-License-Identifier: GPL-3.0-or-later
//
// What of the film's bar is no drawing: times on the strip, the preview's times, thumbnails, requests.
#include <gtest/gtest.h>

#include <cmath>

#include "client/shared/jobs.h"
#include "client/view/film/film_preview.h"
#include "client/view/film/strip_scale.h"
#include "client/view/film/thumbnail.h"
#include "protocol/scene/job_request.h"
#include "tests/support/random.h"

namespace mote::client {
namespace {

using test::Random;

TEST(StripScale, TimesAndPlacesAreEachOthersInverse) {
    Random random(21);
    for (int i = 0; i < 1000; ++i) {
        const double begin = random.between(-20.0, 20.0), end = begin + random.magnitude(-6, 12);
        const float width = static_cast<float>(random.between(200.0, 3000.0));
        const auto scale = StripScale::of(begin, end, 10.0F, width, 40.0F);
        ASSERT_LT(scale.begin, scale.end);
        for (const double seconds : {begin, end, begin + random.unit() * (end - begin)}) {
            const float x = scale.at(seconds);
            ASSERT_GE(x, 49.9F);
            ASSERT_LE(x, 10.0F + width - 39.9F);
            ASSERT_NEAR(scale.from(x), seconds, 1e-5 * (scale.end - scale.begin));
        }
        const double marks = scale.markSpacing(70.0F);
        ASSERT_GE(scale.at(scale.begin + marks) - scale.at(scale.begin), 69.9F);
        ASSERT_LE(scale.at(scale.begin + marks) - scale.at(scale.begin), 70.0F * 5.1F);
    }
}

TEST(FilmPreview, ShowsEveryFrameInItsTimeAndBeginsAnew) {
    FilmPreview preview;
    preview.start(100.0, 5.0, 2.0, 5.0);  // at its end: from its begin
    ASSERT_TRUE(preview.playing());
    int frames = 0;
    for (double now = 100.0; now < 103.1 - 1e-9; now += 0.01) {
        const auto due = preview.next(now + 1e-6, 2.0, 5.0, 10.0);
        if (!due) continue;
        EXPECT_NEAR(*due, 2.0 + 0.1 * frames, 1e-9);
        ++frames;
    }
    EXPECT_EQ(frames, 31);
    const auto again = preview.next(103.15, 2.0, 5.0, 10.0);
    ASSERT_TRUE(again);
    EXPECT_NEAR(*again, 2.0, 1e-9);
}

TEST(FilmPreview, StopsWithTheLastFrame) {
    FilmPreview preview;
    preview.loop = false;
    preview.start(100.0, 3.0, 2.0, 5.0);
    EXPECT_NEAR(preview.next(100.0, 2.0, 5.0, 10.0).value(), 3.0, 1e-9);
    EXPECT_FALSE(preview.next(100.05, 2.0, 5.0, 10.0)) << "the same frame";
    EXPECT_NEAR(preview.next(101.55, 2.0, 5.0, 10.0).value(), 4.5, 1e-9)
        << "frames are left out, time is not";
    EXPECT_EQ(preview.next(109.0, 2.0, 5.0, 10.0), 5.0);
    EXPECT_FALSE(preview.playing());
    EXPECT_FALSE(preview.next(110.0, 2.0, 5.0, 10.0));
    preview.start(0.0, 1.0, 1.0, 1.0);
    EXPECT_FALSE(preview.playing()) << "nothing to play";
}

/// A picture whose colours are its places.
std::vector<std::uint8_t> places(std::uint32_t width, std::uint32_t height) {
    std::vector<std::uint8_t> pixels;
    for (std::uint32_t y = 0; y < height; ++y)
        for (std::uint32_t x = 0; x < width; ++x)
            for (const auto value : {x * 255 / width, y * 255 / height, 7U, 255U})
                pixels.push_back(static_cast<std::uint8_t>(value));
    return pixels;
}

TEST(Thumbnail, IsTheMiddleOfThePictureAveraged) {
    Random random(22);
    for (int i = 0; i < 200; ++i) {
        const auto width = 1 + static_cast<std::uint32_t>(random.below(300));
        const auto height = 1 + static_cast<std::uint32_t>(random.below(300));
        const auto smallWidth = 1 + static_cast<std::uint32_t>(random.below(64));
        const auto smallHeight = 1 + static_cast<std::uint32_t>(random.below(64));
        const auto small = makeThumbnail(places(width, height), width, height, smallWidth, smallHeight);
        ASSERT_EQ(small.pixels.size(), 4U * smallWidth * smallHeight);
        // The same proportions as the thumbnail, in the middle.
        const double shown = std::min(1.0, static_cast<double>(height) * smallWidth / smallHeight / width);
        for (std::uint32_t x = 0; x < smallWidth; ++x) {
            const double share = 0.5 + ((x + 0.5) / smallWidth - 0.5) * shown;
            ASSERT_NEAR(small.pixels[4 * x], 255.0 * share, 2.0 + 255.0 * 2.6 / width) << width << " " << x;
            ASSERT_EQ(small.pixels[4 * x + 2], 7);
            ASSERT_EQ(small.pixels[4 * x + 3], 255);
        }
    }
}

TEST(FilmJobs, ARequestIsValidAndNamesItsFilm) {
    proto::Script script;
    for (const double seconds : {0.0, 2.0}) {
        auto& keyframe = *script.add_keyframes();
        keyframe.set_seconds(seconds);
        keyframe.mutable_view()->set_width(64);
        keyframe.mutable_view()->set_height(64);
        keyframe.mutable_view()->add_layers()->set_dataset("data/" + std::string(400, 'x'));
        keyframe.mutable_view()->mutable_layers(0)->mutable_particles();
    }
    const auto request = filmRequest(script, "mp4");
    const auto parsed = parseJobRequest(request);
    ASSERT_TRUE(parsed.ok()) << parsed.error().toString();
    EXPECT_EQ(request.film().video(), "mp4");
    EXPECT_TRUE(jobName(request).ends_with(", 61 frames")) << jobName(request);
    EXPECT_TRUE(parseJobRequest(filmRequest(script, "")).ok());
    proto::JobStatus job;
    *job.mutable_request() = request;
    EXPECT_FALSE(isReadyFilm(job));
    job.set_state(proto::JobStatus::SUCCEEDED);
    EXPECT_TRUE(isReadyFilm(job));
    EXPECT_FALSE(mayBeTriedAgain(job));
    job.set_state(proto::JobStatus::FAILED);
    EXPECT_TRUE(mayBeTriedAgain(job) && hasEnded(job));
    proto::JobRequest plot;
    plot.set_output("data/beam.mote");
    EXPECT_EQ(jobName(plot), "data/beam");
}

}  // namespace
}  // namespace mote::client
