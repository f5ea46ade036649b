// SPDX-License-Identifier: GPL-3.0-or-later
//
// bench-hybrid-errors: how far a hybrid volume is from its source, sample by sample: of the low-resolution
// volume alone, and with its residual. The error grid must be the source's.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "preprocess/volume/volume_source.h"
#include "protocol/cli/command.h"
#include "storage/hybrid/check_hybrid.h"
#include "storage/hybrid/hybrid_file.h"
#include "storage/hybrid/hybrid_limits.h"
#include "storage/hybrid/residual_file.h"
#include "storage/manifest.h"

namespace {

using namespace mote;
using storage::GridSize;

struct NoProgress final : prep::Progress {
    void report(double, std::string_view) override {}
    void note(std::string_view) override {}
    bool cancelled() const override { return false; }
};

struct Sums {
    double absolute = 0.0, square = 0.0, worst = 0.0;
    void add(double error) {
        absolute += std::abs(error);
        square += error * error;
        worst = std::max(worst, std::abs(error));
    }
};

class Comparison {
  public:
    explicit Comparison(std::string dataset) : dataset_(std::move(dataset)) {}

    Status run(const std::string& input) {
        auto manifest = storage::readManifest(dataset_);
        if (!manifest.ok()) return manifest.error();
        manifest_ = *std::move(manifest);
        NoProgress progress;
        auto source = prep::openVolumeSource(manifest_.request().volume().source(), input, progress);
        if (!source.ok()) return source.error();
        const auto step = storage::HybridStep::open(dataset_, manifest_, 0);
        if (!step.ok()) return step.error();
        MOTE_RETURN_IF_ERROR(readResiduals());
        std::vector<float> slice((*source)->shape().voxelsOfSlice());
        for (std::uint32_t z = 0; z < (*source)->shape().nz; ++z) {
            MOTE_RETURN_IF_ERROR((*source)->read(z, z + 1, slice));
            compare(*step, slice, z);
        }
        print(static_cast<double>((*source)->shape().voxels()));
        return success();
    }

  private:
    Status readResiduals() {
        grid_ = storage::gridSize(manifest_.hybrid().error_size());
        residuals_.resize(storage::samplesOf(grid_));
        if (!manifest_.hybrid().residual()) return success();
        return storage::readResidual(dataset_, manifest_, 0, [&](const storage::ResidualBrick& brick) {
            for (std::uint32_t i = 0; i < storage::residualBrickSamples; ++i) {
                const GridSize at{brick.index[0] * 8 + i % 8, brick.index[1] * 8 + i / 8 % 8,
                                  brick.index[2] * 8 + i / 64};
                if (at[0] >= grid_[0] || at[1] >= grid_[1] || at[2] >= grid_[2]) continue;
                residuals_[(std::size_t{at[2]} * grid_[1] + at[1]) * grid_[0] + at[0]] = brick.values[i];
            }
        });
    }

    void compare(const storage::HybridStep& step, const std::vector<float>& slice, std::uint32_t z) {
        const auto& low = step.lowSize();
        const auto at = [&](std::uint32_t i, std::size_t axis) {
            return storage::between(storage::placeIn(i, grid_[axis], low[axis]), low[axis]);
        };
        const auto code = [&](std::size_t x, std::size_t y, std::size_t k) {
            return std::visit(
                [&](auto codes) { return double{static_cast<double>(codes[(k * low[1] + y) * low[0] + x])}; },
                step.low());
        };
        const auto mix = [](double a, double b, double t) { return a + t * (b - a); };
        const auto& entry = manifest_.hybrid().steps(0);
        const auto az = at(z, 2);
        for (std::uint32_t y = 0; y < grid_[1]; ++y) {
            const auto ay = at(y, 1);
            for (std::uint32_t x = 0; x < grid_[0]; ++x) {
                const auto ax = at(x, 0);
                const auto line = [&](std::uint32_t iy, std::uint32_t iz) {
                    return mix(code(ax.first, iy, iz), code(ax.second, iy, iz), ax.fraction);
                };
                const auto plane = [&](std::uint32_t iz) {
                    return mix(line(ay.first, iz), line(ay.second, iz), ay.fraction);
                };
                const double value = entry.value_min() +
                                     entry.value_step() * mix(plane(az.first), plane(az.second), az.fraction);
                const std::size_t i = std::size_t{y} * grid_[0] + x;
                const double error = slice[i] - value;
                low_.add(error);
                both_.add(error - residuals_[std::size_t{z} * grid_[0] * grid_[1] + i]);
            }
        }
    }

    void print(double samples) const {
        const double span = manifest_.hybrid().value_max() - manifest_.hybrid().value_min();
        for (const auto& [what, sums] : {std::pair{"low", low_}, std::pair{"residual", both_}}) {
            fmt::print("{:<9} mean {:.5f} rms {:.5f} worst {:.4f} of the range, PSNR {:.2f} dB\n", what,
                       sums.absolute / samples / span, std::sqrt(sums.square / samples) / span,
                       sums.worst / span, 10.0 * std::log10(span * span * samples / sums.square));
        }
    }

    std::string dataset_;
    proto::Manifest manifest_;
    GridSize grid_{};
    std::vector<float> residuals_;
    Sums low_, both_;
};

}  // namespace

int main(int argc, char** argv) {
    std::string input;
    std::string dataset;
    const mote::cli::Program commandLine("How far a hybrid volume is from its source.",
                                         "bench-hybrid-errors");
    const auto program = commandLine.command();
    program.option("INPUT", input, "The source").required();
    program.option("DATASET", dataset, "NAME.mote").required();
    if (const auto end = commandLine.parse(argc, argv)) return *end;
    const auto done = Comparison(dataset).run(input);
    if (done.ok()) return 0;
    fmt::print(stderr, "{}\n", done.error().toString());
    return 1;
}
