// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/particles/quantized_block.h"

namespace mote::prep {
namespace {

std::uint32_t fraction(const Range& range, double value) {
    // The division first: multiplying by 2^32 is then exact, so that the cell of any level is the same as the
    // one that floor(2^level (value - min) / (max - min)) gives.
    const double scaled = (value - range.min) / (range.max - range.min) * 0x1p32;
    return scaled >= 0x1p32 ? 0xffffffffU : static_cast<std::uint32_t>(scaled);
}

}  // namespace

void quantize(const ParticleBlock& block, const std::array<Range, 3>& bounds, QuantizedBlock& result) {
    result.particles.resize(block.size());
    result.weight.resize(block.size());
    std::size_t size = 0;
    for (std::size_t i = 0; i < block.size(); ++i) {
        const double x = block.coordinate[0][i];
        const double y = block.coordinate[1][i];
        const double z = block.coordinate[2][i];
        if (!bounds[0].contains(x) || !bounds[1].contains(y) || !bounds[2].contains(z)) continue;
        result.particles[size] = {fraction(bounds[0], x), fraction(bounds[1], y), fraction(bounds[2], z),
                                  block.row[i]};
        result.weight[size] = block.weight[i];
        ++size;
    }
    result.outside = block.size() - size;
    result.particles.resize(size);
    result.weight.resize(size);
}

}  // namespace mote::prep
