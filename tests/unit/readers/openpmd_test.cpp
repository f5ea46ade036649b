// SPDX-License-Identifier: GPL-3.0-or-later
//
// openPMD files of every form that writers are known to make, written here record by record.
#include <gmock/gmock.h>

#include <cmath>

#include "preprocess/readers/units.h"
#include "tests/support/temp_dir.h"
#include "tests/unit/readers/h5_test_file.h"
#include "tests/unit/readers/source_test.h"

namespace mote::test {
namespace {

using prep::Column;
using testing::ElementsAre;
using testing::HasSubstr;

// One eV/c in kg m/s, as BeamPhysics files write it.
constexpr double electronvolt = prep::elementaryCharge / prep::speedOfLight;

void writeRoot(H5TestFile& file, const std::string& basePath, const std::string& particlesPath) {
    file.text("/", "openPMD", "1.1.0");
    file.text("/", "basePath", basePath);
    file.text("/", "particlesPath", particlesPath);
}

/// Three particles at `path`: positions in mm, momenta in eV/c.
void writeParticles(H5TestFile& file, const std::string& path, double shift = 0.0) {
    for (const char* axis : {"x", "y", "z"}) {
        const double base = shift + 10.0 * (axis[0] - 'x');
        file.data(path + "/position/" + axis, std::vector<double>{base + 1, base + 2, base + 3});
        file.attribute(path + "/position/" + axis, "unitSI", 1e-3);
        file.data(path + "/momentum/" + axis, std::vector<double>{base + 100, base + 200, base + 300});
        file.attribute(path + "/momentum/" + axis, "unitSI", electronvolt);
    }
}

testing::Matcher<const std::vector<double>&> near(std::initializer_list<double> values) {
    // 1e-14: a handful of roundings of doubles.
    std::vector<testing::Matcher<double>> each;
    for (const double value : values) each.push_back(testing::DoubleNear(value, 1e-14 * std::abs(value)));
    return testing::ElementsAreArray(each);
}

struct Paths {
    const char* basePath;
    const char* particlesPath;
    const char* where;
    std::int64_t iteration;
};

class OpenpmdPaths : public testing::TestWithParam<Paths> {};

TEST_P(OpenpmdPaths, areAllFound) {
    const TempDir folder;
    {
        H5TestFile file(folder / "run.h5");
        writeRoot(file, GetParam().basePath, GetParam().particlesPath);
        writeParticles(file, GetParam().where);
    }
    NoteKeeper progress;
    MOTE_OPEN(source, {folder / "run.h5"}, progress);
    ASSERT_EQ(source->steps().size(), 1u);
    EXPECT_EQ(source->steps()[0].iteration, GetParam().iteration);
    EXPECT_EQ(source->steps()[0].particles, 3u);
    EXPECT_THAT(column(*source, 0, Column::x), near({0.001, 0.002, 0.003}));
    EXPECT_THAT(column(*source, 0, Column::pz), near({120, 220, 320}));
}

INSTANTIATE_TEST_SUITE_P(
    All, OpenpmdPaths,
    testing::Values(Paths{"/data/%T/", "particles/", "/data/550/particles/e", 550},
                    Paths{"/data/%T/", "particles", "/data/00001/particles/beam", 1},
                    Paths{"/data/%T/", "particles/", "/data/00001/particles", 1},
                    Paths{"/screen/%T/", "./", "/screen/0", 0}, Paths{"/screen/%T/", ".", "/screen/7", 7},
                    Paths{"/screen/%T/", "", "/screen/7", 7}, Paths{"/%T/", "/", "/12", 12},
                    Paths{"/%T", "beams/", "/12/beams/e", 12},
                    Paths{"/run/step_%06T/state/", "p/", "/run/step_000042/state/p/e", 42},
                    Paths{"/", "particles/", "/particles/e", 0}, Paths{"/", "./", "/beam", 0},
                    Paths{"", "", "/beam", 0}, Paths{"data/%T/", "particles/", "/data/3/particles/e", 3},
                    Paths{"/data/", "particles/", "/data/particles/e", 0}));

TEST(Openpmd, takesStandardPathsWhereTheFileNamesNone) {
    const TempDir folder;
    {
        H5TestFile file(folder / "run.h5");
        file.variableText("/", "openPMD", "2.0.0");
        writeParticles(file, "/data/5/particles/e");
    }
    NoteKeeper progress;
    MOTE_OPEN(source, {folder / "run.h5"}, progress);
    EXPECT_EQ(source->format(), "openpmd");
    EXPECT_EQ(source->steps().at(0).iteration, 5);
}

TEST(Openpmd, readsAttributesInEveryForm) {
    const TempDir folder;
    {
        H5TestFile file(folder / "run.h5");
        file.variableText("/", "openPMD", "1.0.1", true);  // an array of one text of variable length
        file.variableText("/", "basePath", "/data/%T/");
        file.text("/", "particlesPath", "particles/");
        writeParticles(file, "/data/1/particles/e");
        // An array of one, an integer, and a unit that stands at the record only.
        file.attribute("/data/1/particles/e/position/x", "unitSI", std::vector<double>{1e-6});
        file.attribute("/data/1/particles/e/position/y", "unitSI", std::int64_t{1});
        const hid_t z = H5Oopen(file.id(), "/data/1/particles/e/position/z", H5P_DEFAULT);
        H5Adelete(z, "unitSI");
        H5Oclose(z);
        file.attribute("/data/1/particles/e/position", "unitSI", std::vector<std::int32_t>{2});
        file.attribute("/data/1", "time", std::vector<double>{3.0});
        file.attribute("/data/1", "timeUnitSI", 1e-9);
    }
    NoteKeeper progress;
    MOTE_OPEN(source, {folder / "run.h5"}, progress);
    EXPECT_THAT(column(*source, 0, Column::x), near({1e-6, 2e-6, 3e-6}));
    EXPECT_THAT(column(*source, 0, Column::y), near({11, 12, 13}));
    EXPECT_THAT(column(*source, 0, Column::z), near({42, 44, 46}));
    EXPECT_DOUBLE_EQ(source->steps()[0].time, 3e-9);
}

/// Texts of variable length are read by our own code: behind a user block, in both formats of the file, among
/// many.
TEST(Openpmd, readsTextsWhereverTheyLie) {
    const TempDir folder;
    for (const hsize_t userBlock : {0, 2048}) {
        for (const bool latest : {false, true}) {
            {
                H5TestFile file(folder / "run.h5", userBlock, latest);
                for (int i = 0; i < 300; ++i) {
                    file.variableText("/", ("note" + std::to_string(i)).c_str(),
                                      std::string(static_cast<std::size_t>(i), 'n'));
                }
                file.variableText("/", "openPMD", "1.1.0");
                file.variableText("/", "basePath", "/run/%T/");
                file.variableText("/", "particlesPath", "");
                writeParticles(file, "/run/8/e");
                file.variableText("/run/8/e", "speciesType", "proton");
            }
            NoteKeeper progress;
            MOTE_OPEN(source, {folder / "run.h5"}, progress);
            EXPECT_EQ(source->steps().at(0).iteration, 8);
            EXPECT_NEAR(source->mass(), 938.272e6, 1e3);
            EXPECT_THAT(column(*source, 0, Column::x), near({0.001, 0.002, 0.003}));
        }
    }
}

TEST(Openpmd, addsOffsetsEachInItsOwnUnit) {
    const TempDir folder;
    {
        H5TestFile file(folder / "run.h5");
        writeRoot(file, "/data/%T/", "particles/");
        const std::string e = "/data/1/particles/e";
        writeParticles(file, e);
        file.data(e + "/positionOffset/x", std::vector<std::int32_t>{10, 20, 30});  // cells of 0.5 m
        file.attribute(e + "/positionOffset/x", "unitSI", 0.5);
        file.constant(e + "/positionOffset/z", 4.0, 3, 1e-3);
        file.constant(e + "/momentumOffset/z", 7.0, 3, 1e3 * electronvolt);
        file.data(e + "/time", std::vector<double>{1, 2, 3});
        file.attribute(e + "/time", "unitSI", 1e-12);
        file.constant(e + "/timeOffset", 5.0, 3, 1e-9);
    }
    NoteKeeper progress;
    MOTE_OPEN(source, {folder / "run.h5"}, progress);
    EXPECT_THAT(column(*source, 0, Column::x), near({5.001, 10.002, 15.003}));
    EXPECT_THAT(column(*source, 0, Column::y), near({0.011, 0.012, 0.013}));
    EXPECT_THAT(column(*source, 0, Column::z), near({0.025, 0.026, 0.027}));
    EXPECT_THAT(column(*source, 0, Column::pz), near({7120, 7220, 7320}));
    EXPECT_THAT(column(*source, 0, Column::t), near({5.001e-9, 5.002e-9, 5.003e-9}));
    EXPECT_DOUBLE_EQ(source->steps()[0].time, 5e-9) << "the offset, where the iteration names no time";
}

TEST(Openpmd, readsConstantsWhateverFormTheirShapeHas) {
    const TempDir folder;
    {
        H5TestFile file(folder / "run.h5");
        writeRoot(file, "/data/%T/", "particles/");
        const std::string e = "/data/1/particles/e";
        file.data(e + "/position/x", std::vector<float>{1.0f, 2.0f});
        file.constant(e + "/position/y", 2.5, 2);
        file.group(e + "/position/z");
        file.attribute(e + "/position/z", "value", std::vector<std::int32_t>{-3});
        file.attribute(e + "/position/z", "shape", std::vector<std::int32_t>{2});
        file.group(e + "/weighting");
        file.attribute(e + "/weighting", "value", 6.0);  // without a shape it fits any number of rows
    }
    NoteKeeper progress;
    MOTE_OPEN(source, {folder / "run.h5"}, progress);
    EXPECT_THAT(column(*source, 0, Column::x), ElementsAre(1, 2));
    EXPECT_THAT(column(*source, 0, Column::y), ElementsAre(2.5, 2.5));
    EXPECT_THAT(column(*source, 0, Column::z), ElementsAre(-3, -3));
    EXPECT_THAT(column(*source, 0, Column::weight), ElementsAre(6, 6));
    EXPECT_FALSE(source->has(Column::px));
    EXPECT_FALSE(source->has(Column::t));
    EXPECT_FALSE(source->has(Column::id));
}

TEST(Openpmd, turnsMacroParticlesIntoSingleOnes) {
    const TempDir folder;
    {
        H5TestFile file(folder / "run.h5");
        writeRoot(file, "/data/%T/", "particles/");
        const std::string e = "/data/1/particles/e";
        writeParticles(file, e);
        file.data(e + "/weighting", std::vector<double>{10, 20, 50});
        file.attribute(e + "/momentum", "macroWeighted", std::int64_t{1});
        file.attribute(e + "/momentum", "weightingPower", 1.0);
        file.attribute(e + "/momentum/y", "weightingPower", 2.0);  // a component may differ from its record
        file.attribute(e + "/momentum/z", "macroWeighted", std::int64_t{0});
        file.data(e + "/mass",
                  std::vector<double>{10 * 9.1093837015e-31, 20 * 9.1093837015e-31, 50 * 9.1093837015e-31});
        file.attribute(e + "/mass", "macroWeighted", std::int64_t{1});
        file.attribute(e + "/mass", "weightingPower", 1.0);
    }
    NoteKeeper progress;
    MOTE_OPEN(source, {folder / "run.h5"}, progress);
    EXPECT_THAT(column(*source, 0, Column::px), near({10, 10, 6}));
    EXPECT_THAT(column(*source, 0, Column::py), near({1.1, 0.525, 0.124}));
    EXPECT_THAT(column(*source, 0, Column::pz), near({120, 220, 320}));
    EXPECT_THAT(column(*source, 0, Column::weight), ElementsAre(10, 20, 50));
    // 1e-9: the electron's mass in kg and in eV/c^2 is each known to ten digits.
    EXPECT_NEAR(source->mass(), prep::electronMass, 1e-9 * prep::electronMass);
    EXPECT_TRUE(progress.notes.empty());
}

TEST(Openpmd, takesTheMagnitudeOfAChargeAsWeight) {
    const TempDir folder;
    {
        H5TestFile file(folder / "run.h5");
        writeRoot(file, "/data/%T/", "particles/");
        const std::string beam = "/data/1/particles";
        writeParticles(file, beam);
        file.data(beam + "/weight", std::vector<double>{-1, 2, -3});
        file.attribute(beam + "/weight", "unitSI", 1e-12);
        file.data(beam + "/particleStatus", std::vector<std::int64_t>{1, 3, 0});
        file.variableText(beam, "speciesType", "Hminus");
    }
    NoteKeeper progress;
    MOTE_OPEN(source, {folder / "run.h5"}, progress);
    const auto chunk = chunkOf(*source, 0, {Column::weight, Column::id});
    EXPECT_THAT(chunk[Column::weight], near({1e-12, 2e-12, 3e-12}));
    EXPECT_THAT(chunk.lost, ElementsAre(0, 1, 1));
    EXPECT_THAT(chunk.id, ElementsAre(0, 1, 2)) << "the row, where there are no ids";
    EXPECT_NEAR(source->mass(), 939.294e6, 1e3);
}

TEST(Openpmd, keepsIdsOf64Bits) {
    const TempDir folder;
    const std::vector<std::uint64_t> ids = {18446744073709551615u, 9223372036854775809u, 9007199254740993u};
    {
        H5TestFile file(folder / "run.h5");
        writeRoot(file, "/data/%T/", "particles/");
        writeParticles(file, "/data/1/particles/e");
        file.data("/data/1/particles/e/id", ids);
    }
    NoteKeeper progress;
    MOTE_OPEN(source, {folder / "run.h5"}, progress);
    EXPECT_EQ(chunkOf(*source, 0, {Column::id}).id, ids);
}

TEST(Openpmd, computesPzFromTheTotalMomentum) {
    const TempDir folder;
    {
        H5TestFile file(folder / "run.h5");
        writeRoot(file, "/data/%T/", "particles/");
        const std::string e = "/data/1/particles/e";
        file.data(e + "/momentum/x", std::vector<double>{3, 0});
        file.attribute(e + "/momentum/x", "unitSI", electronvolt);
        file.data(e + "/momentum/y", std::vector<double>{0, 5});
        file.attribute(e + "/momentum/y", "unitSI", electronvolt);
        file.data(e + "/totalMomentum", std::vector<double>{1, 9});
        file.attribute(e + "/totalMomentum", "unitSI", electronvolt);
        file.constant(e + "/totalMomentumOffset", 4.0, 2, electronvolt);
    }
    NoteKeeper progress;
    MOTE_OPEN(source, {folder / "run.h5"}, progress);
    EXPECT_THAT(column(*source, 0, Column::pz), near({4, 12}));
    EXPECT_FALSE(source->has(Column::x));
}

TEST(Openpmd, readsInPiecesWhatIsGzippedInChunks) {
    const TempDir folder;
    std::vector<double> values(10'000);
    for (std::size_t i = 0; i < values.size(); ++i) values[i] = std::sin(static_cast<double>(i));
    {
        H5TestFile file(folder / "run.h5");
        writeRoot(file, "/data/%T/", "particles/");
        file.gzipped("/data/1/particles/e/position/x", values, 333);
    }
    NoteKeeper progress;
    MOTE_OPEN(source, {folder / "run.h5"}, progress);
    std::vector<double> read;
    for (std::uint64_t begin = 0; begin < values.size(); begin += 777) {
        prep::ParticleChunk chunk;
        const std::size_t count = std::min<std::size_t>(777, values.size() - begin);
        ASSERT_TRUE(source->read(0, begin, count, {Column::x}, chunk).ok());
        EXPECT_EQ(chunk.begin, begin);
        EXPECT_EQ(chunk.size, count);
        read.insert(read.end(), chunk[Column::x].begin(), chunk[Column::x].end());
    }
    EXPECT_EQ(read, values);
    prep::ParticleChunk chunk;
    EXPECT_FALSE(source->read(0, 9'999, 2, {Column::x}, chunk).ok()) << "beyond the last row";
    EXPECT_FALSE(source->read(1, 0, 1, {Column::x}, chunk).ok()) << "beyond the last step";
}

TEST(Openpmd, ordersIterationsOfOneFileByNumber) {
    const TempDir folder;
    {
        H5TestFile file(folder / "run.h5");
        writeRoot(file, "/data/%T/", "particles/");
        for (const int i : {100, 20, 3})
            writeParticles(file, "/data/" + std::to_string(i) + "/particles/e", i);
        file.group("/data/notes");
    }
    NoteKeeper progress;
    MOTE_OPEN(source, {folder / "run.h5"}, progress);
    ASSERT_EQ(source->steps().size(), 3u);
    EXPECT_EQ(source->steps()[0].iteration, 3);
    EXPECT_EQ(source->steps()[2].iteration, 100);
    EXPECT_THAT(column(*source, 2, Column::x), near({0.101, 0.102, 0.103}));
    EXPECT_THAT(column(*source, 0, Column::x), near({0.004, 0.005, 0.006}));
}

TEST(Openpmd, takesSeveralFilesAsOneSeries) {
    const TempDir folder;
    for (const int i : {10, 9, 200}) {
        H5TestFile file(folder / ("run_" + std::to_string(i) + ".h5"));
        writeRoot(file, "/data/%T/", "particles/");
        file.text("/", "iterationEncoding", "fileBased");
        file.text("/", "iterationFormat", "run_%T.h5");
        writeParticles(file, "/data/" + std::to_string(i) + "/particles/e", i);
    }
    NoteKeeper progress;
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

TEST(Openpmd, choosesASpecies) {
    const TempDir folder;
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
    EXPECT_THAT(errorOf({folder / "run.h5"}, job), HasSubstr("holds no species 'muons' but electrons, ions"));
    job.set_species("ions");
    NoteKeeper progress;
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

TEST(Openpmd, survivesASpeciesWithoutParticles) {
    const TempDir folder;
    {
        H5TestFile file(folder / "run.h5");
        writeRoot(file, "/data/%T/", "particles/");
        file.data("/data/1/particles/e/position/x", std::vector<double>{});
        file.constant("/data/1/particles/e/position/y", 0.0, 0);
        file.data("/data/2/particles/e/position/x", std::vector<double>{4});
        file.data("/data/2/particles/e/position/y", std::vector<double>{5});
    }
    NoteKeeper progress;
    MOTE_OPEN(source, {folder / "run.h5"}, progress);
    EXPECT_EQ(source->steps()[0].particles, 0u);
    EXPECT_THAT(column(*source, 0, Column::x), ElementsAre());
    EXPECT_THAT(column(*source, 1, Column::y), ElementsAre(5));
}

TEST(Openpmd, hasAColumnWhereEveryStepHasIt) {
    const TempDir folder;
    {
        H5TestFile file(folder / "run.h5");
        writeRoot(file, "/data/%T/", "particles/");
        writeParticles(file, "/data/1/particles/e");
        file.data("/data/2/particles/e/position/x", std::vector<double>{4});
    }
    NoteKeeper progress;
    MOTE_OPEN(source, {folder / "run.h5"}, progress);
    EXPECT_TRUE(source->has(Column::x));
    EXPECT_FALSE(source->has(Column::y));
    EXPECT_FALSE(source->has(Column::px));
}

TEST(Openpmd, followsLinksWithinTheFile) {
    const TempDir folder;
    {
        H5TestFile file(folder / "run.h5");
        writeRoot(file, "/data/%T/", "particles/");
        writeParticles(file, "/store/e");
        file.group("/data/1");
        ASSERT_GE(H5Lcreate_soft("/store", file.id(), "/data/1/particles", H5P_DEFAULT, H5P_DEFAULT), 0);
        ASSERT_GE(H5Lcreate_soft("../1", file.id(), "/data/2", H5P_DEFAULT, H5P_DEFAULT), 0);
        ASSERT_GE(H5Lcreate_soft("1", file.id(), "/data/3", H5P_DEFAULT, H5P_DEFAULT), 0);
    }
    NoteKeeper progress;
    MOTE_OPEN(source, {folder / "run.h5"}, progress);
    ASSERT_EQ(source->steps().size(), 2u) << "HDF5 knows no '..', and a link to nothing is no iteration";
    EXPECT_THAT(column(*source, 1, Column::x), near({0.001, 0.002, 0.003}));
}

/// A beam as ImpactX writes it: path length in place of time, relative to the reference particle.
TEST(Openpmd, readsABeamRelativeToAReferenceParticle) {
    const TempDir folder;
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
    NoteKeeper progress;
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

TEST(Openpmd, saysWhatIsMissingAndWhere) {
    const TempDir folder;
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
                    writeParticles(file, e);
                    file.data(e + "/weighting", std::vector<double>{1, 2});
                }),
                HasSubstr("has 2 values where"));
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

TEST(Openpmd, stopsWhenCancelled) {
    const TempDir folder;
    {
        H5TestFile file(folder / "run.h5");
        writeRoot(file, "/data/%T/", "particles/");
        writeParticles(file, "/data/1/particles/e");
    }
    NoteKeeper progress;
    progress.cancel = true;
    const auto source = openFiles({folder / "run.h5"}, progress);
    ASSERT_FALSE(source.ok());
    EXPECT_EQ(source.error().code, ErrorCode::cancelled);
}

}  // namespace
}  // namespace mote::test
