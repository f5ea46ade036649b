// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/hybrid/error_pass.h"

#include <oneapi/tbb/concurrent_vector.h>
#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <limits>

#include "preprocess/on_threads.h"

namespace mote::prep {
namespace {

/// Ascends with the magnitude: floats without their sign are in the order of their bits.
std::uint32_t keyOf(float error) {
    return std::bit_cast<std::uint32_t>(std::abs(error));
}

using storage::Between;

std::array<std::vector<Between>, 3> placesIn(const storage::GridSize& grid, const storage::GridSize& other) {
    std::array<std::vector<Between>, 3> places;
    for (std::size_t a = 0; a < 3; ++a) {
        for (std::uint32_t i = 0; i < grid[a]; ++i) {
            places[a].push_back(storage::between(storage::placeIn(i, grid[a], other[a]), other[a]));
        }
    }
    return places;
}

void mix(const float* first, const float* second, float fraction, std::span<float> out) {
    for (std::size_t i = 0; i < out.size(); ++i) out[i] = first[i] + fraction * (second[i] - first[i]);
}

/// Slice `at` of a grid between two of its slices, at the places of another grid's samples: calls row(y,
/// values) for each of its rows.
template <class Row>
void interpolate(const float* first, const float* second, float fraction, std::size_t width,
                 std::size_t height, const std::vector<Between>& x, const std::vector<Between>& y,
                 const Row& row) {
    std::vector<float> slice(width * height);
    mix(first, second, fraction, slice);
    std::vector<float> line(width);
    std::vector<float> values(x.size());
    for (std::uint32_t j = 0; j < y.size(); ++j) {
        mix(slice.data() + y[j].first * width, slice.data() + y[j].second * width, y[j].fraction, line);
        for (std::size_t i = 0; i < x.size(); ++i) {
            const float left = line[x[i].first];
            values[i] = left + x[i].fraction * (line[x[i].second] - left);
        }
        row(j, values);
    }
}

using storage::GridSize;

constexpr std::uint32_t brickSide = storage::residualBrickSide;

/// A part of a node that one thread encodes: so wide along x, in bricks.
constexpr std::uint32_t partBricks = 4;

using Multiples = std::array<std::int32_t, storage::residualBrickSamples>;

/// Whether any sample of the brick with this index is corrected.
bool fill(const ErrorSlab& slab, const ErrorSelection& selection, double step, const GridSize& brick,
          Multiples& multiples) {
    GridSize end{};
    for (std::size_t a = 0; a < 3; ++a) end[a] = std::min(slab.grid[a], (brick[a] + 1) * brickSide);
    bool any = false;
    for (auto z = brick[2] * brickSide; z < end[2]; ++z) {
        for (auto y = brick[1] * brickSide; y < end[1]; ++y) {
            const auto* errors = slab.error(z) + std::size_t{y} * slab.grid[0];
            for (auto x = brick[0] * brickSide; x < end[0]; ++x) {
                if (!selection.takes(errors[x])) continue;
                const auto multiple = static_cast<std::int32_t>(std::floor(errors[x] / step + 0.5));
                multiples[x % brickSide + brickSide * (y % brickSide) +
                          brickSide * brickSide * (z % brickSide)] = multiple;
                any = any || multiple != 0;
            }
        }
    }
    return any;
}

/// Encodes all bricks of the slab with indices from `begin` to `end` along x and y, which are in one node.
void encode(const ErrorSlab& slab, const ErrorSelection& selection, const GridSize& begin,
            const GridSize& end, double step, storage::ResidualEncoder& encoder) {
    Multiples multiples{};
    for (auto bx = begin[0]; bx < end[0]; ++bx) {
        for (auto by = begin[1]; by < end[1]; ++by) {
            for (auto bz = begin[2]; bz < end[2]; ++bz) {
                if (!fill(slab, selection, step, {bx, by, bz}, multiples)) continue;
                encoder.add({bx, by, bz}, multiples);
                multiples = {};
            }
        }
    }
}

}  // namespace

void ErrorCount::add(std::span<const float> errors) {
    constexpr std::uint32_t mask = (1U << lowerBits) - 1;
    for (const float error : errors) {
        const auto key = keyOf(error);
        if (key == 0) continue;
        if (!lower_) ++bins_[key >> lowerBits];
        if (lower_ && key >> lowerBits == upper_) ++bins_[key & mask];
    }
}

void ErrorCount::add(std::span<const std::uint64_t> bins) {
    for (std::size_t i = 0; i < bins_.size(); ++i) bins_[i] += bins[i];
}

ErrorCount::Place ErrorCount::find(std::uint64_t most) const {
    Place place;
    for (auto bin = bins_.size(); bin-- > 0;) {
        if (place.above + bins_[bin] > most || (place.above + bins_[bin] == most && bins_[bin] > 0)) {
            place.bin = static_cast<std::uint32_t>(bin);
            return place;
        }
        place.above += bins_[bin];
    }
    place.fewer = true;
    return place;
}

ErrorSelection selectGreatest(const ErrorCount& lower, std::uint32_t upper, std::uint64_t most,
                              std::uint64_t above) {
    const auto place = lower.find(most - above);
    const auto key = upper << ErrorCount::lowerBits | place.bin;
    const float least = std::bit_cast<float>(key);
    return {std::nextafter(least, 0.0F), least, most - above - place.above};
}

ErrorPass::ErrorPass(VolumeSource& source, const VolumePlan& plan, const ValueRange& range,
                     const LowVolume& low, std::uint32_t together)
    : source_(source),
      plan_(plan),
      range_(range),
      low_(low),
      together_(together),
      same_(plan.error == plan.source),
      inSource_(placesIn(plan.error, plan.source)),
      inLow_(placesIn(plan.error, plan.low)) {
    MOTE_CHECK(together % storage::residualBrickSide == 0);
}

Status ErrorPass::run(std::uint32_t e0, std::uint32_t e1,
                      const std::function<Status(const ErrorSlab&)>& visit) const {
    SlabWindow window(source_, range_.min);
    std::vector<float> sampled;
    ErrorSlab slab;
    slab.grid = plan_.error;
    for (auto z = e0; z < e1; z += together_) {
        slab.z0 = z;
        slab.z1 = std::min(e1, z + together_);
        MOTE_RETURN_IF_ERROR(cover(window, slab));
        sampleSource(window, slab, sampled);
        slab.errors.resize(slab.slice() * (slab.z1 - slab.z0));
        tbb::parallel_for(slab.z0, slab.z1, [&](std::uint32_t at) { subtractLow(at, slab); });
        MOTE_RETURN_IF_ERROR(visit(slab));
    }
    return success();
}

/// The slices of the source that the slab and its neighbours need.
Status ErrorPass::cover(SlabWindow& window, const ErrorSlab& slab) const {
    const auto below = slab.z0 > 0 ? slab.z0 - 1 : 0;
    const auto above = std::min(slab.z1, plan_.error[2] - 1);
    return window.cover(inSource_[2][below].first, inSource_[2][above].second + 1);
}

void ErrorPass::sampleSource(const SlabWindow& window, ErrorSlab& slab, std::vector<float>& sampled) const {
    const auto begin = slab.z0 > 0 ? slab.z0 - 1 : 0;
    const auto end = std::min(slab.z1 + 1, plan_.error[2]);
    slab.valuesBegin_ = begin;
    slab.values_.resize(end - begin);
    if (!same_) sampled.resize(slab.slice() * (end - begin));
    tbb::parallel_for(begin, end, [&](std::uint32_t z) {
        if (same_) {
            slab.values_[z - begin] = window.slice(z).data();
            return;
        }
        const auto out = std::span(sampled).subspan((z - begin) * slab.slice(), slab.slice());
        sampleSlice(window, z, out);
        slab.values_[z - begin] = out.data();
    });
}

void ErrorPass::sampleSlice(const SlabWindow& window, std::uint32_t z, std::span<float> out) const {
    const auto& at = inSource_[2][z];
    interpolate(
        window.slice(at.first).data(), window.slice(at.second).data(), at.fraction, plan_.source[0],
        plan_.source[1], inSource_[0], inSource_[1], [&](std::uint32_t y, std::span<const float> row) {
            std::copy(row.begin(), row.end(), out.begin() + static_cast<std::ptrdiff_t>(y * row.size()));
        });
}

void ErrorPass::subtractLow(std::uint32_t z, ErrorSlab& slab) const {
    const auto& at = inLow_[2][z];
    std::vector<float> low(2 * low_.slice());
    const auto all = std::span(low);
    low_.decode(at.first, all.first(low_.slice()));
    low_.decode(at.second, all.last(low_.slice()));
    auto* errors = slab.errors.data() + (z - slab.z0) * slab.slice();
    const auto* values = slab.value(z);
    interpolate(low.data(), low.data() + low_.slice(), at.fraction, low_.size[0], low_.size[1], inLow_[0],
                inLow_[1], [&](std::uint32_t y, std::span<const float> row) {
                    const auto first = y * row.size();
                    for (std::size_t x = 0; x < row.size(); ++x)
                        errors[first + x] = values[first + x] - row[x];
                });
}

double residualStep(const ValueRange& range, double valueStep, double threshold) {
    const auto powerUpTo = [](double number) { return std::exp2(std::floor(std::log2(number))); };
    const double span = powerUpTo(range.span() > 0.0 ? range.span() : 1.0);
    const double known = valueStep > 0.0 ? powerUpTo(valueStep) : range.integers ? 1.0 : 0.0;
    const double quantum = known > 0.0 ? std::max(known, span * 0x1p-19) : span * 0x1p-16;
    return 2.0 * threshold <= quantum ? quantum : powerUpTo(2.0 * threshold);
}

Result<std::vector<storage::ResidualPart>> residualParts(const ErrorSlab& slab,
                                                         const ErrorSelection& selection,
                                                         const storage::ResidualCoding& coding,
                                                         storage::ScratchFile& scratch) {
    constexpr auto nodeSide = storage::residualNodeBricks;
    const auto bricks = storage::bricksOf(slab.grid, brickSide);
    const auto first = slab.z0 / brickSide;
    const auto last = (slab.z1 + brickSide - 1) / brickSide;
    MOTE_CHECK(slab.z0 % brickSide == 0 && first / nodeSide == (last - 1) / nodeSide);
    const auto columns = (bricks[0] + partBricks - 1) / partBricks;
    const auto rows = (bricks[1] + nodeSide - 1) / nodeSide;
    FirstError failure;
    tbb::concurrent_vector<storage::ResidualPart> parts;
    tbb::parallel_for(0U, columns * rows, [&](std::uint32_t task) {
        const GridSize begin{task % columns * partBricks, task / columns * nodeSide, first};
        const GridSize end{std::min(bricks[0], begin[0] + partBricks),
                           std::min(bricks[1], begin[1] + nodeSide), last};
        storage::ResidualEncoder encoder(coding,
                                         {begin[0] / nodeSide, begin[1] / nodeSide, begin[2] / nodeSide});
        encode(slab, selection, begin, end, coding.step, encoder);
        const auto part = encoder.store(scratch);
        if (!part.ok()) return failure.set(part.error());
        if (*part) parts.push_back(**part);
    });
    MOTE_RETURN_IF_ERROR(failure.status());
    return std::vector<storage::ResidualPart>(parts.begin(), parts.end());
}

}  // namespace mote::prep
