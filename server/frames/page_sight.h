// SPDX-License-Identifier: GPL-3.0-or-later
//
// PageSight finds what lies before the shapes of a page (Sight), for each list of strokes and then for the
// dots: the device draws the plan with something black, then white, in their places. What is drawn beneath a
// list on the page counts as the picture does. Used on the device's thread; it stays where it is.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <stop_token>
#include <vector>

#include "protocol/scene/page.h"
#include "server/encode/vector/shape_places.h"
#include "server/encode/vector/sight_probe.h"
#include "server/render/device.h"
#include "server/render/plan/frame_plan.h"

namespace mote::server {

/// What of a plan are shapes on a page.
struct PageShapes {
    std::shared_ptr<const render::Dots> dots = {};  ///< null: none
    std::vector<std::shared_ptr<const render::Strokes>> strokes = {};
};

/// Takes them out of the plan. EPS knows no transparency: there what is pale stays in the picture, but for a
/// plotter.
PageShapes takeShapes(render::FramePlan& plan, const Page& page);

class PageSight {
  public:
    /// `plan`: without the shapes.
    PageSight(render::FramePlan plan, PageShapes shapes);

    /// Goes on until all is found or `pause` is requested. Whether it is. `stop`: as the device's. Throws
    /// what the device throws.
    bool advance(render::Device& device, const std::stop_token& pause, const std::stop_token& stop);
    /// As VectorDrawing's. Once.
    std::vector<std::shared_ptr<const Sight>> take() { return std::move(sights_); }
    std::uint64_t bytes() const;
    void giveUp();

  private:
    bool beginList();
    void setProbes(const glm::vec3& color);
    bool drawn(render::Device& device, const std::stop_token& pause, const std::stop_token& stop);

    render::FramePlan plan_;  // that is drawn: what lies beneath the list, and its probes
    std::vector<std::shared_ptr<const render::Fragments>> fragments_;  // without probes
    std::shared_ptr<const render::Dots> plansDots_;                    // likewise
    PageShapes shapes_;
    std::size_t left_;  // lists that have not been begun, the dots among them
    std::vector<std::shared_ptr<const Sight>> sights_;
    std::unique_ptr<SightProbe> probe_;  // null: the next list is to be begun
    std::unique_ptr<render::UnfinishedPicture> picture_;
    std::vector<render::Picture> pictures_;  // of the probe, black and white
};

}  // namespace mote::server
