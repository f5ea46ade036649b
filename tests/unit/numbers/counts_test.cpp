// SPDX-License-Identifier: GPL-3.0-or-later
//
// Histograms, statistics and columns of points, held to plain loops over the same columns.
#include <gtest/gtest.h>
#include <oneapi/tbb/task_arena.h>

#include <cmath>
#include <cstring>
#include <map>

#include "storage/numbers/bin_axis.h"
#include "storage/numbers/column_pieces.h"
#include "storage/numbers/histogram.h"
#include "storage/numbers/id_set.h"
#include "storage/numbers/point_statistics.h"
#include "storage/numbers/quantity_range.h"
#include "storage/numbers/select_points.h"
#include "tests/support/any_selection.h"
#include "tests/support/memory_run.h"
#include "tests/unit/numbers/plain_selection.h"

namespace mote::test {
namespace {

using storage::Histogram;
using storage::HistogramAxis;
using storage::PointMask;

const storage::BeamFacts facts{0.5e6, "1", 0, 0.0};

PointMask anyMask(Random& random, std::uint64_t points) {
    PointMask mask(points);
    const double share = random.oneOf({0.0, 0.01, 0.5, 1.0});
    for (std::uint64_t i = 0; i < points; ++i) {
        if (random.chance(share)) mask.choose(i);
    }
    return mask;
}

HistogramAxis anyAxis(Random& random) {
    static const std::vector<HistogramAxis> axes{
        {"x", 1, -2e-3, 2e-3},   {"px", 1, -2e4, 2e4},      {"z", 1, 4.999, 5.001}, {"r", 1, 0.0, 3e-3},
        {"pz", 1, 3.9e6, 4.1e6}, {"z", 1, 5.0, 5.0 + 1e-9}, {"y", 1, -1e3, 1e3}};
    auto axis = axes[random.below(axes.size())];
    axis.bins = static_cast<std::uint32_t>(random.oneOf({1, 2, 7, 100, 512, 4096}));
    return axis;
}

/// The bins of numpy.
std::size_t plainBin(const std::vector<double>& edges, double value) {
    if (!(value >= edges.front() && value <= edges.back())) return edges.size() - 1;
    std::size_t bin = 0;
    while (bin + 2 < edges.size() && value >= edges[bin + 1]) ++bin;
    return bin;
}

TEST(Histogram, CountsWhatAPlainLoopCounts) {
    for (std::uint64_t seed = 0; seed < 60; ++seed) {
        Random random(seed, 81);
        const auto run = anyRun(random, {.most = 2000, .steps = 1, .oddWeights = random.chance(0.5)});
        const auto step = *run->step(0);
        const auto points = step.points->pointCount();
        const auto mask = anyMask(random, points);
        const bool all = random.chance(0.3), unweighted = random.chance(0.3);
        std::vector<HistogramAxis> axes{anyAxis(random)};
        if (random.chance(0.5)) axes.push_back(anyAxis(random));
        if (axes.size() > 1) axes[1].bins = std::min(axes[1].bins, 100U);
        const auto found = storage::countHistogram(axes, unweighted, step, all ? nullptr : &mask, {});
        ASSERT_TRUE(found.ok());
        std::vector<double> expected(found->counts.size(), 0.0);
        double outside = 0.0, size = 0.0;
        std::uint64_t particles = 0;
        const auto weights = plainQuantity("weight", *run, 0);
        std::vector<std::vector<double>> values;
        for (const auto& axis : axes) values.push_back(plainQuantity(axis.column, *run, 0));
        for (std::uint64_t i = 0; i < points; ++i) {
            if (!all && !mask.chosen(i)) continue;
            const double weight = unweighted ? 1.0 : weights[i];
            std::size_t place = 0;
            bool within = true;
            for (std::size_t a = 0; a < axes.size(); ++a) {
                const auto bin = plainBin(found->edges[a], values[a][i]);
                within &= bin < axes[a].bins;
                place = place * axes[a].bins + bin;
            }
            size += std::abs(weight);
            if (!within) {
                outside += weight;
                continue;
            }
            expected[place] += weight;
            ++particles;
        }
        EXPECT_EQ(found->particles, particles) << seed;
        EXPECT_NEAR(found->outside, outside, 1e-12 * size) << seed;
        for (std::size_t i = 0; i < expected.size(); ++i)
            ASSERT_NEAR(found->counts[i], expected[i], 1e-12 * size) << seed << ": bin " << i;
    }
}

TEST(Histogram, AnyNumberOfThreadsGivesTheSameBits) {
    Random random(2, 82);
    auto run = anyRun(random, {.most = 200000, .steps = 1});
    while (run->at(0).points->pointCount() < 60000) run = anyRun(random, {.most = 200000, .steps = 1});
    const auto step = *run->step(0);
    const auto mask = anyMask(random, step.points->pointCount());
    for (const auto* const chosen : {static_cast<const PointMask*>(nullptr), &mask}) {
        std::optional<Histogram> histogram;
        std::optional<storage::PointStatistics> statistics;
        for (const int threads : {1, 2, 5}) {
            tbb::task_arena arena(threads);
            const auto [counted, summed] = arena.execute([&] {
                return std::pair(storage::countHistogram({{"x", 50, -1e-3, 1e-3}, {"px", 50, -1e4, 1e4}},
                                                         false, step, chosen, {}),
                                 storage::pointStatistics(step, facts, chosen, storage::SlicesWanted{"z", 5},
                                                          storage::Passes::percentilesToo, {}));
            });
            ASSERT_TRUE(counted.ok() && summed.ok());
            if (histogram) {
                EXPECT_EQ(counted->counts, histogram->counts);
                EXPECT_EQ(0, std::memcmp(summed->values.data(), statistics->values.data(),
                                         8 * summed->values.size()));
                for (std::size_t i = 0; i < 5; ++i) {
                    EXPECT_EQ(0, std::memcmp(summed->slices[i].data(), statistics->slices[i].data(),
                                             8 * summed->slices[i].size()));
                }
            }
            histogram = *counted;
            statistics = *summed;
        }
    }
}

TEST(PointStatistics, AreThoseOfTheChosenPoints) {
    for (std::uint64_t seed = 0; seed < 20; ++seed) {
        Random random(seed, 83);
        const auto run = anyRun(random, {.most = 3000, .steps = 1});
        const auto step = *run->step(0);
        const auto mask = anyMask(random, step.points->pointCount());
        const auto found = storage::pointStatistics(step, facts, &mask, storage::SlicesWanted{"x", 4},
                                                    storage::Passes::percentilesToo, {});
        ASSERT_TRUE(found.ok());
        const auto value = [&](const char* name) { return found->values[*findStatistic(name)]; };
        EXPECT_EQ(value("n_particle"), static_cast<double>(mask.count()));
        const auto x = plainQuantity("x", *run, 0), weight = plainQuantity("weight", *run, 0);
        std::vector<std::vector<double>> all;
        for (const auto* const name : {"x", "y", "z", "px", "py", "pz"})
            all.push_back(plainQuantity(name, *run, 0));
        long double sum = 0, mean = 0;
        std::uint64_t inSlices = 0;
        for (std::size_t i = 0; i < x.size(); ++i) {
            if (mask.chosen(i) && std::isfinite(x[i])) ++inSlices;
            bool finite = mask.chosen(i) && weight[i] >= 0.0;
            for (const auto& one : all) finite &= std::isfinite(one[i]);
            if (!finite) continue;
            sum += weight[i];
            mean += static_cast<long double>(weight[i]) * x[i];
        }
        if (sum > 0)
            EXPECT_NEAR(value("mean_x"), static_cast<double>(mean / sum), 1e-13) << seed;
        else
            EXPECT_TRUE(std::isnan(value("mean_x")));
        double slices = 0.0;
        for (const auto& slice : found->slices) slices += slice[*findStatistic("n_particle")];
        EXPECT_EQ(slices, static_cast<double>(inSlices)) << seed;
    }
}

TEST(ColumnReader, PiecesAreTheColumns) {
    for (std::uint64_t seed = 0; seed < 30; ++seed) {
        Random random(seed, 84);
        const auto run = anyRun(random, {.most = 20000, .steps = 1});
        const auto step = *run->step(0);
        const auto mask = anyMask(random, step.points->pointCount());
        const bool all = random.chance(0.3);
        const std::vector<std::string> names{"x", "id", "r"};
        const auto reader = storage::ColumnReader::make(step, names);
        ASSERT_TRUE(reader.ok());
        const auto x = plainQuantity("x", *run, 0), r = plainQuantity("r", *run, 0);
        const auto ids = step.columns->ids(0, step.points->pointCount());
        std::uint64_t begin = 0, next = 0;
        for (bool end = false; !end;) {
            const auto most = 1 + random.below(5000);
            const auto piece = reader->read(begin, ~std::uint64_t{0}, most, all ? nullptr : &mask, {});
            ASSERT_TRUE(piece.ok());
            ASSERT_LE(piece->rows, most);
            ASSERT_EQ(piece->bytes.size(), 24 * piece->rows);
            for (std::uint64_t row = 0; row < piece->rows; ++row) {
                while (!all && !mask.chosen(next)) ++next;
                for (std::size_t name = 0; name < 3; ++name) {
                    std::uint64_t bits = 0;
                    std::memcpy(&bits, piece->bytes.data() + 8 * (name * piece->rows + row), 8);
                    const auto expected =
                        name == 1 ? ids[next] : std::bit_cast<std::uint64_t>(name == 0 ? x[next] : r[next]);
                    ASSERT_EQ(bits, expected) << seed;
                }
                ++next;
            }
            ASSERT_TRUE(piece->end || piece->next > begin);
            begin = piece->next;
            end = piece->end;
        }
        EXPECT_EQ(begin, step.points->pointCount());
        while (next < mask.size() && !all && !mask.chosen(next)) ++next;
        EXPECT_EQ(next, step.points->pointCount()) << seed;
    }
}

TEST(IdSet, FindsTheFirstPointOfEachId) {
    for (std::uint64_t seed = 0; seed < 40; ++seed) {
        Random random(seed, 85);
        const auto run = anyRun(random, {.most = 3000, .steps = 2});
        const auto& columns = *run->at(0).columns;
        std::map<std::uint64_t, std::uint32_t> first;
        const auto own = columns.ids(0, columns.pointCount());
        for (std::uint32_t i = 0; i < own.size(); ++i) first.emplace(own[i], i);
        std::vector<std::uint64_t> wanted;
        for (const auto id : own) {
            if (random.chance(0.3)) wanted.push_back(id);
            if (random.chance(0.1)) wanted.push_back(random.next());
            if (random.chance(0.1)) wanted.push_back(id + 1);
        }
        wanted.push_back(0);
        wanted.push_back(~std::uint64_t{0});
        std::ranges::sort(wanted);
        wanted.erase(std::unique(wanted.begin(), wanted.end()), wanted.end());
        const auto points = storage::firstPoints(wanted, columns, {});
        ASSERT_TRUE(points.has_value());
        for (std::size_t i = 0; i < wanted.size(); ++i) {
            const auto found = first.find(wanted[i]);
            ASSERT_EQ((*points)[i], found == first.end() ? storage::noPoint : found->second) << seed;
        }
        const auto mask = anyMask(random, columns.pointCount());
        const auto set = storage::IdSet::of(mask, columns, {});
        ASSERT_TRUE(set.has_value());
        std::vector<std::uint64_t> chosen;
        for (std::uint64_t i = 0; i < own.size(); ++i) {
            if (mask.chosen(i)) chosen.push_back(own[i]);
        }
        std::ranges::sort(chosen);
        chosen.erase(std::unique(chosen.begin(), chosen.end()), chosen.end());
        EXPECT_EQ(set->list(), chosen);
        EXPECT_EQ(set->size(), chosen.size());
    }
}

}  // namespace
}  // namespace mote::test
