// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/hybrid/low_volume.h"

#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "preprocess/hybrid/axis_filter.h"
#include "preprocess/hybrid/gradient.h"

namespace mote::prep {
namespace {

struct Filters {
    AxisFilter x, y, z;
};

/// One slice of the source in the low-resolution volume's x and y.
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
