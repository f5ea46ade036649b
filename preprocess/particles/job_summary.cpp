// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/particles/job_summary.h"

#include <fmt/format.h>

#include <algorithm>
#include <span>

#include "preprocess/particles/range_builder.h"

namespace mote::prep {

Result<std::vector<std::uint64_t>> densityHistogram(const storage::StepFile& file, std::uint64_t leaves,
                                                    const Range& densities, const Progress& progress) {
    constexpr std::uint64_t together = std::uint64_t{1} << 20;
    std::vector<std::uint64_t> bins;
    for (std::uint64_t leaf = 0; leaf < leaves; leaf += together) {
        if (progress.cancelled()) return cancelledError();
        const auto count = static_cast<std::size_t>(std::min(together, leaves - leaf));
        std::vector<float> density(count);
        std::vector<std::uint32_t> points(count);
        MOTE_RETURN_IF_ERROR(file.read(storage::StepArray::leafDensity, leaf * sizeof(float),
                                       std::as_writable_bytes(std::span(density))));
        MOTE_RETURN_IF_ERROR(file.read(storage::StepArray::leafPointCount, leaf * sizeof(std::uint32_t),
                                       std::as_writable_bytes(std::span(points))));
        addToHistogram(density, points, {densities.min, densities.max}, bins);
    }
    return bins;
}

void noteLeftOut(const proto::ParticlesManifest& particles, bool boundsGiven, std::uint64_t others,
                 Progress& progress) {
    std::uint64_t lost = 0;
    std::uint64_t invalid = 0;
    std::uint64_t outside = 0;
    for (const auto& step : particles.steps()) {
        lost += step.lost();
        invalid += step.invalid();
        outside += step.outside();
    }
    const auto note = [&](std::uint64_t count, const char* what) {
        if (count > 0) progress.note(fmt::format("{} particles {}, summed over all steps", count, what));
    };
    note(lost, "that the source marks as lost were left out");
    note(others, "that the source does not mark as lost were left out");
    note(invalid, "with a coordinate or weight that is not a finite number were left out");
    note(outside,
         boundsGiven ? "beyond the given bounds were left out" : "beyond the plot's bounds were left out");
}

}  // namespace mote::prep
