// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/layers/ink/density_grid.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "server/render/plan/frame_plan.h"
#include "storage/storage_error.h"

namespace mote::render {
namespace {

constexpr std::uint32_t mostCells = 512;  // of a step's volume a side
constexpr std::uint32_t coarsest = 4;     // samples a side of the coarsest means
// Cells that weights of 1, 2 and 1 along each axis amount to: one over the sum of their squares.
constexpr double kernelCells = (8.0 / 3.0) * (8.0 / 3.0) * (8.0 / 3.0);
// Particles in a kernel: of fewer a mean tells nothing, of more all that is to be told.
constexpr double fewest = 8.0, enough = 64.0;

/// take(x, y, z, place in memory) for each sample of a grid.
template <class Take>
void eachSample(std::uint32_t size, const Take& take) {
    tbb::parallel_for(std::uint32_t{0}, size, [&](std::uint32_t z) {
        std::size_t at = std::size_t{z} * size * size;
        for (std::uint32_t y = 0; y < size; ++y) {
            for (std::uint32_t x = 0; x < size; ++x, ++at) take(x, y, z, at);
        }
    });
}

/// Means of 2 x 2 x 2 samples.
template <class Values>
DensitySamples halved(const Values& values, std::uint32_t size) {
    DensitySamples made{size / 2, std::vector<float>(std::size_t{size / 2} * (size / 2) * (size / 2))};
    eachSample(made.size, [&](std::uint32_t x, std::uint32_t y, std::uint32_t z, std::size_t at) {
        double sum = 0.0;
        for (unsigned corner = 0; corner < 8; ++corner) {
            const std::size_t from =
                ((std::size_t{2} * z + (corner >> 2)) * size + 2 * y + (corner >> 1 & 1U)) * size + 2 * x +
                (corner & 1U);
            sum += std::max(0.0, static_cast<double>(values[from]));
        }
        made.values[at] = static_cast<float>(sum / 8.0);
    });
    return made;
}

/// By weights of 1, 2 and 1 along one axis after another; beyond the grid its outermost samples go on.
std::vector<float> blurred(const DensitySamples& samples) {
    std::vector<float> from = samples.values, to(from.size());
    const std::uint32_t last = samples.size - 1;
    std::size_t stride = 1;
    for (int axis = 0; axis < 3; ++axis, stride *= samples.size) {
        eachSample(samples.size, [&](std::uint32_t x, std::uint32_t y, std::uint32_t z, std::size_t at) {
            const std::uint32_t along = axis == 0 ? x : axis == 1 ? y : z;
            const float before = from[along > 0 ? at - stride : at],
                        behind = from[along < last ? at + stride : at];
            to[at] = 0.5F * from[at] + 0.25F * (before + behind);
        });
        std::swap(from, to);
    }
    return from;
}

/// A coarser grid's value at the middle of a sample of one twice as fine.
float between(const DensitySamples& coarse, std::uint32_t x, std::uint32_t y, std::uint32_t z) {
    const std::uint32_t last = coarse.size - 1;
    const auto beside = [last](std::uint32_t at) {
        const std::uint32_t own = at / 2;
        return at % 2 == 0 ? (own > 0 ? own - 1 : own) : std::min(own + 1, last);
    };
    const auto value = [&](std::uint32_t i, std::uint32_t k, std::uint32_t l) {
        return coarse.values[(std::size_t{l} * coarse.size + k) * coarse.size + i];
    };
    const std::uint32_t i = x / 2, k = y / 2, l = z / 2, i2 = beside(x), k2 = beside(y), l2 = beside(z);
    const auto row = [&](std::uint32_t b, std::uint32_t c) {
        return 0.75F * value(i, b, c) + 0.25F * value(i2, b, c);
    };
    return 0.75F * (0.75F * row(k, l) + 0.25F * row(k2, l)) +
           0.25F * (0.75F * row(k, l2) + 0.25F * row(k2, l2));
}

/// Choices among means favour what is dense by some hundredths.
void keepWeight(DensitySamples& samples, double sum) {
    double made = 0.0;
    for (const float value : samples.values) made += static_cast<double>(value);
    for (auto& value : samples.values) value *= static_cast<float>(sum / made);
}

}  // namespace

DensitySamples densitySamples(const storage::ParticleStep& step) {
    const std::uint32_t size = step.volumeSize();
    const auto densities = step.volume();
    if (size == 0 || size > mostCells || densities.size() != std::size_t{size} * size * size) {
        throw storage::StorageError(
            Error{ErrorCode::corrupt, "/volume/density", "the volume's size is not its shape"});
    }
    if (size <= mostDensities) return {size, {densities.begin(), densities.end()}};
    auto samples = halved(densities, size);
    while (samples.size > mostDensities) samples = halved(samples.values, samples.size);
    return samples;
}

DensitySamples smoothed(const DensitySamples& samples, double particles) {
    double sum = 0.0;
    for (const float value : samples.values) sum += static_cast<double>(value);
    if (!(sum > 0.0) || !std::isfinite(sum)) return samples;
    std::vector<DensitySamples> means{samples};
    while (means.back().size > coarsest && means.back().size % 2 == 0)
        means.push_back(halved(means.back().values, means.back().size));
    DensitySamples made{means.back().size, blurred(means.back())};
    for (std::size_t level = means.size() - 1; level-- > 0;) {
        const auto own = blurred(means[level]);
        const auto size = means[level].size;
        // Of a density, in a kernel of this level.
        const double most = static_cast<double>(samples.size) / size;
        const double perDensity = particles / sum * most * most * most * kernelCells;
        DensitySamples finer{size, std::vector<float>(own.size())};
        eachSample(size, [&](std::uint32_t x, std::uint32_t y, std::uint32_t z, std::size_t at) {
            const float coarse = between(made, x, y, z);
            // That there are none if some are expected tells as much as some that are there.
            const double count = perDensity * static_cast<double>(std::max(own[at], coarse));
            const double share =
                count > fewest ? std::min(std::log(count / fewest) / std::log(enough / fewest), 1.0) : 0.0;
            finer.values[at] = coarse + static_cast<float>(share) * (own[at] - coarse);
        });
        made = std::move(finer);
    }
    keepWeight(made, sum);
    return made;
}

std::shared_ptr<const GridField> densityGrid(const storage::ParticleStep& step) {
    constexpr std::size_t more = 4;  // that can be read
    const auto samples = smoothed(densitySamples(step), static_cast<double>(step.pointCount()));
    const LogDensity scale = step.logDensity();
    auto field = std::make_shared<GridField>();
    field->boxToLayer = plotToLayer();
    field->range = {-LogDensity::fade, 1.0};
    field->coarse.size = glm::uvec3(samples.size);
    field->coarse.values.resize(samples.values.size() + more);
    field->coarse.normals.resize(samples.values.size() + more);
    eachSample(samples.size, [&](std::uint32_t, std::uint32_t, std::uint32_t, std::size_t at) {
        const double t = scale.ofCell(static_cast<double>(samples.values[at]));
        field->coarse.values[at] = static_cast<std::uint16_t>(std::lround(field->codeOf(t)));
    });
    return field;
}

std::uint64_t densityGridBytes() {
    constexpr std::uint64_t samples = std::uint64_t{mostDensities} * mostDensities * mostDensities;
    // Means of all levels, what is blurred, and codes.
    return samples * (8 * sizeof(float) + sizeof(std::uint16_t) + 1);
}

}  // namespace mote::render
