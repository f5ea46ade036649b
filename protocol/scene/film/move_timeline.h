// SPDX-License-Identifier: GPL-3.0-or-later
//
// MoveTimeline: a view and what it does, one move after the other. Immutable; safe on any number of threads.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "protocol/base/error.h"
#include "protocol/scene/camera.h"
#include "protocol/scene/film/easing.h"
#include "protocol/scene/film/film_datasets.h"
#include "protocol/scene/film/steps_between.h"
#include "protocol/scene/film/timeline.h"

namespace mote {

class MoveTimeline : public Timeline {
  public:
    /// Of a checked script of moves. Errors: of checkDatasets(); steps that are played and not there; a
    /// camera that comes where none may be.
    static Result<std::unique_ptr<const Timeline>> create(const proto::Script& script,
                                                          const FilmDatasets& datasets);

    proto::View at(double seconds) const override;
    double begin() const override { return 0.0; }
    double end() const override { return moves_.back().end; }

  private:
    /// Steps of a layer during a move; it plays them, or both are the same.
    struct Steps {
        std::uint32_t from = 0, to = 0;
        bool played = false;
        bool left = false;  ///< an earlier move played some: it is not where its view says any more
    };
    struct Move {
        double begin = 0.0, end = 0.0;  ///< seconds
        Easing easing = Easing::linear;
        Camera camera;             ///< where it begins
        glm::dvec3 turn{0.0};      ///< about the target: an axis as long as the angle, radians
        glm::dvec3 target{0.0};    ///< where it ends
        double zoom = 0.0;         ///< log of how much larger the picture becomes
        std::vector<Steps> steps;  ///< one a layer

        bool movesCamera() const { return turn != glm::dvec3(0.0) || target != camera.target || zoom != 0.0; }
        glm::dvec3 offsetAt(double share) const;  ///< of the eye from the target
        Camera cameraAt(double share) const;
    };

    MoveTimeline(proto::View view, BetweenSteps between) : view_(std::move(view)), between_(between) {}
    Status add(const proto::Move& message, const FilmDatasets& datasets);
    Status play(const proto::Move::PlaySteps& message, const FilmDatasets& datasets, Move& move) const;
    Move next(const proto::Move& message) const;
    BetweenSteps betweenSteps(const proto::Layer& layer) const;
    std::vector<ShownStep> stepsOf(int layer, const Steps& steps, double share) const;

    proto::View view_;  ///< where it begins, with its camera
    Camera camera_;     ///< parsed
    BetweenSteps between_;
    std::vector<Move> moves_;
};

}  // namespace mote
