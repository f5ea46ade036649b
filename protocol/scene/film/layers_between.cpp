// SPDX-License-Identifier: GPL-3.0-or-later
#include "protocol/scene/film/layers_between.h"

#include <algorithm>
#include <utility>

#include "protocol/scene/film/mix_transform.h"
#include "protocol/scene/layer_parts.h"
#include "protocol/scene/mix.h"

namespace mote {
namespace {

/// Gives fields what lies between.
class Mixer : public FieldVisitor {
  public:
    explicit Mixer(double share) : share_(share) {}
    void between(const std::function<void(double)>& set) override { set(share_); }
    using FieldVisitor::pixels;
    void pixels(ScreenLength& value, const ScreenLength& other, const LengthField&) override {
        value = mix(value.value(), other.value(), share_);
    }
    void word(bool) override {}

  private:
    double share_;
};

/// Looks for fields that have nothing in between.
class Difference : public FieldVisitor {
  public:
    void between(const std::function<void(double)>&) override {}
    using FieldVisitor::pixels;
    void pixels(ScreenLength&, const ScreenLength&, const LengthField&) override {}
    void word(bool same) override { found_ = found_ || !same; }
    bool found() const { return found_; }

  private:
    bool found_ = false;
};

bool mustDissolve(const Layer& from, const Layer& to) {
    if (!canMixTransforms(from.transform, to.transform)) return true;
    Difference difference;
    Layer seen = from;
    visitLayer(seen, to, difference);
    return difference.found();
}

/// A layer on its way to another, but for its step and its opacity; what has nothing in between stays as it
/// is.
Layer mixed(const Layer& from, const Layer& to, double share) {
    Layer layer = from;
    Mixer mixer(share);
    visitLayer(layer, to, mixer);
    if (canMixTransforms(from.transform, to.transform))
        layer.transform = mixTransforms(from.transform, to.transform, share);
    return layer;
}

/// Which of its dataset and kind a layer is.
std::size_t placeAmongLike(const std::vector<Layer>& layers, std::size_t index) {
    return static_cast<std::size_t>(std::count_if(
        layers.begin(), layers.begin() + static_cast<std::ptrdiff_t>(index), [&](const auto& other) {
            return other.dataset == layers[index].dataset &&
                   other.style.index() == layers[index].style.index();
        }));
}

/// The layer among others that it is the same as; their number where there is none.
std::size_t findSame(const std::vector<Layer>& layers, std::size_t index, const std::vector<Layer>& others) {
    const auto place = placeAmongLike(layers, index);
    for (std::size_t i = 0; i < others.size(); ++i) {
        if (others[i].dataset == layers[index].dataset &&
            others[i].style.index() == layers[index].style.index() && placeAmongLike(others, i) == place)
            return i;
    }
    return others.size();
}

/// A layer where its steps are: in one, or on its way from one to the next.
void showIn(const std::vector<ShownStep>& steps, Layer& layer) {
    layer.step = steps.front().step;
    if (steps.size() > 1) layer.towards = Towards{steps.back().step, steps.back().weight};
}

}  // namespace

bool blendsSteps(const Layer& layer) {
    return layer.particles() != nullptr || layer.hybrid() != nullptr;
}

LayersBetween::LayersBetween(const std::vector<Layer>& from, const std::vector<Layer>& to,
                             BetweenSteps betweenSteps)
    : betweenSteps_(betweenSteps) {
    match(from, to);
}

/// In the order of the first view; what comes stands behind what it stands behind in the second.
void LayersBetween::match(const std::vector<Layer>& from, const std::vector<Layer>& to) {
    for (std::size_t i = 0; i < from.size(); ++i) {
        const auto same = findSame(from, i, to);
        const Layer* const other = same < to.size() ? &to[same] : nullptr;
        pairs_.push_back({&from[i], other, other != nullptr && mustDissolve(from[i], *other)});
    }
    const Layer* before = nullptr;
    for (const auto& layer : to) {
        const auto holds = [&](const Layer* one) {
            return std::find_if(pairs_.begin(), pairs_.end(),
                                [&](const auto& pair) { return pair.to == one; });
        };
        if (holds(&layer) == pairs_.end()) {
            const auto behind = before == nullptr ? pairs_.begin() : holds(before) + 1;
            pairs_.insert(behind, Pair{nullptr, &layer, false});
        }
        before = &layer;
    }
}

BetweenSteps LayersBetween::stepsOf(const Pair& pair) const {
    return blendsSteps(*pair.from) ? betweenSteps_ : BetweenSteps::hold;
}

std::size_t LayersBetween::mostLayers() const {
    std::size_t count = 0;
    for (const auto& pair : pairs_) count += pair.dissolves ? 2 : 1;
    return count;
}

std::vector<Layer> LayersBetween::at(double share) const {
    std::vector<Layer> layers;
    for (const auto& [from, to, dissolves] : pairs_) {
        if (from == nullptr || to == nullptr) {
            layers.push_back(from != nullptr ? *from : *to);
            layers.back().opacity *= from != nullptr ? 1.0 - share : share;
            continue;
        }
        // What says itself how far it is between steps is nowhere else.
        const bool says = from->towards || to->towards;
        const auto steps = stepsBetween(from->step, to->step, share, stepsOf({from, to, dissolves}));
        Layer& first = layers.emplace_back(mixed(*from, *to, share));
        first.opacity = dissolves ? from->opacity * (1.0 - share) : mix(from->opacity, to->opacity, share);
        if (!says) showIn(steps, first);
        if (!dissolves) continue;
        Layer& second = layers.emplace_back(mixed(*to, *from, 1.0 - share));
        second.opacity = to->opacity * share;
        if (!says) showIn(steps, second);
    }
    return layers;
}

std::optional<proto::Annotations> mixAnnotations(std::optional<proto::Annotations> from,
                                                 const std::optional<proto::Annotations>& to, double share) {
    Mixer mixer(share);
    if (from && to) visitFields(*from, *to, mixer);
    return from;
}

}  // namespace mote
