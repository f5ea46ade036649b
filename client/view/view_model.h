// SPDX-License-Identifier: GPL-3.0-or-later
//
// ViewModel: what the viewer shows: a view whose first layer the user edits; further layers of a loaded view
// stay as they are. A value, free of any window or connection.
#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "client/view/hybrid_controls.h"
#include "client/view/stipple_controls.h"
#include "client/view/transfer_functions.h"
#include "protocol/mote.pb.h"
#include "protocol/scene/bounds.h"
#include "protocol/scene/camera.h"
#include "protocol/scene/error.h"

namespace mote::client {

/// Steps of a series; none of a dataset without time.
int stepCount(const proto::Manifest& manifest);

class ViewModel {
  public:
    ViewModel();

    /// Takes a saved view. Errors as parseView.
    Status load(const proto::View& view);
    /// The view at a size in pixels; the same message is what "save" writes.
    proto::View view(std::uint32_t width, std::uint32_t height) const;

    bool hasDataset() const { return !dataset().empty(); }
    const std::string& dataset() const { return layer().dataset(); }
    /// Shows another dataset, with the same look if it is of the same kind; the step is kept where it has as
    /// many. A loaded camera stays.
    void setDataset(const std::string& name, const proto::Manifest& manifest);
    /// Whether the edited layer stipples or shows a hybrid volume; otherwise it shows particles.
    bool stipples() const { return layer().has_stipple(); }
    bool showsVolume() const { return layer().has_hybrid(); }
    std::uint32_t step() const { return layer().step(); }
    void setStep(std::uint32_t step) { mutableLayer().set_step(step); }

    /// The camera; fitted to the dataset until the user moves it.
    Camera camera(double aspect) const;
    void setCamera(const Camera& camera);
    void fit() { cameraSet_ = false; }

    HybridControls hybrid;
    StippleControls stipple;
    TransferFunctions functions;
    std::string colorMap;
    float pointOpacity = 0.0F;
    float pointSize = 0.0F;             ///< pixels
    std::array<float, 3> pointColor{};  ///< sRGB-encoded
    std::array<float, 3> background{};  ///< sRGB-encoded

  private:
    void followPlot(const proto::Manifest& manifest);
    /// True where the layer was of another kind.
    bool setKind(const std::string& kind);
    const proto::Layer& layer() const { return base_.layers(0); }
    proto::Layer& mutableLayer() { return *base_.mutable_layers(0); }
    void readStyle();
    void writeParticles(proto::ParticlesStyle& style) const;

    proto::View base_;            // one layer at least; the editable fields above win over it
    float plotOpacity_ = 0.0F;    // defaultPointOpacity() of the dataset
    Bounds bounds_ = plotBounds;  // of the dataset, layer space
    bool described_ = false;      // there was a dataset before
    Camera camera_;
    bool cameraSet_ = false;
};

}  // namespace mote::client
