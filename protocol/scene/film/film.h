// SPDX-License-Identifier: GPL-3.0-or-later
//
// Film: the frames of a script (docs/SCRIPTS.md, "Films"): its views as they are, or what its keyframes or
// its moves give at a time. A value, cheap to copy; frames are computed when they are asked for, each from
// nothing but its time, so that any of them can be asked for by any thread.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>

#include "protocol/base/error.h"
#include "protocol/mote.pb.h"
#include "protocol/scene/film/check_script.h"
#include "protocol/scene/film/film_datasets.h"

namespace mote {

class Timeline;

class Film {
  public:
    /// Errors: of checkScript() and checkDatasets(); steps that a move plays and a dataset lacks; frames that
    /// would need more layers than a view may have; a camera that stands still in a film of constant speed.
    static Result<Film> create(const proto::Script& script, const FilmDatasets& datasets);

    std::size_t frameCount() const { return count_; }
    double fps() const { return fps_; }
    /// Pixels of every frame; of views that differ, of the first.
    std::uint32_t width() const { return width_; }
    std::uint32_t height() const { return height_; }

    /// There is a view at every time: it was made of keyframes or moves.
    bool continuous() const { return timeline_ != nullptr; }
    /// A frame's time on the script's clock: keyframes say where it begins; views and moves begin at 0.
    double secondsOf(std::size_t frame) const { return begin_ + static_cast<double>(frame) * spacing_; }
    /// How long it takes: of keyframes from the first to the last; of moves all together; of views frames /
    /// fps.
    double seconds() const { return seconds_; }

    /// A valid view. `index` < frameCount().
    proto::View frame(std::size_t index) const;
    /// A valid view; the first or the last one at times before and after. Of continuous films only.
    proto::View at(double seconds) const;

  private:
    Film() = default;
    void setTimes(const proto::Script& script);

    std::shared_ptr<const proto::Script> views_;  ///< of a script of views
    std::shared_ptr<const Timeline> timeline_;
    std::size_t count_ = 0;
    double fps_ = defaultFps;
    double begin_ = 0.0, spacing_ = 0.0, seconds_ = 0.0;
    std::uint32_t width_ = 0, height_ = 0;
};

}  // namespace mote
