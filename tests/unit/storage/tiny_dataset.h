// SPDX-License-Identifier: GPL-3.0-or-later
//
// TinyDataset: a small dataset whose numbers a test chooses, made with the writers and nothing of the job.
// Its point arrays are larger than one block of a digest.
#pragma once

#include <filesystem>
#include <vector>

#include "protocol/mote.pb.h"
#include "storage/particles/step_layout.h"

namespace mote::test {

/// A root with two children, of which the second has the lower density. A test changes what it likes before
/// write().
struct TinyDataset {
    static constexpr std::size_t points = 300000;

    std::vector<std::uint8_t> level{0, 1, 1};
    std::vector<std::uint64_t> morton{0, 1, 6};
    std::vector<std::uint32_t> firstChild{1, 1, 0};
    std::vector<std::uint8_t> childCount{2, 0, 0};
    std::vector<std::uint64_t> count{points, 200000, 100000};
    std::vector<float> density{3e5F, 16e5F, 8e5F};
    std::vector<float> minDensity{8e5F, 16e5F, 8e5F};
    std::vector<std::uint32_t> leafNode{2, 1};
    std::vector<std::uint64_t> leafPointBegin{0, 100000};
    std::vector<std::uint32_t> leafPointCount{100000, 200000};
    std::vector<float> leafDensity{8e5F, 16e5F};
    std::vector<storage::PackedPosition> position;
    std::vector<std::uint64_t> row;
    std::vector<float> volume;
    std::vector<storage::PreviewPoint> preview;  ///< not what a job would choose
    std::vector<float> threshold{0.125F, 0.5F};

    TinyDataset();

    storage::StepContent content() const;
    /// A manifest for one step with this content and the given files.
    proto::Manifest manifest() const;
    /// Makes the dataset; throws where that fails.
    void write(const std::filesystem::path& output) const;
};

}  // namespace mote::test
