// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/egl/resident_grids.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <utility>
#include <vector>

#include "protocol/base/most_recent.h"
#include "server/render/device.h"
#include "server/render/egl/frame_block.h"

namespace mote::render {
namespace {

constexpr unsigned longerShift = 21, stepsShift = 24;
constexpr unsigned mostLonger = 3;  // powers of two
// Optical depth of a segment, at most, that is longer than usual: what is taken as even in it is a part of
// that, and differs by less.
constexpr double thin = 0.01;

/// What extinction can reach between two values.
class Extinctions {
  public:
    explicit Extinctions(const TransferTable& table)
        : table_(table), change_(TransferTable::cells + 2, 0.0F) {
        for (std::size_t i = 1; i < change_.size(); ++i)
            change_[i] = change_[i - 1] + std::abs(slope(i) - slope(i - 1));
    }
    /// Not less than any.
    double most(const BlockRanges::Range& range) const {
        const std::size_t first = place(range.low, std::floor), last = place(range.high, std::ceil);
        return double{slope(first)} + change_[last] - change_[first];
    }

  private:
    float slope(std::size_t i) const { return table_.entries()[i].mean(); }
    std::size_t place(double value, double (*rounded)(double)) const {
        const double x = 1.0 + (value - table_.low()) / (table_.high() - table_.low()) * TransferTable::cells;
        return static_cast<std::size_t>(std::clamp(rounded(x), 0.0, TransferTable::cells + 1.0));
    }

    const TransferTable& table_;
    std::vector<float> change_;  // sum of all changes before
};

double longestCell(const GridField& step, const glm::uvec3& grid) {
    double cell = 0.0;
    for (int axis = 0; axis < 3; ++axis)
        cell = std::max(cell, glm::length(glm::dvec3(step.boxToLayer[axis])) / grid[axis]);
    return cell;
}

/// The power of two by which a segment may be longer.
std::uint32_t longerBy(double depth) {
    const double times = thin / std::max(depth, 1e-9);
    return static_cast<std::uint32_t>(std::clamp(std::floor(std::log2(times)), 0.0, double{mostLonger}));
}

/// The words of a field of which nothing is seen.
std::vector<std::uint32_t> unseen(const glm::uvec3& grid) {
    const glm::uvec3 count = (grid + (GridBricks::edge - 1U)) / GridBricks::edge;
    return std::vector<std::uint32_t>(std::size_t{count.x} * count.y * count.z,
                                      std::uint32_t{VisibleBlocks::farthest} << stepsShift);
}

/// A texel as shaders/grid.glsl reads it: five neighbours along x, the last of which is the next one's first.
using Texel = std::array<std::uint32_t, 4>;

constexpr std::size_t piece = std::size_t{1} << 18;  // texels that are packed at once, about

/// Rows of samples along x, which lie side by side.
struct Rows {
    const std::uint16_t* codes;
    const std::uint8_t* normals;
    std::size_t samples, count;  ///< of a row; rows

    std::size_t texels() const { return std::max<std::size_t>((samples + 2) / 4, 1); }  ///< of a row
};

void checkSize(const glm::uvec3& grid, std::size_t texels) {
    const std::uint32_t longest = std::max({grid.x, grid.y, grid.z});
    // volume_mark.comp numbers bricks in ten bits.
    if (longest > 1024 * StepGrid::brickEdge)
        throw DeviceError(fmt::format("the device draws hybrid volumes of {} samples along an edge at most",
                                      1024 * StepGrid::brickEdge));
    GLint held = 0;
    glGetIntegerv(GL_MAX_TEXTURE_BUFFER_SIZE, &held);
    // Some drivers count a texel's place in bytes, in 31 bits.
    const std::size_t most = std::min<std::size_t>(std::max(held, 0), (1U << 31) / sizeof(Texel) - 1);
    if (texels > most)
        throw DeviceError(
            fmt::format("this hybrid volume takes {} MiB of the device's memory in one piece, "
                        "and it gives {}; a greater threshold leaves fewer corrections",
                        texels * sizeof(Texel) >> 20, most * sizeof(Texel) >> 20));
}

/// The texel of the samples from these on; those beyond the row are read with a weight of 0.
Texel packed(const std::uint16_t* code, const std::uint8_t* normal) {
    const auto word = [](std::uint32_t low, std::uint32_t high) { return low | high << 16; };
    const auto normals = [&](int i) { return normal[i] | std::uint32_t{normal[i + 1]} << 8; };
    return {word(code[0], code[1]), word(code[2], code[3]), word(code[4], normals(0)),
            word(normals(2), normal[4])};
}

/// Packs and writes rows from the texel `begin` on. Four samples beyond the last can be read. False if the
/// frame is given up.
bool write(GlBuffer& buffer, std::size_t begin, const Rows& rows, const Pacer& pacer) {
    const std::size_t across = rows.texels(), atOnce = std::max<std::size_t>(piece / across, 1);
    std::vector<Texel> texels;
    for (std::size_t first = 0; first < rows.count; first += atOnce) {
        if (pacer.stopped()) return false;
        texels.clear();
        for (std::size_t row = first; row < std::min(rows.count, first + atOnce); ++row) {
            for (std::size_t i = 0; i < across; ++i) {
                const std::size_t sample = row * rows.samples + 4 * i;
                texels.push_back(packed(rows.codes + sample, rows.normals + sample));
            }
        }
        buffer.write((begin + first * across) * sizeof(Texel), texels.size() * sizeof(Texel), texels.data());
    }
    return true;
}

}  // namespace

std::optional<StepGrid> StepGrid::load(const GridField& step, bool corrected, const GridSlopes* slopes,
                                       const Pacer& pacer) {
    const GridBricks* bricks = corrected ? step.bricks.get() : nullptr;
    StepGrid made(step, bricks);
    if (!made.upload(step, bricks, slopes, pacer)) return std::nullopt;
    return made;
}

StepGrid::StepGrid(const GridField& step, const GridBricks* bricks)
    : grid_(bricks == nullptr ? step.coarse.size : bricks->size) {}

bool StepGrid::upload(const GridField& step, const GridBricks* bricks, const GridSlopes* slopes,
                      const Pacer& pacer) {
    const glm::uvec3& size = step.coarse.size;
    const std::size_t lowSamples = step.coarse.index({0, 0, size.z});
    const Rows low{step.coarse.values.data(), step.coarse.normals.data(), size.x,
                   std::size_t{size.y} * size.z};
    const std::size_t lowTexels = low.texels() * low.count;
    Rows fine{nullptr, nullptr, GridBricks::samples, 0};
    if (bricks != nullptr) {
        fine.codes = bricks->values.data();
        fine.normals = bricks->normals.data();
        fine.count = bricks->corrected() * GridBricks::samples * GridBricks::samples;
    }
    // Where a grid ends, neighbours beyond are read with a weight of 0.
    const std::size_t beyond = low.texels() * (size.y + 1) + 1;
    const std::size_t codes = lowTexels + fine.texels() * fine.count + beyond;
    const std::size_t steep =
        slopes == nullptr ? 0 : (lowSamples + slopes->bricks.size()) / sizeof(Texel) + 2;
    const std::size_t all = codes + steep;
    checkSize(grid_, all);
    samples_ = GlBuffer(all * sizeof(Texel));
    samplesTexture_ = bufferTexture(samples_, GL_RGBA32UI);
    if (slopes != nullptr) {
        firstSlope_ = static_cast<std::uint32_t>(codes);
        samples_.write(codes * sizeof(Texel), slopes->coarse.size(), slopes->coarse.data());
        if (!slopes->bricks.empty())
            samples_.write(codes * sizeof(Texel) + lowSamples, slopes->bricks.size(), slopes->bricks.data());
    }
    return write(samples_, 0, low, pacer) && write(samples_, lowTexels, fine, pacer);
}

ClassifiedBricks::ClassifiedBricks(const CorrectedField& samples, const SeenField& seen)
    : table(tableEntries(*seen.table)) {
    const GridField& step = *samples.grid;
    const GridBricks* const bricks = samples.corrected() ? step.bricks.get() : nullptr;
    const glm::uvec3& grid = bricks == nullptr ? step.coarse.size : bricks->size;
    if (seen.blocks == nullptr) {
        words = unseen(grid);
        return;
    }
    const Extinctions extinctions(*seen.table);
    const double low = longestCell(step, step.coarse.size) / GridBlock::lowSegments;
    const double fine = longestCell(step, grid) / GridBlock::fineSegments;
    const glm::uvec3& count = seen.blocks->count();
    const auto& ranges = seen.ranges->ranges();
    words.reserve(ranges.size());
    for (std::uint32_t i = 0; i < ranges.size(); ++i) {
        const std::uint32_t number =
            bricks == nullptr ? 0U : static_cast<std::uint32_t>(bricks->numbers[i] + 1);
        const std::uint32_t steps = seen.blocks->steps()[i];
        words.push_back(number | steps << stepsShift);
        if (steps < VisibleBlocks::visible) continue;
        words.back() |= longerBy(extinctions.most(ranges[i]) * (number > 0 ? fine : low)) << longerShift;
        visible.push_back(i % count.x | i / count.x % count.y << 10 | i / count.x / count.y << 20);
    }
}

std::optional<GridParts> ResidentGrids::of(const FieldPlan& plan, const CorrectedField& samples,
                                           const Pacer& pacer) {
    const auto slopes = samples.gradient > 0.0 ? seen_.of(plan, samples).slopes : nullptr;
    ResidentGrid* const resident = find(samples, slopes.get(), pacer);
    if (resident == nullptr) return std::nullopt;
    using Classified = ResidentGrid::Classified;
    const auto& classified = mostRecent(
        resident->classified, keptClassified,
        [&](const Classified& one) { return one.transfer == plan.transfer && one.mixed == samples.mixed(); },
        [&] {
            return Classified{plan.transfer, samples.mixed(),
                              ClassifiedBricks(samples, seen_.of(plan, samples))};
        });
    return GridParts{resident, &classified.bricks};
}

ResidentGrid* ResidentGrids::find(const CorrectedField& samples, const GridSlopes* slopes,
                                  const Pacer& pacer) {
    // A new field may stand at the address of one that is gone: the weak pointers tell them apart.
    const auto same = [&](const ResidentGrid& one) {
        return one.key == samples.grid.get() && !one.grid.expired() && one.corrected == samples.corrected() &&
               (slopes == nullptr || one.samples.firstSlope() > 0);
    };
    if (auto* const known = mostRecent(grids_, same)) return known;
    auto loaded = StepGrid::load(*samples.grid, samples.corrected(), slopes, pacer);
    if (!loaded) return nullptr;
    grids_.push_front(ResidentGrid{.grid = samples.grid,
                                   .key = samples.grid.get(),
                                   .corrected = samples.corrected(),
                                   .samples = *std::move(loaded)});
    return &grids_.front();
}

void ResidentGrids::dropExpired() {
    grids_.remove_if([](const ResidentGrid& one) { return one.grid.expired(); });
    seen_.dropExpired();
    std::uint64_t kept = 0;
    // What was drawn last stays whatever it takes.
    for (auto one = grids_.begin(); one != grids_.end();) {
        kept += one->bytes();
        one = one != grids_.begin() && kept > budget_ ? grids_.erase(one) : std::next(one);
    }
}

}  // namespace mote::render
