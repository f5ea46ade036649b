// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/layers/particles/step_speeds.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "storage/beam/quantity_reader.h"
#include "storage/numbers/scan.h"

namespace mote::render {
namespace {

/// The momentum along the axes of a plot that are places; empty: along none that says anything.
std::array<std::string, 3> momentaOf(const proto::ParticlesManifest& plot) {
    std::array<std::string, 3> names;
    const auto known = [&](const std::string& name) {
        return std::ranges::any_of(plot.columns(), [&](const auto& column) {
            return column.name() == name && column.unit() == "eV/c";
        });
    };
    const bool all = plot.mass() > 0.0 && known("px") && known("py") && known("pz");
    for (int axis = 0; axis < plot.axes_size() && axis < 3; ++axis) {
        const auto& its = plot.axes(axis);
        const bool place = its.name() == "x" || its.name() == "y" || its.name() == "z";
        if (all && place && its.unit() == "m") names[static_cast<std::size_t>(axis)] = "p" + its.name();
    }
    return names;
}

}  // namespace

StepSpeeds::StepSpeeds(const proto::ParticlesManifest& plot, double seconds) : mass_(plot.mass()) {
    constexpr double light = 299792458.0;  // m/s
    const auto names = momentaOf(plot);
    for (std::size_t axis = 0; axis < names.size(); ++axis) {
        if (names[axis].empty() || !std::isfinite(seconds) || seconds == 0.0) continue;
        momentum_[axis] = names[axis][1] - 'x';
        const auto& its = plot.axes(static_cast<int>(axis));
        scale_[axis] = light * seconds / (its.max() - its.min());
    }
}

bool StepSpeeds::any() const {
    return std::ranges::any_of(momentum_, [](int column) { return column >= 0; });
}

std::optional<std::vector<glm::vec3>> StepSpeeds::of(const storage::StepNumbers& step,
                                                     const Cancelled& cancelled) const {
    const std::array<std::string, 3> names{"px", "py", "pz"};
    const auto reader = storage::QuantityReader::make(*step.columns, step.context, names);
    std::vector<glm::vec3> speeds(step.points->pointCount(), glm::vec3(0.0F));
    if (!reader.ok()) return speeds;
    const auto read = [&](std::uint64_t block) {
        const auto part = storage::pointsOfBlock(block, speeds.size());
        std::array<std::vector<double>, 3> momenta;
        std::array<std::span<double>, 3> out;
        for (std::size_t k = 0; k < 3; ++k) {
            momenta[k].resize(part.count);
            out[k] = momenta[k];
        }
        storage::QuantityReader::Scratch scratch;
        reader->read(part.begin, part.count, scratch, out);
        for (std::size_t i = 0; i < part.count; ++i)
            speeds[part.begin + i] = speedOf({momenta[0][i], momenta[1][i], momenta[2][i]});
    };
    const bool whole = storage::forBlocks(storage::blockCount(speeds.size()), cancelled, read);
    return whole ? std::optional(std::move(speeds)) : std::nullopt;
}

/// p / (gamma m), of light's.
glm::vec3 StepSpeeds::speedOf(const glm::dvec3& momentum) const {
    const double energy = std::hypot(mass_, std::hypot(momentum.x, momentum.y, momentum.z));
    glm::vec3 speed(0.0F);
    for (int axis = 0; axis < 3; ++axis) {
        const auto at = static_cast<std::size_t>(axis);
        if (momentum_[at] >= 0)
            speed[axis] = static_cast<float>(scale_[at] * momentum[momentum_[at]] / energy);
    }
    return speed;
}

}  // namespace mote::render
