// SPDX-License-Identifier: GPL-3.0-or-later
//
// Films that nobody chose: every frame is a view, and none jumps.
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <string>

#include "protocol/base/json.h"
#include "protocol/scene/view.h"
#include "protocol/scene/view_message.h"
#include "tests/unit/scene/film_difference.h"
#include "tests/unit/scene/film_scripts.h"

namespace mote::test {
namespace {

constexpr std::uint64_t scripts = 300;

View filmView(const proto::View& message) {
    const auto parsed = parseView(message);
    EXPECT_TRUE(parsed.ok()) << parsed.error().toString() << "\n" << toJson(message);
    // As all frames between keyframes are: complete, rounded alike.
    return parseView(toProto(lengthsInPixels(parsed.value()))).value();
}

TEST(FilmGenerated, EveryFrameIsAView) {
    for (std::uint64_t i = 0; i < scripts; ++i) {
        for (auto script : {anyKeyframes(71, i), anyMoves(71, i)}) {
            script.set_fps(11.0);
            const Film film = filmOf(script);
            for (std::size_t frame = 0; frame < film.frameCount(); ++frame) {
                const auto view = parseView(film.frame(frame));
                ASSERT_TRUE(view.ok())
                    << i << " " << frame << ": " << view.error().toString() << toJson(script);
                EXPECT_EQ(view->width, film.width());
                EXPECT_FALSE(view->cameraFitted);
            }
        }
    }
}

TEST(FilmGenerated, TheSameFrameAlways) {
    const auto script = anyKeyframes(72, 5);
    const Film film = filmOf(script), again = filmOf(script);
    for (std::size_t i = film.frameCount(); i-- > 0;)
        EXPECT_EQ(film.frame(i).SerializeAsString(), again.frame(i).SerializeAsString());
}

/// The largest jump within a short time, anywhere in a film: on both sides of each keyframe, and between.
double largestJump(const Film& film, const proto::Script& script, double apart) {
    double most = 0.0;
    const auto look = [&](double seconds) {
        most = std::max(most, difference(filmView(film.at(seconds)), filmView(film.at(seconds + apart))));
    };
    for (const auto& keyframe : script.keyframes()) {
        look(keyframe.seconds() - apart);
        look(keyframe.seconds());
    }
    const double begin = film.secondsOf(0);
    for (int i = 0; i < 25; ++i) look(begin + film.seconds() * (i + 0.37) / 25.0);
    return most;
}

TEST(FilmGenerated, NothingJumpsBetweenKeyframes) {
    int lively = 0;
    for (std::uint64_t i = 0; i < scripts; ++i) {
        const auto script = anyKeyframes(73, i);
        const Film film = filmOf(script);
        const double coarse = largestJump(film, script, 1e-3), fine = largestJump(film, script, 1e-5);
        EXPECT_LT(fine, 0.1 * coarse + 2e-3) << i << toJson(script);
        lively += coarse > 1e-4;
    }
    EXPECT_GT(lively, static_cast<int>(scripts) / 2) << "the difference sees something";
}

/// Opacities over all layers of a dataset.
std::map<std::string, double> opacities(const View& view) {
    std::map<std::string, double> sums;
    for (const auto& layer : view.layers)
        sums[layer.dataset + std::to_string(layer.style.index())] += layer.opacity;
    return sums;
}

TEST(FilmGenerated, WeightsOfWhatIsShownTogetherAddUp) {
    for (std::uint64_t i = 0; i < scripts; ++i) {
        const auto script = anyKeyframes(74, i);
        const Film film = filmOf(script);
        for (int k = 0; k + 1 < script.keyframes_size(); ++k) {
            const auto &from = script.keyframes(k), &to = script.keyframes(k + 1);
            auto first = opacities(parseView(from.view()).value()),
                 last = opacities(parseView(to.view()).value());
            for (const double time : {0.125, 0.5, 0.875}) {
                const double share = from.easing() == "smooth" ? time * time * (3.0 - 2.0 * time) : time;
                const auto shown =
                    opacities(filmView(film.at(from.seconds() + time * (to.seconds() - from.seconds()))));
                for (const auto& [name, sum] : shown)
                    EXPECT_NEAR(sum, (1.0 - share) * first[name] + share * last[name], 1e-9) << name;
            }
        }
    }
}

}  // namespace
}  // namespace mote::test
