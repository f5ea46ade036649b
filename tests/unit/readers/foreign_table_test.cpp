// SPDX-License-Identifier: GPL-3.0-or-later
//
// Tables of other people: momenta in units of a reference momentum, units in every form, a map of columns,
// and tables that are not what they are called.
#include <gmock/gmock.h>

#include <cmath>

#include "preprocess/readers/field_meaning.h"
#include "preprocess/readers/known_files.h"
#include "preprocess/readers/table/table_quantity.h"
#include "tests/support/temp_dir.h"
#include "tests/unit/readers/source_test.h"

namespace mote::test {
namespace {

using prep::Column;
using testing::DoubleNear;
using testing::ElementsAre;
using testing::HasSubstr;

class ForeignTable : public testing::Test {
  protected:
    std::filesystem::path write(const std::string& name, const std::string& text) {
        writeFile(folder_ / name, text);
        return folder_ / name;
    }
    proto::ParticlesJob mapped(const std::string& map) {
        proto::ParticlesJob job;
        job.set_map(map);
        return job;
    }

    const TempDir folder_;
    NoteKeeper progress_;
};

testing::Matcher<double> close(double value) {
    return DoubleNear(value, 1e-12 * std::abs(value));
}

TEST_F(ForeignTable, ofXsuiteHasMomentaInUnitsOfP0c) {
    const auto path = write("p.csv",
                            ",particle_id,state,at_turn,x,px,y,py,zeta,delta,p0c,mass0,q0,weight,s\n"
                            "0,7,1,3,1e-4,0.01,2e-4,-0.02,3e-3,0.05,1e9,938272088.16,1.0,40,0\n"
                            "1,8,0,3,2e-4,0.0,2e-4,0.0,-3e-3,0.0,1e9,938272088.16,1.0,40,0\n"
                            "2,9,-1,3,2e-4,0.0,2e-4,0.0,-3e-3,0.0,1e9,938272088.16,1.0,40,0\n");
    MOTE_OPEN(source, {path}, progress_);
    EXPECT_THAT(column(*source, 0, Column::px), ElementsAre(close(1e7), 0, 0));
    EXPECT_THAT(column(*source, 0, Column::py)[0], close(-2e7));
    EXPECT_THAT(column(*source, 0, Column::pz)[0],
                close(1e9 * std::sqrt(1.05 * 1.05 - 0.01 * 0.01 - 0.02 * 0.02)));
    EXPECT_THAT(column(*source, 0, Column::z), ElementsAre(3e-3, -3e-3, -3e-3));
    const double beta = 1e9 / std::hypot(1e9, 938272088.16);
    EXPECT_THAT(column(*source, 0, Column::t)[0], close(-3e-3 / beta / prep::speedOfLight));
    const auto chunk = chunkOf(*source, 0, {Column::id, Column::weight});
    EXPECT_THAT(chunk.lost, ElementsAre(0, 1, 1)) << "live ones are of state 1 and above";
    EXPECT_THAT(chunk.id, ElementsAre(7, 8, 9));
    EXPECT_EQ(source->mass(), 938272088.16);
    EXPECT_EQ(source->weightUnit(), "1");
    EXPECT_EQ(source->species(), "proton");
    EXPECT_TRUE(progress_.noted("times the reference momentum"));
}

TEST_F(ForeignTable, withoutP0cHasNoMomentaThatCouldBeBelieved) {
    const auto path = write("p.csv", "x,px,y,py,zeta,delta\n1,0.1,1,0.1,0,0\n");
    EXPECT_THAT(errorOf({path}), HasSubstr("units of the reference momentum, which it does not give"));
    EXPECT_EQ(errorOf({path}, mapped("x=x,px=px,y=y,py=py,z=zeta,delta=delta,p0c=2e9")), "");
    MOTE_OPEN(source, {path}, progress_, mapped("x=x [mm],px=px,py=py,delta=delta,p0c=2.0 [GeV/c]"));
    EXPECT_THAT(column(*source, 0, Column::px), ElementsAre(close(2e8)));
    EXPECT_THAT(column(*source, 0, Column::x), ElementsAre(1e-3));
}

TEST_F(ForeignTable, saysWhichUnitsItAssumes) {
    MOTE_OPEN(source, {write("p.csv", "x,y [mm],px,t,q\n1,2,3,4,5\n")}, progress_);
    EXPECT_THAT(progress_.notes, testing::UnorderedElementsAre("no unit is given for x: taken as m",
                                                               "no unit is given for px: taken as eV/c",
                                                               "no unit is given for t: taken as s",
                                                               "no unit is given for q: taken as C"));
    EXPECT_EQ(source->weightUnit(), "C");
}

TEST_F(ForeignTable, readsUnitsWhereverTheyStand) {
    for (const char* text :
         {"x [mm],px (MeV/c),q {nC}\n1,2,3\n", "x/mm,px/MeV/c,q/nC\n1,2,3\n",
          "x_mm,px_MeV/c,charge_nC\n1,2,3\n", "x,px,q\nmm,MeV/c,nC\n1,2,3\n",
          "# x px q\n# [mm] [MeV/c] [nC]\n1 2 3\n", "Made by hand\nof a beam\nx(mm) px(MeV/c) q(nC)\n1 2 3\n",
          "x\tpx\tq\n(mm)\t(MeV/c)\t(nC)\n1\t2\t3\n"}) {
        MOTE_OPEN(source, {write("p.txt", text)}, progress_);
        ASSERT_EQ(source->steps()[0].particles, 1u) << text;
        EXPECT_THAT(column(*source, 0, Column::x), ElementsAre(1e-3)) << text;
        EXPECT_THAT(column(*source, 0, Column::px), ElementsAre(2e6)) << text;
        EXPECT_THAT(column(*source, 0, Column::weight), ElementsAre(close(3e-9))) << text;
        EXPECT_EQ(source->weightUnit(), "C") << text;
    }
    EXPECT_TRUE(progress_.notes.empty()) << progress_.notes.front();
}

TEST_F(ForeignTable, turnsSlopesVelocitiesAndEnergiesIntoMomenta) {
    const double mass = prep::electronMass;
    proto::ParticlesJob job;
    job.mutable_impact()->set_mass(mass);
    MOTE_OPEN(slopes, {write("s.txt", "x(mm) x'(mrad) y(mm) y'(mrad) ekin(MeV) loss\n1 3 1 4 2 0\n")},
              progress_, job);
    const double p = std::sqrt(2e6 * (2e6 + 2 * mass)), norm = std::sqrt(1 + 9e-6 + 16e-6);
    EXPECT_THAT(column(*slopes, 0, Column::pz), ElementsAre(close(p / norm)));
    EXPECT_THAT(column(*slopes, 0, Column::px), ElementsAre(close(3e-3 * p / norm)));
    MOTE_OPEN(speeds, {write("v.csv", "x,vx [m/s],vy [m/s],vz [c]\n1,0,0,0.6\n")}, progress_, job);
    EXPECT_THAT(column(*speeds, 0, Column::pz), ElementsAre(close(0.75 * mass)));
    MOTE_OPEN(gammas, {write("g.csv", "x,px [eV/c],py [eV/c],gamma\n1,3e6,4e6,20\n")}, progress_, job);
    EXPECT_THAT(column(*gammas, 0, Column::pz), ElementsAre(close(std::sqrt(399.0 * mass * mass - 25e12))));
}

TEST_F(ForeignTable, isReadByAMap) {
    const auto names = write("a.txt", "% a title\nPosX;PosY;MomX;Q1\n1,5;2;3;-4\n");
    MOTE_OPEN(named, {names}, progress_, mapped("x=PosX [mm],y=PosY[cm], px=MomX [keV/c],weight=Q1 [pC]"));
    EXPECT_THAT(column(*named, 0, Column::x), ElementsAre(1.5e-3));
    EXPECT_THAT(column(*named, 0, Column::y), ElementsAre(0.02));
    EXPECT_THAT(column(*named, 0, Column::px), ElementsAre(3e3));
    EXPECT_THAT(column(*named, 0, Column::weight), ElementsAre(close(4e-12)));
    const auto numbers = write("b.txt", "1 2 3\n4 5 6\n");
    MOTE_OPEN(nameless, {numbers}, progress_, mapped("z=1 [mm],x=3"));
    EXPECT_THAT(column(*nameless, 0, Column::z), ElementsAre(1e-3, 4e-3));
    EXPECT_THAT(column(*nameless, 0, Column::x), ElementsAre(3, 6));
    EXPECT_THAT(errorOf({names}, mapped("x=Pos")),
                HasSubstr("the table has no column 'Pos'; it has PosX, PosY"));
    EXPECT_THAT(errorOf({names}, mapped("q7=PosX")), HasSubstr("map: 'q7' is none of x, y, z, t, px"));
    EXPECT_THAT(errorOf({names}, mapped("x")), HasSubstr("is not QUANTITY=COLUMN [UNIT]"));
    EXPECT_THAT(errorOf({names}, mapped("x=PosX [furlong]")), HasSubstr("'furlong', which is not known"));
}

TEST_F(ForeignTable, ofNineColumnsIsNoBeamOfImpactUnlessItCanBe) {
    proto::ParticlesJob job;
    job.set_format("impactz");
    job.mutable_impact()->set_mass(938272088.16);
    job.mutable_impact()->set_frequency(2e8);
    job.mutable_impact()->set_kinetic_energy(2.5e6);
    const auto rows = [](const std::string& row) {
        std::string text;
        for (int i = 0; i < 40; ++i) text += row;
        return text;
    };
    EXPECT_EQ(errorOf({write("a", rows("0.1 0.01 0.1 0.01 0.5 -0.01 1.0658e-9 1e-15 3\n"))}, job), "");
    EXPECT_THAT(errorOf({write("b", rows("0.1 0.01 0.1 0.01 0.5 -0.01 1.0658e-9 1e-15 3.5\n"))}, job),
                HasSubstr("b: line 1, column 9: this is no particle file of IMPACT-Z"));
    EXPECT_THAT(errorOf({write("c", rows("0.1 0.01 0.1 0.01 0.5 -0.01 1 1e-15 3\n"))}, job),
                HasSubstr("column 7: this is no particle file"));
    EXPECT_THAT(errorOf({write("d", rows("0.1 0.01 0.1 0.01 5e9 -0.01 1.0658e-9 1e-15 3\n"))}, job),
                HasSubstr("column 5: this is no particle file"));
    EXPECT_THAT(errorOf({write("e", rows("0.1 9.0 0.1 0.01 0.5 -0.01 1.0658e-9 1e-15 3\n"))}, job),
                HasSubstr("less than their transverse momenta ask for"));
}

TEST_F(ForeignTable, ofAFolderIsARun) {
    const auto run = folder_ / "run";
    std::filesystem::create_directory(run);
    for (const int i : {10, 9, 11})
        writeFile(run / ("s" + std::to_string(i) + ".csv"), "x [m]\n" + std::to_string(i) + "\n");
    writeFile(run / "README", "what this is\n");
    writeFile(run / ".hidden.csv", "x [m]\n5\n");
    writeFile(run / "s12.csv", "x [m],y [furlong]\n5,1\n");
    MOTE_OPEN(source, {run}, progress_);
    ASSERT_EQ(source->steps().size(), 3u);
    EXPECT_EQ(source->steps()[0].iteration, 9);
    EXPECT_THAT(column(*source, 2, Column::x), ElementsAre(11));
    EXPECT_TRUE(progress_.noted("2 of the files are left out: "));
}

TEST_F(ForeignTable, aDeckBesideDumpsIsSaidToBeOne) {
    const auto run = folder_ / "dumps";
    std::filesystem::create_directory(run);
    writeFile(run / "ImpactZ.in", "1 2\n");
    writeFile(run / "s1.csv", "x [m]\n1\n");
    MOTE_OPEN(source, {run}, progress_);
    EXPECT_EQ(source->steps().size(), 1u);
    EXPECT_TRUE(progress_.noted("1 of the files is left out: ImpactZ.in is IMPACT's own input"));
}

TEST(KnownFile, isNamedWithAWayOut) {
    const auto said = [](std::string begin, const char* name = "file") {
        return prep::knownFile(begin, name, prep::WantedAs::particles).value_or("");
    };
    EXPECT_THAT(said(std::string("root\x00\x01", 6)),
                HasSubstr("is a ROOT file, which is not read as particles; uproot"));
    EXPECT_THAT(said(std::string(128, '\0') + "DICM"), HasSubstr("DICOM"));
    EXPECT_THAT(said("# vtk DataFile Version 3.0\n"), HasSubstr("VTK"));
    EXPECT_THAT(said("MATLAB 5.0 MAT-file, Platform"), HasSubstr("scipy.io.loadmat"));
    EXPECT_THAT(said("solid cube\n"), HasSubstr("mote-prep mesh"));
    EXPECT_THAT(said("<?xml version=\"1.0\"?>\n<VTKFile type=\"ImageData\""), HasSubstr("VTK image"));
    EXPECT_THAT(said("ITEM: TIMESTEP\n0\n"), HasSubstr("LAMMPS"));
    EXPECT_EQ(said("1 2 3\n"), "");
}

TEST(TableMeaning, isThatOfItsFirstName) {
    // Every quantity that has a name has a meaning, and no name two.
    for (const char* name :
         {"x", "px", "xp", "p0c", "mass", "zeta", "delta", "ptau", "gamma", "vx", "r", "pphi"}) {
        const auto meaning = prep::tableMeaning(name, "");
        ASSERT_TRUE(meaning.ok() && meaning->has_value()) << name;
    }
    EXPECT_FALSE(prep::tableMeaning("x_mean", "")->has_value());
    EXPECT_FALSE(prep::tableMeaning("Bx", "")->has_value()) << "a field in most tables";
    EXPECT_EQ((*prep::tableMeaning("t_ns", ""))->factor, 1e-9);
    EXPECT_TRUE((*prep::tableMeaning("GBx", ""))->inMass);
}

}  // namespace
}  // namespace mote::test
