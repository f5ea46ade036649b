// SPDX-License-Identifier: GPL-3.0-or-later
//
// ViewModel: what the viewer shows: a view, one of whose layers the user edits at a time. Every field that
// the user did not change stays as it was: controls write what they hold of the message twice, at first and
// now, and only what differs is an edit of it (apply_edits.h). So the view is one value: edited() is all of
// it, and load() brings it back. Opens no window and no connection; main thread.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "client/view/layers/layer_editor.h"
#include "client/view/numbers/numbers_model.h"
#include "protocol/base/error.h"
#include "protocol/mote.pb.h"
#include "protocol/scene/bounds.h"
#include "protocol/scene/camera.h"
#include "protocol/scene/film/film_datasets.h"

namespace mote::client {

class ViewModel {
  public:
    ViewModel();

    /// Takes a view whole; `fromFile`: saved() then says no more than it did. The chosen layer stays the one
    /// of its place. Errors as parseView, and unsupported for a layer that has no editor.
    Status load(const proto::View& view, bool fromFile = true);
    /// Shows the same as another one, and knows what that knows.
    void copy(const ViewModel& other);
    /// Counts views that were loaded and datasets that were exchanged: all may be another, the camera too.
    std::uint64_t jumps() const { return jumps_; }
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

    // Its layers, and which of them is edited: the chosen one. Indices are those of layers().

    const google::protobuf::RepeatedPtrField<proto::Layer>& layers() const { return message_.layers(); }
    int chosen() const { return chosen_; }
    void choose(int index);
    /// The chosen one; the usual one of a view without layers.
    const proto::Layer& layer() const;
    /// Draws a dataset as well, by its usual kind of layer, over all others; it is chosen.
    void addLayer(const std::string& dataset, const proto::Manifest& manifest);
    /// A copy above it, which is chosen.
    void duplicateLayer(int index);
    void removeLayer(int index);
    /// The others keep their order; the one that is moved is chosen.
    void moveLayer(int from, int to);
    void keepOnlyChosen();
    /// A layer of the chosen one's kind and style, and nothing else of it.
    proto::Layer style() const;
    /// The chosen layer has that style from now on. Errors: of another kind; as parseView.
    Status setStyle(const proto::Layer& style);
    /// One that is not shown is hidden, or has no opacity, as views of before say it.
    bool isShown(int index) const;
    void setShown(int index, bool shown);
    void setOpacity(int index, double opacity);
    /// What people call it; empty: its dataset's name is shown. Errors as parseView; then nothing changes.
    Status setName(int index, const std::string& name);
    /// Of the view: how plain it is made which of its layers is in front, 0 to 1.
    double depthContrast() const { return message_.depth_contrast(); }
    void setDepthContrast(double contrast);

    // Of the chosen layer:

    bool hasDataset() const { return !dataset().empty(); }
    const std::string& dataset() const { return layer().dataset(); }
    /// Shows another dataset, with the same look if the same kind of layer draws it; the step is kept where
    /// it has as many. A loaded camera stays. Of the one that is shown as describe().
    void setDataset(const std::string& name, const proto::Manifest& manifest);
    /// What is known of the dataset that is shown: of the view nothing changes.
    void describe(const proto::Manifest& manifest);
    /// Its editor knows its dataset.
    bool isDescribed() const { return described_; }
    /// Datasets of further layers that describe() was not told of; those that are known are not asked for.
    std::vector<std::string> unknownDatasets() const;
    /// Where a dataset of a further layer lies.
    void know(const std::string& name, const proto::Manifest& manifest);
    proto::Layer::KindCase kind() const { return layer().kind_case(); }
    /// Shows the dataset, whose manifest is given, by another kind of layer that draws it, every control at
    /// its default.
    void drawAs(proto::Layer::KindCase kind, const proto::Manifest& manifest);
    /// Steps of the dataset; none of one without time.
    int steps() const { return stepsOf(dataset()); }
    /// Of a known one.
    int stepsOf(const std::string& dataset) const;
    std::uint32_t step() const { return layer().step(); }
    /// Where a loaded layer is on its way to another step.
    std::optional<proto::Towards> towards() const;
    /// A layer that was loaded between steps is there no more once another is chosen. Other layers at the
    /// same step that have the new one go along.
    void setStep(std::uint32_t step) { goTo(chosen_, step); }

    /// Where the dataset lies, layer space; nothing before it is known.
    std::optional<Bounds> layerBounds() const;
    /// What is cut away, also by the style of a hybrid volume; set, all of it is the layer's own. A camera
    /// that was fitted stays where it is. Errors as parseClip; then nothing changes.
    proto::Clip clip() const;
    Status setClip(const proto::Clip& clip);
    /// Layer to world, of a view in metres what its place there undergoes; the same holds. Errors as
    /// parseTransform.
    glm::dmat4 transform() const;
    /// Layer to world in any view.
    glm::dmat4 layerToWorld() const;
    Status setTransform(const glm::dmat4& transform);

    // The same of the layer whose steps are played: the chosen one, or the first that has several.

    const proto::Layer& timedLayer() const;
    int timedSteps() const { return stepsOf(timedLayer().dataset()); }
    void setTimedStep(std::uint32_t step) { goTo(timed(), step); }

    /// What is edited of it, by its kind.
    LayerEditor& editor() { return *editor_; }

    /// Takes over what changed of the selections of another view's dataset, where a layer draws its particles
    /// here, or those of another plot of its run: then what means the same there. False where nothing
    /// changes.
    bool followSelections(const ViewModel& other, const SelectionsShown& before, const SelectionsShown& now);

    /// The camera: until the user moves it the one that the server fitted, or before that is known one that
    /// is fitted to all layers whose datasets are known.
    Camera camera(double aspect) const;
    void setCamera(const Camera& camera);
    bool hasCamera() const { return cameraSet_; }
    void fit() { cameraSet_ = false; }
    /// What the server fitted to the view without a camera.
    void setServed(const Camera& camera) { served_ = camera; }
    const std::optional<Camera>& served() const { return served_; }
    /// Whether all layers lie where they are, in metres. Set, the camera is fitted anew and nothing is
    /// stretched. Errors: those of placeLayers(); then nothing changes.
    bool inMetres() const { return !message_.space().empty(); }
    Status setInMetres(bool metres);
    /// From where layers are placed to the world, along its axes: of a view in metres what it says, else 1.
    glm::dvec3 stretch() const;
    /// The box around all layers whose datasets are known, world; nothing where none is.
    std::optional<Bounds> worldBounds() const;

    /// What a first picture says beside what it shows: axes and a colour bar.
    void annotateAsUsual();

    std::array<float, 3> background{};  ///< sRGB-encoded
    NumbersModel numbers;               ///< selections, colours by a column, annotations

  private:
    int timed() const;
    void goTo(int index, std::uint32_t step);
    /// Edits another layer, or the same one anew.
    void adopt(int chosen);
    /// True if the layer was of another kind.
    bool setKind(proto::Layer::KindCase kind);
    /// Makes the edits so far part of the message.
    void settle();
    /// The message as controls write it.
    proto::View written() const;
    void replaceClip(const proto::Clip& clip);
    /// What is seen would go along with what is changed.
    void keepFitted();
    /// Of a view that has a size and no camera.
    Camera fitted(const proto::View& view) const;
    proto::Layer& mutableLayer();

    proto::View message_;  // without the edits since before_
    proto::View before_;   // as controls wrote it when they were last told of it
    bool loaded_ = false;  // from a file; otherwise made here
    int chosen_ = 0;
    std::unique_ptr<LayerEditor> editor_;
    /// What a plot of a run has for selections.
    struct Plot {
        std::string run;  // what it was made of; empty: not known
        std::set<std::string> quantities;
    };

    FilmDatasets known_;  // all that were described
    std::map<std::string, Plot> plots_;
    bool described_ = false;   // the editor was told of the dataset
    bool hadDataset_ = false;  // since the view was loaded
    std::uint64_t jumps_ = 0;
    Camera camera_;
    bool cameraSet_ = false;
    std::optional<Camera> served_;
};

}  // namespace mote::client
