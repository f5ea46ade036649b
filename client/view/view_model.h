// SPDX-License-Identifier: GPL-3.0-or-later
//
// ViewModel: what the viewer shows: a view whose first layer the user edits; further layers of a loaded view
// stay as they are, and so does every field that the user did not change: controls write what they hold of
// the message twice, at first and now, and only what differs is an edit of it (apply_edits.h). Opens no
// window and no connection; main thread.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "client/view/layers/layer_editor.h"
#include "client/view/numbers/numbers_model.h"
#include "protocol/mote.pb.h"
#include "protocol/scene/bounds.h"
#include "protocol/scene/camera.h"
#include "protocol/scene/error.h"
#include "protocol/scene/film/film_datasets.h"

namespace mote::client {

class ViewModel {
  public:
    ViewModel();

    /// Takes a saved view. Errors as parseView, and unsupported for a first layer that has no editor.
    Status load(const proto::View& view);
    /// As it was loaded, but for what the user has changed.
    proto::View edited() const;
    /// What a server is asked for at a size in pixels: without a camera it fits one to all layers.
    proto::View asked(std::uint32_t width, std::uint32_t height) const;
    /// The same with the camera that it is seen by.
    proto::View view(std::uint32_t width, std::uint32_t height) const;
    /// What "save" writes: a loaded view as edited(), another one complete, at this size.
    proto::View saved(std::uint32_t width, std::uint32_t height) const;

    /// Something is to be seen: also a loaded view that has no layers.
    bool isLoaded() const { return loaded_; }
    bool hasDataset() const { return !dataset().empty(); }
    const std::string& dataset() const { return layer().dataset(); }
    /// Shows another dataset, with the same look if the same kind of layer draws it; the step is kept where
    /// it has as many. A loaded camera stays. Of the one that is shown as describe().
    void setDataset(const std::string& name, const proto::Manifest& manifest);
    /// What is known of the dataset that is shown: of the view nothing changes.
    void describe(const proto::Manifest& manifest);
    /// Datasets of further layers that describe() was not told of; those that are known are not asked for.
    std::vector<std::string> unknownDatasets() const;
    /// Where a dataset of a further layer lies.
    void know(const std::string& name, const proto::Manifest& manifest);
    /// The kind of the first layer.
    proto::Layer::KindCase kind() const { return layer().kind_case(); }
    /// Shows the dataset, whose manifest is given, by another kind of layer that draws it, every control at
    /// its default.
    void drawAs(proto::Layer::KindCase kind, const proto::Manifest& manifest);
    /// Steps of the dataset; none of one without time.
    int steps() const { return steps_; }
    std::uint32_t step() const { return layer().step(); }
    /// Where a loaded layer is on its way to another step.
    std::optional<proto::Towards> towards() const;
    /// A layer that was loaded between steps is there no more once another is chosen.
    void setStep(std::uint32_t step);

    /// What is edited of the first layer, by its kind.
    LayerEditor& editor() { return *editor_; }

    /// The camera; fitted to all layers whose datasets are known until the user moves it.
    Camera camera(double aspect) const;
    void setCamera(const Camera& camera);
    void fit() { cameraSet_ = false; }

    std::array<float, 3> background{};  ///< sRGB-encoded
    NumbersModel numbers;               ///< selections, colours by a column, annotations

  private:
    /// True if the layer was of another kind.
    bool setKind(proto::Layer::KindCase kind);
    /// Makes the edits so far part of the message.
    void settle();
    /// The message as controls write it.
    proto::View written() const;
    /// Of a view that has a size and no camera.
    Camera fitted(const proto::View& view) const;
    const proto::Layer& layer() const;
    proto::Layer& mutableLayer();

    proto::View message_;  // without the edits since before_
    proto::View before_;   // as controls wrote it when they were last told of it
    bool loaded_ = false;  // from a file; otherwise made here
    std::unique_ptr<LayerEditor> editor_;
    int steps_ = 0;
    Bounds bounds_ = plotBounds;  // of the dataset, layer space
    FilmDatasets known_;          // all that were described
    bool described_ = false;      // there was a dataset before
    Camera camera_;
    bool cameraSet_ = false;
};

}  // namespace mote::client
