// SPDX-License-Identifier: GPL-3.0-or-later
//
// MeanPicture: a picture between steps on its way: the pictures that it is the mean of (protocol/scene/
// view_parts.h) are made one after another, each as any other, and may wait and give way like these. It is of
// one job. A part of a session's history, of the thread that renders.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "protocol/base/error.h"
#include "protocol/scene/view_parts.h"
#include "server/frames/picture_history.h"
#include "server/frames/picture_maker.h"
#include "server/frames/picture_mean.h"
#include "server/frames/render_schedule.h"

namespace mote::server {

class MeanPicture {
  public:
    /// Makes one picture of a view, with a history of its own.
    using Make = std::function<Result<Making>(const RenderJob& part, PictureHistory& history)>;

    /// Each part goes on from what the session's history remembers, in its part of the time. `before`: of the
    /// same session; null: none. Of it what the parts learned is taken, if there were as many.
    MeanPicture(const RenderJob& job, std::vector<ViewPart> parts, const PictureHistory& history,
                MeanPicture* before);

    /// Whether it is of that job and not done yet.
    bool isOf(const RenderJob& job) const { return task_ == job.task && stage_ == job.stage; }
    /// Makes what is missing. Without a picture where a part has none yet: it waits, or gave way, or was
    /// stopped. When all is done, the history remembers it as if it were one picture. Errors: of the parts.
    Result<Making> goOn(const RenderJob& job, PictureHistory& history, const Make& make);
    std::vector<PictureHistory>& histories() { return histories_; }

  private:
    void take(MadePicture made);
    MadePicture finished(const RenderJob& job, PictureHistory& history);

    std::shared_ptr<const ViewTask> task_;
    Stage stage_;
    std::vector<ViewPart> parts_;
    std::size_t nearest_ = 0;                // part, where every layer shows its nearer step
    std::vector<PictureHistory> histories_;  // one a part
    std::size_t next_ = 0;                   // part to be made
    std::optional<double> resolutionScale_;  // of those that are made
    PictureMean mean_;
    std::optional<MadePicture> made_;           // what those that are made are together, without pixels
    std::vector<PictureMemory::Taken> memory_;  // of the sum and of the latest one
};

}  // namespace mote::server
