// SPDX-License-Identifier: GPL-3.0-or-later
//
// Columns of beams far from the origin: what is read back is held to the source's own doubles.
#include "preprocess/particles/column_coding.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "storage/particles/particle_columns.h"
#include "storage/verify.h"
#include "tests/support/temp_dir.h"
#include "tests/unit/particles/fake_source.h"
#include "tests/unit/particles/job_run.h"

namespace mote::test {
namespace {

using prep::Column;

struct Moments {
    double mean = 0.0, sigma = 0.0;
};

Moments momentsOf(const std::vector<double>& values) {
    long double sum = 0.0L, squares = 0.0L;
    for (const double value : values) sum += static_cast<long double>(value);
    const long double mean = sum / static_cast<long double>(values.size());
    for (const double value : values) squares += (value - mean) * (value - mean);
    return {static_cast<double>(mean),
            static_cast<double>(std::sqrt(squares / static_cast<long double>(values.size())))};
}

/// A beam at `offset` in z, behind `lost` particles at 0 that are marked so.
FakeStep farBeam(std::size_t particles, double offset, double spread, std::size_t lost) {
    auto step = beamStep(particles + lost, 7);
    step.lost.assign(particles + lost, 0);
    for (std::size_t i = 0; i < particles + lost; ++i) {
        auto& z = step[Column::z][i];
        step.lost[i] = i < lost ? 1 : 0;
        z = i < lost ? 0.0 : offset + spread * z / 1e-3;
    }
    return step;
}

class Columns : public testing::Test {
  protected:
    /// All of a column of the step's points, in the order of the source's rows.
    std::vector<double> readBack(const std::string& name, const proto::Manifest& manifest) {
        const auto columns = storage::ParticleColumns::open(dataset(), manifest, 0);
        EXPECT_TRUE(columns.ok()) << columns.error().toString();
        std::vector<double> values((*columns)->pointCount());
        (*columns)->read((*columns)->find(name).value(), 0, values);
        return values;
    }
    proto::Manifest prepare(FakeStep step, prep::JobResources resources = {}) {
        FakeSource source({std::move(step)});
        std::filesystem::remove_all(dataset());
        const auto made = make(requestFor("x", "px", "y"), source, dataset(), resources);
        EXPECT_TRUE(made.ok()) << made.error().toString();
        return *made;
    }
    std::filesystem::path dataset() const { return folder_ / "a.mote"; }

    TempDir folder_;
};

TEST_F(Columns, HoldTheBeamWhereverItIsAndWhateverWasLost) {
    for (const double ratio : {0.0, 1.0, 1e3, 1e6, 1e9, 1e12}) {
        for (const std::size_t lost : {0, 1, 400}) {
            const double spread = 3e-6;
            const auto step = farBeam(3000, ratio * spread, spread, lost);
            std::vector<double> live(step[Column::z].begin() + static_cast<std::ptrdiff_t>(lost),
                                     step[Column::z].end());
            const auto manifest = prepare(step);
            auto got = readBack("z", manifest);
            ASSERT_EQ(got.size(), live.size());
            std::sort(got.begin(), got.end());
            std::sort(live.begin(), live.end());
            const double resolution = manifest.particles().steps(0).column_resolution(2);
            const double doubles = 4e-16 * ratio * spread;  // of the source itself
            EXPECT_LT(resolution, 1e-4 * spread + doubles) << ratio;
            for (std::size_t i = 0; i < got.size(); ++i)
                ASSERT_LE(std::abs(got[i] - live[i]), resolution) << ratio << " " << lost;
            const auto is = momentsOf(got), should = momentsOf(live);
            EXPECT_NEAR(is.sigma, should.sigma, 1e-6 * should.sigma) << ratio << " " << lost;
            EXPECT_NEAR(is.mean, should.mean, 1e-6 * should.sigma + doubles) << ratio << " " << lost;
        }
    }
}

TEST_F(Columns, TwoBunchesFarApartAreBothHeld) {
    auto step = farBeam(4000, 0.0, 1e-6, 0);
    for (std::size_t i = 0; i < 4000; i += 2) step[Column::z][i] += 1000.0;
    const auto manifest = prepare(step);
    EXPECT_EQ(manifest.particles().columns(2).type(), "f64");
    EXPECT_EQ(manifest.particles().columns(0).type(), "");
    auto got = readBack("z", manifest), should = step[Column::z];
    std::sort(got.begin(), got.end());
    std::sort(should.begin(), should.end());
    EXPECT_EQ(got, should);
    EXPECT_TRUE(storage::verifyDataset(dataset()).empty());
}

TEST_F(Columns, DoublesAreTheSameBytesForAnyMemory) {
    auto step = farBeam(400000, 0.0, 1e-6, 3);
    for (std::size_t i = 3; i < 400000; i += 2) step[Column::z][i] += 1000.0;
    prepare(step, {1, 0});
    const auto first = contentOf(dataset());
    prepare(step, {3, std::uint64_t{300} << 20});
    EXPECT_TRUE(contentOf(dataset()) == first);
}

TEST_F(Columns, WeightsAddUpAsInTheSource) {
    for (const bool one : {true, false}) {
        auto step = farBeam(2500, 0.0, 1e-6, 1);
        for (std::size_t i = 0; i < step[Column::weight].size(); ++i)
            step[Column::weight][i] = one ? 1e-9 / 3.0 : 0.1 + 1e-3 * static_cast<double>(i % 7);
        step[Column::weight][0] = 55.0;  // the lost one's
        auto should = step[Column::weight];
        should.erase(should.begin());
        auto got = readBack("weight", prepare(step));
        std::sort(got.begin(), got.end());
        std::sort(should.begin(), should.end());
        EXPECT_EQ(got, should);
    }
}

TEST(ColumnCoding, FloatsOfASourceStayFloats) {
    std::vector<double> values;
    for (int i = 0; i < 5000; ++i)
        values.push_back(static_cast<double>(static_cast<float>(500.0 + 1e-5 * std::sin(i))));
    for (int i = 0; i < 5000; ++i) values.push_back(static_cast<double>(static_cast<float>(1e-9 * i)));
    const auto coding = prep::codingOf(values);
    EXPECT_FALSE(coding.doubles);
    for (const double value : values)
        ASSERT_EQ(coding.offset + static_cast<double>(static_cast<float>(value - coding.offset)), value);
}

TEST(ColumnCoding, AHaloAndALatticeNeedNoDoubles) {
    std::vector<double> values;
    for (int i = 0; i < 65536; ++i) values.push_back(std::erf(1e-4 * i - 3.0) * std::exp(1e-4 * (i % 60000)));
    EXPECT_FALSE(prep::codingOf(values).doubles);
    for (int i = 0; i < 65536; ++i) values[static_cast<std::size_t>(i)] = 0.1 * (i % 64) + 0.05;
    EXPECT_FALSE(prep::codingOf(values).doubles);
    EXPECT_EQ(prep::codingOf(std::vector(100, 0.1)).offset, 0.1);
    EXPECT_EQ(prep::codingOf({}).offset, 0.0);
    EXPECT_EQ(prep::codingOf({std::nan(""), INFINITY}).offset, 0.0);
}

}  // namespace
}  // namespace mote::test
