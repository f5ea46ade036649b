// SPDX-License-Identifier: GPL-3.0-or-later
//
// ViewModel: what the viewer shows: a view whose first layer the user edits; further layers of a loaded view
// stay as they are. Opens no window and no connection; main thread.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string>

#include "client/view/layers/layer_editor.h"
#include "client/view/numbers/numbers_model.h"
#include "protocol/mote.pb.h"
#include "protocol/scene/bounds.h"
#include "protocol/scene/camera.h"
#include "protocol/scene/error.h"

namespace mote::client {

class ViewModel {
  public:
    ViewModel();

    /// Takes a saved view. Errors as parseView, and unsupported for a first layer that has no editor.
    Status load(const proto::View& view);
    /// The view at a size in pixels; the same message is what "save" writes.
    proto::View view(std::uint32_t width, std::uint32_t height) const;

    bool hasDataset() const { return !dataset().empty(); }
    const std::string& dataset() const { return layer().dataset(); }
    /// Shows another dataset, with the same look if the same kind of layer draws it; the step is kept where
    /// it has as many. A loaded camera stays.
    void setDataset(const std::string& name, const proto::Manifest& manifest);
    /// What is known of the dataset that a loaded view shows, whose camera and look stay.
    void describe(const proto::Manifest& manifest);
    /// The kind of the first layer.
    proto::Layer::KindCase kind() const { return layer().kind_case(); }
    /// Shows the dataset, whose manifest is given, by another kind of layer that draws it, every control at
    /// its default.
    void drawAs(proto::Layer::KindCase kind, const proto::Manifest& manifest);
    /// Steps of the dataset; none of one without time.
    int steps() const { return steps_; }
    std::uint32_t step() const { return layer().step(); }
    void setStep(std::uint32_t step) { mutableLayer().set_step(step); }

    /// What is edited of the first layer, by its kind.
    LayerEditor& editor() { return *editor_; }

    /// The camera; fitted to the dataset until the user moves it.
    Camera camera(double aspect) const;
    void setCamera(const Camera& camera);
    void fit() { cameraSet_ = false; }

    std::array<float, 3> background{};  ///< sRGB-encoded
    NumbersModel numbers;               ///< selections, colours by a column, annotations

  private:
    /// True where the layer was of another kind.
    bool setKind(proto::Layer::KindCase kind);
    const proto::Layer& layer() const { return base_.layers(0); }
    proto::Layer& mutableLayer() { return *base_.mutable_layers(0); }

    proto::View base_;  // one layer at least; what the editor holds wins over it
    std::unique_ptr<LayerEditor> editor_;
    int steps_ = 0;
    Bounds bounds_ = plotBounds;  // of the dataset, layer space
    bool described_ = false;      // there was a dataset before
    Camera camera_;
    bool cameraSet_ = false;
};

}  // namespace mote::client
