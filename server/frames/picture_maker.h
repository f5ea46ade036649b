// SPDX-License-Identifier: GPL-3.0-or-later
//
// A PictureMaker owns the device and makes one picture after another: data, quality, plan, pixels. Made, used
// and destroyed on the thread that renders.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "protocol/base/error.h"
#include "protocol/mote.pb.h"
#include "server/data/step_source.h"
#include "server/figures/marks.h"
#include "server/frames/dot_maker.h"
#include "server/frames/picture_history.h"
#include "server/frames/render_schedule.h"
#include "server/render/device.h"
#include "server/render/layers/scene.h"
#include "server/render/plan/frame_plan.h"
#include "server/render/plan/quality.h"
#include "server/render/plan/selection_cache.h"
#include "server/render/plan/work_in_turns.h"

namespace mote::server {

/// Makes a device. May throw render::DeviceError.
using DeviceFactory = std::function<std::unique_ptr<render::Device>()>;

/// A picture, and the message that goes with it as far as it is known now.
struct MadePicture {
    render::Picture picture;
    proto::Frame message;
    Stage next = Stage::done;                            ///< of its view
    std::shared_ptr<const render::Dots> dots = nullptr;  ///< a view's with a page: not in the picture
    std::vector<std::shared_ptr<const render::Strokes>> strokes = {};  ///< likewise
    std::vector<std::shared_ptr<const Sight>> sights = {};             ///< of both, as VectorDrawing's
    std::shared_ptr<const Marks> annotations = nullptr;  ///< in pixels of the view; not in the picture yet
    bool onlyShapes = false;                             ///< there is nothing else in it but background
    double resolutionScale = 1.0;                        ///< as the Quality's that it was made in
    PictureMemory::Taken memory = {};                    ///< that it takes until it is encoded
};

/// What came of a job: a picture, or none, because it was stopped or waits for data.
struct Making {
    std::optional<MadePicture> picture = std::nullopt;
    bool waits = false;
    std::optional<Clock::time_point> until = {};  ///< it waits for memory: then it is refused
    PictureMemory::Taken memory = {};             ///< of what there is of it
};

class PictureMaker {
  public:
    /// Throws render::DeviceError. `steps` must outlive it. `costs`: of such a device where they are known;
    /// else it is measured.
    /// `leastTurn`: of planning, as WorkInTurns. `memory`: that pictures are counted to; null: nobody counts.
    PictureMaker(DeviceFactory factory, StepSource& steps, std::optional<render::DeviceCosts> costs = {},
                 render::WorkInTurns::Duration leastTurn = render::WorkInTurns::shortTurn,
                 std::shared_ptr<PictureMemory> memory = {});

    const std::string& deviceName() const { return name_; }
    const render::DeviceCosts& costs() const { return costs_; }

    /// A view in motion is drawn from what is in memory; the exact picture waits until all of its data is
    /// there, unless there is no room for it, when it is read as it is drawn. What is paused leaves a draft,
    /// which the same job goes on with, to the same bytes. A picture that finds no memory waits until others
    /// give some back. Of a final-only view that comes to no picture the
    /// history's dots are as they were. Errors: notFound, corrupt and so on of the data;
    /// internal of the device, which is made anew where it fails again and again; resourceExhausted (more
    /// memory than there is, or than others gave back in a minute).
    /// A view between steps is drawn once for each of its parts (mean_picture.h). Errors then also:
    /// unsupported (a page for a plotter). Throws BrokenInvariant: then neither it nor the history is good
    /// for more.
    Result<Making> make(const RenderJob& job, PictureHistory& history);

    /// The device frees what nobody needs any more.
    void trim();

  private:
    std::unique_ptr<render::Device> newDevice() const;
    Result<Making> makeAny(const RenderJob& job, PictureHistory& history);
    Result<Making> makeOne(const RenderJob& job, PictureHistory& history);
    void drop(std::unique_ptr<Draft>& draft) const;
    void giveUpDrafts(MeanPicture* mean) const;
    Result<bool> admit(const RenderJob& job, PictureHistory& history, Making& why);
    static std::unique_ptr<Draft> draftOf(PictureHistory& history);
    std::unique_ptr<Draft> planningOf(const RenderJob& job, PictureHistory& history);
    Result<std::unique_ptr<Draft>> newDraft(const RenderJob& job, PictureHistory& history, Making& why);
    std::unique_ptr<Draft> planned(const RenderJob& job, render::Scene scene, Clock::time_point begun,
                                   PictureHistory& history);
    std::optional<render::Picture> drawnBefore(const render::FramePlan& plan, const RenderJob& job);
    std::unique_ptr<render::UnfinishedPicture> begin(const render::FramePlan& plan,
                                                     render::PixelFormat format, Stage stage,
                                                     const std::stop_token& stop);
    bool findSight(const RenderJob& job, Draft& draft, const std::stop_token& pause);
    bool draw(const RenderJob& job, Draft& draft, const std::stop_token& pause);
    MadePicture finished(const RenderJob& job, Draft& draft, PictureHistory& history);
    std::optional<render::FramePlan> planFor(const RenderJob& job, const render::Scene& scene,
                                             const render::Quality& quality);
    bool want(const render::FramePlan& plan);
    Result<std::optional<render::Scene>> sceneOf(const RenderJob& job, PictureHistory& history, Making& why);
    Result<std::optional<render::Scene>> sceneOf(const View& view, const RenderJob& job, DotHistory& dots,
                                                 PictureHistory& history, Making& why);
    Result<std::optional<render::Scene>> stippledSceneOf(const View& view, std::size_t index,
                                                         const RenderJob& job, PictureHistory& history,
                                                         Making& why);
    Result<std::optional<render::Dots>> stippled(const render::Scene& scene, const Layer& layer,
                                                 const RenderJob& job, PictureHistory& history, Making& why);
    void deviceFailed();

    const DeviceFactory factory_;
    StepSource& steps_;
    const render::WorkInTurns::Duration leastTurn_;
    const std::shared_ptr<PictureMemory> memory_;
    std::stop_token stop_;  // of the job that is made
    DrawnPhotographs photographs_;
    render::SelectionCache selections_;
    std::shared_ptr<render::Device> device_;  // empty after it failed twice, until the next picture
    std::string name_;
    render::DeviceCosts costs_;
    int failures_ = 0;  // of the device, in a row
};

}  // namespace mote::server
