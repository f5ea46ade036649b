// SPDX-License-Identifier: GPL-3.0-or-later
//
// openPMD files that are legal and rare, and runs of which a part is odd: the rest is read, and said so.
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

class OpenpmdOdd : public testing::Test {
  protected:
    template <class Fill>
    std::filesystem::path write(const std::string& name, Fill fill) {
        H5TestFile file(folder_ / name);
        fill(file);
        return folder_ / name;
    }

    const TempDir folder_;
    NoteKeeper progress_;
    const std::string e_ = "/data/1/particles/electrons";
};

TEST_F(OpenpmdOdd, aConstantHasItsValueWhateverItsShape) {
    const auto path = write("fbpic.h5", [&](H5TestFile& file) {
        writeRoot(file, "/data/%T/", "particles/");
        writeParticles(file, e_);
        for (const char* axis : {"x", "y", "z"}) file.constant(e_ + "/positionOffset/" + axis, 2.0, 1);
        file.constant(e_ + "/mass", 9.1093837015e-31, 1);
        file.constant(e_ + "/weighting", 5.0, 77);
    });
    MOTE_OPEN(source, {path}, progress_);
    EXPECT_THAT(column(*source, 0, Column::x), near({2.001, 2.002, 2.003}));
    EXPECT_THAT(column(*source, 0, Column::weight), ElementsAre(5, 5, 5));
    EXPECT_NEAR(source->mass(), prep::electronMass, 1.0);
}

TEST_F(OpenpmdOdd, aSpeciesMayBeginLater) {
    const auto path = write("run.h5", [&](H5TestFile& file) {
        writeRoot(file, "/data/%T/", "particles/");
        writeParticles(file, "/data/0/particles/ions");
        writeParticles(file, "/data/100/particles/ions");
        writeParticles(file, "/data/100/particles/electrons");
    });
    proto::ParticlesJob job;
    job.set_species("electrons");
    MOTE_OPEN(source, {path}, progress_, job);
    ASSERT_EQ(source->steps().size(), 2u);
    EXPECT_EQ(source->steps()[0].particles, 0u);
    EXPECT_EQ(source->steps()[1].particles, 3u);
    EXPECT_TRUE(source->has(Column::px));
}

TEST_F(OpenpmdOdd, aRecordThatCannotBeUsedIsLeftOut) {
    const auto path = write("run.h5", [&](H5TestFile& file) {
        writeRoot(file, "/data/%T/", "particles/");
        writeParticles(file, e_);
        file.data(e_ + "/weighting", std::vector<double>{1, 2, 3, 4, 5, 6});
        file.data(e_ + "/id", std::vector<double>{});
        file.group(e_ + "/particleStatus");
        H5Ldelete(file.id(), (e_ + "/position/y").c_str(), H5P_DEFAULT);
        file.group(e_ + "/position/y");
    });
    MOTE_OPEN(source, {path}, progress_);
    EXPECT_EQ(source->steps()[0].particles, 3u);
    EXPECT_FALSE(source->has(Column::y));
    EXPECT_FALSE(source->has(Column::weight));
    EXPECT_FALSE(source->has(Column::id));
    EXPECT_TRUE(source->has(Column::pz));
    EXPECT_TRUE(progress_.noted("record 'weighting' is left out: has 6 values where there are 3 particles"));
    EXPECT_TRUE(progress_.noted("record 'id' is left out: is empty"));
    EXPECT_TRUE(progress_.noted("record 'position/y' is left out: is neither a dataset nor a constant"));
    EXPECT_TRUE(progress_.noted("record 'particleStatus' is left out"));
}

TEST_F(OpenpmdOdd, aRecordMissingInOneStepIsMissingThereAlone) {
    const auto path = write("run.h5", [&](H5TestFile& file) {
        writeRoot(file, "/data/%T/", "particles/");
        for (const char* step : {"1", "2"})
            writeParticles(file, std::string("/data/") + step + "/particles/e");
        H5Ldelete(file.id(), "/data/2/particles/e/momentum/x", H5P_DEFAULT);
        file.data("/data/2/particles/e/momentum/x", std::vector<double>{});
    });
    MOTE_OPEN(source, {path}, progress_);
    ASSERT_TRUE(source->has(Column::px));
    EXPECT_THAT(column(*source, 0, Column::px), near({100, 200, 300}));
    for (const double px : column(*source, 1, Column::px)) EXPECT_TRUE(std::isnan(px));
}

TEST_F(OpenpmdOdd, oneStepThatCannotBeReadIsLeftOut) {
    const auto path = write("run.h5", [&](H5TestFile& file) {
        writeRoot(file, "/data/%T/", "particles/");
        writeParticles(file, "/data/1/particles/e");
        file.group("/data/2/particles/e/position/x");
        writeParticles(file, "/data/3/particles/e");
    });
    write("other.h5", [](H5TestFile&) {});
    MOTE_OPEN(source, {path}, progress_);
    ASSERT_EQ(source->steps().size(), 2u);
    EXPECT_EQ(source->steps()[1].iteration, 3);
    EXPECT_TRUE(progress_.noted("a step cannot be read and is left out: run.h5:/data/2"));
    writeFile(folder_ / "cut.h5", "\x89HDF\r\n\x1a\n and nothing more");
    NoteKeeper notes;
    MOTE_OPEN(files, {path, folder_ / "cut.h5"}, notes);
    EXPECT_EQ(files->steps().size(), 2u);
    EXPECT_TRUE(notes.noted("1 of the files is left out: cut.h5"));
}

TEST_F(OpenpmdOdd, lostParticlesOfImpactxHaveNoMomenta) {
    const auto path = write("lost.h5", [&](H5TestFile& file) {
        writeRoot(file, "/data/%T/", "particles/");
        const std::string lost = "/data/1/particles/particles_lost";
        for (const char* name :
             {"/position/x", "/position/y", "/position/t", "/momentum/x", "/momentum/y", "/momentum/t"})
            file.data(lost + name, std::vector<double>{0.5, 1.5});
        file.data(lost + "/weighting", std::vector<double>{7, 8});
        file.attribute(lost, "gamma_ref", 0.0);
        file.attribute(lost, "mass_ref", 0.0);
        file.attribute(lost, "pt_ref", -0.0);
    });
    MOTE_OPEN(source, {path}, progress_);
    EXPECT_THAT(column(*source, 0, Column::x), ElementsAre(0.5, 1.5));
    EXPECT_THAT(column(*source, 0, Column::t), near({0.5 / prep::speedOfLight, 1.5 / prep::speedOfLight}));
    EXPECT_THAT(column(*source, 0, Column::weight), ElementsAre(7, 8));
    for (const Column missing : {Column::z, Column::px, Column::py, Column::pz})
        EXPECT_FALSE(source->has(missing));
    EXPECT_TRUE(progress_.noted("z and momenta are missing"));
}

TEST_F(OpenpmdOdd, anIterationMayBeVariable) {
    const auto path = write("run.h5", [&](H5TestFile& file) {
        writeRoot(file, "/data/%T/", "particles/");
        file.text("/", "iterationEncoding", "variableBased");
        writeParticles(file, "/data/particles/e");
        file.attribute("/data", "snapshot", std::int64_t{42});
        file.attribute("/data", "time", 3.0);
        file.attribute("/data", "timeUnitSI", 1e-9);
    });
    MOTE_OPEN(source, {path}, progress_);
    ASSERT_EQ(source->steps().size(), 1u);
    EXPECT_EQ(source->steps()[0].iteration, 42);
    EXPECT_DOUBLE_EQ(source->steps()[0].time, 3e-9);
}

TEST_F(OpenpmdOdd, particlesAreFoundBelowGroups) {
    const auto archive = write("lume.h5", [&](H5TestFile& file) {
        writeParticles(file, "/astra/output/particles/3");
        writeParticles(file, "/astra/output/particles/12", 5);
        file.group("/astra/input");
    });
    MOTE_OPEN(steps, {archive}, progress_);
    ASSERT_EQ(steps->steps().size(), 2u);
    EXPECT_EQ(steps->steps()[1].iteration, 12);
    EXPECT_THAT(column(*steps, 1, Column::x), near({0.006, 0.007, 0.008}));

    const auto named = write("named.h5", [&](H5TestFile& file) {
        writeParticles(file, "/impact/output/particles/initial_particles");
        writeParticles(file, "/impact/output/particles/final_particles", 5);
    });
    EXPECT_THAT(errorOf({named}), HasSubstr("choose one with --species: final_particles, initial_particles"));
    proto::ParticlesJob job;
    job.set_species("final_particles");
    MOTE_OPEN(final, {named}, progress_, job);
    EXPECT_THAT(column(*final, 0, Column::x), near({0.006, 0.007, 0.008}));

    const auto whole = write("whole.h5", [&](H5TestFile& file) {
        file.group("/archive/run");
        file.text("/archive/run", "openPMD", "2.0.0");
        file.text("/archive/run", "basePath", "/data/%T/");
        file.text("/archive/run", "particlesPath", "particles/");
        writeParticles(file, "/archive/run/data/7/particles/e");
    });
    MOTE_OPEN(below, {whole}, progress_);
    EXPECT_EQ(below->steps()[0].iteration, 7);
    EXPECT_THAT(column(*below, 0, Column::x), near({0.001, 0.002, 0.003}));
    EXPECT_TRUE(progress_.noted("the group /archive/run"));
}

}  // namespace
}  // namespace mote::test
