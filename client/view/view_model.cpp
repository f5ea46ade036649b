// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/view/view_model.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "client/view/apply_edits.h"
#include "client/view/numbers/quantities.h"
#include "client/view/slider_values.h"
#include "protocol/scene/dataset.h"
#include "protocol/scene/film/sized_script.h"
#include "protocol/scene/view.h"
#include "protocol/scene/write_fields.h"

namespace mote::client {
namespace {

Bounds boundsOf(const FilmDatasets& known, const std::string& dataset) {
    const auto found = known.find(dataset);
    return found != known.end() ? found->second.bounds : plotBounds;
}

/// A saved view may leave its size to the window.
proto::View sized(proto::View view) {
    if (view.width() == 0) view.set_width(1280);
    if (view.height() == 0) view.set_height(720);
    return view;
}

}  // namespace

ViewModel::ViewModel() {
    message_.add_layers();
    setKind(proto::Layer::kParticles);
}

Status ViewModel::load(const proto::View& view, bool fromFile) {
    MOTE_ASSIGN_OR_RETURN(const auto parsed, parseView(sized(view)));
    for (int i = 0; i < view.layers_size(); ++i) {
        if (makeLayerEditor(view.layers(i).kind_case()) == nullptr)
            return Error{ErrorCode::unsupported, fmt::format("layers[{}]", i),
                         "this viewer cannot edit such a layer"};
    }
    message_ = view;
    loaded_ = fromFile;
    hadDataset_ = false;
    ++jumps_;
    served_.reset();
    cameraSet_ = view.has_camera();
    camera_ = parsed.camera;
    background = shownColor(view.background(), parsed.background);
    adopt(chosen_);
    return success();
}

void ViewModel::copy(const ViewModel& other) {
    message_ = other.edited();
    loaded_ = other.loaded_;
    hadDataset_ = other.hadDataset_;
    known_ = other.known_;
    plots_ = other.plots_;
    ++jumps_;
    camera_ = other.camera_;
    cameraSet_ = other.cameraSet_;
    served_ = other.served_;
    background = other.background;
    adopt(other.chosen_);
}

void ViewModel::adopt(int chosen) {
    chosen_ = std::clamp(chosen, 0, std::max(message_.layers_size() - 1, 0));
    const bool empty = message_.layers().empty();
    editor_ = makeLayerEditor(empty ? proto::Layer::kParticles : layer().kind_case());
    if (!empty) editor_->read(layer());
    numbers.read(message_, chosen_);
    described_ = false;
    before_ = written();
}

void ViewModel::choose(int index) {
    if (index == chosen_ || index < 0 || index >= message_.layers_size()) return;
    settle();
    adopt(index);
}

void ViewModel::addLayer(const std::string& dataset, const proto::Manifest& manifest) {
    const auto kinds = layersThatDraw(manifest.kind());
    if (kinds.empty()) return setDataset(dataset, manifest);  // the server says why it cannot
    settle();
    know(dataset, manifest);
    auto& added = *message_.add_layers();
    added.set_dataset(dataset);
    makeLayerEditor(kinds.front())->write(added);
    adopt(message_.layers_size() - 1);
}

void ViewModel::duplicateLayer(int index) {
    settle();
    *message_.add_layers() = proto::Layer(message_.layers(index));
    for (int i = message_.layers_size() - 1; i > index + 1; --i)
        message_.mutable_layers()->SwapElements(i, i - 1);
    adopt(index + 1);
}

void ViewModel::removeLayer(int index) {
    settle();
    message_.mutable_layers()->DeleteSubrange(index, 1);
    adopt(chosen_ > index ? chosen_ - 1 : chosen_);
}

void ViewModel::moveLayer(int from, int to) {
    settle();
    for (int i = from; i != to; i += to > from ? 1 : -1)
        message_.mutable_layers()->SwapElements(i, i + (to > from ? 1 : -1));
    adopt(to);
}

void ViewModel::keepOnlyChosen() {
    if (message_.layers_size() < 2) return;
    settle();
    proto::Layer kept = layer();
    message_.clear_layers();
    message_.add_layers()->Swap(&kept);
    adopt(0);
}

namespace {

const google::protobuf::FieldDescriptor& kindField(proto::Layer::KindCase kind) {
    return *proto::Layer::descriptor()->FindFieldByNumber(kind);
}

}  // namespace

proto::Layer ViewModel::style() const {
    proto::Layer style;
    if (kind() == proto::Layer::KIND_NOT_SET) return style;
    const auto whole = edited();
    const auto& from = whole.layers(chosen_);
    const auto& field = kindField(kind());
    style.GetReflection()
        ->MutableMessage(&style, &field)
        ->CopyFrom(from.GetReflection()->GetMessage(from, &field));
    return style;
}

Status ViewModel::setStyle(const proto::Layer& style) {
    if (style.kind_case() != kind() || kind() == proto::Layer::KIND_NOT_SET)
        return invalid("style", "it is one of another kind of layer");
    auto changed = edited();
    auto& to = *changed.mutable_layers(chosen_);
    const auto& field = kindField(kind());
    to.GetReflection()
        ->MutableMessage(&to, &field)
        ->CopyFrom(style.GetReflection()->GetMessage(style, &field));
    MOTE_RETURN_IF_ERROR(parseView(sized(changed)));
    message_ = changed;
    adopt(chosen_);
    return success();
}

bool ViewModel::isShown(int index) const {
    const auto& layer = message_.layers(index);
    return !layer.hidden() && (!layer.has_opacity() || layer.opacity() > 0.0);
}

void ViewModel::setOpacity(int index, double opacity) {
    settle();
    auto& layer = *message_.mutable_layers(index);
    layer.set_opacity(opacity);
    if (opacity >= 1.0) layer.clear_opacity();
    before_ = written();
}

void ViewModel::setDepthContrast(double contrast) {
    settle();
    message_.set_depth_contrast(contrast);
    if (contrast <= 0.0) message_.clear_depth_contrast();
    before_ = written();
}

void ViewModel::setShown(int index, bool shown) {
    settle();
    auto& layer = *message_.mutable_layers(index);
    layer.set_hidden(!shown);
    if (!isShown(index) && shown) layer.clear_opacity();
    before_ = written();
}

Status ViewModel::setName(int index, const std::string& name) {
    auto changed = edited();
    changed.mutable_layers(index)->set_name(name);
    MOTE_RETURN_IF_ERROR(parseView(sized(changed)));
    settle();
    message_.mutable_layers(index)->set_name(name);
    before_ = written();
    return success();
}

const proto::Layer& ViewModel::layer() const {
    return message_.layers().empty() ? proto::Layer::default_instance() : message_.layers(chosen_);
}

proto::Layer& ViewModel::mutableLayer() {
    return message_.layers().empty() ? *message_.add_layers() : *message_.mutable_layers(chosen_);
}

proto::View ViewModel::written() const {
    proto::View view = message_;
    assignColor(view.mutable_background(), background);
    view.clear_camera();
    if (cameraSet_) *view.mutable_camera() = toProto(camera_);
    if (!view.layers().empty()) editor_->write(*view.mutable_layers(chosen_));
    numbers.write(view);
    return view;
}

proto::View ViewModel::edited() const {
    proto::View view = message_;
    applyEdits(before_, written(), view);
    return view;
}

void ViewModel::settle() {
    message_ = edited();
    before_ = written();
}

proto::View ViewModel::asked(std::uint32_t width, std::uint32_t height) const {
    proto::View view = edited();
    view.set_width(width);
    view.set_height(height);
    return view;
}

proto::View ViewModel::view(std::uint32_t width, std::uint32_t height) const {
    proto::View view = asked(width, height);
    if (!view.has_camera()) *view.mutable_camera() = toProto(fitted(view));
    return view;
}

proto::View ViewModel::saved(std::uint32_t width, std::uint32_t height) const {
    return loaded_ ? edited() : view(width, height);
}

void ViewModel::setDataset(const std::string& name, const proto::Manifest& manifest) {
    // What no kind of layer draws is asked for as particles, so that the server says why it cannot.
    const auto kinds = layersThatDraw(manifest.kind());
    const bool same = std::find(kinds.begin(), kinds.end(), layer().kind_case()) != kinds.end();
    if (name == dataset() && (same || loaded_)) return describe(manifest);
    settle();
    const Bounds before = boundsOf(known_, dataset());
    mutableLayer().set_dataset(name);
    know(name, manifest);
    ++jumps_;
    served_.reset();
    described_ = true;
    const bool otherKind = !same && setKind(kinds.empty() ? proto::Layer::kParticles : kinds.front());
    if (layer().towards().step() >= static_cast<std::uint32_t>(steps())) mutableLayer().clear_towards();
    const auto last = static_cast<std::uint32_t>(std::max(steps(), 1)) - 1;
    if (step() > last) setStep(last);
    // They lie in spaces of their own; but a loaded camera is for the first.
    if (std::exchange(hadDataset_, true) && boundsOf(known_, name) != before) {
        fit();
        replaceClip({});
    }
    if (otherKind) fit();
    editor_->setDataset(manifest);
    numbers.setDataset(manifest.particles());
}

std::optional<proto::Towards> ViewModel::towards() const {
    return layer().has_towards() ? std::optional(layer().towards()) : std::nullopt;
}

int ViewModel::timed() const {
    if (steps() > 1) return chosen_;
    for (int i = 0; i < message_.layers_size(); ++i) {
        if (stepsOf(message_.layers(i).dataset()) > 1) return i;
    }
    return chosen_;
}

const proto::Layer& ViewModel::timedLayer() const {
    return message_.layers().empty() ? layer() : message_.layers(timed());
}

void ViewModel::goTo(int index, std::uint32_t step) {
    if (message_.layers().empty() || step == message_.layers(index).step()) return;
    const auto before = message_.layers(index).step();
    for (int i = 0; i < message_.layers_size(); ++i) {
        auto& each = *message_.mutable_layers(i);
        const bool along =
            each.step() == before && step < static_cast<std::uint32_t>(stepsOf(each.dataset()));
        if (i != index && !along) continue;
        each.clear_towards();
        each.set_step(step);
    }
}

int ViewModel::stepsOf(const std::string& dataset) const {
    const auto known = known_.find(dataset);
    return known != known_.end() ? known->second.steps : 0;
}

void ViewModel::describe(const proto::Manifest& manifest) {
    settle();
    know(dataset(), manifest);
    described_ = hadDataset_ = true;
    // Read anew, it is as in a view that was just loaded: a dataset brings what that leaves out, and no more.
    if (hasDataset() && parseView(sized(message_)).ok()) editor_->read(layer());
    editor_->setDataset(manifest);
    before_ = written();
}

void ViewModel::know(const std::string& name, const proto::Manifest& manifest) {
    known_[name] = {datasetBounds(manifest), stepCount(manifest), datasetOutlook(manifest)};
    if (!manifest.has_particles()) return;
    auto& plot = plots_[name] = {};
    for (const auto& quantity : quantitiesOf(manifest.particles())) plot.quantities.insert(quantity.name);
    // Inputs are named from the folder of the dataset.
    const auto folder = name.substr(0, name.rfind('/') + 1);
    const auto& made = manifest.request().particles();
    for (const auto& input : made.inputs()) plot.run += folder + input + "\n";
    if (!plot.run.empty()) plot.run += made.species();
}

std::vector<std::string> ViewModel::unknownDatasets() const {
    std::vector<std::string> names;
    for (const auto& each : message_.layers()) {
        if (known_.count(each.dataset()) == 0) names.push_back(each.dataset());
    }
    return names;
}

void ViewModel::drawAs(proto::Layer::KindCase kind, const proto::Manifest& manifest) {
    if (setKind(kind)) editor_->setDataset(manifest);
}

bool ViewModel::setKind(proto::Layer::KindCase kind) {
    if (kind == layer().kind_case()) return false;
    if (editor_) settle();
    editor_ = makeLayerEditor(kind);
    editor_->write(mutableLayer());
    const bool inSteps = kind == proto::Layer::kParticles || kind == proto::Layer::kHybrid;
    if (!inSteps) mutableLayer().clear_towards();
    if (message_.background().empty()) {
        // Drawings have other paper.
        const auto parsed = parseView(sized(message_));
        if (parsed.ok()) background = shownColor(message_.background(), parsed->background);
    }
    before_ = written();
    return true;
}

Camera ViewModel::camera(double aspect) const {
    if (cameraSet_) return camera_;
    if (served_) return *served_;
    constexpr double usualHeight = 720.0;
    const double height = std::clamp(View::maxSide / aspect, 1.0, usualHeight);
    const auto pixels = [](double side) { return static_cast<std::uint32_t>(std::lround(side)); };
    return fitted(asked(std::max(pixels(height * aspect), 1U), pixels(height)));
}

Camera ViewModel::fitted(const proto::View& view) const {
    if (served_) return *served_;
    auto parsed = parseView(view);
    if (!parsed.ok() || !fitToDatasets(*parsed, known_).ok())
        return fitCamera(boundsOf(known_, dataset()), static_cast<double>(view.width()) / view.height());
    return parsed->camera;
}

namespace {

/// What all plots with these quantities understand.
SelectionsShown ofQuantities(SelectionsShown shown, const std::set<std::string>& quantities) {
    const auto all = shown.named;
    shown.named.Clear();
    for (const auto& each : all) {
        const auto columns = columnsIn(each.selection(), all);
        if (!dependsOnPlot(each.selection(), all) && std::ranges::includes(quantities, columns))
            *shown.named.Add() = each;
    }
    const auto isHighlighted = [&](const auto& each) { return each.name() == shown.highlighted; };
    if (std::ranges::none_of(shown.named, isHighlighted)) shown.highlighted.clear();
    return shown;
}

}  // namespace

bool ViewModel::followSelections(const ViewModel& other, const SelectionsShown& before,
                                 const SelectionsShown& now) {
    const int edited = chosen_;
    const auto& from = other.dataset();
    const auto theirs = other.plots_.find(from);
    std::set<std::string> done;
    bool changed = false;
    for (int i = 0; i < message_.layers_size(); ++i) {
        const std::string to = message_.layers(i).dataset();
        const auto mine = plots_.find(to);
        const bool related = theirs != other.plots_.end() && mine != plots_.end() &&
                             !mine->second.run.empty() && mine->second.run == theirs->second.run;
        if (!message_.layers(i).has_particles() || !(to == from || related) || !done.insert(to).second)
            continue;
        choose(i);
        changed |= to == from ? numbers.follow(before, now)
                              : numbers.follow(ofQuantities(before, mine->second.quantities),
                                               ofQuantities(now, mine->second.quantities));
    }
    choose(edited);
    return changed;
}

std::optional<Bounds> ViewModel::worldBounds() const {
    std::optional<Bounds> all;
    auto parsed = parseView(sized(edited()));
    if (!parsed.ok() || !placeAmong(*parsed, known_).ok()) return all;
    for (const auto& layer : parsed->layers) {
        const auto known = known_.find(layer.dataset);
        if (known == known_.end()) continue;
        const auto box = known->second.bounds.transformed(layer.transform);
        all = all ? all->united(box) : box;
    }
    return all;
}

std::optional<Bounds> ViewModel::layerBounds() const {
    const auto known = known_.find(dataset());
    if (kind() == proto::Layer::kImage) return std::nullopt;  // it lies on the screen
    return known != known_.end() ? std::optional(known->second.bounds) : std::nullopt;
}

proto::Clip ViewModel::clip() const {
    proto::Clip clip = saidClip(layer());
    const auto& own = layer().hybrid();
    clip.mutable_planes()->MergeFrom(own.clip_planes());
    if (own.has_clip_box()) *clip.mutable_box() = own.clip_box();
    return clip;
}

Status ViewModel::setClip(const proto::Clip& clip) {
    if (const auto valid = parseClip(clip); !valid.ok()) return valid.error();
    settle();
    replaceClip(clip);
    keepFitted();
    return success();
}

void ViewModel::replaceClip(const proto::Clip& clip) {
    auto& layer = mutableLayer();
    *layer.mutable_clip() = clip;
    if (clip.planes().empty() && !clip.has_box()) layer.clear_clip();
    layer.clear_clip_planes();
    layer.clear_clip_box();
    if (!layer.has_hybrid()) return;
    layer.mutable_hybrid()->clear_clip_planes();
    layer.mutable_hybrid()->clear_clip_box();
}

glm::dmat4 ViewModel::transform() const {
    const auto transform = parseTransform(layer().transform());
    return transform.ok() ? *transform : glm::dmat4(1.0);
}

glm::dmat4 ViewModel::layerToWorld() const {
    if (!inMetres()) return transform();
    auto parsed = parseView(sized(message_));
    if (!parsed.ok() || !placeAmong(*parsed, known_).ok()) return transform();
    return parsed->layers[static_cast<std::size_t>(chosen_)].transform;
}

Status ViewModel::setInMetres(bool metres) {
    if (metres == inMetres()) return success();
    auto changed = message_;
    changed.set_space(metres ? "metres" : "");
    changed.clear_stretch();
    auto parsed = parseView(sized(changed));
    MOTE_RETURN_IF_ERROR(parsed);
    MOTE_RETURN_IF_ERROR(placeAmong(*parsed, known_));
    settle();
    message_.set_space(changed.space());
    message_.clear_stretch();
    fit();
    return success();
}

glm::dvec3 ViewModel::stretch() const {
    return inMetres() && message_.stretch_size() == 3 ? readVector(message_.stretch()) : glm::dvec3(1.0);
}

Status ViewModel::setTransform(const glm::dmat4& transform) {
    proto::Layer placed;
    writeTransform(transform, placed.mutable_transform());
    if (const auto valid = parseTransform(placed.transform()); !valid.ok()) return valid.error();
    settle();
    mutableLayer().mutable_transform()->Swap(placed.mutable_transform());
    keepFitted();
    return success();
}

void ViewModel::keepFitted() {
    if (!cameraSet_ && served_) setCamera(*served_);
}

void ViewModel::annotateAsUsual() {
    numbers.annotations = annotatedAsUsual(std::move(numbers.annotations));
}

void ViewModel::setCamera(const Camera& camera) {
    camera_ = camera;
    cameraSet_ = true;
}

}  // namespace mote::client
