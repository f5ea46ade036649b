// SPDX-License-Identifier: GPL-3.0-or-later
//
// Files that other people's programs wrote, against what is known of them from elsewhere: the attributes
// beside the data, the lists of their contents, and the physics of the machine.
#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <set>

#include "preprocess/readers/field_meaning.h"
#include "tests/unit/readers/source_test.h"

namespace mote::test {
namespace {

using prep::Column;
using RealFiles = SourceTest;

const std::filesystem::path particles = std::filesystem::path(MOTE_SHARED_DATA) / "particles";

#define MOTE_NEEDS(path) \
    if (!std::filesystem::exists(path)) GTEST_SKIP() << "the real file is not here"

struct Range {
    double least, greatest;
};

Range rangeOf(const std::vector<double>& values) {
    const auto [least, greatest] = std::minmax_element(values.begin(), values.end());
    return {*least, *greatest};
}

/// The lists of contents have six digits.
void expectRange(const std::vector<double>& values, double least, double greatest) {
    const Range range = rangeOf(values);
    EXPECT_NEAR(range.least, least, 1e-5 * std::abs(least));
    EXPECT_NEAR(range.greatest, greatest, 1e-5 * std::abs(greatest));
}

double sum(const std::vector<double>& values) {
    return std::accumulate(values.begin(), values.end(), 0.0);
}

TEST_F(RealFiles, astraScreens) {
    MOTE_NEEDS(particles / "astra_particles.h5");
    MOTE_OPEN(source, {particles / "astra_particles.h5"}, progress);
    EXPECT_EQ(source->format(), "openpmd");
    EXPECT_EQ(source->mass(), prep::electronMass);
    ASSERT_EQ(source->steps().size(), 2u);
    const double place[] = {0.50013, 1.0001}, time[] = {2.0826e-9, 4.0157e-9};
    const double behind[] = {-0.0043699, -0.0043713}, ahead[] = {0.0039985, 0.0039975};
    for (std::size_t step = 0; step < 2; ++step) {
        EXPECT_EQ(source->steps()[step].iteration, static_cast<std::int64_t>(step));
        ASSERT_EQ(source->steps()[step].particles, 998u);
        EXPECT_NEAR(source->steps()[step].time, time[step], 1e-5 * time[step]);
        expectRange(column(*source, step, Column::z), behind[step] + place[step], ahead[step] + place[step]);
        expectRange(column(*source, step, Column::t), time[step] - 1.6379e-11, time[step] + 1.5948e-11);
        const auto chunk = chunkOf(*source, step, {Column::weight});
        EXPECT_EQ(std::count(chunk.lost.begin(), chunk.lost.end(), 1), 6);
        // The file's attributes totalCharge and chargeLive; 998 roundings.
        EXPECT_NEAR(sum(chunk[Column::weight]), 9.989979999999996e-11, 1e-22);
        double live = 0.0;
        for (std::size_t i = 0; i < 998; ++i) live += chunk.lost[i] == 0 ? chunk[Column::weight][i] : 0.0;
        EXPECT_NEAR(live, 9.929919999999996e-11, 1e-22);
    }
    expectRange(column(*source, 0, Column::px), -3734.3, 3658.8);
    expectRange(column(*source, 0, Column::pz), 872110.0 - 14.589, 872110.0 + 2.8457);
}

TEST_F(RealFiles, bmadBeam) {
    MOTE_NEEDS(particles / "bmad_particles.h5");
    MOTE_OPEN(source, {particles / "bmad_particles.h5"}, progress);
    ASSERT_EQ(source->steps().size(), 1u);
    EXPECT_EQ(source->steps()[0].iteration, 1);
    ASSERT_EQ(source->steps()[0].particles, 10'000u);
    EXPECT_EQ(source->mass(), prep::electronMass);
    // minValue and maxValue in the file, to the digits of the list.
    expectRange(column(*source, 0, Column::px), -70872.29835722, 69789.8645451);
    expectRange(column(*source, 0, Column::py), -61176.63207432, 58895.42954708);
    expectRange(column(*source, 0, Column::pz), 41995952.19566412, 41997764.49278675);
    expectRange(column(*source, 0, Column::y), -0.000250561, 0.000255723);
    expectRange(column(*source, 0, Column::z), 0.0, 0.0);
    EXPECT_NEAR(sum(column(*source, 0, Column::weight)), 7.7e-11, 1e-21) << "the file's totalCharge";
    const auto chunk = chunkOf(*source, 0, {});
    EXPECT_EQ(std::count(chunk.lost.begin(), chunk.lost.end(), 1), 0);
}

TEST_F(RealFiles, picongpuWake) {
    MOTE_NEEDS(particles / "picongpu_lwfa_000550.h5");
    MOTE_OPEN(source, {particles / "picongpu_lwfa_000550.h5"}, progress);
    ASSERT_EQ(source->steps().size(), 1u);
    EXPECT_EQ(source->steps()[0].iteration, 550);
    EXPECT_DOUBLE_EQ(source->steps()[0].time, 550 * 1.39e-16);
    ASSERT_EQ(source->steps()[0].particles, 35'915u);
    // Single precision in the file: 1.5e-7.
    EXPECT_NEAR(source->mass(), prep::electronMass, 2e-7 * prep::electronMass);
    // 56 x 64 x 32 cells; the list has the ends of the place in a cell (0 to 1) and of the cells.
    const struct {
        Column column;
        double cell, cells;
    } axes[] = {{Column::x, 1.7719999774007647e-07, 56},
                {Column::y, 4.429999943501912e-08, 64},
                {Column::z, 1.7719999774007647e-07, 32}};
    for (const auto& axis : axes) {
        const Range range = rangeOf(column(*source, 0, axis.column));
        EXPECT_GE(range.least, 0.0);
        EXPECT_LT(range.least, axis.cell);
        EXPECT_LE(range.greatest, axis.cells * axis.cell);
        EXPECT_GT(range.greatest, (axis.cells - 1) * axis.cell);
    }
    expectRange(column(*source, 0, Column::weight), 2833.82, 2920.87);
    // The greatest momentum of a macro-particle, over the least and the greatest weight.
    const double unit = 1.8993752580145115e-18 * prep::speedOfLight / prep::elementaryCharge;
    const double greatest = rangeOf(column(*source, 0, Column::px)).greatest;
    EXPECT_LE(greatest, 0.1405075 * unit / 2833.815);
    EXPECT_GE(greatest, 0.1405065 * unit / 2920.875);
    EXPECT_FALSE(source->has(Column::t));
    EXPECT_FALSE(source->has(Column::id));
}

class ImpactLinac : public testing::Test {
  protected:
    void SetUp() override {
        MOTE_NEEDS(folder);
        std::vector<std::filesystem::path> files;
        for (int i = 113; i >= 101; --i) files.push_back(folder / ("fort." + std::to_string(i) + ".txt.gz"));
        auto opened = openFiles(files, progress);
        ASSERT_TRUE(opened.ok()) << opened.error().toString();
        source = std::move(opened).value();
        ASSERT_EQ(source->steps().size(), 13u);
    }

    const std::filesystem::path folder = particles / "impactz_dtl_20k";
    NoteKeeper progress;
    std::unique_ptr<prep::ParticleSource> source;
};

TEST_F(ImpactLinac, losesParticlesOnTheWay) {
    std::vector<std::uint64_t> counts;
    for (std::size_t i = 0; i < 13; ++i) {
        EXPECT_EQ(source->steps()[i].iteration, static_cast<std::int64_t>(101 + i));
        counts.push_back(source->steps()[i].particles);
    }
    EXPECT_THAT(counts, testing::ElementsAre(20000, 20000, 20000, 19970, 19892, 19427, 18363, 18358, 18358,
                                             18358, 18358, 18358, 18358));
    const auto first = chunkOf(*source, 0, {Column::id}).id;
    const auto last = chunkOf(*source, 12, {Column::id}).id;
    const std::set<std::uint64_t> started(first.begin(), first.end()), arrived(last.begin(), last.end());
    EXPECT_EQ(started.size(), 20'000u);
    EXPECT_EQ(arrived.size(), 18'358u) << "each id once";
    EXPECT_TRUE(std::includes(started.begin(), started.end(), arrived.begin(), arrived.end()));
    // 0.03 A at 324 MHz, shared by 20 000.
    EXPECT_NEAR(sum(column(*source, 0, Column::weight)), 0.03 / 324e6, 1e-20);
}

TEST_F(ImpactLinac, gainsTheEnergyOfItsReferenceParticle) {
    const double mass = source->mass();
    EXPECT_EQ(mass, 939.29432e6);
    double before = 0.0;
    for (std::size_t step = 0; step < 13; ++step) {
        const auto px = column(*source, step, Column::px), py = column(*source, step, Column::py),
                   pz = column(*source, step, Column::pz);
        double mean = 0.0;
        for (std::size_t i = 0; i < px.size(); ++i) {
            const double p2 = px[i] * px[i] + py[i] * py[i] + pz[i] * pz[i];
            mean += p2 / (std::sqrt(p2 + mass * mass) + mass) / static_cast<double>(px.size());
        }
        EXPECT_GT(mean, before - 20e3) << "step " << step;
        before = mean;
        // fort.18 begins with 3.35176 MeV and ends with 4.64071 MeV. The bunch oscillates about its reference
        // particle: its mean of column 6 is below 1.1e-5 of the rest energy, 11 keV.
        if (step == 0) {
            EXPECT_NEAR(mean, 3.35176e6, 11e3);
        }
        if (step == 12) {
            EXPECT_NEAR(mean, 4.64071e6, 11e3);
        }
    }
}

TEST_F(ImpactLinac, staysWithinItsPipeAndMovesOn) {
    for (std::size_t step = 0; step < 13; ++step) {
        const auto x = column(*source, step, Column::x), y = column(*source, step, Column::y);
        double radius = 0.0;
        for (std::size_t i = 0; i < x.size(); ++i) radius = std::max(radius, std::hypot(x[i], y[i]));
        // The deck's greatest aperture: 11 mm.
        EXPECT_LT(radius, 0.011) << "step " << step;
        EXPECT_GT(radius, 0.001) << "step " << step;
        // A bunch is shorter than the way that it goes in one period of 324 MHz, beta c / f.
        const Range z = rangeOf(column(*source, step, Column::z));
        EXPECT_LT(z.greatest - z.least, 0.1 * prep::speedOfLight / 324e6);
        if (step > 0) {
            EXPECT_GT(source->steps()[step].time, source->steps()[step - 1].time);
        }
    }
    // 0.950 m, at 0.0843 to 0.0992 of the speed of light (fort.18).
    const double duration = source->steps()[12].time - source->steps()[0].time;
    EXPECT_GT(duration, 0.950 / (0.0992 * prep::speedOfLight));
    EXPECT_LT(duration, 0.951 / (0.0842 * prep::speedOfLight));
}

}  // namespace
}  // namespace mote::test
