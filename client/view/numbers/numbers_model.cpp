// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/view/numbers/numbers_model.h"

#include <algorithm>
#include <utility>

#include "client/view/numbers/quantities.h"
#include "client/view/slider_values.h"
#include "protocol/scene/fields/facts.h"
#include "protocol/scene/layer_parts.h"

namespace mote::client {
namespace {

const proto::NamedSelection* findNamed(const NamedSelectionMessages& named, const std::string& name) {
    const auto found = std::ranges::find_if(named, [&](const auto& each) { return each.name() == name; });
    return found != named.end() ? &*found : nullptr;
}

bool isNamed(const NamedSelectionMessages& named, const std::string& name) {
    return findNamed(named, name) != nullptr;
}

ColorByControls controlsOf(const proto::Layer& layer) {
    ColorByControls controls;
    if (!layer.has_color_by()) return controls;
    const auto parsed = parseColorBy(layer.color_by()).value();
    controls.column = parsed.column();
    if (const auto range = colorRangeOf(parsed)) {
        controls.ownRange = true;
        controls.low = range->low;
        controls.high = range->high;
    }
    controls.colorMap = parsed.color_map();
    controls.ofPixel = parsed.of_pixel();
    return controls;
}

void writeColorBy(const ColorByControls& controls, proto::Layer& layer) {
    layer.clear_color_by();
    if (controls.column.empty()) return;
    auto& colorBy = *layer.mutable_color_by();
    colorBy.set_column(controls.column);
    if (controls.ownRange && controls.low < controls.high) {
        colorBy.add_range(controls.low);
        colorBy.add_range(controls.high);
    }
    colorBy.set_color_map(controls.colorMap);
    if (!controls.ofPixel.empty()) colorBy.set_of_pixel(controls.ofPixel);
}

}  // namespace

NumbersModel::NumbersModel() {
    proto::View view;
    view.add_layers();
    read(view);
}

void NumbersModel::read(const proto::View& view, int index) {
    layer_ = index;
    const std::string before = chosen_ ? selections_[static_cast<int>(*chosen_)].name() : std::string();
    const auto& layer = index < view.layers_size() ? view.layers(index) : proto::Layer::default_instance();
    selections_ = view.selections();
    given_.clear();
    annotations = view.annotations();
    highlighted_ = layer.has_highlight() ? keepNamed(layer.highlight().selection(), "highlight") : "";
    alone_ = layer.has_select() ? keepNamed(layer.select(), "shown") : "";
    shownByUser_ = false;
    proto::Highlight style = layer.highlight();
    style.mutable_selection();  // of a layer without a highlight: every default
    const auto look = parseHighlight(style, selections_).value();
    highlightColor = shownColor(style.color(), look.color);
    highlightSize = static_cast<float>(look.pointSize.value_or(0.0));
    highlightOpacity = static_cast<float>(look.opacity);
    colorBy = controlsOf(layer);
    const auto paths = parsePaths(layer.paths()).value();
    pathIds_.assign(paths.ids().begin(), paths.ids().end());
    pathWidth = static_cast<float>(lengthOf(paths, paths.kWidthFieldNumber));
    pathColor_.reset();
    if (const auto color = colorOf(paths, paths.kColorFieldNumber))
        pathColor_ = shownColor(paths.color(), *color);
    chosen_.reset();
    for (int i = 0; i < selections_.size(); ++i) {
        const auto& name = selections_[i].name();
        const bool shown = name == highlighted_ || (highlighted_.empty() && name == alone_);
        if (name == before || (shown && !isNamed(selections_, before))) choose(static_cast<std::size_t>(i));
    }
    if (!chosen_ && !selections_.empty()) chosen_ = 0;
}

/// A selection that a layer holds itself gets a name, so that the panel can edit it; that name is the panel's
/// own until something else goes by it.
std::string NumbersModel::keepNamed(const proto::Selection& selection, const std::string& wish) {
    proto::Selection rest = selection;
    rest.clear_named();
    if (!selection.named().empty() && rest.ByteSizeLong() == 0) return selection.named();
    auto& named = *selections_.Add();
    named.set_name(freshName(selections_, wish));
    *named.mutable_selection() = selection;
    given_.insert(named.name());
    return named.name();
}

bool NumbersModel::isUnnamed(const std::string& name) const {
    if (given_.count(name) == 0 || (highlighted_ == name) == (alone_ == name)) return false;
    return std::ranges::none_of(selections_, [&](const auto& each) {
        return each.name() != name && namesIn(each.selection(), selections_).count(name) > 0;
    });
}

proto::Selection NumbersModel::selectionOf(const std::string& name) const {
    if (!isUnnamed(name)) return reference(name);
    const auto found =
        std::ranges::find_if(selections_, [&](const auto& each) { return each.name() == name; });
    return found != selections_.end() ? found->selection() : reference(name);
}

void NumbersModel::write(proto::View& view) const {
    view.clear_selections();
    for (const auto& each : selections_) {
        if (!isUnnamed(each.name())) *view.add_selections() = each;
    }
    if (annotations.ByteSizeLong() > 0) {
        *view.mutable_annotations() = annotations;
    } else {
        view.clear_annotations();
    }
    for (int i = 0; i < view.layers_size(); ++i) {
        auto& layer = *view.mutable_layers(i);
        if (i == layer_) {
            writeLayer(layer);
        } else if (layer.has_particles() && shownByUser_ &&
                   layer.dataset() == view.layers(layer_).dataset()) {
            writeShown(layer);
        }
    }
}

void NumbersModel::writeLayer(proto::Layer& layer) const {
    layer.clear_select();
    layer.clear_highlight();
    layer.clear_color_by();
    layer.clear_paths();
    if (!layer.has_particles()) return;
    writeShown(layer);
    writeColorBy(colorBy, layer);
    if (pathIds_.empty()) return;
    auto& paths = *layer.mutable_paths();
    paths.mutable_ids()->Add(pathIds_.begin(), pathIds_.end());
    if (pathColor_) assignColor(paths.mutable_color(), *pathColor_);
    paths.set_width(decimal(pathWidth));
}

void NumbersModel::writeShown(proto::Layer& layer) const {
    layer.clear_select();
    layer.clear_highlight();
    if (!alone_.empty()) *layer.mutable_select() = selectionOf(alone_);
    if (highlighted_.empty()) return;
    auto& highlight = *layer.mutable_highlight();
    *highlight.mutable_selection() = selectionOf(highlighted_);
    assignColor(highlight.mutable_color(), highlightColor);
    if (highlightSize > 0.0F) highlight.set_size_pixels(decimal(std::clamp(highlightSize, 0.1F, 64.0F)));
    highlight.set_opacity(share(highlightOpacity));
}

void NumbersModel::setDataset(const proto::ParticlesManifest& manifest) {
    const auto quantities = quantitiesOf(manifest);
    const auto has = [&](const std::string& name) { return findQuantity(quantities, name) != nullptr; };
    const auto drawable = [&](const std::string& name) {
        const auto columns = columnsIn(reference(name), selections_);
        return std::ranges::all_of(columns, has);
    };
    if (!colorBy.column.empty() && !has(colorBy.column)) colorBy.column.clear();
    if (!highlighted_.empty() && !drawable(highlighted_)) highlighted_.clear();
    if (!alone_.empty() && !drawable(alone_)) alone_.clear();
    if (!manifest.ids()) pathIds_.clear();
}

const proto::NamedSelection* NumbersModel::chosenSelection() const {
    return chosen_ ? &selections_[static_cast<int>(*chosen_)] : nullptr;
}

void NumbersModel::choose(std::size_t index) {
    if (index < static_cast<std::size_t>(selections_.size())) chosen_ = index;
}

std::optional<proto::Selection> NumbersModel::chosenWhole() const {
    if (!chosen_) return std::nullopt;
    const auto parsed = parseSelection(chosenSelection()->selection(), selections_);
    if (!parsed.ok()) return std::nullopt;
    return toProto(*parsed);
}

Status NumbersModel::accept(NamedSelectionMessages edited) {
    MOTE_RETURN_IF_ERROR(parseNamedSelections(edited));
    selections_ = std::move(edited);
    return success();
}

Status NumbersModel::take(const proto::Selection& gesture, Combine how, const std::string& wish) {
    if (how != Combine::fresh && chosen_)
        return replace(*chosen_, combined(chosenSelection()->selection(), how, gesture));
    auto edited = selections_;
    auto& named = *edited.Add();
    named.set_name(freshName(selections_, wish));
    *named.mutable_selection() = gesture;
    MOTE_RETURN_IF_ERROR(accept(std::move(edited)));
    choose(static_cast<std::size_t>(selections_.size()) - 1);
    highlight(chosenSelection()->name());
    return success();
}

Status NumbersModel::replace(std::size_t index, const proto::Selection& selection) {
    auto edited = selections_;
    *edited[static_cast<int>(index)].mutable_selection() = selection;
    return accept(std::move(edited));
}

Status NumbersModel::rename(std::size_t index, const std::string& name) {
    auto edited = selections_;
    const std::string before = edited[static_cast<int>(index)].name();
    edited[static_cast<int>(index)].set_name(name);
    for (auto& each : edited) renameIn(*each.mutable_selection(), before, name);
    MOTE_RETURN_IF_ERROR(accept(std::move(edited)));
    if (highlighted_ == before) highlighted_ = name;
    if (alone_ == before) alone_ = name;
    given_.erase(before);  // now it has one of its own
    return success();
}

Status NumbersModel::remove(std::size_t index) {
    const std::string name = selections_[static_cast<int>(index)].name();
    auto edited = selections_;
    edited.DeleteSubrange(static_cast<int>(index), 1);
    MOTE_RETURN_IF_ERROR(accept(std::move(edited)));
    if (highlighted_ == name) highlight("");
    if (alone_ == name) showAlone("");
    given_.erase(name);
    chosen_.reset();
    if (!selections_.empty()) choose(std::min(index, static_cast<std::size_t>(selections_.size()) - 1));
    return success();
}

void NumbersModel::highlight(const std::string& name) {
    highlighted_ = name;
    shownByUser_ = true;
}

namespace {

bool sameSelection(const proto::NamedSelection* one, const proto::NamedSelection& other) {
    return one != nullptr && one->selection().SerializeAsString() == other.selection().SerializeAsString();
}

/// What a selection is called now that had this name: a list of as many, with one other name, renamed it.
std::string nameNow(const std::string& name, const NamedSelectionMessages& before,
                    const NamedSelectionMessages& now) {
    if (isNamed(now, name) || before.size() != now.size()) return name;
    for (int i = 0; i < before.size(); ++i) {
        if (before[i].name() == name && !isNamed(before, now[i].name())) return now[i].name();
    }
    return name;
}

/// `mine` with what went and came between two lists.
NamedSelectionMessages merged(NamedSelectionMessages mine, const NamedSelectionMessages& before,
                              const NamedSelectionMessages& now) {
    for (int i = mine.size(); i-- > 0;) {
        const auto& name = mine[i].name();
        if (isNamed(before, name) && !isNamed(now, name)) mine.DeleteSubrange(i, 1);
    }
    for (const auto& each : now) {
        if (sameSelection(findNamed(before, each.name()), each)) continue;
        const auto place =
            std::ranges::find_if(mine, [&](const auto& known) { return known.name() == each.name(); });
        (place != mine.end() ? *place : *mine.Add()) = each;
    }
    return mine;
}

}  // namespace

bool operator==(const SelectionsShown& one, const SelectionsShown& other) {
    const auto same = [](const auto& a, const auto& b) {
        return a.SerializeAsString() == b.SerializeAsString();
    };
    return one.highlighted == other.highlighted && one.color == other.color && one.size == other.size &&
           one.opacity == other.opacity && std::ranges::equal(one.named, other.named, same);
}

SelectionsShown NumbersModel::shown() const {
    return {selections_, highlighted_, highlightColor, highlightSize, highlightOpacity};
}

bool NumbersModel::follow(const SelectionsShown& before, const SelectionsShown& now) {
    const auto was = shown();
    const auto wasChosen = chosen_ ? chosenSelection()->name() : std::string();
    if (!accept(merged(selections_, before.named, now.named)).ok()) return false;
    alone_ = nameNow(alone_, before.named, now.named);
    if (!isNamed(selections_, alone_)) alone_.clear();
    highlighted_ = nameNow(highlighted_, before.named, now.named);
    if (now.highlighted != before.highlighted) highlighted_ = now.highlighted;
    if (!isNamed(selections_, highlighted_)) highlighted_.clear();
    if (now.color != before.color) highlightColor = now.color;
    if (now.size != before.size) highlightSize = now.size;
    if (now.opacity != before.opacity) highlightOpacity = now.opacity;
    chosen_.reset();
    for (int i = 0; i < selections_.size(); ++i) {
        if (selections_[i].name() == wasChosen || !chosen_) chosen_ = static_cast<std::size_t>(i);
    }
    const bool changed = !(was == shown());
    shownByUser_ |= changed;
    return changed;
}

void NumbersModel::showAlone(const std::string& name) {
    alone_ = name;
    shownByUser_ = true;
}

Status NumbersModel::addPath(std::uint64_t id) {
    if (std::ranges::find(pathIds_, id) != pathIds_.end()) return success();
    if (pathIds_.size() >= mostPathIds)
        return Error{ErrorCode::invalidArgument, "paths.ids", "a layer has no more paths than 1000"};
    pathIds_.push_back(id);
    return success();
}

}  // namespace mote::client
