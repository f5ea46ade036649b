// SPDX-License-Identifier: GPL-3.0-or-later
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <mutex>
#include <numeric>
#include <random>

#include "preprocess/job.h"
#include "preprocess/stipple/periodic_triangulation.h"
#include "preprocess/stipple/stipple_job.h"
#include "preprocess/stipple/thinning.h"
#include "server/render/layers/stipple/replay.h"
#include "storage/manifest.h"
#include "storage/stipple/stipple_hierarchy.h"
#include "storage/verify.h"
#include "tests/support/plane_measures.h"
#include "tests/support/temp_dir.h"

namespace mote::test {

/// Remembers what a job reports, checks that it never falls, and can ask it to stop. A value of
/// one test; any thread may report.
class TestProgress final : public prep::Progress {
  public:
    void report(double fraction, std::string_view) override {
        const std::lock_guard lock(mutex_);
        EXPECT_GE(fraction, 0.0);
        EXPECT_LE(fraction, 1.0);
        fraction_ = fraction;
    }
    void note(std::string_view) override {}
    bool cancelled() const override {
        const std::lock_guard lock(mutex_);
        return fraction_ >= limit_;
    }
    /// Asks to stop from that share of the work on.
    void cancelAt(double fraction) { limit_ = fraction; }

  private:
    mutable std::mutex mutex_;
    double fraction_ = 0.0;
    double limit_ = 2.0;
};

}  // namespace mote::test

namespace mote::prep {
namespace {

using test::measurePlane;
using test::PlaneMeasures;

storage::StippleHierarchy hierarchyOf(std::uint32_t points, std::uint64_t seed,
                                      const ThinningOptions& options = thinningOptions({})) {
    test::TestProgress progress;
    const auto start = evenPoints(points, seed, 0.5, progress);
    auto made = thinPlane(*start, options, 0.5, progress);
    EXPECT_TRUE(made.ok());
    return *std::move(made);
}

/// The points that replay draws where this share is wanted everywhere.
std::vector<glm::dvec2> drawn(const render::StippleReplay& replay, double share) {
    std::vector<glm::dvec2> points;
    for (const auto& placed :
         replay.place(replay.select(std::vector<float>(replay.size(), static_cast<float>(share))))) {
        points.emplace_back(placed.position.x, placed.position.y);
    }
    return points;
}

/// The bars of docs/STIPPLES.md.
bool meetsBars(const PlaneMeasures& m) {
    return m.rho >= 0.65 && m.nearest >= 0.86 && m.energy <= 1.05 && m.areaCv <= 0.085 &&
           m.lowEnergy <= 0.013;
}

void printTo(const PlaneMeasures& m, std::ostream& out) {
    out << "rho " << m.rho << " NN " << m.nearest << " E " << m.energy << " areaCV " << m.areaCv << " lowE "
        << m.lowEnergy;
}

TEST(Thinning, EveryLevelIsAsEvenAsItMustBe) {
    constexpr std::uint32_t points = 2500;
    for (const std::uint64_t seed : {1U, 2U, 3U}) {
        const render::StippleReplay replay(hierarchyOf(points, seed));
        for (const double level : {1.0, 0.95, 0.8, 0.65, 0.5, 0.35, 0.2, 0.1}) {
            const auto dots = drawn(replay, level);
            EXPECT_EQ(dots.size(), static_cast<std::size_t>(std::lround(level * points)));
            const auto measures = measurePlane(dots);
            EXPECT_TRUE(meetsBars(measures))
                << "seed " << seed << " level " << level << " " << (printTo(measures, std::cerr), "");
        }
    }
}

// Its least distance alone is no worse: nobody comes closer when others go.
TEST(Thinning, AStaticHierarchyIsNotEven) {
    const render::StippleReplay replay(hierarchyOf(2500, 1, {0, 1.0}));
    for (const double level : {0.8, 0.5, 0.2}) {
        const auto measures = measurePlane(drawn(replay, level));
        EXPECT_LT(measures.nearest, 0.86);
        EXPECT_GT(measures.energy, 1.05);
        EXPECT_GT(measures.areaCv, 0.085);
        EXPECT_GT(measures.lowEnergy, 0.013);
    }
}

/// Where a point lies once the first `removed` of the order are gone.
glm::dvec2 positionAfter(const storage::StippleHierarchy& h, std::uint32_t point, std::uint32_t removed) {
    auto at = h.positions[point];
    for (auto m = h.movesBegin[point]; m < h.movesBegin[point + 1]; ++m) {
        if (h.removal[h.moveNeighbour[m]] < removed) at = h.movePosition[m];
    }
    return {at.x, at.y};
}

TEST(Thinning, RemovesTheSmallestCellAndKnowsTheLargest) {
    // The whole story of a hierarchy again, with cells that are found by clipping.
    constexpr std::uint32_t points = 150;
    const auto h = hierarchyOf(points, 9);
    ASSERT_TRUE(storage::checkHierarchy(h).ok());
    std::vector<std::uint32_t> order(points);
    for (std::uint32_t i = 0; i < points; ++i) order[h.removal[i]] = i;
    std::vector<double> largest(points, 0.0);
    for (std::uint32_t removed = 0; removed < points; ++removed) {
        std::vector<glm::dvec2> positions;
        for (auto i = removed; i < points; ++i) positions.push_back(positionAfter(h, order[i], removed));
        const auto cells = test::voronoiCells(positions);
        double smallest = 1.0;
        for (auto i = removed; i < points; ++i) {
            const double area = cells[i - removed].area;
            largest[order[i]] = std::max(largest[order[i]], area);
            smallest = std::min(smallest, area);
        }
        // Positions are rounded to floats, 6e-8, and a cell's area changes with each of its corners by about
        // its diameter, at most 1.5, times that; some ten of them.
        EXPECT_NEAR(cells[0].area, smallest, 1e-6) << removed;
    }
    for (std::uint32_t i = 0; i < points; ++i) EXPECT_NEAR(h.deathArea[i], largest[i], 1e-6);
}

TEST(Thinning, MovesAreShortAndFew) {
    constexpr std::uint32_t points = 2500;
    const auto h = hierarchyOf(points, 4);
    // Euler: six neighbours and twelve in the second ring of the mean point; fewer at the end, when rings
    // meet around the square.
    EXPECT_LT(h.moveNeighbour.size(), std::size_t{18} * points);
    EXPECT_GT(h.moveNeighbour.size(), std::size_t{15} * points);
    for (std::uint32_t i = 0; i < points; ++i) {
        auto last = h.positions[i];
        for (auto m = h.movesBegin[i]; m < h.movesBegin[i + 1]; ++m) {
            const double left = points - h.removal[h.moveNeighbour[m]];
            const glm::vec3 step = h.movePosition[m] - last;
            last = h.movePosition[m];
            // The bar, in mean distances of the points that are left.
            EXPECT_TRUE(left < 30 || std::hypot(step.x, step.y) * std::sqrt(left) < 0.4) << left << " left";
        }
    }
}

TEST(Thinning, ReplayTakesFewBytes) {
    const auto h = hierarchyOf(2500, 4);
    // The bar: 120 bytes a point, what the dissertation needed.
    EXPECT_LT(render::StippleReplay(h).bytes(), std::size_t{120} * 2500);
}

TEST(Thinning, OneTwoAndThreePoints) {
    for (std::uint32_t points = 1; points <= 12; ++points) {
        const auto h = hierarchyOf(points, 1);
        ASSERT_EQ(h.size(), points);
        EXPECT_TRUE(storage::checkHierarchy(h).ok());
        // Who is left last has the whole square.
        EXPECT_NEAR(*std::max_element(h.deathArea.begin(), h.deathArea.end()), 1.0, 1e-6);
    }
}

TEST(Thinning, OneRingMovesTheNeighboursOnly) {
    const auto h = hierarchyOf(600, 2, {1, 1.0});
    EXPECT_LT(h.moveNeighbour.size(), 6U * 600U);
    EXPECT_GT(h.moveNeighbour.size(), 5U * 600U);
}

TEST(Thinning, CanBeCancelled) {
    test::TestProgress progress;
    const auto start = stratifiedPoints(3000, 1);
    progress.cancelAt(0.5);
    const auto made = thinPlane(start, thinningOptions({}), 0.0, progress);
    ASSERT_FALSE(made.ok());
    EXPECT_EQ(made.error().code, ErrorCode::cancelled);
    EXPECT_EQ(evenPoints(100, 1, 0.5, progress).error().code, ErrorCode::cancelled);
}

TEST(PlaneStart, StratifiedPointsAreOneInEachBox) {
    for (const std::uint32_t points : {1U, 2U, 3U, 7U, 100U, 1001U}) {
        const auto made = stratifiedPoints(points, 3);
        ASSERT_EQ(made.size(), points);
        for (const auto& point : made) {
            EXPECT_TRUE(point.x > 0.0 && point.x < 1.0 && point.y > 0.0 && point.y < 1.0);
        }
    }
    EXPECT_EQ(stratifiedPoints(100, 3), stratifiedPoints(100, 3));
    EXPECT_NE(stratifiedPoints(100, 3), stratifiedPoints(100, 4));
}

TEST(PlaneStart, RelaxingOnceGoesToTheCentroids) {
    const auto points = stratifiedPoints(500, 8);
    const auto cells = test::voronoiCells(points);
    const auto relaxed = relaxOnce(points, 1.5);
    for (std::size_t i = 0; i < points.size(); ++i) {
        const auto expected = points[i] + 1.5 * cells[i].centroid;
        // The grid of 2^-40, and ten roundings of numbers of order 1.
        EXPECT_NEAR(relaxed[i].x, expected.x, 1e-10);
        EXPECT_NEAR(relaxed[i].y, expected.y, 1e-10);
    }
}

TEST(AreaQueue, GivesTheSmallestWhateverChanges) {
    std::mt19937 random(3);
    std::vector<double> areas(300);
    // Few values, so that there are equals.
    for (auto& area : areas) area = random() % 40;
    AreaQueue queue(areas);
    std::vector<std::uint32_t> left(areas.size());
    for (std::uint32_t i = 0; i < left.size(); ++i) left[i] = i;
    while (!left.empty()) {
        ASSERT_FALSE(queue.empty());
        for (int i = 0; i < 5; ++i) {
            const auto point = left[random() % left.size()];
            areas[point] = random() % 40;
            queue.update(point, areas[point]);
            EXPECT_EQ(queue.area(point), areas[point]);
        }
        const auto smallest = std::min_element(left.begin(), left.end(), [&](auto a, auto b) {
            return areas[a] < areas[b] || (areas[a] == areas[b] && a < b);
        });
        ASSERT_EQ(queue.smallest(), *smallest);
        queue.removeSmallest();
        left.erase(smallest);
    }
    EXPECT_TRUE(queue.empty());
}

std::vector<glm::dvec2> whiteNoise(std::size_t count, unsigned seed) {
    std::mt19937_64 random(seed);
    std::uniform_real_distribution<double> uniform;
    std::vector<glm::dvec2> points(count);
    for (auto& point : points) point = {uniform(random), uniform(random)};
    return points;
}

PlaneCell cellOf(PeriodicTriangulation& triangulation, std::uint32_t point) {
    for (int i = 0; i < 8; ++i) {
        if (const auto cell = triangulation.cell(point)) return *cell;
        triangulation.widen();
    }
    ADD_FAILURE() << "the widest margin does not tell the cell of point " << point;
    return {};
}

/// Of the points in `kept`, against cells that are found by clipping.
void expectSameCells(PeriodicTriangulation& triangulation, const std::vector<std::uint32_t>& kept) {
    std::vector<glm::dvec2> positions;
    for (const auto point : kept) positions.push_back(triangulation.position(point));
    const auto expected = test::voronoiCells(positions);
    double sum = 0.0;
    for (std::size_t i = 0; i < kept.size(); ++i) {
        const auto cell = cellOf(triangulation, kept[i]);
        sum += cell.area;
        // Corners are differences of numbers of order 1: errors of some 1e-16 times the ratio of a thin
        // triangle's sides, which is 1e4 in the worst of these sets.
        EXPECT_NEAR(cell.area, expected[i].area, 1e-11) << kept.size() << " points, " << i;
        EXPECT_NEAR(glm::distance(cell.centroid, expected[i].centroid), 0.0, 1e-10);
        EXPECT_NEAR(cell.secondMoment, expected[i].secondMoment, 1e-11);
    }
    EXPECT_NEAR(sum, 1.0, 1e-10);
}

std::vector<std::uint32_t> upTo(std::size_t count) {
    std::vector<std::uint32_t> points(count);
    for (std::uint32_t i = 0; i < count; ++i) points[i] = i;
    return points;
}

TEST(PeriodicTriangulation, CellsAreTheVoronoiCellsOfThePeriodicSquare) {
    for (const std::size_t count : {1U, 2U, 3U, 4U, 5U, 8U, 20U, 60U, 300U, 2000U}) {
        PeriodicTriangulation triangulation(whiteNoise(count, static_cast<unsigned>(count)));
        expectSameCells(triangulation, upTo(count));
    }
}

TEST(PeriodicTriangulation, StayThatWhilePointsMoveAndGo) {
    constexpr std::size_t count = 400;
    PeriodicTriangulation triangulation(stratifiedPoints(count, 5));
    std::mt19937_64 random(7);
    std::normal_distribution<double> normal;
    auto kept = upTo(count);
    while (kept.size() > 1) {
        const double step = 0.4 / std::sqrt(static_cast<double>(kept.size()));
        for (const auto point : kept) {
            if (random() % 4 == 0)
                triangulation.move(point, step * glm::dvec2(normal(random), normal(random)));
        }
        const auto gone = random() % kept.size();
        triangulation.remove(kept[gone]);
        kept.erase(kept.begin() + static_cast<std::ptrdiff_t>(gone));
        if (kept.size() % 20 == 0 || kept.size() < 10) expectSameCells(triangulation, kept);
    }
}

TEST(PeriodicTriangulation, ALatticeIsNoTrouble) {
    // Every four neighbours lie on a circle: the predicates must be exact for this to end well.
    std::vector<glm::dvec2> lattice;
    for (int i = 0; i < 256; ++i) lattice.emplace_back(i % 16 / 16.0, i / 16 / 16.0);
    PeriodicTriangulation triangulation(lattice);
    expectSameCells(triangulation, upTo(lattice.size()));
    for (std::uint32_t i = 0; i < 256; i += 2) triangulation.remove(i);
    std::vector<std::uint32_t> odd;
    for (std::uint32_t i = 1; i < 256; i += 2) odd.push_back(i);
    expectSameCells(triangulation, odd);
}

TEST(PeriodicTriangulation, NobodyMovesOntoAnother) {
    const std::vector<glm::dvec2> points{{0.25, 0.25}, {0.75, 0.25}, {0.5, 0.75}};
    PeriodicTriangulation triangulation(points);
    triangulation.move(0, {0.5, 0.0});
    EXPECT_EQ(triangulation.position(0), glm::dvec2(0.25, 0.25));
    expectSameCells(triangulation, upTo(3));
}

TEST(PeriodicTriangulation, PointsMayWanderFarOff) {
    constexpr std::size_t count = 200;
    PeriodicTriangulation triangulation(stratifiedPoints(count, 6));
    // All of them the same way, in steps of a third of their distance: by two periods in the end.
    for (int step = 0; step < 84; ++step) {
        for (const auto point : upTo(count)) triangulation.move(point, {0.024, 0.0});
    }
    expectSameCells(triangulation, upTo(count));
}

TEST(PeriodicTriangulation, PositionsAreNotWrapped) {
    const std::vector<glm::dvec2> points{{0.75, 0.5}, {0.25, 0.5}};
    PeriodicTriangulation triangulation(points);
    for (int i = 0; i < 6; ++i) triangulation.move(0, {0.0625, 0.0});
    triangulation.widen();
    EXPECT_EQ(triangulation.position(0), glm::dvec2(1.125, 0.5));
    expectSameCells(triangulation, upTo(2));
}

namespace fs = std::filesystem;
using testing::HasSubstr;

proto::JobRequest request(std::uint64_t points, std::uint64_t seed = 1) {
    proto::JobRequest request;
    request.mutable_stipple()->set_points(points);
    request.mutable_stipple()->set_seed(seed);
    return request;
}

Result<proto::Manifest> run(const proto::JobRequest& request, const fs::path& output, int threads = 0) {
    test::TestProgress progress;
    return runPlaneJob(request, output, {threads, 0}, progress);
}

std::string digestOf(const Result<proto::Manifest>& manifest) {
    return storage::findFile(*manifest, "hierarchy.h5")->xxh3_128();
}

TEST(PlaneJob, MakesADatasetThatIsWhole) {
    const test::TempDir dir;
    const auto made = run(request(300), dir / "a.mote");
    ASSERT_TRUE(made.ok()) << made.error().toString();
    EXPECT_TRUE(storage::verifyDataset(dir / "a.mote").empty());
    const auto manifest = storage::readManifest(dir / "a.mote");
    EXPECT_EQ(manifest->title(), "plane of 300 points");
    EXPECT_EQ(manifest->stipple().domain(), proto::StippleManifest::PLANE);
    EXPECT_EQ(manifest->stipple().seed(), 1U);
    const auto hierarchy = storage::readHierarchy(dir / "a.mote", *manifest);
    ASSERT_TRUE(hierarchy.ok()) << hierarchy.error().toString();
    EXPECT_EQ(hierarchy->size(), 300U);
}

TEST(PlaneJob, TheSameBytesOnAnyNumberOfThreads) {
    const test::TempDir dir;
    const auto one = digestOf(run(request(3000), dir / "one.mote", 1));
    EXPECT_EQ(digestOf(run(request(3000), dir / "four.mote", 4)), one);
    EXPECT_NE(digestOf(run(request(3000, 2), dir / "other.mote", 4)), one);
}

TEST(PlaneJob, OneToThreePoints) {
    const test::TempDir dir;
    for (std::uint64_t points = 1; points <= 3; ++points) {
        const auto output = dir / (std::to_string(points) + ".mote");
        ASSERT_TRUE(run(request(points), output).ok());
        EXPECT_TRUE(storage::verifyDataset(output).empty());
    }
}

TEST(PlaneJob, RefusesWhatCannotBeDone) {
    const test::TempDir dir;
    const auto refused = [&](const proto::JobRequest& asked, ErrorCode code, const std::string& where) {
        const auto made = run(asked, dir / "a.mote");
        ASSERT_FALSE(made.ok()) << where;
        EXPECT_EQ(made.error().code, code);
        EXPECT_EQ(made.error().where, where);
        EXPECT_TRUE(fs::is_empty(dir.path()));
    };
    refused(request(0), ErrorCode::invalidArgument, "points");
    refused(request(1ULL << 32), ErrorCode::invalidArgument, "points");
    refused(request(~0ULL), ErrorCode::invalidArgument, "points");
    refused(request(4000000000), ErrorCode::resourceExhausted, "points");
    auto rings = request(10);
    rings.mutable_stipple()->set_rings(3);
    refused(rings, ErrorCode::invalidArgument, "rings");
    for (const double wrong : {0.5, 2.0, -1.0, std::numeric_limits<double>::quiet_NaN()}) {
        auto relaxation = request(10);
        relaxation.mutable_stipple()->set_relaxation(wrong);
        refused(relaxation, ErrorCode::invalidArgument, "relaxation");
    }
}

TEST(PlaneJob, LeavesNothingWhenItIsCancelled) {
    const test::TempDir dir;
    for (const double at : {0.0, 0.1, 0.6}) {
        test::TestProgress progress;
        progress.cancelAt(at);
        const auto made = runPlaneJob(request(3000), dir / "a.mote", {}, progress);
        ASSERT_FALSE(made.ok());
        EXPECT_EQ(made.error().code, ErrorCode::cancelled);
        EXPECT_TRUE(fs::is_empty(dir.path()));
    }
}

TEST(PlaneJob, SaysAtOnceThatTheOutputExists) {
    const test::TempDir dir;
    fs::create_directory(dir / "a.mote");
    test::TestProgress progress;
    progress.cancelAt(0.0);
    EXPECT_EQ(runPlaneJob(request(3000), dir / "a.mote", {}, progress).error().code,
              ErrorCode::alreadyExists);
}

}  // namespace
}  // namespace mote::prep
