// SPDX-License-Identifier: GPL-3.0-or-later
//
// What is exported is read again by Mote's own reader and held to the dataset's columns; h5py reads it in
// tests/python/export_test.py.
#include "preprocess/export/export_job.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <optional>

#include "preprocess/openpmd/h5_output.h"
#include "storage/particles/particle_columns.h"
#include "tests/support/random.h"
#include "tests/support/temp_dir.h"
#include "tests/unit/particles/job_run.h"

namespace mote::test {
namespace {

/// Before whatever else calls HDF5 here, as in mote-prep, which exports without having called it.
[[maybe_unused]] const bool first = [] {
    const prep::H5Errors errors;
    return true;
}();

using prep::Column;
using testing::HasSubstr;

constexpr double mass = 0.51099895e6;  // eV/c^2

class ExportJob : public testing::Test {
  protected:
    std::filesystem::path dataset() const { return folder_ / "beam.mote"; }
    std::filesystem::path output() const { return folder_ / "out.h5"; }

    /// A run of these steps, prepared.
    void prepare(std::vector<FakeStep> steps, const std::vector<std::string>& columns = {},
                 const FakeSource::What& what = {}, double ofOne = mass, const std::string& lost = "") {
        std::filesystem::remove_all(dataset());
        for (std::size_t i = 0; i < steps.size(); ++i) {
            steps[i].iteration = static_cast<std::int64_t>(10 * i);
            steps[i].time = 0.5 * static_cast<double>(i);
        }
        FakeSource source(std::move(steps), ofOne);
        source.what = what;
        auto request = requestFor();
        request.mutable_particles()->set_lost(lost);
        request.mutable_particles()->mutable_columns()->Assign(columns.begin(), columns.end());
        const auto made = make(request, source, dataset());
        ASSERT_TRUE(made.ok()) << made.error().toString();
        manifest_ = *made;
    }

    Status write(const proto::ExportJob& job, long cancelAfter = -1) {
        std::filesystem::remove(output());
        QuietProgress progress(cancelAfter);
        auto done = prep::exportParticles(job, dataset(), output(), {}, progress);
        asked_ = progress.asked();
        return done;
    }

    /// All rows of a column of a step of what was written.
    std::vector<double> readBack(Column column, std::size_t step) {
        QuietProgress progress;
        proto::ParticlesJob job;
        auto source = prep::openParticleSource(job, {output()}, progress);
        EXPECT_TRUE(source.ok()) << source.error().toString();
        if (!source.ok() || step >= (*source)->steps().size()) return {};
        EXPECT_DOUBLE_EQ((*source)->mass(), mass);
        prep::ParticleChunk chunk;
        const auto rows = (*source)->steps()[step].particles;
        const auto read = (*source)->read(step, 0, rows, {column}, chunk);
        EXPECT_TRUE(read.ok());
        for (const auto mark : chunk.lost) EXPECT_EQ(mark, 0);
        return chunk[column];
    }

    /// The dataset's own values of those points whose x is in [low, high].
    std::vector<double> expected(const std::string& column, std::uint32_t step, double low, double high) {
        const auto columns = storage::ParticleColumns::open(dataset(), manifest_, step);
        EXPECT_TRUE(columns.ok()) << columns.error().toString();
        const auto all = [&](const std::string& name) {
            const auto index = (*columns)->find(name).value();
            std::vector<double> values((*columns)->pointCount());
            (*columns)->read(index, 0, values);
            return values;
        };
        const auto x = all("x"), wanted = all(column);
        std::vector<double> chosen;
        for (std::size_t i = 0; i < x.size(); ++i) {
            if (x[i] >= low && x[i] <= high) chosen.push_back(wanted[i]);
        }
        return chosen;
    }

    /// What was written, prepared again.
    proto::ParticlesManifest again(const std::string& lost = "") {
        const auto path = folder_ / "again.mote";
        std::filesystem::remove_all(path);
        auto request = requestFor();
        request.mutable_particles()->set_lost(lost);
        QuietProgress progress;
        const auto made = prep::runParticlesJob(request, {output()}, path, {}, progress);
        EXPECT_TRUE(made.ok()) << made.error().toString();
        return made.ok() ? made->particles() : proto::ParticlesManifest();
    }

    void expectNothing() const { EXPECT_EQ(entriesOf(folder_.path()), 1U) << "besides the dataset"; }

    TempDir folder_;
    proto::Manifest manifest_;
    long asked_ = 0;
};

proto::ExportJob within(double low, double high) {
    proto::ExportJob job;
    auto& range = *job.mutable_select()->add_ranges();
    range.set_column("x");
    range.set_min(low);
    range.set_max(high);
    return job;
}

TEST_F(ExportJob, IsReadAgainAsTheDatasetHasIt) {
    Random random(1);
    for (std::uint64_t seed = 0; seed < 12; ++seed) {
        const std::size_t particles = random.oneOf({1, 2, 500, 3000});
        prepare({beamStep(particles, 2 * seed), beamStep(particles, 2 * seed + 1, 2.0)});
        const double low = random.between(-3e-3, 1e-3), high = low + random.between(0.0, 4e-3);
        auto job = within(low, high);
        ASSERT_TRUE(write(job).ok());
        for (const std::uint32_t step : {0U, 1U}) {
            const auto x = expected("x", step, low, high);
            EXPECT_EQ(readBack(Column::x, step), x) << "position is in m: no unit is multiplied";
            EXPECT_EQ(readBack(Column::weight, step), expected("weight", step, low, high));
            for (const auto& [column, name] : {std::pair{Column::px, "px"}, std::pair{Column::pz, "pz"}}) {
                const auto got = readBack(column, step), should = expected(name, step, low, high);
                ASSERT_EQ(got.size(), should.size());
                // Into kg m/s and back: three roundings.
                for (std::size_t i = 0; i < got.size(); ++i)
                    EXPECT_NEAR(got[i], should[i], 4 * 1.2e-16 * std::abs(should[i]));
            }
            // Not of the run, but the step's.
            EXPECT_EQ(readBack(Column::t, step), std::vector<double>(x.size(), 0.5 * step));
        }
    }
}

double statistic(const proto::ParticlesManifest& manifest, const std::string& name) {
    const auto& names = manifest.statistic_names();
    const auto at = std::find(names.begin(), names.end(), name) - names.begin();
    return manifest.steps(0).statistics(static_cast<int>(at));
}

TEST_F(ExportJob, IsADatasetAgainWithTheSameSpeciesChargeAndCounts) {
    constexpr double e = 1.602176634e-19, proton = 938272088.16;
    struct Kind {
        FakeSource::What what;
        double mass;
        double weight;  ///< 0: all different
    };
    const std::vector<Kind> kinds{
        {{"positron", "1", e}, mass, 0.0},         {{"antiproton", "C", -e}, proton, 1e-9 / 7},
        {{"electron", "C", -e}, mass, 1e-9 / 500}, {{"#12C+6", "1", 6 * e}, 11.1749e9, 33.3},
        {{"H-", "1", -e}, 939.29407e6, 1.0},       {{"", "C", 0.0}, 5e9, 1e-12 / 3},
        {{"unobtainium", "1", 0.0}, 5e9, 0.0}};
    for (const auto& kind : kinds) {
        auto step = beamStep(500, 3);
        if (kind.weight != 0.0) step[Column::weight].assign(500, kind.weight);
        prepare({step}, {}, kind.what, kind.mass);
        ASSERT_TRUE(write({}).ok());
        const auto is = again();
        const auto& should = manifest_.particles();
        EXPECT_EQ(is.species(), kind.what.species);
        EXPECT_NEAR(is.mass(), kind.mass, 1e-14 * kind.mass);
        EXPECT_NEAR(is.particle_charge(), kind.what.charge, 1e-14 * e);
        EXPECT_EQ(is.steps(0).particles(), 500U);
        for (const char* name : {"charge", "n_particle"})
            EXPECT_NEAR(statistic(is, name), statistic(should, name), 1e-14 * statistic(should, name))
                << name;
        for (const char* name : {"sigma_x", "sigma_px", "mean_pz", "norm_emit_x", "mean_energy"})
            EXPECT_NEAR(statistic(is, name), statistic(should, name), 1e-6 * statistic(should, name)) << name;
    }
}

TEST_F(ExportJob, LostParticlesAreWrittenAsLost) {
    auto step = beamStep(400, 5);
    step.lost.assign(400, 0);
    for (std::size_t i = 0; i < 400; i += 4) step.lost[i] = 1;
    for (const std::string lost : {"without", "with", "only"}) {
        prepare({step}, {}, {"electron", "1", -1.602176634e-19}, mass, lost);
        ASSERT_TRUE(write({}).ok());
        const auto live = lost == "only" ? 0U : 300U, gone = lost == "without" ? 0U : 100U;
        EXPECT_EQ(again("with").steps(0).particles(), live + gone);
        if (live > 0) {
            EXPECT_EQ(again().steps(0).particles(), live);
            EXPECT_EQ(again().steps(0).lost(), gone);
        }
        if (gone > 0) {
            EXPECT_EQ(again("only").steps(0).particles(), gone);
        }
    }
}

TEST_F(ExportJob, AnEmptySelectionIsAFileWithoutRows) {
    prepare({beamStep(300, 1)});
    ASSERT_TRUE(write(within(5.0, 6.0)).ok());
    EXPECT_TRUE(readBack(Column::x, 0).empty());
}

TEST_F(ExportJob, StepsAreChosenAndKeepTheirNumbers) {
    prepare({beamStep(30, 1), beamStep(31, 2), beamStep(32, 3), beamStep(33, 4)});
    proto::ExportJob job;
    job.set_steps("1:3:2");
    ASSERT_TRUE(write(job).ok());
    QuietProgress progress;
    const auto source = prep::openParticleSource({}, {output()}, progress);
    ASSERT_TRUE(source.ok());
    const auto& steps = (*source)->steps();
    ASSERT_EQ(steps.size(), 2U);
    EXPECT_EQ(steps[0].iteration, 10);
    EXPECT_EQ(steps[1].iteration, 30);
    EXPECT_EQ(steps[1].time, 1.5);
    EXPECT_EQ(steps[1].particles, manifest_.particles().steps(3).particles());
}

TEST_F(ExportJob, TheSameBytesWhateverTheThreads) {
    prepare({beamStep(2000, 1)});
    std::vector<std::string> bytes;
    for (const int threads : {1, 3}) {
        std::filesystem::remove(output());
        QuietProgress progress;
        prep::JobResources resources;
        resources.threads = threads;
        ASSERT_TRUE(prep::exportParticles(within(0.0, 1.0), dataset(), output(), resources, progress).ok());
        std::ifstream file(output(), std::ios::binary);
        bytes.emplace_back(std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>());
    }
    EXPECT_TRUE(bytes[0] == bytes[1]);
}

TEST_F(ExportJob, ColumnsAreChosenBesidesThoseThatTheFormatNeeds) {
    prepare({beamStep(40, 1)});
    auto job = within(-1.0, 1.0);
    job.add_columns("px");
    ASSERT_TRUE(write(job).ok());
    EXPECT_FALSE(readBack(Column::y, 0).empty());
    job.add_columns("wind");
    const auto refused = write(job);
    ASSERT_FALSE(refused.ok());
    EXPECT_EQ(refused.error().where, "columns[1]");
    EXPECT_THAT(refused.error().message, HasSubstr("wind"));
    expectNothing();
}

TEST_F(ExportJob, WhatIsWrongIsSaidAndNothingIsLeft) {
    prepare({beamStep(40, 1)}, {"none"});
    const auto without = write({});
    ASSERT_FALSE(without.ok());
    EXPECT_EQ(without.error().code, ErrorCode::notFound);
    EXPECT_THAT(without.error().message, HasSubstr("mote-prep particles"));
    prepare({beamStep(40, 1)});
    proto::ExportJob job;
    job.set_steps("7");
    EXPECT_EQ(write(job).error().where, "steps");
    job.clear_steps();
    job.mutable_select()->mutable_polygon()->add_columns("x");
    EXPECT_THAT(write(job).error().where, HasSubstr("select.polygon"));
    EXPECT_EQ(write(within(std::nan(""), 1.0)).error().code, ErrorCode::invalidArgument);
    expectNothing();
    std::ofstream(output()) << "here";
    QuietProgress progress;
    const auto there = prep::exportParticles({}, dataset(), output(), {}, progress);
    ASSERT_FALSE(there.ok());
    EXPECT_EQ(there.error().code, ErrorCode::alreadyExists);
}

TEST_F(ExportJob, ADamagedColumnIsNeverExported) {
    prepare({beamStep(40000, 1)});
    const auto path = dataset() / manifest_.particles().steps(0).columns_file();
    {
        std::fstream file(path, std::ios::in | std::ios::out | std::ios::binary);
        const auto size = std::filesystem::file_size(path);
        file.seekg(static_cast<std::streamoff>(size / 2));
        const char byte = static_cast<char>(file.get() ^ 0x10);
        file.seekp(static_cast<std::streamoff>(size / 2));
        file.put(byte);
    }
    const auto done = write({});
    ASSERT_FALSE(done.ok());
    EXPECT_EQ(done.error().code, ErrorCode::corrupt);
    expectNothing();
}

TEST_F(ExportJob, CancelledAnywhereItLeavesNothing) {
    prepare({beamStep(200000, 1), beamStep(200000, 2)});
    ASSERT_TRUE(write(within(-1.0, 1.0)).ok());
    const long all = asked_;
    ASSERT_GT(all, 6);
    for (long after = 0; after < all; after += std::max(1L, all / 7)) {
        const auto done = write(within(-1.0, 1.0), after);
        ASSERT_FALSE(done.ok()) << after;
        EXPECT_EQ(done.error().code, ErrorCode::cancelled);
        expectNothing();
    }
}

TEST_F(ExportJob, AFullDiskIsSaid) {
    prepare({beamStep(50000, 1)});
    const FileSizeLimit limit(1 << 20);
    const auto done = write({});
    ASSERT_FALSE(done.ok());
    EXPECT_EQ(done.error().code, ErrorCode::resourceExhausted) << done.error().toString();
    expectNothing();
}

}  // namespace
}  // namespace mote::test
