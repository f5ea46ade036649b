// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/views/dissolve_check.h"

#include <stdexcept>
#include <vector>

#include "protocol/scene/view.h"
#include "tests/support/random.h"
#include "tests/views/difference_check.h"

namespace mote::test {

proto::View dissolved(const proto::View& view) {
    Random random(view.ByteSizeLong(), 7);
    proto::View result = view;
    result.clear_layers();
    int room = View::maxLayers - view.layers_size();
    for (const auto& layer : view.layers()) {
        auto& first = *result.add_layers() = layer;
        // Paths are ink, which two layers show twice, and so are surfaces.
        const bool matter = (layer.has_particles() && !layer.has_paths()) ||
                            (layer.has_hybrid() && layer.hybrid().shows().empty());
        if (room == 0 || !matter) continue;
        --room;
        const double opacity = layer.has_opacity() ? layer.opacity() : 1.0;
        const double share = random.chance(0.1) ? 0.999 : random.unit();
        first.set_opacity(share * opacity);
        *result.add_layers() = layer;
        result.mutable_layers(result.layers_size() - 1)->set_opacity((1.0 - share) * opacity);
    }
    return result;
}

Verdict DissolveCheck::examine(const proto::View& view) {
    const auto drawn = [this](const proto::View& one) {
        const auto scene = data_.scene(one);
        if (!scene.ok()) throw std::invalid_argument(scene.error().toString());
        return imageOf(drawer_->draw(*scene, render::Quality::exact()));
    };
    Judgement whole{drawn(view), {}, 0.0};
    whole.doubtful.assign(whole.expected.pixels.size() / 4, 0);
    Verdict verdict;
    measure(drawn(dissolved(view)), whole, verdict);
    return verdict;
}

}  // namespace mote::test
