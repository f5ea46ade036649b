// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/hybrid/under_filter.h"

#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <vector>

#include "storage/hybrid/grid_axis.h"

namespace mote::prep {
namespace {

using storage::Between;

std::vector<Between> betweens(std::uint32_t samples, std::uint32_t low) {
    std::vector<Between> all;
    for (std::uint32_t i = 0; i < samples; ++i) {
        all.push_back(storage::between(storage::placeIn(i, samples, low), low));
    }
    return all;
}

struct Axes {
    std::vector<Between> x, y, z;
    std::size_t width, slice;  ///< of the low-resolution volume
};

/// Two weights along an axis; at a grid's end one sample has both.
std::array<float, 2> weights(const Between& at) {
    if (at.first == at.second) return {1.0F, 0.0F};
    return {1.0F - at.fraction, at.fraction};
}

/// What a sample of the source at x, between these slices and rows, asks for.
class Sample {
  public:
    Sample(const Axes& axes, const Between& x, const Between& y, const Between& z) {
        const std::array along{weights(x), weights(y), weights(z)};
        for (std::size_t i = 0; i < 8; ++i) {
            const std::size_t right = i & 1U;
            const std::size_t back = i >> 1U & 1U;
            const std::size_t up = i >> 2U;
            index_[i] = (up ? z.second : z.first) * axes.slice + (back ? y.second : y.first) * axes.width +
                        (right ? x.second : x.first);
            weight_[i] = along[0][right] * along[1][back] * along[2][up];
            squares_ += weight_[i] * weight_[i];
        }
    }
    float interpolated(std::span<const float> low) const {
        float sum = 0.0F;
        for (std::size_t i = 0; i < 8; ++i) sum += weight_[i] * low[index_[i]];
        return sum;
    }
    void ask(float overshoot, std::span<float> falls) const {
        for (std::size_t i = 0; i < 8; ++i) {
            auto& fall = falls[index_[i]];
            fall = std::max(fall, overshoot * weight_[i] / squares_);
        }
    }

  private:
    std::array<std::size_t, 8> index_{};
    std::array<float, 8> weight_{};
    float squares_ = 0.0F;
};

void askForSlice(std::span<const float> slice, std::uint32_t z, const Axes& axes, float allowance,
                 std::span<const float> low, std::span<float> falls) {
    for (std::size_t y = 0; y < axes.y.size(); ++y) {
        for (std::size_t x = 0; x < axes.x.size(); ++x) {
            const Sample sample(axes, axes.x[x], axes.y[y], axes.z[z]);
            const float overshoot = sample.interpolated(low) - slice[y * axes.x.size() + x] - allowance;
            if (overshoot > 0.0F) sample.ask(overshoot, falls);
        }
    }
}

}  // namespace

Status findFalls(VolumeSource& source, const VolumePlan& plan, const ValueRange& range,
                 std::span<const float> low, std::uint32_t z0, std::uint32_t z1, std::uint32_t together,
                 const std::function<Status(std::uint32_t z)>& progress, std::span<float> falls) {
    const Axes axes{betweens(plan.source[0], plan.low[0]), betweens(plan.source[1], plan.low[1]),
                    betweens(plan.source[2], plan.low[2]), plan.low[0],
                    std::size_t{plan.low[0]} * plan.low[1]};
    const auto allowance = static_cast<float>(plan.allowance * range.span());
    SlabWindow window(source, range.min);
    for (auto z = z0; z < z1; z += together) {
        const auto end = std::min(z1, z + together);
        MOTE_RETURN_IF_ERROR(progress(z));
        MOTE_RETURN_IF_ERROR(window.cover(z, end));
        // Slices between the low slices k and k + 1 ask both: those of every other k at once, so that no two
        // threads meet.
        for (const std::uint32_t parity : {0U, 1U}) {
            const auto lastPair = axes.z[end - 1].first / 2;
            tbb::parallel_for(axes.z[z].first / 2, lastPair + 1, [&](std::uint32_t pair) {
                const auto k = 2 * pair + parity;
                for (auto at = z; at < end; ++at) {
                    if (axes.z[at].first != k) continue;
                    askForSlice(window.slice(at), at, axes, allowance, low, falls);
                }
            });
        }
    }
    return success();
}

}  // namespace mote::prep
