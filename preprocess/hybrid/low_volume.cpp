// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/hybrid/low_volume.h"

#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <numeric>

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

/// Which samples of the source make a sample of the low-resolution volume, along one axis, and
/// with which weights.
class AxisFilter {
  public:
    /// Filters `samples` of the source to `low` of them, low <= samples. Box: by how much of a sample's cell
    /// each covers. Cubic (also for `under`): Keys' kernel with a = -1/2 (Keys 1981, Cubic convolution
    /// interpolation), stretched to the spacing of the low samples, so that nothing is skipped; what lies
    /// beyond the ends has no weight. Weights add up to 1.
    AxisFilter(LowFilter filter, std::uint32_t samples, std::uint32_t low);

    std::uint32_t size() const { return static_cast<std::uint32_t>(taps_.size()); }
    /// Samples [first, end) of the source make sample j.
    std::uint32_t first(std::uint32_t j) const { return taps_[j].first; }
    std::uint32_t end(std::uint32_t j) const { return taps_[j].first + taps_[j].count; }
    std::span<const float> weights(std::uint32_t j) const {
        return std::span(weights_).subspan(taps_[j].begin, taps_[j].count);
    }

  private:
    struct Taps {
        std::uint32_t first, count;
        std::size_t begin;  ///< in weights_
    };
    std::vector<Taps> taps_;
    std::vector<float> weights_;
};

double keys(double x) {
    x = std::abs(x);
    if (x < 1.0) return (1.5 * x - 2.5) * x * x + 1.0;
    if (x < 2.0) return ((-0.5 * x + 2.5) * x - 4.0) * x + 2.0;
    return 0.0;
}

AxisFilter::AxisFilter(LowFilter filter, std::uint32_t samples, std::uint32_t low) {
    const double scale = static_cast<double>(samples) / low;
    const bool box = filter == LowFilter::box;
    for (std::uint32_t j = 0; j < low; ++j) {
        const double centre = storage::placeIn(j, low, samples);
        const double reach = box ? scale / 2 + 0.5 : 2 * scale;
        const auto first = static_cast<std::uint32_t>(std::max(0.0, std::floor(centre - reach) + 1.0));
        const auto last =
            static_cast<std::uint32_t>(std::min(samples - 1.0, std::ceil(centre + reach) - 1.0));
        std::vector<double> weights;
        for (auto i = first; i <= last; ++i) {
            const double overlap =
                std::min(i + 0.5, centre + scale / 2) - std::max(i - 0.5, centre - scale / 2);
            weights.push_back(box ? std::max(0.0, overlap) : keys((i - centre) / scale));
        }
        const double sum = std::accumulate(weights.begin(), weights.end(), 0.0);
        taps_.push_back({first, static_cast<std::uint32_t>(weights.size()), weights_.size()});
        for (const double weight : weights) weights_.push_back(static_cast<float>(weight / sum));
    }
}

struct Filters {
    AxisFilter x, y, z;
};

/// Filters one slice of the source to the low-resolution volume's x and y.
void reduceSlice(std::span<const float> slice, std::uint32_t sourceWidth, const Filters& filters,
                 std::span<float> reduced) {
    const std::size_t width = filters.x.size();
    const std::size_t height = slice.size() / sourceWidth;
    std::vector<float> rows(width * height);
    for (std::size_t y = 0; y < height; ++y) {
        const auto* row = slice.data() + y * sourceWidth;
        for (std::uint32_t j = 0; j < width; ++j) {
            const auto weights = filters.x.weights(j);
            const auto* from = row + filters.x.first(j);
            float sum = 0.0F;
            for (std::size_t i = 0; i < weights.size(); ++i) sum += weights[i] * from[i];
            rows[y * width + j] = sum;
        }
    }
    std::fill(reduced.begin(), reduced.end(), 0.0F);
    for (std::uint32_t j = 0; j < filters.y.size(); ++j) {
        auto* to = reduced.data() + j * width;
        const auto weights = filters.y.weights(j);
        for (std::size_t i = 0; i < weights.size(); ++i) {
            const auto* from = rows.data() + (filters.y.first(j) + i) * width;
            for (std::size_t x = 0; x < width; ++x) to[x] += weights[i] * from[x];
        }
    }
}

/// Adds slices [z0, z1), reduced, to low slice k, in ascending z.
void addSlices(const AxisFilter& filter, std::uint32_t k, std::uint32_t z0, std::uint32_t z1,
               std::span<const float> reduced, std::span<float> low) {
    const auto first = std::max(z0, filter.first(k));
    const auto end = std::min(z1, filter.end(k));
    for (auto z = first; z < end; ++z) {
        const float weight = filter.weights(k)[z - filter.first(k)];
        const auto* from = reduced.data() + (z - z0) * low.size();
        for (std::size_t i = 0; i < low.size(); ++i) low[i] += weight * from[i];
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

Status SlabWindow::cover(std::uint32_t z0, std::uint32_t z1) {
    MOTE_CHECK(z0 >= begin_ && z1 >= end_ && z0 < z1);
    const auto kept = end_ > z0 ? end_ - z0 : 0;
    const auto from = std::max(z0, end_);
    if (kept > 0) {
        std::copy_n(values_.begin() + static_cast<std::ptrdiff_t>((z0 - begin_) * slice_), kept * slice_,
                    values_.begin());
    }
    values_.resize((z1 - z0) * slice_);
    begin_ = z0;
    end_ = z1;
    if (from == z1) return success();
    const auto fresh = std::span(values_).subspan(kept * slice_);
    MOTE_RETURN_IF_ERROR(source_.read(from, z1, fresh));
    if (source_.shape().type != ScalarType::f32 && source_.shape().type != ScalarType::f64) return success();
    tbb::parallel_for(std::size_t{0}, std::size_t{z1 - from}, [&](std::size_t z) {
        for (auto& value : fresh.subspan(z * slice_, slice_)) value = std::isfinite(value) ? value : least_;
    });
    return success();
}

Result<std::vector<float>> filterSlices(
    VolumeSource& source, const VolumePlan& plan, const ValueRange& range, std::uint32_t k0, std::uint32_t k1,
    std::uint32_t together,
    const std::function<Status(const SlabWindow&, std::uint32_t z0, std::uint32_t z1)>& seen) {
    const Filters filters{{plan.filter, plan.source[0], plan.low[0]},
                          {plan.filter, plan.source[1], plan.low[1]},
                          {plan.filter, plan.source[2], plan.low[2]}};
    const std::size_t slice = std::size_t{plan.low[0]} * plan.low[1];
    std::vector<float> low(slice * (k1 - k0));
    if (k0 == k1) return low;
    SlabWindow window(source, range.min);
    std::vector<float> reduced;
    const auto last = filters.z.end(k1 - 1);
    for (auto z = filters.z.first(k0); z < last; z += together) {
        const auto end = std::min(last, z + together);
        MOTE_RETURN_IF_ERROR(window.cover(z, end));
        MOTE_RETURN_IF_ERROR(seen(window, z, end));
        reduced.resize(slice * (end - z));
        const auto all = std::span(reduced);
        tbb::parallel_for(z, end, [&](std::uint32_t at) {
            reduceSlice(window.slice(at), plan.source[0], filters, all.subspan((at - z) * slice, slice));
        });
        tbb::parallel_for(k0, k1, [&](std::uint32_t k) {
            addSlices(filters.z, k, z, end, all, std::span(low).subspan((k - k0) * slice, slice));
        });
    }
    const auto least = static_cast<float>(range.min);
    const auto greatest = static_cast<float>(range.max);
    for (auto& value : low) value = std::clamp(value, least, greatest);
    return low;
}

void LowVolume::decode(std::uint32_t z, std::span<float> values) const {
    const auto from = z * slice();
    for (std::size_t i = 0; i < values.size(); ++i) {
        const int code = codes8.empty() ? codes16[from + i] : codes8[from + i];
        values[i] = static_cast<float>(min + code * step);
    }
}

storage::LowCodes LowVolume::codes() const {
    if (codes8.empty()) return std::span<const std::uint16_t>(codes16);
    return std::span<const std::uint8_t>(codes8);
}

LowVolume encodeLow(const VolumePlan& plan, const ValueRange& range, std::span<const float> values) {
    LowVolume low{plan.low, range.min, 0.0, {}, {}};
    double greatest = range.max;
    const bool under = plan.filter == LowFilter::under;
    if (under) {
        const auto [least, most] = std::minmax_element(values.begin(), values.end());
        low.min = *least;
        greatest = *most;
    }
    const int codes = plan.valueBits == 8 ? 255 : 65535;
    low.step = (greatest - low.min) / codes;
    const auto codeOf = [&](float value) {
        if (!(low.step > 0.0)) return 0;
        const double code = (value - low.min) / low.step;
        return std::clamp(static_cast<int>(under ? std::floor(code) : std::floor(code + 0.5)), 0, codes);
    };
    if (plan.valueBits == 8) low.codes8.resize(values.size());
    if (plan.valueBits == 16) low.codes16.resize(values.size());
    tbb::parallel_for(std::uint32_t{0}, plan.low[2], [&](std::uint32_t z) {
        for (auto i = z * low.slice(); i < (z + 1) * low.slice(); ++i) {
            if (plan.valueBits == 8) low.codes8[i] = static_cast<std::uint8_t>(codeOf(values[i]));
            if (plan.valueBits == 16) low.codes16[i] = static_cast<std::uint16_t>(codeOf(values[i]));
        }
    });
    return low;
}

std::vector<std::uint8_t> lowNormals(const LowVolume& low, const glm::dmat4& lowToWorld) {
    const GradientNormals normals(low.size, lowToWorld);
    std::vector<std::uint8_t> codes(low.slice() * low.size[2]);
    tbb::parallel_for(std::uint32_t{0}, low.size[2], [&](std::uint32_t z) {
        std::vector<float> values(3 * low.slice());
        const auto all = std::span(values);
        const std::array<std::uint32_t, 3> around{z > 0 ? z - 1 : 0, z, std::min(z + 1, low.size[2] - 1)};
        std::array<const float*, 3> slices{};
        for (std::size_t i = 0; i < 3; ++i) {
            low.decode(around[i], all.subspan(i * low.slice(), low.slice()));
            slices[i] = all.data() + i * low.slice();
        }
        for (std::uint32_t y = 0; y < low.size[1]; ++y) {
            for (std::uint32_t x = 0; x < low.size[0]; ++x) {
                codes[z * low.slice() + std::size_t{y} * low.size[0] + x] = normals.code(slices, {x, y, z});
            }
        }
    });
    return codes;
}

}  // namespace mote::prep
