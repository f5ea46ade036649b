// SPDX-License-Identifier: GPL-3.0-or-later
//
// What particles are, how much charge they have, and of which time they are: by each way in which files say
// it.
#include <gmock/gmock.h>

#include <cmath>

#include "preprocess/readers/known_species.h"
#include "tests/support/temp_dir.h"
#include "tests/unit/readers/h5_test_file.h"
#include "tests/unit/readers/openpmd_test_file.h"
#include "tests/unit/readers/source_test.h"

namespace mote::test {
namespace {

using prep::Column;
using testing::ElementsAre;
using testing::HasSubstr;
using Species = SourceTest;

constexpr double e = prep::elementaryCharge;
constexpr double unit = 931494102.42;  // eV/c^2, of one u

struct Said {
    std::string group, type;  ///< "" : no attribute
    double mass = 0.0;        ///< kg, of a record; 0: none
    double charge = 0.0;      ///< C, likewise
    bool macro = false;       ///< of macro-particles of 50
};

struct Meant {
    std::string species;
    double mass = 0.0, charge = 0.0;  ///< eV/c^2, C
};

void writeSpecies(const std::filesystem::path& path, const Said& said) {
    H5TestFile file(path);
    writeRoot(file, "/data/%T/", "particles/");
    const std::string group = "/data/7/particles/" + said.group;
    writeParticles(file, group);
    if (!said.type.empty()) file.variableText(group, "speciesType", said.type);
    const double each = said.macro ? 50.0 : 1.0;
    file.data(group + "/weighting", std::vector<double>{50.0, 50.0, 50.0});
    const auto add = [&](const std::string& name, double value) {
        file.data(group + "/" + name, std::vector<double>{each * value, each * value, each * value});
        file.attribute(group + "/" + name, "macroWeighted", std::int64_t{said.macro ? 1 : 0});
        file.attribute(group + "/" + name, "weightingPower", 1.0);
    };
    if (said.mass != 0.0) add("mass", said.mass);
    if (said.charge != 0.0) add("charge", said.charge);
}

TEST_F(Species, IsTheRecordsThenTheAttributesThenTheGroups) {
    constexpr double electron = 9.1093837015e-31, proton = 1.67262192369e-27, carbon = 1.99264687e-26;
    const double inEv = prep::massInEv;
    const std::vector<std::pair<Said, Meant>> all{
        {{"positrons", "", electron, e}, {"positron", electron * inEv, e}},
        {{"beam", "", electron, e, true}, {"positron", electron * inEv, e}},
        {{"beam", "", electron, -e}, {"electron", electron * inEv, -e}},
        {{"electrons", "", electron, e}, {"positron", electron * inEv, e}},
        {{"beam", "", proton, -e}, {"antiproton", proton * inEv, -e}},
        {{"C6+", "", carbon, 6 * e}, {"#12C+6", carbon * inEv, 6 * e}},
        {{"electrons", "#12C+3"}, {"#12C+3", 12 * unit - 3 * prep::electronMass, 3 * e}},
        {{"ions", "#40Ar+8"}, {"#40Ar+8", 39.96238312204 * unit - 8 * prep::electronMass, 8 * e}},
        {{"positrons", ""}, {"positron", prep::electronMass, e}},
        {{"beam", "antiproton"}, {"antiproton", 938272088.16, -e}},
        {{"beam", "H-"}, {"H-", 939294071.71, -e}},
        {{"beam", "unobtainium"}, {"unobtainium", 0.0, 0.0}},
        {{"beam", ""}, {"", 0.0, 0.0}},
    };
    for (const auto& [said, meant] : all) {
        writeSpecies(folder / "run.h5", said);
        NoteKeeper notes;
        MOTE_OPEN(source, {folder / "run.h5"}, notes);
        EXPECT_EQ(source->species(), meant.species) << said.group << " " << said.type;
        EXPECT_NEAR(source->mass(), meant.mass, 1e-7 * meant.mass) << said.group << " " << said.type;
        EXPECT_NEAR(source->particleCharge(), meant.charge, 1e-12 * e) << said.group << " " << said.type;
    }
}

TEST_F(Species, AGivenMassIsUsedOrRefused) {
    proto::ParticlesJob job;
    job.set_mass(123456789.0);
    writeSpecies(folder / "run.h5", {"beam", ""});
    MOTE_OPEN(source, {folder / "run.h5"}, progress, job);
    EXPECT_EQ(source->mass(), 123456789.0);
    writeSpecies(folder / "run.h5", {"beam", "electron"});
    EXPECT_THAT(errorOf({folder / "run.h5"}, job), HasSubstr("leave the mass out"));
    job.set_mass(prep::electronMass);
    EXPECT_EQ(errorOf({folder / "run.h5"}, job), "");
}

TEST_F(Species, NamesOfNuclidesAreReadToTheEnd) {
    EXPECT_EQ(prep::speciesOf("#238U+92")->charge, 92 * e);
    EXPECT_EQ(prep::speciesOf("#1H-")->name, "H-");
    EXPECT_FALSE(prep::speciesOf("#12C")->chargeKnown);
    for (const char* wrong :
         {"#", "#C", "#12", "#12Q+3", "#12C3", "#12C+3x", "#12C+-3", "#-12C+3", "#99999999999C+3"})
        EXPECT_FALSE(prep::speciesOf(wrong).has_value()) << wrong;
    EXPECT_EQ(prep::speciesOf(938272088.16, 0.0)->name, "proton");
    EXPECT_TRUE(prep::speciesOf(938272088.16, 0.0)->usual);
    EXPECT_FALSE(prep::speciesOf(938272088.16, e)->usual);
    EXPECT_FALSE(prep::speciesOf(1e9, e).has_value());
}

TEST_F(Species, StepsHaveTheTimeOfTheirParticles) {
    {
        H5TestFile file(folder / "run.h5");
        writeRoot(file, "/screen/%T/", "./");
        for (int step = 0; step < 3; ++step) {
            const std::string group = "/screen/" + std::to_string(step);
            writeParticles(file, group);
            const double t = 1e-9 * step;
            file.data(group + "/time", std::vector<double>{t, t - 1e-12, t + 1e-12});
        }
    }
    MOTE_OPEN(source, {folder / "run.h5"}, progress);
    for (std::size_t step = 0; step < 3; ++step)
        EXPECT_NEAR(source->steps()[step].time, 1e-9 * static_cast<double>(step), 1e-20);
}

TEST_F(Species, H5PartHasTheUnitOfItsCharges) {
    for (const auto& [written, factor] : {std::pair{"C", 1.0}, std::pair{"nC", 1e-9}}) {
        for (const double sign : {1.0, -1.0}) {
            {
                H5TestFile file(folder / "run.h5");
                for (const char* axis : {"x", "px", "py", "pz"})
                    file.data(std::string("/Step#0/") + axis, std::vector<double>{1.0, 2.0, 3.0});
                file.data("/Step#0/q", std::vector<double>{2.0 * sign, 2.0 * sign, 3.0 * sign});
                file.attribute("/Step#0", "MASS", prep::electronMass * 1e-9);
                file.text("/", "qUnit", written);
                file.text("/", "pxUnit", "#beta#gamma");
            }
            NoteKeeper notes;
            MOTE_OPEN(source, {folder / "run.h5"}, notes);
            EXPECT_EQ(source->weightUnit(), "C");
            EXPECT_THAT(column(*source, 0, Column::weight), near({2.0 * factor, 2.0 * factor, 3.0 * factor}));
            EXPECT_EQ(source->species(), sign < 0 ? "electron" : "positron");
            EXPECT_EQ(source->particleCharge(), sign * e);
            EXPECT_TRUE(notes.noted("after the mass and the sign"));
        }
    }
}

}  // namespace
}  // namespace mote::test
