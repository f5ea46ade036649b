// SPDX-License-Identifier: GPL-3.0-or-later
#include "protocol/scene/film/sized_script.h"

#include <utility>

#include "protocol/scene/film/check_script.h"

namespace mote {

Result<proto::Script> sizedScript(proto::Script script, std::uint32_t width, std::uint32_t height) {
    const auto size = [&](proto::View& view) {
        const double scale = view.has_scale() ? view.scale() : 1.0;
        if (view.height() != height) view.set_scale(scale * height / view.height());
        view.set_width(width);
        view.set_height(height);
    };
    for (auto& view : *script.mutable_views()) size(view);
    for (auto& keyframe : *script.mutable_keyframes()) size(*keyframe.mutable_view());
    if (script.has_view()) size(*script.mutable_view());
    MOTE_RETURN_IF_ERROR(checkScript(script));
    return script;
}

}  // namespace mote
