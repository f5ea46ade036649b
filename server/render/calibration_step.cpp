// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/calibration_step.h"

#include <cmath>
#include <numeric>
#include <random>

namespace mote::render {

CalibrationStep::CalibrationStep() {
    addNodes();
    addLeaves();
    positions_.resize(leafNode_.size() * leafPoints);
    std::minstd_rand random;
    const auto place = [&] { return static_cast<std::uint16_t>(random() >> 8); };
    for (auto& position : positions_) position = {place(), place(), place()};
    rows_.resize(positions_.size());
    std::iota(rows_.begin(), rows_.end(), std::uint64_t{0});
    // Log densities that rise from one corner of the box to the opposite one.
    for (std::uint32_t z = 0; z < volumeEdge; ++z) {
        for (std::uint32_t y = 0; y < volumeEdge; ++y) {
            for (std::uint32_t x = 0; x < volumeEdge; ++x) {
                volume_.push_back(std::pow(10.0F, 6.0F * static_cast<float>(x + y + z) / (3 * volumeEdge)));
            }
        }
    }
}

/// All cells of all levels down to that of the leaves, breadth first.
void CalibrationStep::addNodes() {
    const std::uint64_t leaves = std::uint64_t{1} << (3 * level);
    for (std::uint8_t l = 0; l <= level; ++l) {
        const std::uint64_t cells = std::uint64_t{1} << (3 * l);
        const std::size_t next = level_.size() + cells;
        for (std::uint64_t morton = 0; morton < cells; ++morton) {
            level_.push_back(l);
            morton_.push_back(morton);
            childCount_.push_back(l == level ? 0 : 8);
            firstChild_.push_back(static_cast<std::uint32_t>(l == level ? morton : next + 8 * morton));
            count_.push_back(leaves / cells * leafPoints);
            density_.push_back(1.0F);
        }
    }
}

void CalibrationStep::addLeaves() {
    const std::uint32_t leaves = 1U << (3 * level);
    const auto first = static_cast<std::uint32_t>(level_.size()) - leaves;
    for (std::uint32_t i = 0; i < leaves; ++i) {
        leafNode_.push_back(first + i);
        leafBegin_.push_back(std::uint64_t{i} * leafPoints);
        leafCount_.push_back(leafPoints);
        leafDensity_.push_back(1.0F);
    }
}

storage::OctreeNodes CalibrationStep::nodes() const {
    return {level_, morton_, firstChild_, childCount_, count_, density_, density_};
}

storage::Leaves CalibrationStep::leaves() const {
    return {leafNode_, leafBegin_, leafCount_, leafDensity_};
}

std::span<const storage::PackedPosition> CalibrationStep::positions(std::uint64_t begin,
                                                                    std::uint64_t count) const {
    return std::span(positions_).subspan(begin, count);
}

std::span<const std::uint64_t> CalibrationStep::rows(std::uint64_t begin, std::uint64_t count) const {
    return std::span(rows_).subspan(begin, count);
}

}  // namespace mote::render
