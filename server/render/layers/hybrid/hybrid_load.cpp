// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/layers/hybrid/hybrid_load.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>

#include "server/render/layers/hybrid/brick_maker.h"
#include "storage/files/packed_file.h"
#include "storage/hash.h"
#include "storage/hybrid/check_hybrid.h"
#include "storage/hybrid/hybrid_file.h"
#include "storage/hybrid/residual_file.h"

namespace mote::render {
namespace {

glm::uvec3 vectorOf(const storage::GridSize& size) {
    return {size[0], size[1], size[2]};
}

/// A volume of one value has no range: one is made up.
ValueRange rangeOf(const proto::HybridManifest& hybrid) {
    const double low = hybrid.value_min(), high = hybrid.value_max();
    return {low, high > low ? high : low + std::max(1.0, 1e-6 * std::abs(low))};
}

/// `codes`: on disk, value_min + code * value_step of the entry.
void fillLow(const storage::HybridStep& file, const proto::HybridStepEntry& entry, GridField& step) {
    constexpr std::size_t more = 4;  // that can be read
    step.coarse.size = vectorOf(file.lowSize());
    const auto fill = [&](const auto& codes) {
        step.coarse.values.reserve(codes.size() + more);
        for (const auto code : codes) {
            const double value = step.codeOf(entry.value_min() + code * entry.value_step());
            step.coarse.values.push_back(
                static_cast<std::uint16_t>(std::lround(std::clamp(value, 0.0, 65535.0))));
        }
    };
    std::visit(fill, file.low());
    step.coarse.values.resize(step.coarse.values.size() + more);
    step.coarse.normals.reserve(step.coarse.values.size());
    step.coarse.normals.assign(file.lowNormal().begin(), file.lowNormal().end());
    step.coarse.normals.resize(step.coarse.values.size());
}

Status addPoints(const storage::HybridPoints& points, BrickMaker& maker) {
    Status added = success();
    points.forEach([&](const storage::HybridPoint& point) {
        constexpr std::uint16_t codes = 65535 / 255;  // to one of a point's value
        const auto code = static_cast<std::uint16_t>(point.value * codes);
        if (!added.ok()) return;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            if (point.place[axis] < points.grid[axis]) continue;
            added = Error{ErrorCode::corrupt, "points", "one lies outside of the error grid"};
            return;
        }
        added = maker.addPoint(vectorOf(point.place), code, point.normal);
    });
    return added;
}

Status addResidual(const storage::PathBeneath& directory, const proto::Manifest& manifest,
                   std::uint32_t index, const std::function<bool()>& cancelled, BrickMaker& maker) {
    Status added = success();
    auto read = storage::readResidual(
        directory, manifest, index,
        [&](const storage::ResidualBrick& brick) {
            if (added.ok()) added = maker.add(vectorOf(brick.index), brick.values);
        },
        [&] { return !added.ok() || (cancelled && cancelled()); });
    MOTE_RETURN_IF_ERROR(added);
    return read;
}

std::uint64_t bricksOf(const proto::HybridManifest& hybrid) {
    return storage::samplesOf(
        storage::bricksOf(storage::gridSize(hybrid.error_size()), storage::residualBrickSide));
}

/// An estimate of how many bricks are corrected: what lies at a brick's border corrects the bricks beside it.
std::uint64_t corrected(const proto::HybridManifest& hybrid, std::uint32_t step,
                        HybridRepresentation representation) {
    const auto& entry = hybrid.steps(static_cast<int>(step));
    const auto held =
        representation == HybridRepresentation::points ? entry.points() : entry.residual_bricks();
    return std::min(bricksOf(hybrid), 2 * held);
}

}  // namespace

glm::dmat4 hybridBox(const proto::HybridManifest& hybrid) {
    glm::dmat4 toIndex(1.0);
    for (int axis = 0; axis < 3; ++axis) {
        toIndex[axis][axis] = hybrid.source_size(axis);
        toIndex[3][axis] = -0.5;
    }
    return storage::indexToWorld(hybrid) * toIndex;
}

Bounds hybridBounds(const proto::HybridManifest& hybrid) {
    return Bounds{glm::dvec3(0.0), glm::dvec3(1.0)}.transformed(hybridBox(hybrid));
}

Result<HybridRepresentation> hybridParts(const proto::HybridManifest& hybrid, HybridRepresentation asked) {
    using enum HybridRepresentation;
    const bool hasPoints = hybrid.point_bytes() != 0;
    if (asked == best) return hybrid.residual() ? residual : hasPoints ? points : volume;
    if ((asked == points && !hasPoints) || (asked == residual && !hybrid.residual())) {
        return Error{ErrorCode::unsupported, "hybrid.representation",
                     fmt::format("the dataset holds no {}", asked == points ? "points" : "residual")};
    }
    return asked;
}

std::uint64_t hybridBytes(const proto::HybridManifest& hybrid, std::uint32_t step,
                          HybridRepresentation representation) {
    constexpr std::uint64_t perSample = sizeof(std::uint16_t) + sizeof(std::uint8_t);
    if (step >= static_cast<std::uint32_t>(hybrid.steps_size())) return 0;
    const std::uint64_t bytes = storage::samplesOf(storage::gridSize(hybrid.low_size())) * perSample;
    if (representation == HybridRepresentation::volume) return bytes;
    return bytes + bricksOf(hybrid) * sizeof(std::int32_t) +
           corrected(hybrid, step, representation) * (GridBricks::volume * perSample + sizeof(CodeRange));
}

std::uint64_t hybridLoadingBytes(const proto::HybridManifest& hybrid, std::uint32_t step,
                                 HybridRepresentation representation) {
    if (step >= static_cast<std::uint32_t>(hybrid.steps_size())) return 0;
    const auto& entry = hybrid.steps(static_cast<int>(step));
    const auto packed = [](const std::string& file) { return file.ends_with(storage::packedSuffix); };
    std::uint64_t bytes = packed(entry.file()) ? storage::mostHybridStepBytes(hybrid, entry) : 0;
    if (representation == HybridRepresentation::volume) return bytes;
    // What grows lies in memory twice when it moves.
    constexpr std::uint64_t moved = 2;
    bytes += corrected(hybrid, step, representation) *
             (moved * storage::residualBrickSamples / 8 + GridBricks::volume * sizeof(std::uint16_t));
    if (representation == HybridRepresentation::points) return bytes;
    bytes += packed(entry.residual_file()) ? storage::unpackingBytes : 0;
    return bytes + moved * entry.residual_bricks() * sizeof(storage::GridSize);
}

std::string hybridDigest(const proto::Manifest& manifest) {
    const std::string text = manifest.SerializeAsString();
    return storage::hash128(std::as_bytes(std::span(text)));
}

Result<std::shared_ptr<const GridField>> loadHybrid(const storage::PathBeneath& directory,
                                                    const proto::Manifest& manifest, std::uint32_t index,
                                                    HybridRepresentation representation,
                                                    const std::function<bool()>& cancelled) {
    const auto* const entry = storage::findHybridStep(manifest, index);
    if (entry == nullptr) {
        return Error{ErrorCode::notFound, "step",
                     fmt::format("the dataset has {} steps", manifest.hybrid().steps_size())};
    }
    MOTE_ASSIGN_OR_RETURN(const auto file, storage::HybridStep::open(directory, manifest, index));
    auto step = std::make_shared<GridField>();
    step->origin = {(directory / entry->file()).path(), hybridDigest(manifest)};
    step->boxToLayer = hybridBox(manifest.hybrid());
    step->range = rangeOf(manifest.hybrid());
    // The first step's for all, so that a series that is played does not flicker.
    const auto& histogram = manifest.hybrid().steps(0).histogram();
    step->histogram.assign(histogram.begin(), histogram.end());
    step->unit = manifest.hybrid().value_unit();
    fillLow(file, *entry, *step);
    step->parts = representation;
    BrickMaker maker(*step, vectorOf(storage::gridSize(manifest.hybrid().error_size())));
    if (representation == HybridRepresentation::points) MOTE_RETURN_IF_ERROR(addPoints(file.points(), maker));
    MOTE_RETURN_IF_ERROR(file.check());
    if (representation == HybridRepresentation::residual)
        MOTE_RETURN_IF_ERROR(addResidual(directory, manifest, index, cancelled, maker));
    if (representation != HybridRepresentation::volume)
        step->bricks = std::make_shared<const GridBricks>(maker.make());
    return std::shared_ptr<const GridField>(std::move(step));
}

}  // namespace mote::render
