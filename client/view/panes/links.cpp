// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/view/panes/links.h"

#include <algorithm>
#include <utility>

#include "client/view/view_model.h"

namespace mote::client {
namespace {

LinkedParts partsOf(const ViewModel& model) {
    LinkedParts parts{model.timedLayer().step(), model.numbers.shown(), {}};
    if (model.hasCamera()) parts.camera = model.camera(1.0);
    return parts;
}

bool takeStep(ViewModel& to, std::uint32_t step) {
    if (to.timedSteps() < 2) return false;
    const auto wanted = std::min(step, static_cast<std::uint32_t>(to.timedSteps()) - 1);
    if (to.timedLayer().step() == wanted) return false;
    to.setTimedStep(wanted);
    return true;
}

bool takeCamera(ViewModel& to, const std::optional<Camera>& camera) {
    if (!camera && !to.hasCamera()) return false;
    camera ? to.setCamera(*camera) : to.fit();
    return true;
}

/// What differs between two moments of the active view.
struct Differs {
    bool step, selections, camera;
};

std::vector<std::size_t> carryOver(const ViewModel& active, const LinkedParts& before, const LinkedParts& now,
                                   const Differs& differs, std::span<ViewModel* const> others) {
    std::vector<std::size_t> changed;
    for (std::size_t i = 0; i < others.size(); ++i) {
        auto& other = *others[i];
        bool any = differs.step && takeStep(other, now.step);
        any |= differs.selections && other.followSelections(active, before.selections, now.selections);
        any |= differs.camera && takeCamera(other, now.camera);
        if (any) changed.push_back(i);
    }
    return changed;
}

}  // namespace

std::vector<std::size_t> LinkedViews::follow(const ViewModel& active, std::span<ViewModel* const> others,
                                             const Links& links) {
    auto now = partsOf(active);
    const auto before = std::exchange(seen_, now);
    const bool same = std::exchange(of_, &active) == &active;
    const bool stays = std::exchange(jumps_, active.jumps()) == active.jumps();
    // Another layer has a step and shown selections of its own.
    const bool sameLayer = std::exchange(chosen_, active.chosen()) == active.chosen();
    const bool asMany = std::exchange(layers_, active.layers().size()) == active.layers().size();
    if (!same || !stays) return {};
    const bool layer = sameLayer && asMany;
    const Differs differs{links.steps && layer && now.step != before.step,
                          links.selections && layer && !(now.selections == before.selections),
                          links.cameras && now.camera != before.camera};
    return carryOver(active, before, now, differs, others);
}

std::vector<std::size_t> shareAll(const ViewModel& active, std::span<ViewModel* const> others,
                                  const Links& links) {
    return carryOver(active, {}, partsOf(active), {links.steps, links.selections, links.cameras}, others);
}

std::optional<std::uint32_t> heldStep(const ViewModel& view, const ViewModel& active) {
    const auto steps = static_cast<std::uint32_t>(std::max(view.timedSteps(), 0));
    const bool held = steps > 1 && view.timedLayer().step() + 1 == steps && active.timedSteps() > 1 &&
                      active.timedLayer().step() >= steps;
    return held ? std::optional(steps - 1) : std::nullopt;
}

}  // namespace mote::client
