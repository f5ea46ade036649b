// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/view/replot.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <functional>
#include <vector>

#include "protocol/quantity/known_quantity.h"

namespace mote::client {
namespace {

/// An expression holds signs that the name of a file should not.
std::string joined(const AxisNames& axes) {
    auto name = fmt::format("{}", fmt::join(axes, "-"));
    const auto isPlain = [](char c) {
        return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '-' || c == '_';
    };
    std::ranges::replace_if(name, std::not_fn(isPlain), '_');
    return name;
}

/// The plot's name without the axes that an earlier replot put behind it.
std::string baseName(const std::string& dataset, const AxisNames& axes) {
    const std::string tail = "-" + joined(axes);
    const bool named = dataset.size() > tail.size() && dataset.ends_with(tail);
    return named ? dataset.substr(0, dataset.size() - tail.size()) : dataset;
}

}  // namespace

std::span<const std::string_view> plotAxes() {
    static const auto names = [] {
        std::vector<std::string_view> all;
        for (const auto& known : knownQuantities()) {
            if (known.name != "weight") all.push_back(known.name);
        }
        return all;
    }();
    return names;
}

std::optional<AxisNames> axesOf(const proto::Description& description) {
    const auto& axes = description.manifest().particles().axes();
    if (axes.size() < 3) return std::nullopt;
    return AxisNames{axes[0].name(), axes[1].name(), axes[2].name()};
}

std::optional<proto::JobRequest> replotRequest(const proto::Description& description, const AxisNames& axes) {
    const auto shown = axesOf(description);
    if (!shown || !description.has_replot() || !description.replot().has_particles()) return std::nullopt;
    proto::JobRequest request = description.replot();
    auto& particles = *request.mutable_particles();
    particles.clear_axes();
    for (const auto& axis : axes) particles.add_axes(axis);
    // Bounds belonged to the other axes; that they are each step's own goes on.
    for (const auto& bounds : particles.bounds()) {
        if (bounds.unit() == "step") particles.set_bounds_of("step");
    }
    particles.clear_bounds();
    request.set_output(fmt::format("{}-{}.mote", baseName(description.dataset(), *shown), joined(axes)));
    return request;
}

}  // namespace mote::client
