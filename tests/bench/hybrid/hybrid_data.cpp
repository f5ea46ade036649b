// SPDX-License-Identifier: GPL-3.0-or-later
//
// bench-hybrid-data: volumes of 8 bits and any size for the measurements of hybrid volumes: the synthetic
// bubble, or a given volume resampled linearly to a cube, its values from LEAST to GREATEST as 0 to 255.
// Writes NRRD.
#include <fmt/format.h>
#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <vector>

#include "preprocess/volume/volume_source.h"
#include "protocol/cli/command.h"
#include "storage/hybrid/hybrid_limits.h"
#include "tests/bench/hybrid/bubble.h"

namespace {

using namespace mote;

struct Options {
    std::string out, input;
    std::uint32_t size = 512;
    std::vector<double> range{0.0, 255.0};
};

struct NoProgress final : prep::Progress {
    void report(double, std::string_view) override {}
    void note(std::string_view sentence) override { fmt::print(stderr, "{}\n", sentence); }
    bool cancelled() const override { return false; }
};

using Bytes = std::vector<char>;

char byteOf(double value) {
    return static_cast<char>(static_cast<unsigned char>(std::clamp(std::floor(value + 0.5), 0.0, 255.0)));
}

void makeBubble(std::uint32_t size, Bytes& bytes) {
    tbb::parallel_for(std::uint32_t{0}, size, [&](std::uint32_t z) {
        const auto place = [&](std::uint32_t i) {
            return (static_cast<float>(i) + 0.5F) / size * 2.0F - 1.0F;
        };
        auto* to = bytes.data() + std::size_t{z} * size * size;
        for (std::uint32_t y = 0; y < size; ++y) {
            for (std::uint32_t x = 0; x < size; ++x) {
                *to++ = byteOf(255.0 * bench::bubble(place(x), place(y), place(z)));
            }
        }
    });
}

/// The whole source as floats is held.
Status resample(const Options& options, Bytes& bytes) {
    NoProgress progress;
    const auto source = prep::openVolumeSource({}, options.input, progress);
    if (!source.ok()) return source.error();
    const auto& shape = (*source)->shape();
    std::vector<float> values(shape.voxels());
    MOTE_RETURN_IF_ERROR((*source)->read(0, shape.nz, values));
    const auto size = options.size;
    const double scale = 255.0 / (options.range[1] - options.range[0]);
    tbb::parallel_for(std::uint32_t{0}, size, [&](std::uint32_t z) {
        const auto at = [&](std::uint32_t i, std::uint32_t n) {
            return storage::between(storage::placeIn(i, size, n), n);
        };
        const auto az = at(z, shape.nz);
        for (std::uint32_t y = 0; y < size; ++y) {
            const auto ay = at(y, shape.ny);
            for (std::uint32_t x = 0; x < size; ++x) {
                const auto ax = at(x, shape.nx);
                const auto line = [&](std::uint32_t iy, std::uint32_t iz) {
                    const auto* row = values.data() + (std::size_t{iz} * shape.ny + iy) * shape.nx;
                    return row[ax.first] + ax.fraction * (row[ax.second] - row[ax.first]);
                };
                const auto plane = [&](std::uint32_t iz) {
                    const float front = line(ay.first, iz);
                    return front + ay.fraction * (line(ay.second, iz) - front);
                };
                const float below = plane(az.first);
                const float value = below + az.fraction * (plane(az.second) - below);
                bytes[(std::size_t{z} * size + y) * size + x] = byteOf((value - options.range[0]) * scale);
            }
        }
    });
    return success();
}

int write(const Options& options, const Bytes& bytes) {
    std::ofstream file(options.out, std::ios::binary);
    file << fmt::format(
        "NRRD0004\ntype: uint8\ndimension: 3\nsizes: {0} {0} {0}\nspacings: 1 1 1\nencoding: raw\n\n",
        options.size);
    file.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    return file.flush().good() ? 0 : 1;
}

}  // namespace

int main(int argc, char** argv) {
    Options options;
    const mote::cli::Program commandLine("Volumes for the measurements of hybrid volumes.",
                                         "bench-hybrid-data");
    const auto program = commandLine.command();
    program.option("--out", options.out, "The NRRD file to write").required();
    program.option("--size", options.size, "Samples a side; default 512").range(1, 4096);
    program.option("--resample", options.input, "A volume instead of the bubble");
    program.option("--range", options.range, "Its values that become 0 and 255").values(2);
    if (const auto end = commandLine.parse(argc, argv)) return *end;
    Bytes bytes(std::size_t{options.size} * options.size * options.size);
    if (options.input.empty()) {
        makeBubble(options.size, bytes);
    } else if (const auto made = resample(options, bytes); !made.ok()) {
        fmt::print(stderr, "{}\n", made.error().toString());
        return 1;
    }
    return write(options, bytes);
}
