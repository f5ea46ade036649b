// SPDX-License-Identifier: GPL-3.0-or-later
#include "protocol/scene/film/sized_script.h"

#include <map>
#include <string>
#include <utility>

#include "protocol/base/mote_check.h"
#include "protocol/scene/film/check_script.h"

namespace mote {

namespace {

template <class Take>
void eachView(proto::Script& script, const Take& take) {
    for (auto& view : *script.mutable_views()) take(view);
    for (auto& keyframe : *script.mutable_keyframes()) take(*keyframe.mutable_view());
    if (script.has_view()) take(*script.mutable_view());
}

bool goesThroughSteps(const proto::Script& script) {
    for (const auto& move : script.moves())
        if (move.has_play_steps()) return true;
    std::map<std::string, std::uint32_t> steps;
    for (const auto& keyframe : script.keyframes()) {
        for (const auto& layer : keyframe.view().layers()) {
            if (steps.try_emplace(layer.dataset(), layer.step()).first->second != layer.step()) return true;
        }
    }
    return false;
}

}  // namespace

proto::Annotations annotatedAsUsual(proto::Annotations annotations) {
    for (const auto name : usualAnnotations) {
        const auto* const field = proto::Annotations::descriptor()->FindFieldByName(std::string(name));
        MOTE_CHECK(field != nullptr);
        annotations.GetReflection()->SetBool(&annotations, field, true);
    }
    return annotations;
}

proto::Script annotatedScript(proto::Script script) {
    eachView(script, [](proto::View& view) {
        if (view.has_annotations()) return;
        auto& annotations = *view.mutable_annotations();
        annotations.set_axes(true);
        annotations.set_color_bar(true);
        annotations.set_scale_bar(true);
        annotations.set_labels(true);
    });
    return script;
}

proto::Script withStillAxes(proto::Script script) {
    if (!goesThroughSteps(script)) return script;
    eachView(script, [](proto::View& view) {
        if (!view.annotations().axes() || !view.annotations().axes_around().empty()) return;
        view.mutable_annotations()->set_axes_around("plot");
    });
    return script;
}

Result<proto::Script> sizedScript(proto::Script script, std::uint32_t width, std::uint32_t height) {
    const auto size = [&](proto::View& view) {
        const double scale = view.has_scale() ? view.scale() : 1.0;
        if (view.height() != height) view.set_scale(scale * height / view.height());
        view.set_width(width);
        view.set_height(height);
    };
    eachView(script, size);
    MOTE_RETURN_IF_ERROR(checkScript(script));
    return script;
}

}  // namespace mote
