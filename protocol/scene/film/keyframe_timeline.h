// SPDX-License-Identifier: GPL-3.0-or-later
//
// KeyframeTimeline: what lies between keyframes. Immutable; safe on any number of threads.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "protocol/base/error.h"
#include "protocol/scene/film/camera_path.h"
#include "protocol/scene/film/easing.h"
#include "protocol/scene/film/film_datasets.h"
#include "protocol/scene/film/layers_between.h"
#include "protocol/scene/film/path_length.h"
#include "protocol/scene/film/timeline.h"
#include "protocol/scene/view.h"

namespace mote {

class KeyframeTimeline : public Timeline {
  public:
    /// Of a checked script of keyframes. Errors: of checkDatasets(); more layers than a view may have; a film
    /// of constant speed whose camera stands still on a part of its way.
    static Result<std::unique_ptr<const Timeline>> create(const proto::Script& script,
                                                          const FilmDatasets& datasets);

    KeyframeTimeline(const KeyframeTimeline&) = delete;
    KeyframeTimeline& operator=(const KeyframeTimeline&) = delete;

    proto::View at(double seconds) const override;
    double begin() const override { return keyframes_.front().seconds; }
    double end() const override { return keyframes_.back().seconds; }

  private:
    struct Keyframe {
        double seconds;
        Easing easing;
        View view;            ///< with its camera
        proto::View message;  ///< the same, as it was written
    };
    /// Where a film is: at a share of a way's time, more than 0 and less than 1; or at a keyframe.
    struct Place {
        std::size_t keyframe;
        double share;
    };

    KeyframeTimeline(const proto::Script& script, std::vector<Keyframe> keyframes);
    static Result<std::vector<Keyframe>> read(const proto::Script& script, const FilmDatasets& datasets);
    Status checkLayers() const;
    Status goEvenly();
    Place placeAt(double seconds) const;
    double cameraShare(std::size_t way, double share) const;
    proto::View between(const Place& place) const;

    std::vector<Keyframe> keyframes_;
    std::vector<LayersBetween> layers_;  // one a way; refer to the keyframes' own
    CameraPath path_;
    std::optional<PathLength> length_;  // of constant speed
    double rounding_;                   // seconds within which a time is a keyframe's
};

}  // namespace mote
