// SPDX-License-Identifier: GPL-3.0-or-later
//
// Holds a dataset to its source, particle by particle, with its own plain arithmetic.
#pragma once

#include <gtest/gtest.h>
#include <filesystem>

#include "preprocess/particles/step_reader.h"
#include "preprocess/readers/particle_source.h"
#include "protocol/mote.pb.h"

namespace mote::test {

/// Fails the test unless every particle of every selected step is in exactly one leaf, at its place to within
/// the leaf's cell / 65536, or counted as lost, invalid or outside; unless all densities are what the
/// particles say, and the volume is an independent histogram.
void expectAccounted(const std::filesystem::path& dataset, const proto::ParticlesJob& job,
                     prep::ParticleSource& source);

// A step's particles in one block, for tests that look at them one by one.

inline prep::ParticleBlock loadStep(prep::ParticleSource& source, std::size_t step,
                                    const prep::PlotAxes& axes, const prep::Progress& progress) {
    const auto alone = prep::singleProcess();
    auto reader = prep::StepReader::open(source, step, axes, *alone, progress, 0);
    EXPECT_TRUE(reader.ok());
    std::vector<prep::ParticleBlock> blocks(reader->blockCount());
    EXPECT_TRUE(
        reader->forEach(0, blocks.size(), [&](const auto& block, std::size_t i) { blocks[i] = block; }).ok());
    prep::ParticleBlock all;
    for (const auto& block : blocks) {
        for (std::size_t a = 0; a < 3; ++a) {
            auto& values = all.coordinate[a];
            values.insert(values.end(), block.coordinate[a].begin(), block.coordinate[a].end());
        }
        all.weight.insert(all.weight.end(), block.weight.begin(), block.weight.end());
        all.row.insert(all.row.end(), block.row.begin(), block.row.end());
        all.lost += block.lost;
        all.invalid += block.invalid;
    }
    return all;
}

}  // namespace mote::test
