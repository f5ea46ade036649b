// SPDX-License-Identifier: GPL-3.0-or-later
//
// PictureHistory: what a PictureMaker remembers of one session. A value of the thread that renders.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "server/data/picture_memory.h"
#include "server/encode/vector/sight.h"
#include "server/frames/dot_maker.h"
#include "server/frames/page_sight.h"
#include "server/frames/quality_controller.h"
#include "server/frames/render_schedule.h"
#include "server/frames/scene_maker.h"
#include "server/render/device.h"
#include "server/render/layers/scene.h"
#include "server/render/plan/frame_plan.h"
#include "server/render/plan/quality.h"
#include "server/render/plan/unfinished_picture.h"

namespace mote::server {

class MeanPicture;
class Planning;

/// A picture that gave way to others, with all that it needs to go on. It is of one job. It may outlive its
/// maker and the device, but then it can only go.
struct Draft {
    std::shared_ptr<const ViewTask> task;
    Stage stage = Stage::quick;
    std::weak_ptr<render::Device> device;     ///< that began it
    std::shared_ptr<Planning> planning = {};  ///< not null: what follows is not there yet
    render::Scene scene = {};
    render::Quality quality = {};
    render::FramePlan plan = {};
    PageShapes shapes = {};                                   ///< of a page: not in the plan
    std::unique_ptr<PageSight> sight = {};                    ///< of these; null: found, or nobody asks
    std::vector<std::shared_ptr<const Sight>> sights = {};    ///< that it found; as MadePicture's
    double planMs = 0.0, renderMs = 0.0;                      ///< that it took so far
    double learnMs = 0.0;                                     ///< of planMs: apart from data
    std::unique_ptr<render::UnfinishedPicture> picture = {};  ///< refers to the plan; null: not begun
    std::optional<DotHistory> after = {};                     ///< as its scene left the history's dots
    PictureMemory::Taken memory = {};                         ///< that it takes at most
};

/// A picture that waits for memory, which others have.
struct MemoryWait {
    std::weak_ptr<const ViewTask> task;
    Clock::time_point since;      ///< that nobody gave any back
    std::uint64_t givenBack = 0;  ///< as PictureMemory's
};

/// What is remembered of one session's pictures, to choose the quality of the next.
struct PictureHistory {
    QualityController quality;
    std::vector<std::shared_ptr<const storage::ParticleStep>> steps = {};  ///< of the latest picture
    std::vector<const render::GridField*> hybrids = {};  ///< likewise; not held, only told apart
    double exactPoints = 0.0;  ///< that the exact picture of the latest view would have drawn, as ViewLoad's
    DotHistory dots = {};
    PlotBoxes boxes = {};                    ///< of the latest view that has axes
    std::unique_ptr<Draft> draft = {};       ///< of the latest job, where it gave way
    std::optional<MemoryWait> wait = {};     ///< of the latest job
    std::shared_ptr<MeanPicture> mean = {};  ///< the latest, where the latest job was between steps
};

}  // namespace mote::server
