// SPDX-License-Identifier: GPL-3.0-or-later
//
// A step's particles in one block, for tests that look at them one by one.
#pragma once

#include <gtest/gtest.h>

#include "preprocess/particles/step_reader.h"

namespace mote::test {

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
