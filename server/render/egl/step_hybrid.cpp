// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/egl/step_hybrid.h"

#include <fmt/format.h>

#include <algorithm>

#include "server/render/cpu/resident_hybrids.h"
#include "server/render/device.h"

namespace mote::render {
namespace {

/// Neighbours along x lie side by side.
struct Samples {
    const std::uint16_t* codes;
    const std::uint8_t* normals;
    std::size_t count;
};

constexpr std::size_t piece = std::size_t{1} << 20;  // samples that are packed at once, even

/// How many the device can hold as texels.
std::size_t mostWords() {
    GLint texels = 0;
    glGetIntegerv(GL_MAX_TEXTURE_BUFFER_SIZE, &texels);
    return static_cast<std::size_t>(std::max(texels, 0));
}

void checkSize(const glm::uvec3& grid, std::size_t words) {
    const std::uint32_t longest = std::max({grid.x, grid.y, grid.z});
    // volume_mark.comp numbers bricks in ten bits.
    if (longest > 1024 * StepHybrid::brickEdge)
        throw DeviceError(fmt::format("the device draws hybrid volumes of {} samples along an edge at most",
                                      1024 * StepHybrid::brickEdge));
    if (words > mostWords())
        throw DeviceError(
            fmt::format("this hybrid volume needs {} words of the device's memory in one piece, and it "
                        "gives {}; a greater threshold leaves fewer corrections",
                        words, mostWords()));
}

/// Packs and writes samples from the even place `begin` of the buffer on. One more can be read. False where
/// the frame is given up.
bool write(GlBuffer& buffer, std::size_t begin, std::size_t normalsBegin, const Samples& samples,
           const Pacer& pacer) {
    constexpr std::size_t word = sizeof(std::uint32_t);
    std::vector<std::uint32_t> codes, normals;
    for (std::size_t first = 0; first < samples.count; first += piece) {
        if (pacer.stopped()) return false;
        const std::size_t count = std::min(piece, samples.count - first);
        codes.resize(count);
        normals.assign((count + 1) / 2, 0);
        for (std::size_t i = 0; i < count; ++i) {
            const std::uint16_t* const code = samples.codes + first + i;
            const std::uint8_t* const normal = samples.normals + first + i;
            codes[i] = code[0] | std::uint32_t{code[1]} << 16;
            normals[i / 2] |= (normal[0] | std::uint32_t{normal[1]} << 8) << 16 * (i % 2);
        }
        buffer.write((begin + first) * word, codes.size() * word, codes.data());
        buffer.write((normalsBegin + (begin + first) / 2) * word, normals.size() * word, normals.data());
    }
    return true;
}

}  // namespace

std::optional<StepHybrid> StepHybrid::load(const HybridStep& step, bool corrected, const Pacer& pacer) {
    const HybridBricks* bricks = corrected ? step.bricks.get() : nullptr;
    StepHybrid made(step, bricks);
    if (!made.upload(step, bricks, pacer)) return std::nullopt;
    return made;
}

StepHybrid::StepHybrid(const HybridStep& step, const HybridBricks* bricks)
    : grid_(bricks == nullptr ? step.low.size : bricks->size),
      ranges_(hybridRanges(step, bricks != nullptr)) {
    if (bricks != nullptr) numbers_ = bricks->numbers;
}

bool StepHybrid::upload(const HybridStep& step, const HybridBricks* bricks, const Pacer& pacer) {
    // Bricks begin at an even place; a sample's neighbours are read with a weight of 0 where the grid ends.
    const auto even = [](std::size_t count) { return (count + 1) / 2 * 2; };
    const std::size_t low = std::size_t{step.low.size.x} * step.low.size.y * step.low.size.z;
    const std::size_t fine = bricks == nullptr ? 0 : bricks->corrected() * HybridBricks::volume;
    const std::size_t beyond = std::size_t{step.low.size.x} * (step.low.size.y + 1) + 2;
    const std::size_t all = even(even(low) + fine + beyond);
    checkSize(grid_, all + all / 2);
    samplesCount_ = static_cast<std::uint32_t>(all);
    samples_ = GlBuffer((all + all / 2) * sizeof(std::uint32_t));
    samplesTexture_ = bufferTexture(samples_, GL_R32UI);
    const Samples lows{step.low.values.data(), step.low.normals.data(), low};
    if (!write(samples_, 0, all, lows, pacer)) return false;
    if (bricks == nullptr) return true;
    return write(samples_, even(low), all, {bricks->values.data(), bricks->normals.data(), fine}, pacer);
}

std::vector<std::uint32_t> StepHybrid::brickWords(const TransferTable& table) const {
    std::vector<std::uint32_t> words(ranges_.ranges().size());
    for (std::size_t i = 0; i < words.size(); ++i) {
        words[i] = numbers_.empty() ? 0U : static_cast<std::uint32_t>(numbers_[i] + 1);
        const auto& range = ranges_.ranges()[i];
        if (table.visible(range.low, range.high)) words[i] |= 0x80000000U;
    }
    return words;
}

}  // namespace mote::render
