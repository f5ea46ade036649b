// SPDX-License-Identifier: GPL-3.0-or-later
//
// openPMD files of every form that writers are known to make, written here record by record.
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

TEST_F(Openpmd, takesStandardPathsWhereTheFileNamesNone) {
    {
        H5TestFile file(folder / "run.h5");
        file.variableText("/", "openPMD", "2.0.0");
        writeParticles(file, "/data/5/particles/e");
    }
    MOTE_OPEN(source, {folder / "run.h5"}, progress);
    EXPECT_EQ(source->format(), "openpmd");
    EXPECT_EQ(source->steps().at(0).iteration, 5);
}

TEST_F(Openpmd, readsAttributesInEveryForm) {
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
    MOTE_OPEN(source, {folder / "run.h5"}, progress);
    EXPECT_THAT(column(*source, 0, Column::x), near({1e-6, 2e-6, 3e-6}));
    EXPECT_THAT(column(*source, 0, Column::y), near({11, 12, 13}));
    EXPECT_THAT(column(*source, 0, Column::z), near({42, 44, 46}));
    EXPECT_DOUBLE_EQ(source->steps()[0].time, 3e-9);
}

/// Texts of variable length are read by our own code: behind a user block, in both formats of the file, among
/// many.
TEST_F(Openpmd, readsTextsWhereverTheyLie) {
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
            NoteKeeper notes;
            MOTE_OPEN(source, {folder / "run.h5"}, notes);
            EXPECT_EQ(source->steps().at(0).iteration, 8);
            EXPECT_NEAR(source->mass(), 938.272e6, 1e3);
            EXPECT_THAT(column(*source, 0, Column::x), near({0.001, 0.002, 0.003}));
        }
    }
}

TEST_F(Openpmd, addsOffsetsEachInItsOwnUnit) {
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
    MOTE_OPEN(source, {folder / "run.h5"}, progress);
    EXPECT_THAT(column(*source, 0, Column::x), near({5.001, 10.002, 15.003}));
    EXPECT_THAT(column(*source, 0, Column::y), near({0.011, 0.012, 0.013}));
    EXPECT_THAT(column(*source, 0, Column::z), near({0.025, 0.026, 0.027}));
    EXPECT_THAT(column(*source, 0, Column::pz), near({7120, 7220, 7320}));
    EXPECT_THAT(column(*source, 0, Column::t), near({5.001e-9, 5.002e-9, 5.003e-9}));
    EXPECT_DOUBLE_EQ(source->steps()[0].time, 5e-9) << "the offset, where the iteration names no time";
}

TEST_F(Openpmd, readsConstantsWhateverFormTheirShapeHas) {
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
    MOTE_OPEN(source, {folder / "run.h5"}, progress);
    EXPECT_THAT(column(*source, 0, Column::x), ElementsAre(1, 2));
    EXPECT_THAT(column(*source, 0, Column::y), ElementsAre(2.5, 2.5));
    EXPECT_THAT(column(*source, 0, Column::z), ElementsAre(-3, -3));
    EXPECT_THAT(column(*source, 0, Column::weight), ElementsAre(6, 6));
    EXPECT_FALSE(source->has(Column::px));
    EXPECT_FALSE(source->has(Column::t));
    EXPECT_FALSE(source->has(Column::id));
}

TEST_F(Openpmd, turnsMacroParticlesIntoSingleOnes) {
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
    MOTE_OPEN(source, {folder / "run.h5"}, progress);
    EXPECT_THAT(column(*source, 0, Column::px), near({10, 10, 6}));
    EXPECT_THAT(column(*source, 0, Column::py), near({1.1, 0.525, 0.124}));
    EXPECT_THAT(column(*source, 0, Column::pz), near({120, 220, 320}));
    EXPECT_THAT(column(*source, 0, Column::weight), ElementsAre(10, 20, 50));
    // 1e-9: the electron's mass in kg and in eV/c^2 is each known to ten digits.
    EXPECT_NEAR(source->mass(), prep::electronMass, 1e-9 * prep::electronMass);
    EXPECT_TRUE(progress.notes.empty());
}

TEST_F(Openpmd, takesTheMagnitudeOfAChargeAsWeight) {
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
    MOTE_OPEN(source, {folder / "run.h5"}, progress);
    const auto chunk = chunkOf(*source, 0, {Column::weight, Column::id});
    EXPECT_THAT(chunk[Column::weight], near({1e-12, 2e-12, 3e-12}));
    EXPECT_THAT(chunk.lost, ElementsAre(0, 1, 0));  // 0: at the cathode, and live
    EXPECT_THAT(chunk.id, ElementsAre(0, 1, 2)) << "the row, where there are no ids";
    EXPECT_NEAR(source->mass(), 939.294e6, 1e3);
}

TEST_F(Openpmd, keepsIdsOf64Bits) {
    const std::vector<std::uint64_t> ids = {18446744073709551615u, 9223372036854775809u, 9007199254740993u};
    {
        H5TestFile file(folder / "run.h5");
        writeRoot(file, "/data/%T/", "particles/");
        writeParticles(file, "/data/1/particles/e");
        file.data("/data/1/particles/e/id", ids);
    }
    MOTE_OPEN(source, {folder / "run.h5"}, progress);
    EXPECT_EQ(chunkOf(*source, 0, {Column::id}).id, ids);
}

TEST_F(Openpmd, computesPzFromTheTotalMomentum) {
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
    MOTE_OPEN(source, {folder / "run.h5"}, progress);
    EXPECT_THAT(column(*source, 0, Column::pz), near({4, 12}));
    EXPECT_FALSE(source->has(Column::x));
}

TEST_F(Openpmd, readsInPiecesWhatIsGzippedInChunks) {
    std::vector<double> values(10'000);
    for (std::size_t i = 0; i < values.size(); ++i) values[i] = std::sin(static_cast<double>(i));
    {
        H5TestFile file(folder / "run.h5");
        writeRoot(file, "/data/%T/", "particles/");
        file.gzipped("/data/1/particles/e/position/x", values, 333);
    }
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

}  // namespace
}  // namespace mote::test
