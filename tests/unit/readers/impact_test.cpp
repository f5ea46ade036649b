// SPDX-License-Identifier: GPL-3.0-or-later
//
// Particle files of IMPACT-Z and IMPACT-T, their decks and what Fortran does to numbers.
#include <gmock/gmock.h>
#include <zlib.h>

#include <cmath>

#include "preprocess/readers/field_meaning.h"
#include "preprocess/readers/impact/impact_deck.h"
#include "tests/support/must.h"
#include "tests/support/temp_dir.h"
#include "tests/unit/readers/source_test.h"

namespace mote::test {
namespace {

using prep::Column;
using prep::ImpactDeck;
using testing::ElementsAre;
using testing::HasSubstr;
using ImpactT = SourceTest;
using ImpactZ = SourceTest;

constexpr double frequency = 1e9, mass = 500e6, energy = 100e6;

constexpr const char* deckZ = R"(! a comment, and a blank line

  1 1 /  processors
6 1000 2 0 1
32 32 64, 1 0.02 0.02
  0.1            ! a read goes on in the next line
3 0 0 1
1000
0.5D-1
-1.064629e-9
7*0.0
3*1.0 2*2.0 0.0 0.0
0 0 0 /
0.05 1.0d8 5.0D+8 -1.0 1000.0e6 0.0
0.25 10 20 0 1.0 /
0.0 0 101 -2 1 /
!0.5 10 20 0 1.0 /
0.5 10 20 101 2.0 /
0.0 0 102 -2 1 /
0.0 0 0 -99 /
9.0 10 20 0 1.0 /
0.0 0 103 -2 1 /
)";

/// gamma 1.2 at the start, rising by 0.4 a metre; the phase by 10 rad a metre.
constexpr const char* track =
    "0.00 1.0 1.20 1.0\n0.10 2.0 1.24 1.0\n0.25 3.5 1.30 1.0\n0.25 3.5 1.30 1.0\n0.75 8.5 1.5D0 1.0\n";

void writeGzip(const std::filesystem::path& path, std::string_view bytes) {
    const gzFile file = gzopen(path.c_str(), "wb");
    ASSERT_EQ(gzwrite(file, bytes.data(), static_cast<unsigned>(bytes.size())),
              static_cast<int>(bytes.size()));
    ASSERT_EQ(gzclose(file), Z_OK);
}

TEST(ImpactDeck, isReadAsFortranReadsIt) {
    const TempDir folder;
    writeFile(folder / "ImpactZ.in", deckZ);
    const auto deck = must(ImpactDeck::read(folder / "ImpactZ.in", ImpactDeck::Code::impactZ));
    EXPECT_EQ(deck.particles, 1000);
    EXPECT_EQ(deck.current, 0.05);
    EXPECT_EQ(deck.kineticEnergy, 1e8);
    EXPECT_EQ(deck.mass, 5e8);
    EXPECT_EQ(deck.frequency, 1e9);
    EXPECT_THAT(deck.dumps, ElementsAre(std::pair(101, 0.25), std::pair(102, 0.75))) << "nothing behind -99";
}

TEST(ImpactDeck, saysInWhichLineItIsWrong) {
    const TempDir folder;
    const auto error = [&](std::string text) {
        writeFile(folder / "ImpactZ.in", text);
        const auto deck = ImpactDeck::read(folder / "ImpactZ.in", ImpactDeck::Code::impactZ);
        return deck.ok() ? std::string() : deck.error().toString();
    };
    EXPECT_THAT(error("1 1\n6 1000 2 0 1\n"), HasSubstr("ImpactZ.in: line 2: the deck ends before"));
    EXPECT_THAT(error("1 1\nsix\n"),
                HasSubstr("line 2: has no numbers where the number of particles should stand"));
    std::string text = deckZ;
    text.replace(text.find("1000.0e6"), 8, "0.000000");
    EXPECT_THAT(error(text), HasSubstr("line 14: needs a mass and a frequency above 0"));
    text = deckZ;
    text.replace(text.find("3 0 0 1"), 7, "3 0 0 0");
    EXPECT_THAT(error(text), HasSubstr("impossible number of charge states"));
    EXPECT_THAT(error(std::string(100'000, '7')), HasSubstr("longer than 64 KiB"));
}

TEST(ReferenceTrack, isStraightBetweenItsPoints) {
    const TempDir folder;
    writeFile(folder / "fort.18", std::string("0 0 1.1\n7 9 1.9\n") + track);
    const auto read = prep::ReferenceTrack::read(folder / "fort.18");
    ASSERT_TRUE(read.ok());
    EXPECT_EQ(read->points.size(), 5u) << "an earlier run stands before";
    EXPECT_DOUBLE_EQ(read->at(0.25).gamma, 1.3);
    EXPECT_DOUBLE_EQ(read->at(0.5).gamma, 1.4);
    EXPECT_DOUBLE_EQ(read->at(0.5).phase, 6.0);
    EXPECT_DOUBLE_EQ(read->at(-1).gamma, 1.2);
    EXPECT_DOUBLE_EQ(read->at(9).gamma, 1.5);
    writeFile(folder / "fort.18", "0 0 0.5\n");
    EXPECT_FALSE(prep::ReferenceTrack::read(folder / "fort.18").ok());
    writeFile(folder / "fort.18", "");
    EXPECT_FALSE(prep::ReferenceTrack::read(folder / "fort.18").ok());
}

/// Two particles in IMPACT-Z's units; the second in the forms that Fortran gives to numbers.
constexpr const char* dump =
    "  0.1 0.02 0.3 0.04 0.5 0.06 -1.0E-9 -2.0E-15 1.0\n"
    "  -0.1D+0 0.0 +0.0 0.123-104 -.25 -6.D-2 -1.0E-9 -2.5D-15 0.2E+1\n";

TEST_F(ImpactZ, turnsUnitsByDeckAndTrack) {
    writeFile(folder / "ImpactZ.in", deckZ);
    writeFile(folder / "fort.18", track);
    writeFile(folder / "fort.102", dump);
    writeGzip(folder / "fort.101.txt.gz", dump);
    MOTE_OPEN(source, {folder / "fort.102", folder / "fort.101.txt.gz"}, progress);
    EXPECT_EQ(source->format(), "impactz");
    EXPECT_EQ(source->mass(), mass);
    ASSERT_EQ(source->steps().size(), 2u);
    EXPECT_EQ(source->steps()[0].iteration, 101);
    EXPECT_EQ(source->steps()[1].iteration, 102);
    const double omega = 2 * M_PI * frequency;
    EXPECT_DOUBLE_EQ(source->steps()[0].time, 3.5 / omega);
    EXPECT_DOUBLE_EQ(source->steps()[1].time, 8.5 / omega);

    const double length = prep::speedOfLight / omega;
    const double gamma = 1.3, beta = std::sqrt(1 - 1 / (gamma * gamma));
    const auto close = [](double value) { return testing::DoubleNear(value, 1e-12 * std::abs(value)); };
    EXPECT_THAT(column(*source, 0, Column::x), ElementsAre(close(0.1 * length), close(-0.1 * length)));
    EXPECT_THAT(column(*source, 0, Column::y), ElementsAre(close(0.3 * length), 0));
    EXPECT_THAT(column(*source, 0, Column::px), ElementsAre(close(0.02 * mass), 0));
    EXPECT_THAT(column(*source, 0, Column::py), ElementsAre(close(0.04 * mass), close(0.123e-104 * mass)));
    EXPECT_THAT(column(*source, 0, Column::z),
                ElementsAre(close(-0.5 * beta * length), close(0.25 * beta * length)));
    EXPECT_THAT(column(*source, 0, Column::t), ElementsAre(close(0.5 / omega), close(-0.25 / omega)));
    const double g0 = gamma - 0.06, g1 = gamma + 0.06;
    EXPECT_THAT(column(*source, 0, Column::pz),
                ElementsAre(close(mass * std::sqrt(g0 * g0 - 1 - 0.02 * 0.02 - 0.04 * 0.04)),
                            close(mass * std::sqrt(g1 * g1 - 1))));
    const auto chunk = chunkOf(*source, 0, {Column::weight, Column::id});
    EXPECT_THAT(chunk[Column::weight], ElementsAre(2e-15, 2.5e-15));
    EXPECT_THAT(chunk.id, ElementsAre(1, 2));
    EXPECT_TRUE(progress.noted("units and mass are those of ImpactZ.in"));
    EXPECT_TRUE(progress.noted("fort.18"));
}

TEST_F(ImpactZ, saysThatItTakesTheEnergyAtTheStart) {
    writeFile(folder / "ImpactZ.in", deckZ);
    writeFile(folder / "fort.101", dump);
    MOTE_OPEN(source, {folder / "fort.101"}, progress);
    const double gamma = 1 + energy / mass + 0.06;
    EXPECT_NEAR(column(*source, 0, Column::pz)[1], mass * std::sqrt(gamma * gamma - 1), 1e-6);
    EXPECT_EQ(source->steps()[0].time, 0.0);
    EXPECT_TRUE(progress.noted("is not known at fort.101"));
    writeFile(folder / "fort.18", track);
    writeFile(folder / "fort.999", dump);
    NoteKeeper other;
    MOTE_OPEN(unlisted, {folder / "fort.999"}, other);
    EXPECT_TRUE(other.noted("is not known at fort.999")) << "no such file in the deck";
}

TEST_F(ImpactZ, takesUnitsFromTheJobBeforeTheDeck) {
    writeFile(folder / "beam.txt", dump);
    proto::ParticlesJob job;
    job.set_format("impactz");
    EXPECT_THAT(errorOf({folder / "beam.txt"}, job),
                HasSubstr("impact.frequency: no ImpactZ.in stands beside"));
    job.mutable_impact()->set_frequency(frequency / 2);
    EXPECT_THAT(errorOf({folder / "beam.txt"}, job), HasSubstr("impact.mass: no ImpactZ.in stands beside"));
    job.mutable_impact()->set_mass(2 * mass);
    job.mutable_impact()->set_kinetic_energy(2 * mass);  // gamma 2
    writeFile(folder / "ImpactZ.in", deckZ);
    MOTE_OPEN(source, {folder / "beam.txt"}, progress, job);
    EXPECT_EQ(source->mass(), 2 * mass);
    EXPECT_NEAR(column(*source, 0, Column::x)[0], 0.1 * prep::speedOfLight / (M_PI * frequency), 1e-12);
    EXPECT_NEAR(column(*source, 0, Column::pz)[1], 2 * mass * std::sqrt(2.06 * 2.06 - 1), 1e-5);
    job.mutable_impact()->set_kinetic_energy(-1e30);
    EXPECT_THAT(errorOf({folder / "beam.txt"}, job), HasSubstr("impact.kinetic_energy: needs a number"));
}

TEST_F(ImpactZ, givesNoNumberToAParticleWhoseEnergyIsTooSmall) {
    writeFile(folder / "ImpactZ.in", deckZ);
    writeFile(folder / "fort.101", "0 9.0 0 0 0 0 -1e-9 -2e-15 1\n");
    MOTE_OPEN(source, {folder / "fort.101"}, progress);
    EXPECT_TRUE(std::isnan(column(*source, 0, Column::pz)[0]));
}

TEST_F(ImpactZ, readsAnyRowsOfAGzippedFileInAnyOrder) {
    std::string text = " 3000 0.0 0.0\n";
    for (int i = 0; i < 3000; ++i) {
        text += std::to_string(i) + " 0 0 0 0 0 -1e-9 -1e-15 " + std::to_string(i + 1) + "\n";
    }
    writeFile(folder / "ImpactZ.in", deckZ);
    writeGzip(folder / "fort.101.gz", text);
    MOTE_OPEN(source, {folder / "fort.101.gz"}, progress);
    ASSERT_EQ(source->steps()[0].particles, 3000u) << "the first line counts the rows";
    for (const std::uint64_t begin : {2500u, 0u, 100u, 99u}) {
        prep::ParticleChunk chunk;
        ASSERT_TRUE(source->read(0, begin, 500, {Column::id}, chunk).ok());
        EXPECT_EQ(chunk.id.front(), begin + 1);
        EXPECT_EQ(chunk.id.back(), begin + 500);
    }
}

TEST_F(ImpactZ, namesLineAndColumnOfWhatIsWrong) {
    writeFile(folder / "ImpactZ.in", deckZ);
    const auto error = [&](const std::string& text) {
        writeFile(folder / "fort.101", text);
        return errorOf({folder / "fort.101"});
    };
    EXPECT_THAT(error(std::string(dump) + "0 0 0 zero 0 0 0 0 3\n"),
                HasSubstr("corrupt: fort.101: line 3, column 4: 'zero' is not a number"));
    EXPECT_THAT(error(std::string(dump) + "0 0 0 0 0 0\n"),
                HasSubstr("fort.101: line 3: has 6 columns where"));
    EXPECT_THAT(error("1 2 3\n4 5 6\n"), HasSubstr("fort.101"));
    EXPECT_THAT(error(""), HasSubstr("unsupported: fort.101: is empty"));
    std::string cut;
    {
        writeGzip(folder / "whole.gz", dump);
        std::ifstream file(folder / "whole.gz", std::ios::binary);
        cut.assign(std::istreambuf_iterator<char>(file), {});
    }
    writeFile(folder / "fort.102.gz", cut.substr(0, cut.size() - 12));
    EXPECT_THAT(errorOf({folder / "fort.102.gz"}),
                HasSubstr("corrupt: fort.102.gz: its gzip data is cut short"));
    cut[20] ^= 0x55;
    writeFile(folder / "fort.102.gz", cut);
    EXPECT_THAT(errorOf({folder / "fort.102.gz"}),
                HasSubstr("corrupt: fort.102.gz: its gzip data is damaged"));
}

TEST_F(ImpactT, readsSixColumnsInTheirOwnUnits) {
    writeFile(folder / "fort.50", "2\n 0.001 0.1 0.002 0.2 0.5 3.0\n-0.001 -0.1 0.0 0.0 0.6D0 2.0\n");
    proto::ParticlesJob job;
    job.set_format("impactt");
    MOTE_OPEN(source, {folder / "fort.50"}, progress, job);
    EXPECT_EQ(source->format(), "impactt");
    EXPECT_EQ(source->steps()[0].iteration, 50);
    EXPECT_EQ(source->mass(), prep::electronMass);
    EXPECT_TRUE(progress.noted("taken for electrons"));
    EXPECT_THAT(column(*source, 0, Column::x), ElementsAre(0.001, -0.001));
    EXPECT_THAT(column(*source, 0, Column::z), ElementsAre(0.5, 0.6));
    EXPECT_THAT(column(*source, 0, Column::px),
                ElementsAre(0.1 * prep::electronMass, -0.1 * prep::electronMass));
    EXPECT_THAT(column(*source, 0, Column::pz), ElementsAre(3 * prep::electronMass, 2 * prep::electronMass));
    EXPECT_THAT(column(*source, 0, Column::weight), ElementsAre(1, 1));
    EXPECT_FALSE(source->has(Column::t));
    EXPECT_FALSE(source->has(Column::weight));
}

TEST_F(ImpactT, takesMassAndChargeFromItsDeck) {
    writeFile(folder / "ImpactT.in",
              "!deck\n1 1\n1e-12 1000 1\n6 200 1 0 1 0 0.02\n32 32 32 1 0.1 0.1 0.1\n1 0 0 100 1e-9\n"
              "7*0\n7*0\n7*0\n0.4 1.0 0.938e9 1.0 2e9 0.0\n");
    writeFile(folder / "fort.40", "0 0 0 0 0 1\n");
    MOTE_OPEN(source, {folder / "fort.40"}, progress);  // found by its deck
    EXPECT_EQ(source->format(), "impactt");
    EXPECT_EQ(source->mass(), 0.938e9);
    // 0.4 A at 2 GHz are 0.2 nC a bunch, in 200 macro-particles.
    EXPECT_NEAR(column(*source, 0, Column::weight)[0], 1e-12, 1e-25);
}

}  // namespace
}  // namespace mote::test
