// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/synth/tracker.h"

#include <algorithm>
#include <cmath>

#include "preprocess/synth/waterbag.h"

// The loops below are compiled for several instruction sets and the machine's best is taken. All give the
// same bits: only + - * / sqrt are used, and the build forbids their contraction (-ffp-contract=off). A
// sanitizer's runtime is not up yet when the choice is made, and clang words it differently: those builds
// take the plain loop.
#if defined(__x86_64__) && defined(__gnu_linux__) && defined(__GNUC__) && !defined(__clang__) && \
    !defined(__SANITIZE_THREAD__) && !defined(__SANITIZE_ADDRESS__)
#define MOTE_VECTOR_CLONES __attribute__((target_clones("avx512f", "avx2", "default")))
#else
#define MOTE_VECTOR_CLONES
#endif

namespace mote::prep {
namespace {

/// Rows that one pass over the stages takes along: six columns of it stay in the first-level cache.
constexpr std::size_t blockRows = 512;

/// Newton steps to the confocal coordinate. docs/SYNTH.md has the table of errors they leave.
constexpr int newtonSteps = 3;

struct BlockColumns {
    double* __restrict x;
    double* __restrict y;
    double* __restrict z;
    double* __restrict xs;
    double* __restrict ys;
    double* __restrict zs;
};

inline double polynomial(const double* c, double x) {
    static_assert(CoreKick::terms == 12);
    const double x2 = x * x, x4 = x2 * x2;
    const double low = (c[0] + c[1] * x) + (c[2] + c[3] * x) * x2;
    const double middle = (c[4] + c[5] * x) + (c[6] + c[7] * x) * x2;
    const double high = (c[8] + c[9] * x) + (c[10] + c[11] * x) * x2;
    return low + (middle + high * x4) * x4;
}

inline void mapPlane(const PlaneMap& map, double& u, double& slope) {
    const double there = map.uu * u + map.up * slope;
    slope = map.pu * u + map.pp * slope;
    u = there;
}

MOTE_VECTOR_CLONES
void runStage(const PlanStage& stage, const BlockColumns columns, std::size_t rows) {
    const ChannelMap map = stage.map;
    const CoreKick kick = stage.kick;
    const double aa = kick.squares[0], bb = kick.squares[1], cc = kick.squares[2];
    double* __restrict px = columns.x;
    double* __restrict py = columns.y;
    double* __restrict pz = columns.z;
    double* __restrict pxs = columns.xs;
    double* __restrict pys = columns.ys;
    double* __restrict pzs = columns.zs;
    for (std::size_t i = 0; i < rows; ++i) {
        double x = px[i], y = py[i], z = pz[i];
        double xs = pxs[i], ys = pys[i], zs = pzs[i];
        mapPlane(map[0], x, xs);
        mapPlane(map[1], y, ys);
        mapPlane(map[2], z, zs);

        // The confocal coordinate: Newton on 1 / sum with the sums over a common denominator, from the
        // greater of two lower bounds: r^2 - largest, good far away, and least (sum(0) - 1), good near the
        // core. Inside the core every step is negative and the maximum keeps it at 0.
        const double xx = x * x, yy = y * y, zz = z * z;
        const double near =
            xx * kick.leastOver[0] + yy * kick.leastOver[1] + zz * kick.leastOver[2] - kick.least;
        double lambda = std::max(std::max(xx + yy + zz - kick.largest, near), 0.0);
        for (int step = 0; step < newtonSteps; ++step) {
            const double a = aa + lambda, b = bb + lambda, c = cc + lambda;
            const double bc = b * c, ca = c * a, ab = a * b;
            const double whole = ab * c;
            const double sum = xx * bc + yy * ca + zz * ab;
            const double slope = xx * (bc * bc) + yy * (ca * ca) + zz * (ab * ab);
            // The smallest number keeps the origin from 0 / 0.
            lambda = std::max(lambda + sum * (sum - whole) / (slope + 1e-300), 0.0);
        }
        const double t = kick.scale / (kick.scale + lambda);
        const double factor = t * std::sqrt(t);
        const double argument = 2.0 * t - 1.0;
        px[i] = x;
        py[i] = y;
        pz[i] = z;
        pxs[i] = xs + x * factor * polynomial(kick.coefficients[0].data(), argument);
        pys[i] = ys + y * factor * polynomial(kick.coefficients[1].data(), argument);
        pzs[i] = zs + z * factor * polynomial(kick.coefficients[2].data(), argument);
    }
}

void runMap(const ChannelMap& map, const BlockColumns& columns, std::size_t rows) {
    for (std::size_t i = 0; i < rows; ++i) mapPlane(map[0], columns.x[i], columns.xs[i]);
    for (std::size_t i = 0; i < rows; ++i) mapPlane(map[1], columns.y[i], columns.ys[i]);
    for (std::size_t i = 0; i < rows; ++i) mapPlane(map[2], columns.z[i], columns.zs[i]);
}

}  // namespace

void startParticles(const ChannelPlan& plan, std::uint64_t seed, std::uint64_t first,
                    ParticleArrays& particles, std::size_t begin, std::size_t end) {
    // The waterbag has the rms sizes of the core, whose semi-axes are sqrt(5) rms, while its own edge is at
    // sqrt(8): its outer shell starts beyond the core. The mismatch scales sizes and keeps emittances.
    const double edge = std::sqrt(8.0 / 5.0);
    std::array<double, 3> size{}, divergence{}, tilt{};
    for (std::size_t plane = 0; plane < 3; ++plane) {
        const double axis = plan.matched.axes[plane] * plan.design.mismatch[plane];
        const double slope = plan.matched.slopes[plane] * plan.design.mismatch[plane];
        size[plane] = edge * axis;
        divergence[plane] = edge * plan.emittance[plane] / axis;
        tilt[plane] = edge * slope;
    }
    for (std::size_t row = begin; row < end; ++row) {
        const auto point = waterbagPoint(seed, first + row);
        for (std::size_t plane = 0; plane < 3; ++plane) {
            particles.position[plane][row] = size[plane] * point[plane][0];
            particles.slope[plane][row] = tilt[plane] * point[plane][0] + divergence[plane] * point[plane][1];
        }
    }
}

void trackParticles(const PlanDump& dump, ParticleArrays& particles, std::size_t begin, std::size_t end) {
    for (std::size_t row = begin; row < end; row += blockRows) {
        const std::size_t rows = std::min(blockRows, end - row);
        const BlockColumns columns{particles.position[0].data() + row, particles.position[1].data() + row,
                                   particles.position[2].data() + row, particles.slope[0].data() + row,
                                   particles.slope[1].data() + row,    particles.slope[2].data() + row};
        for (const PlanStage& stage : dump.stages) runStage(stage, columns, rows);
        runMap(dump.last, columns, rows);
    }
}

}  // namespace mote::prep
