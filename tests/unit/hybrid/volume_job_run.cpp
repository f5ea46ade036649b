// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/unit/hybrid/volume_job_run.h"

#include <gtest/gtest.h>
#include <algorithm>
#include <cmath>

#include "storage/hybrid/check_hybrid.h"
#include "storage/hybrid/residual_file.h"
#include "storage/manifest.h"

namespace mote::test {

using storage::GridSize;

Reconstruction::Reconstruction(const std::filesystem::path& dataset, std::uint32_t step) : step_(step) {
    auto manifest = storage::readManifest(dataset);
    if (!manifest.ok()) throw std::runtime_error(manifest.error().toString());
    manifest_ = *std::move(manifest);
    auto file = storage::HybridStep::open(dataset, manifest_, step);
    if (!file.ok()) throw std::runtime_error(file.error().toString());
    file_.emplace(*std::move(file));
    low_ = storage::gridSize(manifest_.hybrid().low_size());
    error_ = storage::gridSize(manifest_.hybrid().error_size());
    residuals_.resize(storage::samplesOf(error_));
    if (!manifest_.hybrid().residual()) return;
    const auto read =
        storage::readResidual(dataset, manifest_, step, [&](const storage::ResidualBrick& brick) {
            for (std::uint32_t i = 0; i < storage::residualBrickSamples; ++i) {
                const GridSize at{brick.index[0] * 8 + i % 8, brick.index[1] * 8 + i / 8 % 8,
                                  brick.index[2] * 8 + i / 64};
                if (at[0] >= error_[0] || at[1] >= error_[1] || at[2] >= error_[2]) continue;
                residuals_[(std::size_t{at[2]} * error_[1] + at[1]) * error_[0] + at[0]] = brick.values[i];
            }
        });
    if (!read.ok()) throw std::runtime_error(read.error().toString());
}

double Reconstruction::code(std::int64_t x, std::int64_t y, std::int64_t z) const {
    const auto inside = [](std::int64_t i, std::uint32_t n) {
        return static_cast<std::size_t>(std::clamp<std::int64_t>(i, 0, n - 1));
    };
    const auto index = (inside(z, low_[2]) * low_[1] + inside(y, low_[1])) * low_[0] + inside(x, low_[0]);
    return std::visit([&](auto codes) { return static_cast<double>(codes[index]); }, file_->low());
}

double Reconstruction::low(const GridSize& at, const GridSize& grid) const {
    double place[3];
    double whole[3];
    for (std::size_t a = 0; a < 3; ++a) {
        place[a] = (at[a] + 0.5) * low_[a] / grid[a] - 0.5;
        whole[a] = std::floor(place[a]);
    }
    double sum = 0.0;
    for (int corner = 0; corner < 8; ++corner) {
        double weight = 1.0;
        std::int64_t index[3];
        for (int a = 0; a < 3; ++a) {
            const bool upper = (corner >> a & 1) != 0;
            const double fraction = place[a] - whole[a];
            weight *= upper ? fraction : 1.0 - fraction;
            index[a] = static_cast<std::int64_t>(whole[a]) + (upper ? 1 : 0);
        }
        sum += weight * code(index[0], index[1], index[2]);
    }
    return entry().value_min() + sum * entry().value_step();
}

double Reconstruction::residual(const GridSize& at) const {
    return residuals_[(std::size_t{at[2]} * error_[1] + at[1]) * error_[0] + at[0]];
}

std::vector<storage::HybridPoint> Reconstruction::points() const {
    std::vector<storage::HybridPoint> points;
    file_->points().forEach([&](const storage::HybridPoint& point) { points.push_back(point); });
    return points;
}

std::uint8_t Reconstruction::normal(const GridSize& at) const {
    return file_->lowNormal()[(std::size_t{at[2]} * low_[1] + at[1]) * low_[0] + at[0]];
}

}  // namespace mote::test
