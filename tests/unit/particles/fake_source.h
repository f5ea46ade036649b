// SPDX-License-Identifier: GPL-3.0-or-later
//
// FakeSource: a run in memory, for tests of the job. Particles are given as whole columns.
#pragma once

#include <array>
#include <cstdint>
#include <numeric>
#include <random>
#include <vector>

#include "preprocess/readers/particle_source.h"

namespace mote::test {

struct FakeStep {
    std::array<std::vector<double>, prep::columnCount - 1> columns;  ///< by Column; empty ones are missing
    std::vector<std::uint8_t> lost;
    std::int64_t iteration = 0;
    double time = 0.0;

    std::vector<double>& operator[](prep::Column column) { return columns[static_cast<std::size_t>(column)]; }
    const std::vector<double>& operator[](prep::Column column) const {
        return columns[static_cast<std::size_t>(column)];
    }
};

class FakeSource final : public prep::ParticleSource {
  public:
    explicit FakeSource(std::vector<FakeStep> steps, double mass = 0.0)
        : data_(std::move(steps)), mass_(mass) {
        for (const auto& step : data_) {
            steps_.push_back({"fake.h5", step.iteration, step.time, step[prep::Column::x].size()});
        }
    }

    std::string format() const override { return "fake"; }
    const std::vector<prep::SourceStep>& steps() const override { return steps_; }
    bool has(prep::Column column) const override {
        if (column == prep::Column::id || column == prep::Column::weight) return true;
        for (const auto& step : data_) {
            if (step[column].size() != step[prep::Column::x].size()) return false;
        }
        return true;
    }
    double mass() const override { return mass_; }
    std::string species() const override { return what.species; }
    double particleCharge() const override { return what.charge; }
    std::string weightUnit() const override { return what.weightUnit; }
    Status read(std::size_t step, std::uint64_t begin, std::size_t count,
                const std::vector<prep::Column>& wanted, prep::ParticleChunk& chunk) override {
        const auto& from = data_[step];
        ++reads;
        chunk.begin = begin;
        chunk.size = count;
        const auto part = [&](const auto& values, auto& to, auto missing) {
            to.assign(count, missing);
            if (values.empty()) return;
            const auto first = values.begin() + static_cast<std::ptrdiff_t>(begin);
            std::copy(first, first + static_cast<std::ptrdiff_t>(count), to.begin());
        };
        for (const auto column : wanted) {
            if (column != prep::Column::id) {
                part(from[column], chunk[column], 1.0);
                continue;
            }
            chunk.id.resize(count);
            std::iota(chunk.id.begin(), chunk.id.end(), begin);
        }
        part(from.lost, chunk.lost, std::uint8_t{0});
        return success();
    }

    /// What it says of its particles.
    struct What {
        std::string species, weightUnit;
        double charge = 0.0;
    };
    What what;
    std::size_t reads = 0;

  private:
    std::vector<FakeStep> data_;
    std::vector<prep::SourceStep> steps_;
    double mass_;
};

/// A dense core with a thin halo in x, y, px, py, pz, z; weights from 0.5 to 1.5.
inline FakeStep beamStep(std::size_t particles, std::uint64_t seed, double width = 1.0) {
    std::mt19937_64 random(seed);
    // Not std::normal_distribution, whose numbers differ between libraries.
    const auto uniform = [&] { return static_cast<double>(random() >> 11) * 0x1p-53; };
    const auto bell = [&] { return uniform() + uniform() + uniform() + uniform() - 2.0; };
    FakeStep step;
    for (std::size_t i = 0; i < particles; ++i) {
        const double scale = width * (i % 10 == 0 ? 8.0 : 1.0);
        for (const auto column :
             {prep::Column::x, prep::Column::y, prep::Column::z, prep::Column::px, prep::Column::py}) {
            step[column].push_back(1e-3 * scale * bell());
        }
        step[prep::Column::pz].push_back(1e6 + 1e3 * bell());
        step[prep::Column::weight].push_back(0.5 + uniform());
    }
    return step;
}

}  // namespace mote::test
