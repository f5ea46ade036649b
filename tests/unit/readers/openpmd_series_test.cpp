// SPDX-License-Identifier: GPL-3.0-or-later
//
// openPMD runs as a whole: series, species, links, and what is missing or wrong.
#include <gmock/gmock.h>

#include <cmath>

#include "preprocess/readers/field_meaning.h"
#include "tests/support/temp_dir.h"
#include "tests/unit/readers/h5_test_file.h"
#include "tests/unit/readers/openpmd_test_file.h"
#include "tests/unit/readers/source_test.h"

namespace mote::test {
namespace {

using prep::Column;
using testing::ElementsAre;
using testing::HasSubstr;
using Openpmd = SourceTest;

TEST_F(Openpmd, ordersIterationsOfOneFileByNumber) {
    {
        H5TestFile file(folder / "run.h5");
        writeRoot(file, "/data/%T/", "particles/");
        for (const int i : {100, 20, 3})
            writeParticles(file, "/data/" + std::to_string(i) + "/particles/e", i);
        file.group("/data/notes");
    }
    MOTE_OPEN(source, {folder / "run.h5"}, progress);
    ASSERT_EQ(source->steps().size(), 3u);
    EXPECT_EQ(source->steps()[0].iteration, 3);
    EXPECT_EQ(source->steps()[2].iteration, 100);
    EXPECT_THAT(column(*source, 2, Column::x), near({0.101, 0.102, 0.103}));
    EXPECT_THAT(column(*source, 0, Column::x), near({0.004, 0.005, 0.006}));
}

TEST_F(Openpmd, takesSeveralFilesAsOneSeries) {
    for (const int i : {10, 9, 200}) {
        H5TestFile file(folder / ("run_" + std::to_string(i) + ".h5"));
        writeRoot(file, "/data/%T/", "particles/");
        file.text("/", "iterationEncoding", "fileBased");
        file.text("/", "iterationFormat", "run_%T.h5");
        writeParticles(file, "/data/" + std::to_string(i) + "/particles/e", i);
    }
    MOTE_OPEN(named, {folder / "run_200.h5", folder / "run_10.h5", folder / "run_9.h5"}, progress);
    MOTE_OPEN(listed, {folder / "run_%T.h5"}, progress);
    for (auto* source : {named.get(), listed.get()}) {
        ASSERT_EQ(source->steps().size(), 3u);
        EXPECT_EQ(source->steps()[0].file, "run_9.h5");
        EXPECT_EQ(source->steps()[1].file, "run_10.h5");
        EXPECT_THAT(column(*source, 2, Column::x), near({0.201, 0.202, 0.203}));
        EXPECT_THAT(column(*source, 0, Column::x), near({0.010, 0.011, 0.012}));
    }
    EXPECT_THAT(errorOf({folder / "other_%T.h5"}), HasSubstr("not_found: other_%T.h5"));
}

TEST_F(Openpmd, choosesASpecies) {
    {
        H5TestFile file(folder / "run.h5");
        writeRoot(file, "/data/%T/", "particles/");
        writeParticles(file, "/data/1/particles/electrons");
        writeParticles(file, "/data/1/particles/ions", 5);
        writeParticles(file, "/data/2/particles/electrons");
        file.group("/data/3");
    }
    EXPECT_THAT(errorOf({folder / "run.h5"}), HasSubstr("choose one with --species: electrons, ions"));
    proto::ParticlesJob job;
    job.set_species("muons");
    EXPECT_THAT(errorOf({folder / "run.h5"}, job),
                HasSubstr("holds no species 'muons', but electrons, ions"));
    job.set_species("ions");
    MOTE_OPEN(ions, {folder / "run.h5"}, progress, job);
    EXPECT_THAT(column(*ions, 0, Column::x), near({0.006, 0.007, 0.008}));
    ASSERT_EQ(ions->steps().size(), 3u);
    EXPECT_EQ(ions->steps()[1].particles, 0u);
    EXPECT_EQ(ions->steps()[2].particles, 0u);
    EXPECT_TRUE(ions->has(Column::x)) << "an empty step lacks nothing";
    EXPECT_TRUE(progress.noted("empty steps"));
    job.set_species("electrons");
    MOTE_OPEN(electrons, {folder / "run.h5"}, progress, job);
    EXPECT_NEAR(electrons->mass(), prep::electronMass, 1.0) << "after the group's name";
}

TEST_F(Openpmd, survivesASpeciesWithoutParticles) {
    {
        H5TestFile file(folder / "run.h5");
        writeRoot(file, "/data/%T/", "particles/");
        file.data("/data/1/particles/e/position/x", std::vector<double>{});
        file.constant("/data/1/particles/e/position/y", 0.0, 0);
        file.data("/data/2/particles/e/position/x", std::vector<double>{4});
        file.data("/data/2/particles/e/position/y", std::vector<double>{5});
    }
    MOTE_OPEN(source, {folder / "run.h5"}, progress);
    EXPECT_EQ(source->steps()[0].particles, 0u);
    EXPECT_THAT(column(*source, 0, Column::x), ElementsAre());
    EXPECT_THAT(column(*source, 1, Column::y), ElementsAre(5));
}

TEST_F(Openpmd, hasAColumnWhereEveryStepHasIt) {
    {
        H5TestFile file(folder / "run.h5");
        writeRoot(file, "/data/%T/", "particles/");
        writeParticles(file, "/data/1/particles/e");
        file.data("/data/2/particles/e/position/x", std::vector<double>{4});
    }
    MOTE_OPEN(source, {folder / "run.h5"}, progress);
    EXPECT_TRUE(source->has(Column::x));
    EXPECT_FALSE(source->has(Column::y));
    EXPECT_FALSE(source->has(Column::px));
}

TEST_F(Openpmd, saysWhatWeightsCountWhereAllStepsAgree) {
    struct Case {
        const char *first, *second, *unit;
        bool noted;
    };
    for (const auto& [first, second, unit, noted] :
         {Case{"weighting", "weighting", "1", false}, Case{"weight", "weight", "C", false},
          Case{"weighting", "other", "", false}, Case{"weighting", "weight", "", true}}) {
        const TempDir own;
        {
            H5TestFile file(own / "run.h5");
            writeRoot(file, "/data/%T/", "particles/");
            for (const std::string species : {"/data/1/particles/e/", "/data/2/particles/e/"}) {
                writeParticles(file, species.substr(0, species.size() - 1));
                file.data(species + (species[6] == '1' ? first : second), std::vector<double>{7, 8, 9});
            }
        }
        NoteKeeper notes;
        MOTE_OPEN(source, {own / "run.h5"}, notes);
        EXPECT_EQ(source->weightUnit(), unit) << first << ' ' << second;
        EXPECT_EQ(notes.noted("weights count real particles in some steps and charge in others"), noted);
    }
}

TEST_F(Openpmd, followsLinksWithinTheFile) {
    {
        H5TestFile file(folder / "run.h5");
        writeRoot(file, "/data/%T/", "particles/");
        writeParticles(file, "/store/e");
        file.group("/data/1");
        ASSERT_GE(H5Lcreate_soft("/store", file.id(), "/data/1/particles", H5P_DEFAULT, H5P_DEFAULT), 0);
        ASSERT_GE(H5Lcreate_soft("../1", file.id(), "/data/2", H5P_DEFAULT, H5P_DEFAULT), 0);
        ASSERT_GE(H5Lcreate_soft("1", file.id(), "/data/3", H5P_DEFAULT, H5P_DEFAULT), 0);
    }
    MOTE_OPEN(source, {folder / "run.h5"}, progress);
    ASSERT_EQ(source->steps().size(), 2u) << "HDF5 knows no '..', and a link to nothing is no iteration";
    EXPECT_THAT(column(*source, 1, Column::x), near({0.001, 0.002, 0.003}));
}

/// A beam as ImpactX writes it: path length in place of time, relative to the reference particle.
TEST_F(Openpmd, readsABeamRelativeToAReferenceParticle) {
    const double gamma = 5.0, betaGamma = std::sqrt(24.0), kilogram = 9.1093837015e-31;
    {
        H5TestFile file(folder / "monitor.h5");
        writeRoot(file, "/data/%T/", "particles/");
        const std::string beam = "/data/1/particles/beam";
        file.data(beam + "/position/x", std::vector<double>{1e-3, -2e-3});
        file.data(beam + "/position/y", std::vector<double>{3e-3, 0});
        file.data(beam + "/position/t", std::vector<double>{6e-3, 0});
        file.constant(beam + "/positionOffset/x", 12.0, 2);  // the reference particle in the laboratory
        file.constant(beam + "/positionOffset/t", 30.0, 2);
        file.data(beam + "/momentum/x", std::vector<double>{0.01, 0});
        file.data(beam + "/momentum/y", std::vector<double>{0, -0.02});
        file.data(beam + "/momentum/t", std::vector<double>{-0.1, 0.05});
        file.data(beam + "/qm", std::vector<double>{-1, -1});
        file.data(beam + "/weighting", std::vector<double>{100, 100});
        file.attribute(beam, "gamma_ref", gamma);
        file.attribute(beam, "beta_ref", betaGamma / gamma);
        file.attribute(beam, "mass_ref", kilogram);
        file.attribute(beam, "t_ref", 29.9792458);
    }
    MOTE_OPEN(source, {folder / "monitor.h5"}, progress);
    const double mass = kilogram * prep::speedOfLight * prep::speedOfLight / prep::elementaryCharge;
    EXPECT_NEAR(source->mass(), mass, 1e-9 * mass);
    EXPECT_NEAR(source->steps()[0].time, 1e-7, 1e-18);
    EXPECT_THAT(column(*source, 0, Column::x), near({1e-3, -2e-3}))
        << "without the offset, in the moving frame";
    EXPECT_THAT(column(*source, 0, Column::z), near({-6e-3 * betaGamma / gamma, -0.0}))
        << "a late particle is behind";
    EXPECT_THAT(column(*source, 0, Column::t), near({6e-3 / prep::speedOfLight, 0}));
    EXPECT_THAT(column(*source, 0, Column::px), near({0.01 * betaGamma * mass, 0}));
    // A negative momentum/t means more energy than the reference particle has.
    const double gamma0 = gamma + 0.1 * betaGamma, px0 = 0.01 * betaGamma;
    const double gamma1 = gamma - 0.05 * betaGamma, py1 = 0.02 * betaGamma;
    const auto pz = column(*source, 0, Column::pz);
    EXPECT_NEAR(pz[0], mass * std::sqrt(gamma0 * gamma0 - 1 - px0 * px0), 1e-9 * mass);
    EXPECT_NEAR(pz[1], mass * std::sqrt(gamma1 * gamma1 - 1 - py1 * py1), 1e-9 * mass);
}

TEST_F(Openpmd, saysWhatIsMissingAndWhere) {
    const auto written = [&](const auto& fill) {
        {
            H5TestFile file(folder / "run.h5");
            writeRoot(file, "/data/%T/", "particles/");
            fill(file);
        }
        return errorOf({folder / "run.h5"});
    };
    const std::string e = "/data/1/particles/e";
    EXPECT_THAT(written([](H5TestFile&) {}),
                HasSubstr("not_found: run.h5:/data/%T/: the file has no iterations there"));
    EXPECT_THAT(written([&](H5TestFile& file) { file.group("/data/1/particles"); }),
                HasSubstr("not_found: run.h5"));
    EXPECT_THAT(written([&](H5TestFile& file) { file.text("/", "openPMD", "3.0.0"); }),
                HasSubstr("version '3.0.0'"));
    EXPECT_THAT(written([&](H5TestFile& file) { file.group(e + "/position/x"); }),
                HasSubstr("run.h5:/data/1/particles/e/position/x: is neither a dataset nor a constant"));
    EXPECT_THAT(written([&](H5TestFile& file) {
                    file.data(e + "/position/x", std::vector<double>{1, 2});
                    file.data(e + "/position/y", std::vector<double>{1, 2, 3});
                }),
                HasSubstr("has 3 values where others have 2"));
    EXPECT_THAT(written([&](H5TestFile& file) {
                    writeParticles(file, e);
                    file.attribute(e + "/momentum", "macroWeighted", std::int64_t{1});
                }),
                HasSubstr("'weighting' is missing"));
    EXPECT_THAT(
        written([&](H5TestFile& file) {
            writeParticles(file, e);
            file.attribute(e + "/momentum/x", "unitDimension", std::vector<double>{1, 0, -1, 0, 0, 0, 0});
        }),
        HasSubstr("/momentum/x@unitDimension: is not that of a momentum"));
    EXPECT_THAT(written([&](H5TestFile& file) { file.data(e + "/position/t", std::vector<double>{1}); }),
                HasSubstr("@gamma_ref: is missing"));
    EXPECT_THAT(written([&](H5TestFile& file) { file.constant(e + "/position/x", 0.0, 1'000'000'000'000); }),
                HasSubstr("every record is a constant"));
    EXPECT_THAT(written([&](H5TestFile& file) { file.constant(e + "/position/x", 0.0, -1); }),
                HasSubstr("@shape: is no possible number of particles"));
    EXPECT_THAT(written([&](H5TestFile& file) {
                    file.group(e + "/position");
                    file.text(e + "/position", "unitSI", "metre");
                    file.data(e + "/position/x", std::vector<double>{1});
                }),
                HasSubstr("@unitSI: is no number"));
}

TEST_F(Openpmd, stopsWhenCancelled) {
    {
        H5TestFile file(folder / "run.h5");
        writeRoot(file, "/data/%T/", "particles/");
        writeParticles(file, "/data/1/particles/e");
    }
    progress.cancel = true;
    const auto source = openFiles({folder / "run.h5"}, progress);
    ASSERT_FALSE(source.ok());
    EXPECT_EQ(source.error().code, ErrorCode::cancelled);
}

}  // namespace
}  // namespace mote::test
