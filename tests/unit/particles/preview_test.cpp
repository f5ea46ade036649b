// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>
#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/task_arena.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <set>

#include "preprocess/particles/column_coding.h"
#include "preprocess/particles/particles_job.h"
#include "preprocess/particles/preview_selection.h"
#include "protocol/scene/drawn_points.h"
#include "storage/particles/particle_columns.h"
#include "storage/verify.h"
#include "tests/support/beams.h"
#include "tests/support/memory_step.h"
#include "tests/support/temp_dir.h"
#include "tests/unit/particles/job_run.h"
#include "tests/unit/particles/quiet_progress.h"

namespace mote::prep {
namespace {

using storage::PreviewPoint;

bool same(std::span<const PreviewPoint> a, std::span<const PreviewPoint> b) {
    return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const auto& p, const auto& q) {
        return p.x == q.x && p.y == q.y && p.z == q.z && p.density == q.density;
    });
}

std::shared_ptr<const test::MemoryStep> beam(std::uint32_t leafCapacity) {
    test::BeamShape shape{.core = 30000, .halo = 5000, .filaments = 3000};
    shape.evenWeights = false;
    return test::MemoryStep::make(test::beam(shape), {.leafCapacity = leafCapacity, .maxLevel = 9});
}

template <class T>
std::vector<T> copyOf(std::span<const T> values) {
    return {values.begin(), values.end()};
}

void findDensities(Octree& tree) {
    tree.leafDensities = {};
    for (const double density : tree.leafDensity) {
        if (density > 0.0) tree.leafDensities = tree.leafDensities.united({density, density});
    }
}

PreviewSelection selectionOf(const Octree& tree) {
    return *PreviewSelection::make(tree, *singleProcess());
}

Octree octreeOf(const storage::ParticleStep& step) {
    const auto nodes = step.nodes();
    const auto leaves = step.leaves();
    Octree tree;
    tree.level = copyOf(nodes.level);
    tree.morton = copyOf(nodes.morton);
    tree.count = copyOf(nodes.count);
    tree.leafNode = copyOf(leaves.node);
    tree.leafPointBegin = copyOf(leaves.pointBegin);
    tree.leafPointCount = copyOf(leaves.pointCount);
    tree.leafDensity = copyOf(leaves.density);
    tree.leafCell.reserve(leaves.size());
    for (const auto node : leaves.node)
        tree.leafCell.push_back(cellCode(tree.morton[node], tree.level[node]));
    findDensities(tree);
    return tree;
}

/// As the job does it, `together` points at once: leaves come in pieces.
std::vector<PreviewCandidate> candidatesOf(const PreviewSelection& selection,
                                           const storage::ParticleStep& step, const Octree& tree,
                                           std::uint64_t together) {
    std::vector<PreviewCandidate> candidates;
    for (std::size_t leaf = 0; leaf < tree.leafNode.size(); ++leaf) {
        const std::uint64_t begin = tree.leafPointBegin[leaf];
        const std::uint64_t end = begin + tree.leafPointCount[leaf];
        for (auto at = begin; at < end;) {
            const auto next = std::min(end, (at / together + 1) * together);
            selection.add(leaf, static_cast<std::uint32_t>(at - begin), step.positions(at, next - at),
                          candidates);
            at = next;
        }
    }
    return candidates;
}

std::vector<PreviewCandidate> sorted(const PreviewSelection& selection,
                                     const std::vector<std::span<const PreviewCandidate>>& lists,
                                     std::size_t slice, std::size_t slices) {
    std::size_t size = 0;
    for (const auto& list : lists) size += list.size();
    std::vector<PreviewCandidate> all(size);
    selection.sort(lists, slice, slice + 1, slices, all);
    return all;
}

BuiltPreview build(const storage::ParticleStep& step, const Octree& tree, std::uint64_t together) {
    const auto selection = selectionOf(tree);
    const auto candidates = candidatesOf(selection, step, tree, together);
    const std::span all(candidates);
    const std::size_t half = all.size() / 2;
    return selection.preview(sorted(selection, {all.first(half), {}, all.subspan(half)}, 0, 1), 0);
}

/// Leaves of one point, of a few and of all.
TEST(Preview, IsWhatSortingAllPointsGives) {
    for (const std::uint32_t capacity : {1U, 20U, 100000U}) {
        SCOPED_TRACE(capacity);
        const auto step = beam(capacity);
        const auto expected = test::brutePreview(*step);
        ASSERT_EQ(expected.points.size(), 38000U / 4);
        const auto built = build(*step, octreeOf(*step), 1000);
        EXPECT_TRUE(same(built.points, expected.points));
        EXPECT_EQ(built.threshold, expected.threshold);
        EXPECT_EQ(built.threshold.size(), 3U);
    }
}

/// The slices of several ranks in turn, also where some hold nothing or nothing that is in the preview.
TEST(Preview, SlicesAreThoseOfTheWhole) {
    const auto step = beam(20);
    const auto tree = octreeOf(*step);
    const auto selection = selectionOf(tree);
    const auto whole = build(*step, tree, 1000);
    const auto candidates = candidatesOf(selection, *step, tree, 1000);
    for (const std::size_t slices : {1U, 2U, 3U, 7U, 50000U}) {
        SCOPED_TRACE(slices);
        std::vector<std::vector<PreviewCandidate>> of(slices);
        for (const auto& candidate : candidates)
            of[selection.sliceOf(candidate, slices)].push_back(candidate);
        BuiltPreview all;
        std::uint64_t before = 0;
        for (std::size_t slice = 0; slice < slices; ++slice) {
            const auto part = selection.preview(sorted(selection, {of[slice]}, slice, slices), before);
            EXPECT_EQ(part.first, all.points.size());
            all.points.insert(all.points.end(), part.points.begin(), part.points.end());
            all.threshold.insert(all.threshold.end(), part.threshold.begin(), part.threshold.end());
            before += of[slice].size();
        }
        EXPECT_TRUE(same(all.points, whole.points));
        EXPECT_EQ(all.threshold, whole.threshold);
    }
}

TEST(Preview, DoesNotDependOnTheThreads) {
    const auto step = beam(8);
    const auto tree = octreeOf(*step);
    const auto with = [&](int threads) {
        tbb::task_arena arena(threads);
        return arena.execute([&] { return build(*step, tree, 1U << 20); });
    };
    const tbb::global_control more(tbb::global_control::max_allowed_parallelism, 4);
    const auto one = with(1);
    const auto four = with(4);
    EXPECT_TRUE(same(one.points, four.points));
    EXPECT_EQ(one.threshold, four.threshold);
}

/// The first k points are those that some fraction draws: the numbers of points by leaf density agree with
/// drawnPoints at that fraction.
TEST(Preview, APrefixIsWhatAFractionDraws) {
    const auto step = beam(20);
    const auto preview = step->preview(storage::Preview::mostPoints);
    const auto nodes = step->nodes();
    const auto leaves = step->leaves();
    ASSERT_EQ(preview.threshold.size(), 3U);
    for (std::size_t block = 1; block < 3; ++block) {
        // Halfway to the neighbouring number, so that rounding to single precision does not count.
        const double fraction = preview.threshold[block];
        std::array<double, 16> drawn{};
        for (std::size_t leaf = 0; leaf < leaves.size(); ++leaf) {
            const auto node = leaves.node[leaf];
            const auto bin = static_cast<std::size_t>(15.0 * preview.scale.ofLeaf(leaves.density[leaf]));
            drawn[bin] +=
                drawnPoints(fraction, leaves.pointCount[leaf], nodes.level[node], nodes.morton[node]);
        }
        std::array<double, 16> shown{};
        for (const auto& point : preview.points.first(block * storage::Preview::blockPoints)) {
            ++shown[static_cast<std::size_t>(15.0 * point.density / 65535.0)];
        }
        // Points at the border of a bin, by the rounding of the density, and those at the very fraction.
        for (std::size_t bin = 0; bin < 16; ++bin) EXPECT_NEAR(shown[bin], drawn[bin], 2.0) << bin;
    }
}

TEST(Preview, OfFewPointsIsEmptyAndWithoutWeightAllZero) {
    for (const std::size_t points : {std::size_t{0}, std::size_t{1}, std::size_t{3}}) {
        const auto step =
            test::MemoryStep::make(std::vector<test::WeightedPoint>(points, {{0.3, 0.3, 0.3}, 1.0}));
        EXPECT_TRUE(step->preview(10).points.empty());
        if (points == 0) continue;
        EXPECT_TRUE(build(*step, octreeOf(*step), 10).points.empty());
    }
    const auto step = beam(1);
    auto tree = octreeOf(*step);
    tree.leafDensity.assign(tree.leafDensity.size(), 0.0F);
    findDensities(tree);
    const auto built = build(*step, tree, 1000);
    ASSERT_EQ(built.points.size(), 38000U / 4);
    EXPECT_TRUE(std::all_of(built.points.begin(), built.points.end(),
                            [](const auto& point) { return point.density == 0; }));
}

TEST(Preview, OfAJobIsThatOfItsStep) {
    const test::TempDir dir;
    auto columns = test::beamStep(30000, 4);
    // Leaves of density zero are no part of the scale.
    for (std::size_t i = 0; i < 3000; ++i) columns[Column::weight][i] = 0.0;
    test::FakeSource source({columns});
    proto::JobRequest request;
    request.mutable_particles()->add_inputs("fake.h5");
    for (const char* axis : {"x", "px", "y"}) request.mutable_particles()->add_axes(axis);
    request.mutable_particles()->set_leaf_capacity(4);
    test::QuietProgress progress;
    const auto manifest = runParticlesJob(request, source, {}, dir / "a.mote", {}, progress);
    ASSERT_TRUE(manifest.ok()) << manifest.error().toString();
    EXPECT_TRUE(storage::verifyDataset(dir / "a.mote").empty());
    const auto step = *storage::ParticleStep::open(dir / "a.mote", *manifest, 0);
    const auto expected = test::brutePreview(*step);
    const auto preview = step->preview(storage::Preview::mostPoints);
    EXPECT_EQ(preview.total, 7500U);
    EXPECT_TRUE(same(preview.points, expected.points));
    EXPECT_TRUE(std::equal(preview.threshold.begin(), preview.threshold.end(), expected.threshold.begin(),
                           expected.threshold.end()));
    EXPECT_EQ(preview.scale.min, expected.scale.min);
    EXPECT_EQ(preview.scale.max, expected.scale.max);
    EXPECT_TRUE(same(step->preview(100).points, std::span(expected.points).first(100)));
    EXPECT_EQ(step->preview(100).total, 7500U);
}

}  // namespace
}  // namespace mote::prep

namespace mote::test {
namespace {

// Columns of beams far from the origin: what is read back is held to the source's own doubles.

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

TEST_F(Columns, IdsAreFoundByOneOrderHoweverTheyLie) {
    constexpr std::size_t count = 30000;
    std::mt19937_64 random(11);
    std::vector<std::uint64_t> order(count);
    std::iota(order.begin(), order.end(), std::uint64_t{0});
    std::shuffle(order.begin(), order.end(), random);
    using Rule = std::uint64_t (*)(std::uint64_t);
    const std::array<Rule, 6> rules{
        [](std::uint64_t i) { return i + 1'000'000'000'000; },             // all of a range
        [](std::uint64_t i) { return 2 * i + 5; },                         // with gaps, in a table still
        [](std::uint64_t i) { return i * std::uint64_t{0x123456789ab}; },  // far apart, also beyond 2^63
        [](std::uint64_t i) { return i / 2; },                             // each twice
        [](std::uint64_t i) { return i == 7 ? 8 : i; },                    // one twice, one missing
        [](std::uint64_t i) { return i % 2 == 0 ? i : ~i; },               // at both ends of all numbers
    };
    for (std::size_t rule = 0; rule < rules.size(); ++rule) {
        auto step = farBeam(count, 0.0, 1e-6, 3);
        step.ids = {0, 1, ~std::uint64_t{0}};  // of the lost: no point has them
        for (const auto i : order) step.ids.push_back(rules[rule](i));
        const auto manifest = prepare(step);
        const auto columns = *storage::ParticleColumns::open(dataset(), manifest, 0);
        const auto ids = columns->ids(0, count);
        std::vector<std::uint32_t> should(count);
        std::iota(should.begin(), should.end(), 0U);
        std::ranges::stable_sort(should, {}, [&](std::uint32_t point) { return ids[point]; });
        EXPECT_TRUE(std::ranges::equal(columns->pointsById(0, count), should)) << rule;
    }
}

TEST(ColumnCoding, FloatsOfASourceStayFloats) {
    std::vector<double> values;
    values.reserve(10000);
    for (int i = 0; i < 5000; ++i)
        values.push_back(static_cast<double>(static_cast<float>(500.0 + 1e-5 * std::sin(i))));
    for (int i = 0; i < 5000; ++i) values.push_back(static_cast<double>(static_cast<float>(1e-9 * i)));
    const auto coding = prep::codingOf(values);
    EXPECT_FALSE(coding.doubles);
    for (const double value : values)
        ASSERT_EQ(coding.offset + static_cast<double>(static_cast<float>(value - coding.offset)), value);
}

TEST(ColumnCoding, IntegersStayExact) {
    std::vector<double> turns;
    turns.reserve(5000);
    for (int i = 0; i < 5000; ++i) turns.push_back(20'001.0 * i);  // to 10^8: floats step by 8 there
    EXPECT_TRUE(prep::codingOf(turns).doubles);
    for (double& turn : turns) turn = 4e9 + std::fmod(turn, 1000.0);
    const auto coding = prep::codingOf(turns);
    EXPECT_FALSE(coding.doubles);
    for (const double turn : turns)
        ASSERT_EQ(coding.offset + static_cast<double>(static_cast<float>(turn - coding.offset)), turn);
    for (double& turn : turns) turn = std::fmod(turn, 7.0);
    EXPECT_EQ(prep::codingOf(turns).offset, 0.0);
}

TEST(ColumnCoding, AHaloAndALatticeNeedNoDoubles) {
    std::vector<double> values;
    values.reserve(65536);
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
