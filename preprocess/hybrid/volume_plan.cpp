// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/hybrid/volume_plan.h"

#include <fmt/format.h>

#include <charconv>

#include "preprocess/job.h"
#include "protocol/scene/fields/facts.h"
#include "protocol/scene/fields/resolve.h"

namespace mote::prep {
namespace {

using storage::GridSize;

constexpr std::string_view underPrefix = "under:";

bool isFraction(double number) {
    return number >= 0.0 && number <= 1.0;
}

std::optional<double> allowanceOf(std::string_view filter) {
    if (!filter.starts_with(underPrefix)) return std::nullopt;
    filter.remove_prefix(underPrefix.size());
    double number = 0.0;
    const auto [end, code] = std::from_chars(filter.data(), filter.data() + filter.size(), number);
    if (code != std::errc() || end != filter.data() + filter.size() || !isFraction(number))
        return std::nullopt;
    return number;
}

/// `longest` samples along the longest axis, the others in proportion: at least one, no more than the
/// source's.
GridSize sizeOf(const GridSize& source, std::uint32_t longest) {
    const auto most = *std::max_element(source.begin(), source.end());
    const double scale = std::min(1.0, static_cast<double>(longest) / most);
    GridSize size{};
    for (std::size_t a = 0; a < 3; ++a) {
        size[a] = std::max(1U, static_cast<std::uint32_t>(std::lround(source[a] * scale)));
    }
    return size;
}

Status checkPlan(const VolumePlan& plan) {
    if (storage::samplesOf(plan.source) > storage::maxGridSamples) {
        return Error{
            ErrorCode::resourceExhausted, "inputs",
            fmt::format("have more samples than the {} that a dataset may have", storage::maxGridSamples)};
    }
    if (storage::samplesOf(plan.low) > storage::maxLowSamples) {
        return Error{ErrorCode::resourceExhausted, "low",
                     fmt::format("gives more samples than the {} that a low-resolution volume may have",
                                 storage::maxLowSamples)};
    }
    const auto side = *std::max_element(plan.error.begin(), plan.error.end());
    if (plan.pointBytes == 6 && side > 256) {
        return invalid("pointBytes",
                       fmt::format("points of 6 bytes lie on grids of at most 256 samples a side, "
                                   "where the error grid has {}; take 5 or 9",
                                   side));
    }
    return success();
}

constexpr std::uint64_t megabyte = std::uint64_t{1} << 20;
/// The program, its threads and what a source holds.
constexpr std::uint64_t fixed = 96 * megabyte;

/// An error pass holds the source's slices as floats, its samples on the error grid where that is another,
/// and the errors.
std::uint64_t slabBytes(const VolumePlan& plan, std::uint64_t slices) {
    const double ratio = static_cast<double>(plan.source[2]) / plan.error[2];
    const auto ofSource = static_cast<std::uint64_t>(std::ceil(static_cast<double>(slices + 2) * ratio)) + 1;
    const std::uint64_t sourceSlice = std::uint64_t{plan.source[0]} * plan.source[1];
    const std::uint64_t errorSlice = std::uint64_t{plan.error[0]} * plan.error[1];
    const std::uint64_t grids = plan.error == plan.source ? 1 : 2;
    return 4 * sourceSlice * std::max(ofSource, slices) + 4 * grids * errorSlice * (slices + 2);
}

/// Each thread collects the points of a row of bricks, 6 bytes each, in vectors that grow, and puts them
/// aside in one piece; residuals come in smaller parts.
std::uint64_t threadBytes(const VolumePlan& plan, std::uint64_t slices) {
    const std::uint64_t perSample = 18;
    return perSample * storage::pointBrickSide * plan.error[0] * slices;
}

/// The low-resolution volume as floats, a rank's share of it, its falls where it is lowered; its codes and
/// normals.
std::uint64_t lowBytes(const VolumePlan& plan) {
    const std::uint64_t perSample = (plan.filter == LowFilter::under ? 12 : 8) + plan.valueBits / 8 + 1;
    return perSample * storage::samplesOf(plan.low);
}

}  // namespace

Status checkVolumeJob(const proto::VolumeJob& job) {
    if (job.inputs_size() < 1) return invalid("inputs", "are missing");
    if (job.has_low() && job.low() < 1) return invalid("low", "must be at least 1");
    if (job.has_error_grid() && job.error_grid() < 1) return invalid("errorGrid", "must be at least 1");
    if (job.has_threshold() && job.has_max_points()) {
        return invalid("threshold", "either a threshold or a number of points is taken, not both");
    }
    MOTE_RETURN_IF_ERROR(checkOwnFields(job));
    const auto& filter = job.filter();
    if (!filter.empty() && filter != "cubic" && filter != "box" && !allowanceOf(filter)) {
        return invalid("filter", "must be cubic, box or under:P with P from 0 to 1");
    }
    const auto bytes = job.point_bytes();
    if (job.has_point_bytes() && bytes != 5 && bytes != 6 && bytes != 9) {
        return invalid("pointBytes", "must be 5, 6 or 9");
    }
    if (job.has_value_bits() && job.value_bits() != 8 && job.value_bits() != 16) {
        return invalid("valueBits", "must be 8 or 16");
    }
    return success();
}

Result<VolumePlan> planVolume(const proto::VolumeJob& job, const VolumeShape& shape) {
    using Job = proto::VolumeJob;
    VolumePlan plan;
    plan.source = {shape.nx, shape.ny, shape.nz};
    plan.low = sizeOf(plan.source, static_cast<std::uint32_t>(numberOf(job, Job::kLowFieldNumber)));
    plan.error = job.has_error_grid() ? sizeOf(plan.source, job.error_grid()) : plan.source;
    if (job.filter() == "box") plan.filter = LowFilter::box;
    if (const auto allowance = allowanceOf(job.filter())) {
        plan.filter = LowFilter::under;
        plan.allowance = *allowance;
    }
    plan.threshold = numberOf(job, Job::kThresholdFieldNumber);
    if (job.has_max_points()) plan.maxPoints = job.max_points();
    const auto& kind = job.representation();
    if (kind == "points" || kind == "both") plan.pointBytes = job.has_point_bytes() ? job.point_bytes() : 5;
    plan.residual = kind != "points";
    const bool oneByte = shape.type == ScalarType::u8 || shape.type == ScalarType::i8;
    plan.valueBits = job.has_value_bits() ? job.value_bits() : oneByte ? 8 : 16;
    plan.indexToWorld = shape.indexToWorld;
    MOTE_RETURN_IF_ERROR(checkPlan(plan));
    return plan;
}

glm::dmat4 gridToWorld(const VolumePlan& plan, const GridSize& grid) {
    return storage::gridToWorld(plan.indexToWorld, plan.source, grid);
}

Result<VolumeMemory> planMemory(const VolumePlan& plan, std::uint64_t limit, int threads) {
    const std::uint64_t all = memoryFor(limit);
    const auto needed = [&](std::uint32_t slices) {
        return fixed + lowBytes(plan) + slabBytes(plan, slices) +
               static_cast<std::uint64_t>(threads) * threadBytes(plan, slices);
    };
    // As many slices as help, a divisor of a brick of points.
    VolumeMemory memory{storage::pointBrickSide};
    while (memory.slices > storage::residualBrickSide && needed(memory.slices) > all) memory.slices /= 2;
    if (needed(memory.slices) <= all) return memory;
    return Error{
        ErrorCode::resourceExhausted, "",
        fmt::format("a volume of {} x {} x {} samples needs at least {} MiB of memory where the job may take "
                    "{} MiB",
                    plan.source[0], plan.source[1], plan.source[2], (needed(memory.slices) >> 20) + 1,
                    all >> 20)};
}

}  // namespace mote::prep
