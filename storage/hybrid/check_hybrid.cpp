// SPDX-License-Identifier: GPL-3.0-or-later
#include "storage/hybrid/check_hybrid.h"

#include <fmt/format.h>

#include <cmath>
#include <glm/matrix.hpp>
#include <numeric>

#include "storage/manifest.h"

namespace mote::storage {
namespace {

bool isSize(const google::protobuf::RepeatedField<std::uint32_t>& size, std::uint64_t mostSamples) {
    if (size.size() != 3) return false;
    for (const auto side : size) {
        if (side < 1 || side > maxGridSide) return false;
    }
    return samplesOf(gridSize(size)) <= mostSamples;
}

Status checkSizes(const proto::HybridManifest& hybrid) {
    const auto message = [](std::uint64_t most) {
        return fmt::format("must be three numbers from 1 to {}, of {} samples at most", maxGridSide, most);
    };
    if (!isSize(hybrid.source_size(), maxGridSamples)) return corrupt("sourceSize", message(maxGridSamples));
    if (!isSize(hybrid.error_size(), maxGridSamples)) return corrupt("errorSize", message(maxGridSamples));
    if (!isSize(hybrid.low_size(), maxLowSamples)) return corrupt("lowSize", message(maxLowSamples));
    return success();
}

Status checkPlacing(const proto::HybridManifest& hybrid) {
    if (hybrid.index_to_world_size() != 16) return corrupt("indexToWorld", "must be 16 numbers");
    const auto matrix = indexToWorld(hybrid);
    const double determinant = glm::determinant(glm::dmat3(matrix));
    bool finite = true;
    for (const auto number : hybrid.index_to_world()) finite = finite && std::isfinite(number);
    const bool affine =
        matrix[0][3] == 0.0 && matrix[1][3] == 0.0 && matrix[2][3] == 0.0 && matrix[3][3] == 1.0;
    if (finite && affine && std::isfinite(determinant) && determinant != 0.0) return success();
    return corrupt("indexToWorld", "must be an affine map that can be inverted");
}

Status checkValues(const proto::HybridManifest& hybrid) {
    if (!std::isfinite(hybrid.value_max() - hybrid.value_min()) || hybrid.value_min() > hybrid.value_max()) {
        return corrupt("valueMin", "the range of values must be finite, the least not above the greatest");
    }
    if (hybrid.value_bits() != 8 && hybrid.value_bits() != 16) return corrupt("valueBits", "must be 8 or 16");
    const auto bytes = hybrid.point_bytes();
    if (bytes != 0 && bytes != 5 && bytes != 6 && bytes != 9) {
        return corrupt("pointBytes", "must be 5, 6 or 9, or 0 where there are no points");
    }
    for (const auto side : hybrid.error_size()) {
        if (bytes == 6 && side > 256) return corrupt("pointBytes", "are too few for this error grid");
    }
    return success();
}

Status checkFilesOf(const FileNames& files, const proto::HybridStepEntry& step, bool residual) {
    const auto stem = [](const std::string& name, std::string_view suffix) {
        return name.ends_with(suffix) ? name.substr(0, name.size() - suffix.size()) : std::string();
    };
    auto name = stem(step.file(), ".h5");
    if (name.empty()) name = stem(step.file(), ".h5.zst");
    if (!files.contains(step.file()) || name.empty()) {
        return corrupt("file", "is not among the dataset's files");
    }
    if (!files.contains(step.digest()) || stem(step.digest(), ".digest") != name) {
        return corrupt("digest", "is not the digest of the step's file");
    }
    if (residual ? !files.contains(step.residual_file()) : !step.residual_file().empty()) {
        return corrupt("residualFile", "is not among the dataset's files");
    }
    return success();
}

Status checkStep(const proto::HybridManifest& hybrid, const proto::HybridStepEntry& step) {
    const auto known = [](double number) { return std::isfinite(number) && number >= 0.0; };
    if (!std::isfinite(step.time())) return corrupt("time", "must be finite");
    if (!std::isfinite(step.value_min())) return corrupt("valueMin", "must be finite");
    if (!known(step.value_step())) return corrupt("valueStep", "must be finite and not negative");
    if (!known(step.threshold())) return corrupt("threshold", "must be finite and not negative");
    if (!known(step.error_step())) return corrupt("errorStep", "must be finite and not negative");
    if (hybrid.residual() && !(known(step.residual_step()) && step.residual_step() > 0.0)) {
        return corrupt("residualStep", "must be finite and positive");
    }
    const auto samples = samplesOf(gridSize(hybrid.error_size()));
    const auto bricks = samplesOf(bricksOf(gridSize(hybrid.error_size()), residualBrickSide));
    if (step.points() > samples || (step.points() > 0 && hybrid.point_bytes() == 0)) {
        return corrupt("points", "are more than the error grid has samples, or there are to be none");
    }
    if (step.residual_samples() > samples || step.residual_bricks() > bricks) {
        return corrupt("residualSamples", "are more than the error grid has");
    }
    const auto& bins = step.histogram();
    if (bins.size() != valueHistogramBins) {
        return corrupt("histogram", fmt::format("must have {} bins", valueHistogramBins));
    }
    if (std::accumulate(bins.begin(), bins.end(), std::uint64_t{0}) !=
        samplesOf(gridSize(hybrid.source_size()))) {
        return corrupt("histogram", "does not add up to the source's samples");
    }
    return success();
}

}  // namespace

GridSize gridSize(const google::protobuf::RepeatedField<std::uint32_t>& size) {
    return {size.at(0), size.at(1), size.at(2)};
}

glm::dmat4 indexToWorld(const proto::HybridManifest& hybrid) {
    glm::dmat4 matrix;
    for (int i = 0; i < 16; ++i) matrix[i % 4][i / 4] = hybrid.index_to_world(i);  // glm keeps columns
    return matrix;
}

const proto::HybridStepEntry* findHybridStep(const proto::Manifest& manifest, std::uint32_t step) {
    const auto& steps = manifest.hybrid().steps();
    return step < static_cast<std::uint32_t>(steps.size()) ? &steps.at(static_cast<int>(step)) : nullptr;
}

Status checkHybrid(const proto::HybridManifest& hybrid, const FileNames& files) {
    MOTE_RETURN_IF_ERROR(checkSizes(hybrid));
    MOTE_RETURN_IF_ERROR(checkPlacing(hybrid));
    MOTE_RETURN_IF_ERROR(checkValues(hybrid));
    if (hybrid.steps_size() < 1 || hybrid.steps_size() > maxSteps) {
        return corrupt("steps", fmt::format("a dataset has 1 to {} steps", maxSteps));
    }
    for (int i = 0; i < hybrid.steps_size(); ++i) {
        const auto& step = hybrid.steps(i);
        const auto place = fmt::format("steps[{}]", i);
        MOTE_RETURN_IF_ERROR(checkFilesOf(files, step, hybrid.residual()), place);
        MOTE_RETURN_IF_ERROR(checkStep(hybrid, step), place);
    }
    return success();
}

}  // namespace mote::storage
