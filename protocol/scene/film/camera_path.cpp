// SPDX-License-Identifier: GPL-3.0-or-later
#include "protocol/scene/film/camera_path.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>

#include "protocol/scene/film/legal_camera.h"

namespace mote {
namespace {

/// A camera as numbers between which there is something.
struct Numbers {
    double seconds;
    bool parallel;
    glm::dvec3 target;
    glm::dquat orientation;  ///< eye space to world space
    double height, lens, distance;
};

double lensOf(double fovYDegrees) {
    return std::log(std::tan(glm::radians(0.5 * fovYDegrees)));
}

Numbers numbersOf(const CameraPath::Stop& stop) {
    const Camera& camera = stop.camera;
    const bool parallel = !camera.perspective();
    const double distance = std::log(glm::distance(camera.eye, camera.target));
    const double lens = lensOf(parallel ? leastFovYDegrees : camera.fovYDegrees);
    const double height = parallel ? std::log(*camera.orthographicHeight) : std::log(2.0) + distance + lens;
    return {stop.seconds, parallel, camera.target, orientationOf(camera), height, lens, distance};
}

/// What changes from one stop to the next, per second.
template <class Value>
struct Rates {
    std::vector<Value> ofWays;         ///< one a way
    const std::vector<double>& taken;  ///< seconds, one a way; below 0 where there is no way

    bool has(std::size_t way) const { return way < taken.size() && taken[way] > 0.0; }

    Value leaving(std::size_t way) const {
        if (way == 0 || !has(way - 1)) return ofWays[way];
        return tangentBetween(ofWays[way - 1], taken[way - 1], ofWays[way], taken[way]);
    }
    Value arriving(std::size_t way) const {
        if (!has(way + 1)) return ofWays[way];
        return tangentBetween(ofWays[way], taken[way], ofWays[way + 1], taken[way + 1]);
    }
};

template <class Value, class Member>
void setWays(const std::vector<Numbers>& stops, const std::vector<double>& taken, Value Numbers::*value,
             Member&& wayOf) {
    Rates<Value> rates{{}, taken};
    for (std::size_t i = 0; i < taken.size(); ++i)
        rates.ofWays.push_back((stops[i + 1].*value - stops[i].*value) / std::abs(taken[i]));
    for (std::size_t i = 0; i < taken.size(); ++i) {
        const double seconds = std::abs(taken[i]);
        wayOf(i) = {stops[i].*value, stops[i + 1].*value, seconds * rates.leaving(i),
                    seconds * rates.arriving(i)};
    }
}

/// The vectors of rotations between neighbours hold in the space of either.
template <class Member>
void setOrientations(const std::vector<Numbers>& stops, const std::vector<double>& taken, Member&& wayOf) {
    Rates<glm::dvec3> rates{{}, taken};
    for (std::size_t i = 0; i < taken.size(); ++i) {
        const auto turn = glm::conjugate(stops[i].orientation) * stops[i + 1].orientation;
        rates.ofWays.push_back(rotationVector(turn) / std::abs(taken[i]));
    }
    for (std::size_t i = 0; i < taken.size(); ++i) {
        const auto &from = stops[i].orientation, &to = stops[i + 1].orientation;
        const double third = std::abs(taken[i]) / 3.0;
        wayOf(i) = {from, from * rotationBy(third * rates.leaving(i)),
                    to * rotationBy(-third * rates.arriving(i)), to};
    }
}

/// Seconds of each way; with a minus where the path is interrupted.
std::vector<double> secondsOfWays(std::span<const CameraPath::Stop> stops) {
    std::vector<double> taken;
    for (std::size_t i = 0; i + 1 < stops.size(); ++i) {
        const double seconds = stops[i + 1].seconds - stops[i].seconds;
        taken.push_back(stops[i].jumps ? -seconds : seconds);
    }
    return taken;
}

/// The eye of a parallel projection goes its own way among those of its like.
std::vector<double> onlyParallel(std::vector<double> taken, const std::vector<Numbers>& stops) {
    for (std::size_t i = 0; i < taken.size(); ++i) {
        if (!stops[i].parallel || !stops[i + 1].parallel) taken[i] = -std::abs(taken[i]);
    }
    return taken;
}

}  // namespace

CameraPath::CameraPath(std::span<const Stop> stops) : ways_(stops.size() - 1) {
    std::vector<Numbers> numbers;
    for (const auto& stop : stops) {
        numbers.push_back(numbersOf(stop));
        if (numbers.size() < 2) continue;
        auto& orientation = numbers.back().orientation;
        orientation = nearerTo(numbers[numbers.size() - 2].orientation, orientation);
    }
    for (std::size_t i = 0; i < ways_.size(); ++i) {
        ways_[i].jumps = stops[i].jumps;
        ways_[i].first = stops[i].camera;
        ways_[i].fromParallel = numbers[i].parallel;
        ways_[i].toParallel = numbers[i + 1].parallel;
    }
    const auto taken = secondsOfWays(stops);
    setWays(
        numbers, taken, &Numbers::target, [&](std::size_t i) -> auto& { return ways_[i].target; });
    setWays(
        numbers, taken, &Numbers::height, [&](std::size_t i) -> auto& { return ways_[i].height; });
    setWays(
        numbers, taken, &Numbers::lens, [&](std::size_t i) -> auto& { return ways_[i].lens; });
    setWays(
        numbers, onlyParallel(taken, numbers),
        &Numbers::distance, [&](std::size_t i) -> auto& { return ways_[i].distance; });
    setOrientations(
        numbers, taken, [&](std::size_t i) -> auto& { return ways_[i].orientation; });
}

Camera CameraPath::cameraOf(const Way& way, double share) {
    Camera camera = way.first;
    camera.orthographicHeight.reset();
    const double height = way.height(share);
    double distance = 0.0;
    if (way.fromParallel && way.toParallel) {
        camera.orthographicHeight = std::exp(height);
        distance = std::exp(way.distance(share));
    } else {
        const double lens = std::clamp(way.lens(share), lensOf(leastFovYDegrees), lensOf(mostFovYDegrees));
        camera.fovYDegrees = glm::degrees(2.0 * std::atan(std::exp(lens)));
        distance = std::exp(height - std::log(2.0) - lens);
    }
    return standing(camera, way.target(share), way.orientation(share), distance);
}

Camera CameraPath::at(std::size_t way, double share) const {
    const Way& on = ways_[way];
    return on.jumps ? on.first : cameraOf(on, std::clamp(share, 0.0, 1.0));
}

}  // namespace mote
