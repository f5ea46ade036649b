// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/particles/density_volume.h"

#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "preprocess/particles/morton.h"

namespace mote::prep {

std::vector<float> densityVolume(std::span<const std::uint64_t> keys, std::span<const double> weights,
                                 unsigned keyLevel, unsigned level) {
    constexpr std::size_t blockSize = std::size_t{1} << 16;
    const unsigned shift = 3 * (keyLevel - level);
    const std::size_t size = std::size_t{1} << level;
    std::vector<float> volume(size * size * size);
    // A block takes the cells that begin in it, to their ends: no cell is shared, and none is summed in
    // pieces.
    const auto sumBlock = [&](std::size_t block) {
        std::size_t i = block * blockSize;
        const std::size_t end = std::min(keys.size(), i + blockSize);
        while (i > 0 && i < end && keys[i] >> shift == keys[i - 1] >> shift) ++i;
        while (i < end) {
            const std::uint64_t cell = keys[i] >> shift;
            double sum = 0.0;
            for (; i < keys.size() && keys[i] >> shift == cell; ++i) sum += weights[i];
            const auto at = mortonCell(cell);
            volume[(at[2] * size + at[1]) * size + at[0]] =
                static_cast<float>(std::ldexp(sum, static_cast<int>(3 * level)));
        }
    };
    tbb::parallel_for(std::size_t{0}, (keys.size() + blockSize - 1) / blockSize, sumBlock);
    return volume;
}

}  // namespace mote::prep
