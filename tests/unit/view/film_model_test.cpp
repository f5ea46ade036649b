// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>
#include <algorithm>
#include <cmath>

#include "client/shared/jobs.h"
#include "client/view/film/film_model.h"
#include "client/view/film/film_strip.h"
#include "client/view/film/film_thumbnails.h"
#include "protocol/base/json.h"
#include "protocol/scene/film/film.h"
#include "protocol/scene/job_request.h"
#include "protocol/scene/view.h"
#include "tests/support/random.h"

namespace mote::client {
namespace {

using test::Random;

proto::View viewFrom(const glm::dvec3& direction, std::uint32_t width = 1261, std::uint32_t height = 707) {
    proto::View view;
    view.set_width(width);
    view.set_height(height);
    auto& camera = *view.mutable_camera();
    for (int i = 0; i < 3; ++i) camera.add_eye(4.0 * direction[i]);
    for (int i = 0; i < 3; ++i) camera.add_target(0.0);
    // Never along the line of sight.
    const bool upright = std::abs(direction.y) < 0.9;
    for (const double number : {upright ? 0.0 : 1.0, upright ? 1.0 : 0.0, 0.0}) camera.add_up(number);
    auto& layer = *view.add_layers();
    layer.set_dataset("data/beam");
    layer.mutable_particles();
    return view;
}

proto::View anyView(Random& random) {
    return viewFrom(random.direction(), 64 + static_cast<std::uint32_t>(random.below(2000)),
                    64 + static_cast<std::uint32_t>(random.below(2000)));
}

/// What holds after every edit.
void expectSound(const FilmModel& film) {
    const auto& keyframes = film.keyframes();
    const double frame = 1.0 / film.fps();
    for (std::size_t i = 1; i < keyframes.size(); ++i) {
        const double rounding = 1e-9 * frame + 1e-15 * std::abs(keyframes[i].seconds);
        ASSERT_GE(keyframes[i].seconds - keyframes[i - 1].seconds, frame - rounding) << i;
    }
    ASSERT_EQ(film.selected().has_value(), !film.empty());
    ASSERT_LT(film.selected().value_or(0), std::max<std::size_t>(keyframes.size(), 1));
    ASSERT_GE(film.playhead(), film.begin());
    ASSERT_LE(film.playhead(), film.end());
    const auto script = film.toScript();
    const auto checked = checkScript(script);
    ASSERT_EQ(checked.ok(), film.isFilm()) << (checked.ok() ? "" : checked.error().toString());
    ASSERT_EQ(film.frameCount(), film.isFilm() ? frameCountOf(script) : 0U);
}

void edit(Random& random, FilmModel& film) {
    const auto some = [&] { return random.below(std::max<std::size_t>(film.keyframes().size(), 1)); };
    const double wild = random.sign() * random.magnitude(-6, 35);
    const double near = film.begin() + (film.end() - film.begin() + 3.0) * random.unit() - 0.5;
    switch (random.below(12)) {
        case 0:
        case 1:
            (void)film.add(anyView(random));
            break;
        case 2:
            (void)film.duplicate();
            break;
        case 3:
            film.removeSelected();
            break;
        case 4:
        case 5:
            if (!film.empty()) film.move(some(), random.chance(0.8) ? near : wild);
            break;
        case 6:
            if (!film.empty()) film.select(some());
            break;
        case 7:
            film.setPlayhead(random.chance(0.8) ? near : wild);
            break;
        case 8:
            film.setFps(random.chance(0.7) ? random.between(1.0, 120.0) : random.magnitude(-12, 12));
            break;
        case 9:
            film.setEasing(random.oneOf({Easing::linear, Easing::smooth, Easing::hold}));
            film.setBetweenSteps(random.chance(0.5) ? BetweenSteps::hold : BetweenSteps::blend);
            break;
        case 10:
            film.setConstantSpeed(random.chance(0.5));
            (void)film.replace(anyView(random));
            break;
        default:
            film.setSize({static_cast<std::uint32_t>(random.below(20000)),
                          static_cast<std::uint32_t>(random.below(5000))});
    }
}

TEST(FilmModel, StaysSoundWhateverIsDone) {
    for (std::uint64_t series = 0; series < 200; ++series) {
        Random random(13, series);
        FilmModel film;
        for (int step = 0; step < 120; ++step) {
            edit(random, film);
            expectSound(film);
            if (testing::Test::HasFatalFailure()) FAIL() << "series " << series << ", step " << step;
        }
    }
}

TEST(FilmModel, AScriptThatWasSavedIsTheSameFilm) {
    for (std::uint64_t series = 0; series < 100; ++series) {
        Random random(14, series);
        FilmModel film;
        for (int edits = 0; !film.isFilm() || random.chance(0.9); ++edits) {
            ASSERT_LT(edits, 10'000) << "no edit makes a film";
            edit(random, film);
        }
        proto::Script read;
        ASSERT_TRUE(parseJson(toJson(film.toScript()), read, "test").ok());
        const auto again = FilmModel::fromScript(read);
        ASSERT_TRUE(again.ok()) << again.error().toString();
        ASSERT_EQ(toJson(again->toScript()), toJson(film.toScript())) << "series " << series;
        ASSERT_EQ(again->size(), film.size());
    }
}

/// Times that a hand-written script may have, nearer than a frame.
TEST(FilmModel, ScriptsOfAnyTimesAreTaken) {
    for (std::uint64_t series = 0; series < 200; ++series) {
        Random random(15, series);
        proto::Script script;
        if (random.chance(0.8)) script.set_fps(random.magnitude(-9, 9));
        const bool dense = random.chance(0.5);
        double seconds = random.between(-50.0, 50.0);
        for (auto count = 2 + random.below(30); count > 0; --count) {
            script.add_keyframes()->set_seconds(seconds);
            *script.mutable_keyframes()->rbegin()->mutable_view() = viewFrom(random.direction());
            seconds += dense ? 1e-4 * (1.0 + random.unit()) : random.between(0.01, 30.0);
        }
        ASSERT_TRUE(checkScript(script).ok());
        auto film = FilmModel::fromScript(script);
        ASSERT_TRUE(film.ok()) << film.error().toString();
        expectSound(*film);
        EXPECT_EQ(film->begin(), script.keyframes(0).seconds());
        for (int step = 0; step < 20; ++step) edit(random, *film);
        expectSound(*film);
        if (testing::Test::HasFatalFailure()) FAIL() << "series " << series;
    }
}

FilmModel filmOfThree() {
    FilmModel film;
    EXPECT_TRUE(film.add(viewFrom({0, 0, 1})).ok());
    EXPECT_TRUE(film.add(viewFrom({1, 0, 0})).ok());
    EXPECT_TRUE(film.add(viewFrom({0, 0, -1})).ok());
    return film;
}

TEST(FilmModel, KeyframesAreTwoSecondsApartOrAtThePlayhead) {
    auto film = filmOfThree();
    EXPECT_EQ(film.keyframes()[1].seconds, 2.0);
    EXPECT_EQ(film.end(), 4.0);
    EXPECT_EQ(film.selected(), 2U);
    film.setPlayhead(2.5);
    ASSERT_TRUE(film.add(viewFrom({0, 1, 0})).ok());
    EXPECT_EQ(film.keyframes()[2].seconds, 2.5);
    EXPECT_EQ(film.selected(), 2U);
    film.select(1);  // on a keyframe is not between two
    ASSERT_TRUE(film.add(viewFrom({0, 1, 0})).ok());
    EXPECT_EQ(film.end(), 6.0);
}

TEST(FilmModel, DraggedKeyframesStopAFrameBeforeTheirNeighbours) {
    auto film = filmOfThree();
    film.move(1, 100.0);
    EXPECT_DOUBLE_EQ(film.keyframes()[1].seconds, 4.0 - 1.0 / 30.0);
    film.move(1, -100.0);
    EXPECT_DOUBLE_EQ(film.keyframes()[1].seconds, 1.0 / 30.0);
    film.move(1, 1.017);  // whole frames
    EXPECT_DOUBLE_EQ(film.keyframes()[1].seconds, std::round(1.017 * 30.0) / 30.0);
    film.move(0, -100.0);
    EXPECT_EQ(film.begin(), 0.0);
    film.move(2, 1e7);
    EXPECT_EQ(film.frameCount(), maxFrames);
}

TEST(FilmModel, TheFirstViewDecidesTheSizeMadeEven) {
    const auto film = filmOfThree();
    EXPECT_EQ(film.size(), (FilmSize{1260, 706}));
    EXPECT_EQ(film.keyframes()[2].view.width(), 1260U);
}

TEST(FilmModel, ACopyLiesHalfWayAndHasTheSamePicture) {
    auto film = filmOfThree();
    film.select(0);
    film.setEasing(Easing::smooth);
    ASSERT_TRUE(film.duplicate().ok());
    EXPECT_EQ(film.keyframes()[1].seconds, 1.0);
    EXPECT_EQ(film.keyframes()[1].picture, film.keyframes()[0].picture);
    EXPECT_EQ(film.keyframes()[1].easing, Easing::smooth);
    ASSERT_TRUE(film.replace(viewFrom({0, 1, 0})).ok());
    EXPECT_NE(film.keyframes()[1].picture, film.keyframes()[0].picture);
}

TEST(FilmModel, ConstantSpeedLeavesEasingsOutAndKeepsThem) {
    auto film = filmOfThree();
    film.select(0);
    film.setEasing(Easing::hold);
    film.setConstantSpeed(true);
    EXPECT_EQ(film.toScript().keyframes(0).easing(), "");
    film.setConstantSpeed(false);
    EXPECT_EQ(film.toScript().keyframes(0).easing(), "hold");
}

TEST(FilmModel, ItsScriptIsAFilm) {
    const auto made = filmOfThree();
    const auto film = Film::create(made.toScript(), {{"data/beam", {}}});
    ASSERT_TRUE(film.ok()) << film.error().toString();
    EXPECT_EQ(film->frameCount(), made.frameCount());
    EXPECT_EQ(film->frameCount(), 121U);
}

TEST(FilmModel, RefusesWhatIsNoFilmOfKeyframes) {
    proto::Script views;
    *views.add_views() = viewFrom({0, 0, 1});
    const auto ofViews = FilmModel::fromScript(views);
    ASSERT_FALSE(ofViews.ok());
    EXPECT_EQ(ofViews.error().code, ErrorCode::unsupported);
    EXPECT_EQ(ofViews.error().where, "views");
    EXPECT_FALSE(FilmModel::fromScript(proto::Script()).ok());
    FilmModel film;
    EXPECT_FALSE(film.add(proto::View()).ok());
    EXPECT_TRUE(film.empty());
    EXPECT_FALSE(film.duplicate().ok());
    EXPECT_FALSE(film.replace(viewFrom({0, 0, 1})).ok());
}

TEST(FilmModel, AScriptIsSavedAsItWasReadButForWhatWasChanged) {
    proto::Script script;
    const auto status = parseJson(R"({"betweenSteps": "hold", "keyframes": [
        {"view": {"width": 64, "height": 48}, "easing": "linear"},
        {"seconds": 0.001, "view": {"width": 64, "height": 48, "background": [0.1, 0.1, 0.1]}},
        {"seconds": 101325.001, "view": {"width": 64, "height": 48}, "easing": "hold"}], "fps": 0.5})",
                                  script, "test");
    ASSERT_TRUE(status.ok()) << status.error().toString();
    auto model = FilmModel::fromScript(script).value();
    EXPECT_EQ(toJson(model.saved()), toJson(script));
    model.select(2);
    model.setEasing(Easing::smooth);
    auto wanted = script;
    wanted.mutable_keyframes(2)->set_easing("smooth");
    EXPECT_EQ(toJson(model.saved()), toJson(wanted));
    model.select(1);
    model.removeSelected();
    wanted.mutable_keyframes()->DeleteSubrange(1, 1);
    EXPECT_EQ(toJson(model.saved()), toJson(wanted));
}

/// What lies nearer than a frame is moved apart here; the order stays.
TEST(FilmModel, ASavedScriptIsValidWhateverIsMoved) {
    proto::Script script;
    script.set_fps(1.0);
    for (const double seconds : {0.0, 0.001, 0.002, 9.0}) {
        auto& keyframe = *script.add_keyframes();
        keyframe.set_seconds(seconds);
        keyframe.mutable_view()->set_width(64);
        keyframe.mutable_view()->set_height(48);
    }
    auto model = FilmModel::fromScript(script).value();
    EXPECT_EQ(toJson(model.saved()), toJson(script));
    model.move(3, 12.0);
    model.move(2, 8.0);
    model.move(1, 5.0);
    EXPECT_TRUE(checkScript(model.saved()).ok());
    model.setFps(20.0);
    model.move(1, 0.5);
    EXPECT_TRUE(checkScript(model.saved()).ok());
    EXPECT_EQ(model.saved().keyframes(1).seconds(), 0.5);
}

// What of the film's bar is no drawing: times on the strip, the preview's times, thumbnails, requests.

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
