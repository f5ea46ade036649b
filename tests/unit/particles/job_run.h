// SPDX-License-Identifier: GPL-3.0-or-later
//
// What tests of the job share: a request, a run of it, and a look at what it made; and a disk that is full.
#pragma once

#include <sys/resource.h>
#include <array>
#include <csignal>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <numeric>
#include <random>
#include <string>
#include <vector>

#include "preprocess/particles/particles_job.h"
#include "preprocess/readers/particle_source.h"
#include "tests/unit/particles/quiet_progress.h"

namespace mote::test {

struct FakeStep {
    std::array<std::vector<double>, prep::columnCount - 1> columns;  ///< by Column; empty ones are missing
    std::vector<std::uint8_t> lost;
    std::vector<std::uint64_t> ids;  ///< empty: the row
    std::int64_t iteration = 0;
    double time = 0.0;

    std::vector<double>& operator[](prep::Column column) { return columns[static_cast<std::size_t>(column)]; }
    const std::vector<double>& operator[](prep::Column column) const {
        return columns[static_cast<std::size_t>(column)];
    }
};

/// A run in memory, for tests of the job. Particles are given as whole columns.
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
    std::uint64_t keptBytes(std::size_t, std::size_t threads) const override { return threads * kept_; }
    /// Says that it keeps so many bytes for each thread that reads.
    void keep(std::uint64_t bytes) { kept_ = bytes; }
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
            part(from.ids, chunk.id, std::uint64_t{0});
            if (from.ids.empty()) std::iota(chunk.id.begin(), chunk.id.end(), begin);
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
    std::uint64_t kept_ = 0;
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

inline proto::JobRequest requestFor(const char* a = "x", const char* b = "px", const char* c = "y") {
    proto::JobRequest request;
    auto& job = *request.mutable_particles();
    job.add_inputs("fake.h5");
    for (const char* axis : {a, b, c}) job.add_axes(axis);
    return request;
}

inline Result<proto::Manifest> make(const proto::JobRequest& request, FakeSource& source,
                                    const std::filesystem::path& output, prep::JobResources options = {}) {
    QuietProgress progress;
    return prep::runParticlesJob(request, source, {output.parent_path() / "fake.h5"}, output, options,
                                 progress);
}

inline std::map<std::string, std::string> contentOf(const std::filesystem::path& folder) {
    std::map<std::string, std::string> files;
    for (const auto& entry : std::filesystem::directory_iterator(folder)) {
        std::ifstream file(entry.path(), std::ios::binary);
        files[entry.path().filename()] = {std::istreambuf_iterator<char>(file), {}};
    }
    return files;
}

inline std::size_t entriesOf(const std::filesystem::path& folder) {
    return static_cast<std::size_t>(
        std::distance(std::filesystem::directory_iterator(folder), std::filesystem::directory_iterator()));
}

/// A limit on the size of files for as long as the object lives: the kernel then refuses writes as on a full
/// disk.
class FileSizeLimit {
  public:
    explicit FileSizeLimit(rlim_t bytes) {
        ::getrlimit(RLIMIT_FSIZE, &before_);
        auto limit = before_;
        limit.rlim_cur = bytes;
        std::signal(SIGXFSZ, SIG_IGN);
        ::setrlimit(RLIMIT_FSIZE, &limit);
    }
    ~FileSizeLimit() {
        ::setrlimit(RLIMIT_FSIZE, &before_);
        std::signal(SIGXFSZ, SIG_DFL);
    }

  private:
    rlimit before_{};
};

}  // namespace mote::test
