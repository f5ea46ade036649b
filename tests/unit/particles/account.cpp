// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/unit/particles/account.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "preprocess/particles/step_reader.h"
#include "protocol/scene/step_range.h"
#include "storage/manifest.h"
#include "storage/particles/particle_step.h"
#include "tests/unit/particles/quiet_progress.h"

namespace mote::test {
namespace {

struct Expected {
    std::array<std::vector<double>, 3> unit;  ///< 0 to 1 in the box, by row; not finite where left out
    std::vector<double> weight;               ///< by row
    std::uint64_t lost = 0, invalid = 0, outside = 0, inside = 0;
};

Expected expectedOf(prep::ParticleSource& source, std::size_t step, const prep::PlotAxes& axes,
                    const proto::ParticlesManifest& manifest) {
    Expected expected;
    QuietProgress progress;
    const auto loaded = loadStep(source, step, axes, progress);
    const std::size_t rows = source.steps()[step].particles;
    for (auto& unit : expected.unit) unit.assign(rows, NAN);
    expected.weight.assign(rows, 0.0);
    expected.lost = loaded.lost;
    expected.invalid = loaded.invalid;
    for (std::size_t i = 0; i < loaded.size(); ++i) {
        std::array<double, 3> unit{};
        bool inside = true;
        for (std::size_t a = 0; a < 3; ++a) {
            const auto& axis = manifest.axes(static_cast<int>(a));
            unit[a] = (loaded.coordinate[a][i] - axis.min()) / (axis.max() - axis.min());
            inside = inside && unit[a] >= 0.0 && unit[a] <= 1.0;
        }
        ++(inside ? expected.inside : expected.outside);
        if (!inside) continue;
        for (std::size_t a = 0; a < 3; ++a) expected.unit[a][loaded.row[i]] = unit[a];
        expected.weight[loaded.row[i]] = loaded.weight[i];
    }
    EXPECT_EQ(expected.lost + expected.invalid + expected.outside + expected.inside, rows);
    return expected;
}

std::array<double, 3> cellOf(std::uint64_t morton, unsigned level) {
    std::array<double, 3> cell{};
    for (unsigned bit = 0; bit < 3 * level; ++bit) {
        if (morton >> bit & 1) cell[bit % 3] += std::ldexp(1.0, static_cast<int>(bit / 3));
    }
    return cell;
}

void expectPoints(const storage::ParticleStep& step, const Expected& expected) {
    const auto nodes = step.nodes();
    const auto leaves = step.leaves();
    std::vector<std::uint8_t> seen(expected.weight.size());
    std::size_t misplaced = 0;
    for (std::size_t leaf = 0; leaf < leaves.size(); ++leaf) {
        const unsigned level = nodes.level[leaves.node[leaf]];
        const auto cell = cellOf(nodes.morton[leaves.node[leaf]], level);
        const double edge = std::ldexp(1.0, -static_cast<int>(level));
        const auto positions = step.positions(leaves.pointBegin[leaf], leaves.pointCount[leaf]);
        const auto rows = step.rows(leaves.pointBegin[leaf], leaves.pointCount[leaf]);
        double weight = 0.0;
        for (std::size_t i = 0; i < rows.size(); ++i) {
            ASSERT_LT(rows[i], seen.size());
            ++seen[rows[i]];
            weight += expected.weight[rows[i]];
            const std::array<double, 3> packed{1.0 * positions[i].x, 1.0 * positions[i].y,
                                               1.0 * positions[i].z};
            for (std::size_t a = 0; a < 3; ++a) {
                const double decoded = (cell[a] + (packed[a] + 0.5) / 65536.0) * edge;
                if (!(std::abs(decoded - expected.unit[a][rows[i]]) <= edge / 65536.0)) ++misplaced;
            }
        }
        // Doubles summed in another order, then single precision: 2^-24 and a little.
        const double density = weight * std::pow(8.0, level);
        ASSERT_NEAR(leaves.density[leaf], density, 1e-6 * density);
    }
    EXPECT_EQ(misplaced, 0U);
    for (std::size_t row = 0; row < seen.size(); ++row) {
        ASSERT_EQ(seen[row], std::isfinite(expected.unit[0][row]) ? 1 : 0) << "row " << row;
    }
}

void expectVolume(const storage::ParticleStep& step, const Expected& expected) {
    const std::size_t size = step.volumeSize();
    std::vector<double> sums(size * size * size);
    for (std::size_t row = 0; row < expected.weight.size(); ++row) {
        if (!std::isfinite(expected.unit[0][row])) continue;
        std::array<std::size_t, 3> cell{};
        for (std::size_t a = 0; a < 3; ++a) {
            cell[a] = std::min(size - 1,
                               static_cast<std::size_t>(expected.unit[a][row] * static_cast<double>(size)));
        }
        sums[(cell[2] * size + cell[1]) * size + cell[0]] += expected.weight[row];
    }
    const double cells = static_cast<double>(sums.size());
    for (std::size_t i = 0; i < sums.size(); ++i) {
        ASSERT_NEAR(step.volume()[i], sums[i] * cells, 1e-6 * sums[i] * cells) << "cell " << i;
    }
}

void expectMinDensities(const storage::OctreeNodes& nodes) {
    std::vector<float> least(nodes.size());
    for (std::size_t i = nodes.size(); i-- > 0;) {
        least[i] = nodes.density[i];
        if (nodes.childCount[i] > 0) {
            const auto first = least.begin() + nodes.firstChild[i];
            least[i] = *std::min_element(first, first + nodes.childCount[i]);
        }
        ASSERT_EQ(nodes.minDensity[i], least[i]);
    }
}

void expectEntry(const proto::ParticleStepEntry& entry, const storage::ParticleStep& step,
                 const Expected& expected) {
    EXPECT_EQ(entry.particles(), expected.inside);
    EXPECT_EQ(entry.lost(), expected.lost);
    EXPECT_EQ(entry.invalid(), expected.invalid);
    EXPECT_EQ(entry.outside(), expected.outside);
    const double weight = std::accumulate(expected.weight.begin(), expected.weight.end(), 0.0);
    EXPECT_NEAR(entry.total_weight(), weight, 1e-9 * weight);
    std::vector<std::uint64_t> histogram(128);
    const auto leaves = step.leaves();
    for (std::size_t i = 0; i < leaves.size(); ++i) {
        const double t = leaves.density[i] > 0.0F ? step.logDensity().ofLeaf(leaves.density[i]) : 0.0;
        histogram[std::min<std::size_t>(127, static_cast<std::size_t>(t * 128.0))] += leaves.pointCount[i];
    }
    EXPECT_TRUE(std::equal(histogram.begin(), histogram.end(), entry.density_histogram().begin(),
                           entry.density_histogram().end()));
}

/// Of each leaf, the density of the smallest cell around it that holds 64 particles, or of the plot.
std::vector<double> toldDensities(const storage::OctreeNodes& nodes) {
    std::vector<double> told;
    for (std::size_t leaf = 0; leaf < nodes.size(); ++leaf) {
        if (nodes.childCount[leaf] != 0 || !(nodes.density[leaf] > 0.0F)) continue;
        std::size_t node = 0, best = 0;
        while (nodes.childCount[node] != 0) {
            const unsigned down = nodes.level[leaf] - nodes.level[node] - 1U;
            const auto wanted = nodes.morton[leaf] >> (3 * down);
            for (std::size_t child = nodes.firstChild[node], last = child + nodes.childCount[node];
                 child < last; ++child) {
                if (nodes.morton[child] == wanted) node = child;
            }
            if (nodes.count[node] >= 64) best = node;
        }
        told.push_back(nodes.density[best]);
    }
    return told;
}

}  // namespace

void expectAccounted(const std::filesystem::path& dataset, const proto::ParticlesJob& job,
                     prep::ParticleSource& source) {
    const auto manifest = storage::readManifest(dataset);
    ASSERT_TRUE(manifest.ok()) << manifest.error().toString();
    prep::PlotAxes axes;
    for (int i = 0; i < 3; ++i)
        axes.at(static_cast<std::size_t>(i)) = *prep::PlotAxis::make(job.axes(i), source);
    const auto steps = *selectSteps(job.steps(), source.steps().size());
    ASSERT_EQ(static_cast<std::size_t>(manifest->particles().steps_size()), steps.size());
    double least = INFINITY;
    double greatest = 0.0;
    for (std::size_t i = 0; i < steps.size(); ++i) {
        SCOPED_TRACE(testing::Message() << "step " << steps[i]);
        const auto opened = storage::ParticleStep::open(dataset, *manifest, static_cast<std::uint32_t>(i));
        ASSERT_TRUE(opened.ok()) << opened.error().toString();
        const auto expected = expectedOf(source, steps[i], axes, manifest->particles());
        expectPoints(**opened, expected);
        expectVolume(**opened, expected);
        expectMinDensities((*opened)->nodes());
        expectEntry(manifest->particles().steps(static_cast<int>(i)), **opened, expected);
        for (const double density : toldDensities((*opened)->nodes())) {
            if (density > 0.0) least = std::min(least, density);
            greatest = std::max(greatest, density);
        }
    }
    EXPECT_EQ(manifest->particles().density_min(), least);
    EXPECT_EQ(manifest->particles().density_max(), greatest);
}

}  // namespace mote::test
