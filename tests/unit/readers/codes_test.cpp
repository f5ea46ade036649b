// SPDX-License-Identifier: GPL-3.0-or-later
//
// Particle files of single codes: TraceWin (.dst), ASTRA, Genesis 4, and SDDS data sets of elegant as HDF5.
// Truths are computed here from the numbers that are written, in the direction of the codes' own manuals.
#include <gmock/gmock.h>

#include <cmath>
#include <limits>

#include "preprocess/readers/field_meaning.h"
#include "tests/support/random.h"
#include "tests/support/temp_dir.h"
#include "tests/unit/readers/h5_test_file.h"
#include "tests/unit/readers/source_test.h"

namespace mote::test {
namespace {

using prep::Column;
using prep::speedOfLight;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;

template <class Number>
std::string raw(Number value) {
    return {reinterpret_cast<const char*>(&value), sizeof(value)};
}

/// Equal but for what a dozen roundings of doubles may do: 2^-53 each, to a number of this size.
void expectClose(double found, double truth, const char* what) {
    EXPECT_LE(std::abs(found - truth), 1e-14 * std::abs(truth)) << what << ": " << found << " and " << truth;
}

// ------------------------------------------------------------------------------------------------ TraceWin

/// x and y in cm, slopes, phase in rad, kinetic energy in MeV.
using DstRow = std::array<double, 6>;
using Astra = SourceTest;
using ElegantHdf5 = SourceTest;
using Genesis = SourceTest;
using TraceWin = SourceTest;

std::string dst(const std::vector<DstRow>& rows, double milliamperes, double megahertz, double mass) {
    std::string bytes =
        "\x7d\x64" + raw(static_cast<std::int32_t>(rows.size())) + raw(milliamperes) + raw(megahertz) + '\0';
    for (const DstRow& row : rows) {
        for (const double value : row) bytes += raw(value);
    }
    return bytes + raw(mass);
}

std::vector<DstRow> dstRows(std::size_t count) {
    Random random(11);
    std::vector<DstRow> rows(count);
    for (DstRow& row : rows) {
        row = {random.between(-1, 1),     random.between(-0.1, 0.1), random.between(-1, 1),
               random.between(-0.1, 0.1), random.between(-0.5, 0.5), random.between(1, 100)};
    }
    return rows;
}

TEST_F(TraceWin, unitsAreThoseOfParticles) {
    const auto rows = dstRows(20'000);  // more than a block of the reader
    constexpr double massMeV = 938.272, frequency = 352.2, current = 62.5;
    writeFile(folder / "out7.dst", dst(rows, current, frequency, massMeV));
    MOTE_OPEN(source, {folder / "out7.dst"}, progress);
    EXPECT_EQ(source->format(), "tracewin");
    EXPECT_EQ(source->steps()[0].iteration, 7);
    EXPECT_EQ(source->mass(), massMeV * 1e6);
    prep::ParticleChunk chunk;
    const std::size_t begin = 5;
    ASSERT_TRUE(source
                    ->read(0, begin, rows.size() - begin,
                           {Column::x, Column::y, Column::z, Column::t, Column::px, Column::py, Column::pz,
                            Column::weight, Column::id},
                           chunk)
                    .ok());
    for (std::size_t i = 0; i < chunk.size; ++i) {
        const DstRow& row = rows[begin + i];
        const double gamma = 1 + row[5] / massMeV, p = massMeV * 1e6 * std::sqrt(gamma * gamma - 1);
        const double px = chunk[Column::px][i], py = chunk[Column::py][i], pz = chunk[Column::pz][i];
        // gamma^2 - 1 of a slow particle loses digits: (gamma^2 - 1) 1e-3 at 1 MeV, so ten bits.
        EXPECT_LE(std::abs(std::sqrt(px * px + py * py + pz * pz) - p), 1e-12 * p);
        expectClose(px / pz, row[1], "x'");
        expectClose(py / pz, row[3], "y'");
        expectClose(chunk[Column::x][i], row[0] / 100, "x");
        expectClose(chunk[Column::y][i], row[2] / 100, "y");
        const double t = row[4] / (2 * M_PI * frequency * 1e6);
        expectClose(chunk[Column::t][i], t, "t");
        // Where it was at time 0: behind, by its own velocity along z.
        const double z = -t * speedOfLight * pz / (gamma * massMeV * 1e6);
        EXPECT_LE(std::abs(chunk[Column::z][i] - z), 1e-12 * std::abs(z));
        expectClose(chunk[Column::weight][i], current * 1e-3 / (frequency * 1e6) / 20'000, "charge");
        EXPECT_EQ(chunk.id[i], begin + i);
    }
}

TEST_F(TraceWin, filesAreStepsInTheOrderOfTheirNumbers) {
    for (const int i : {10, 2}) {
        writeFile(folder / ("part" + std::to_string(i) + ".dst"), dst({{1.0 * i, 0, 0, 0, 0, 1}}, 0, 1, 1));
    }
    MOTE_OPEN(source, {folder / "part%T.dst"}, progress);
    ASSERT_EQ(source->steps().size(), 2u);
    EXPECT_THAT(column(*source, 1, Column::x), ElementsAre(0.1));
    EXPECT_FALSE(source->has(Column::weight)) << "without current";
    EXPECT_THAT(column(*source, 1, Column::weight), ElementsAre(1));
    writeFile(folder / "part3.dst", dst({}, 0, 1, 2));
    EXPECT_THAT(errorOf({folder / "part%T.dst"}), HasSubstr("particles of another mass"));
}

TEST_F(TraceWin, refusesWhatContradictsItself) {
    const auto error = [&](const std::string& bytes) {
        writeFile(folder / "beam.dst", bytes);
        return errorOf({folder / "beam.dst"});
    };
    const std::string whole = dst(dstRows(3), 1, 100, 0.511);
    EXPECT_EQ(error(whole), "");
    for (std::size_t length = 2; length < whole.size(); ++length) {
        ASSERT_THAT(error(whole.substr(0, length)), HasSubstr("corrupt: beam.dst: ")) << length;
    }
    EXPECT_THAT(error(whole + "x"), HasSubstr("declares 3 particles, which take 175 bytes, and has 176"));
    EXPECT_THAT(error("\x7d\x64" + raw(std::int32_t{-1}) + std::string(17, '\0')),
                HasSubstr("declares -1 particles"));
    EXPECT_THAT(error(dst({}, 1, 0, 1)), HasSubstr("has no frequency"));
    EXPECT_THAT(error(dst({}, 1, 1, std::nan(""))), HasSubstr("has no rest mass"));
    Random random(3);
    for (std::size_t i = 0; i < whole.size(); ++i) {  // any flipped bit: read or refused, in bounded time
        std::string damaged = whole;
        damaged[i] = static_cast<char>(damaged[i] ^ (1 << random.below(8)));
        error(damaged);
    }
    // A negative energy has no momentum.
    writeFile(folder / "beam.dst", dst({{0, 0, 0, 0, 0, -0.1}}, 1, 1, 1));
    MOTE_OPEN(source, {folder / "beam.dst"}, progress);
    EXPECT_TRUE(std::isnan(column(*source, 0, Column::pz)[0]));
}

// ------------------------------------------------------------------------------------------------ ASTRA

constexpr const char* astraText =
    "  1.0E-4  2.0E-4  1.5E+0  1.0E+3  2.0E+3  5.0E+6  2.5E+0 -1.0E-3   1    5\n"
    "  3.0E-4  4.0E-4 -1.0E-3 -1.0E+3 -2.0E+3 -1.0E+4  1.0E-3 -2.0E-3   1    5\n"
    "  5.0E-4  6.0E-4  1.0E-3  0.0D+0  0.0E+0  1.0E+4 -1.0E-3 -2.0E-3   1  -15\n"
    "  5.0E-4  6.0E-4  2.0E-3  0.0E+0  0.0E+0  0.0E+0  0.0E+0 -2.0E-3   1   -1\n";

TEST_F(Astra, firstRowIsTheReferenceOfTheOthers) {
    writeFile(folder / "run.0150.001", astraText);
    MOTE_OPEN(source, {folder / "run.0150.001"}, progress);
    EXPECT_EQ(source->format(), "astra");
    EXPECT_EQ(source->steps()[0].iteration, 150);
    EXPECT_EQ(source->steps()[0].time, 2.5e-9);
    EXPECT_EQ(source->mass(), prep::electronMass);
    EXPECT_THAT(column(*source, 0, Column::x), ElementsAre(1e-4, 3e-4, 5e-4, 5e-4));
    EXPECT_THAT(column(*source, 0, Column::z), ElementsAre(1.5, 1.5 - 1e-3, 1.5 + 1e-3, 1.5 + 2e-3));
    EXPECT_THAT(column(*source, 0, Column::pz), ElementsAre(5e6, 4.99e6, 5.01e6, 5e6));
    EXPECT_THAT(column(*source, 0, Column::px), ElementsAre(1e3, -1e3, 0, 0));
    EXPECT_THAT(column(*source, 0, Column::t),
                ElementsAre(2.5e-9, (2.5 + 1e-3) * 1e-9, (2.5 - 1e-3) * 1e-9, 2.5e-9));
    EXPECT_THAT(column(*source, 0, Column::weight),
                ElementsAre(1e-3 * 1e-9, 2e-3 * 1e-9, 2e-3 * 1e-9, 2e-3 * 1e-9));
    EXPECT_THAT(chunkOf(*source, 0, {Column::id}).lost, ElementsAre(0, 0, 1, 0)) << "-1 waits at the cathode";
    prep::ParticleChunk tail;
    ASSERT_TRUE(source->read(0, 2, 1, {Column::z}, tail).ok());
    EXPECT_THAT(tail[Column::z], ElementsAre(1.5 + 1e-3)) << "relative also without the first row";
}

TEST_F(Astra, filesAreStepsByPlaceAndOfOneSpecies) {
    const std::string row = " 0 0 1 0 0 1E6 0 1 3 5\n";
    for (const char* name : {"run.0200.001", "run.0050.001", "run.1000.001"}) writeFile(folder / name, row);
    MOTE_OPEN(source, {folder / "run.0200.001", folder / "run.0050.001", folder / "run.1000.001"}, progress);
    ASSERT_EQ(source->steps().size(), 3u);
    EXPECT_EQ(source->steps()[0].iteration, 50);
    EXPECT_EQ(source->steps()[2].iteration, 1000);
    EXPECT_EQ(source->mass(), *prep::speciesMass("proton"));
    writeFile(folder / "run.0060.001", " 0 0 1 0 0 1E6 0 1 1 5\n");
    EXPECT_THAT(errorOf({folder / "run.0050.001", folder / "run.0060.001"}), HasSubstr("another species"));
    writeFile(folder / "own.ini", " 0 0 1 0 0 1E6 0 1 7 5\n");
    MOTE_OPEN(own, {folder / "own.ini"}, progress);
    EXPECT_EQ(own->mass(), 0.0);
    EXPECT_TRUE(progress.noted("mass of species 7"));
}

TEST_F(Astra, isFoundByItsContentAndRefusedByLine) {
    const auto error = [&](const std::string& text, const char* format = "auto") {
        writeFile(folder / "beam.ini", text);
        proto::ParticlesJob job;
        job.set_format(format);
        return errorOf({folder / "beam.ini"}, job);
    };
    EXPECT_EQ(error(astraText), "");
    EXPECT_THAT(error("1 2 3 4 5 6 7 8 0.5 5\n"), HasSubstr("table of 10 columns"));
    EXPECT_THAT(error("1 2 3 4 5 6 7 8 0.5 5\n", "astra"), HasSubstr("is no ASTRA distribution"));
    EXPECT_THAT(error("1 2 3 4 5 6 7 8 9\n", "astra"), HasSubstr("has 9 columns where at least 10"));
    EXPECT_THAT(error(astraText + std::string("1 2 x 4 5 6 7 8 1 5\n")),
                HasSubstr("beam.ini: line 5, column 3: 'x' is not a number"));
    EXPECT_THAT(error(astraText + std::string("1 2 3\n")), HasSubstr("line 5: has 3 columns"));
    const std::string whole = astraText;
    for (std::size_t length = 0; length < whole.size(); ++length) {
        writeFile(folder / "beam.ini", whole.substr(0, length));
        proto::ParticlesJob job;
        job.set_format("astra");
        errorOf({folder / "beam.ini"}, job);  // read or refused
    }
}

// ------------------------------------------------------------------------------------------------ Genesis 4

struct GenesisSlice {
    std::vector<double> x, y, px, py, gamma, theta;
    double current = 0;
};

GenesisSlice genesisSlice(Random& random, std::size_t count, double current) {
    GenesisSlice slice;
    slice.current = current;
    for (std::size_t i = 0; i < count; ++i) {
        for (auto* values : {&slice.x, &slice.y}) values->push_back(random.between(-1e-4, 1e-4));
        for (auto* values : {&slice.px, &slice.py}) values->push_back(random.between(-1, 1));
        slice.gamma.push_back(random.between(9e3, 11e3));
        slice.theta.push_back(random.between(0, 6));
    }
    return slice;
}

void writeGenesis(const std::filesystem::path& path, const std::vector<std::pair<int, GenesisSlice>>& slices,
                  std::int32_t one4one) {
    H5TestFile file(path);
    file.data("/slicelength", std::vector<double>{1e-9});
    file.data("/slicespacing", std::vector<double>{3e-9});
    file.data("/beamletsize", std::vector<std::int32_t>{4});
    file.data("/one4one", std::vector<std::int32_t>{one4one});
    file.data("/refposition", std::vector<double>{0});
    file.data("/slicecount", std::vector<std::int32_t>{static_cast<std::int32_t>(slices.size())});
    for (const auto& [number, slice] : slices) {
        const std::string group = "/slice00000" + std::to_string(number) + "/";
        file.data(group + "x", slice.x);
        file.data(group + "y", slice.y);
        file.data(group + "px", slice.px);
        file.data(group + "py", slice.py);
        file.data(group + "gamma", slice.gamma);
        file.data(group + "theta", slice.theta);
        file.data(group + "current", std::vector<double>{slice.current});
    }
}

TEST_F(Genesis, slicesAreOneStepWithTheCurrentsCharge) {
    Random random(2);
    const double nan = std::numeric_limits<double>::quiet_NaN();
    const std::vector<std::pair<int, GenesisSlice>> slices = {{1, genesisSlice(random, 40, 2000)},
                                                              {2, genesisSlice(random, 7, 0)},
                                                              {3, genesisSlice(random, 8, nan)},
                                                              {5, genesisSlice(random, 24, 3000)}};
    writeGenesis(folder / "run.2.par.h5", slices, 0);
    MOTE_OPEN(source, {folder / "run.2.par.h5"}, progress);
    EXPECT_EQ(source->format(), "genesis4");
    ASSERT_EQ(source->steps().size(), 1u);
    EXPECT_EQ(source->steps()[0].particles, 64u) << "slices without current hold nothing";
    EXPECT_EQ(source->steps()[0].iteration, 2);
    for (int round = 0; round < 40; ++round) {
        const std::size_t begin = random.below(64), count = random.below(64 - begin + 1);
        prep::ParticleChunk chunk;
        ASSERT_TRUE(source
                        ->read(0, begin, count,
                               {Column::x, Column::z, Column::px, Column::py, Column::pz, Column::weight,
                                Column::y, Column::id},
                               chunk)
                        .ok());
        for (std::size_t i = 0; i < count; ++i) {
            const std::size_t row = begin + i, at = row < 40 ? row : row - 40;
            const auto& [number, slice] = row < 40 ? slices[0] : slices[3];
            ASSERT_EQ(chunk[Column::x][i], slice.x[at]);
            ASSERT_EQ(chunk[Column::y][i], slice.y[at]);
            ASSERT_EQ(chunk.id[i], row);
            expectClose(chunk[Column::z][i], (number - 1) * 3e-9 + slice.theta[at] / (2 * M_PI) * 1e-9, "z");
            expectClose(chunk[Column::py][i], slice.py[at] * prep::electronMass, "py");
            const double px = chunk[Column::px][i], py = chunk[Column::py][i], pz = chunk[Column::pz][i];
            const double energy =
                std::sqrt(px * px + py * py + pz * pz + prep::electronMass * prep::electronMass);
            expectClose(energy, slice.gamma[at] * prep::electronMass, "energy");
            expectClose(chunk[Column::weight][i],
                        slice.current * 3e-9 / speedOfLight / static_cast<double>(slice.x.size()), "charge");
        }
    }
    writeGenesis(folder / "run.3.par.h5", slices, 1);
    MOTE_OPEN(single, {folder / "run.3.par.h5"}, progress);
    EXPECT_EQ(single->steps()[0].particles, 79u);
    EXPECT_EQ(column(*single, 0, Column::weight)[0], prep::elementaryCharge);
}

TEST_F(Genesis, refusesWhatContradictsItself) {
    Random random(2);
    GenesisSlice slice = genesisSlice(random, 4, 1);
    slice.gamma.pop_back();
    writeGenesis(folder / "a.par.h5", {{1, slice}}, 0);
    EXPECT_THAT(errorOf({folder / "a.par.h5"}),
                HasSubstr("corrupt: a.par.h5:/slice000001/gamma: has 3 values where other columns have 4"));
    {
        H5TestFile file(folder / "a.par.h5");
        file.data("/slicelength", std::vector<double>{0});
        file.data("/slicespacing", std::vector<double>{1});
        file.data("/beamletsize", std::vector<std::int32_t>{4});
    }
    EXPECT_THAT(errorOf({folder / "a.par.h5"}), HasSubstr("slices without length"));
}

// ------------------------------------------------------------------------------------------------ elegant

void writeElegant(const std::filesystem::path& path, bool units) {
    H5TestFile file(path);
    for (const int page : {1, 2, 10}) {
        const std::string group = "/page" + std::to_string(page);
        const double n = page;
        file.data(group + "/columns/x", std::vector<double>{1e-3 * n, 2e-3});
        file.data(group + "/columns/xp", std::vector<double>{3e-3, 4e-3});
        file.data(group + "/columns/y", std::vector<double>{0, 1e-3});
        file.data(group + "/columns/yp", std::vector<double>{0, 1e-3});
        file.data(group + "/columns/t", std::vector<double>{1e-9, 3e-9});
        file.data(group + "/columns/p", std::vector<double>{1000, 2000});
        file.data(group + "/columns/particleID", std::vector<std::int64_t>{5, 6});
        file.data(group + "/parameters/Charge", std::vector<double>{1e-9});
        if (!units) continue;
        file.text(group + "/columns/x", "units", "mm");
        file.text(group + "/columns/p", "units", "m$be$nc");
    }
}

TEST_F(ElegantHdf5, pagesAreStepsAsInSdds) {
    writeElegant(folder / "w1.h5", false);
    MOTE_OPEN(source, {folder / "w1.h5"}, progress);
    EXPECT_EQ(source->format(), "elegant");
    ASSERT_EQ(source->steps().size(), 3u);
    EXPECT_THAT(column(*source, 2, Column::x), ElementsAre(1e-2, 2e-3)) << "page 10 after page 2";
    EXPECT_THAT(chunkOf(*source, 0, {Column::id}).id, ElementsAre(5, 6));
    EXPECT_THAT(column(*source, 0, Column::weight), ElementsAre(0.5e-9, 0.5e-9));
    const double pz = 1000 * prep::electronMass / std::sqrt(1 + 9e-6);
    expectClose(column(*source, 0, Column::pz)[0], pz, "pz");
    expectClose(column(*source, 0, Column::px)[0], 3e-3 * pz, "px");
    const double velocity = speedOfLight * pz / (prep::electronMass * std::sqrt(1 + 1e6));
    // The mean of the times is 2 ns; their difference is exact to 2^-53 of 3 ns: 3e-25 s in 1e-9 s.
    EXPECT_NEAR(column(*source, 0, Column::z)[0], velocity * 1e-9, 1e-15);
    EXPECT_TRUE(progress.noted("taken for electrons"));
    writeElegant(folder / "w2.h5", true);
    MOTE_OPEN(other, {folder / "w2.h5"}, progress);
    EXPECT_THAT(column(*other, 0, Column::x), ElementsAre(1e-6, 2e-6));
}

TEST_F(ElegantHdf5, refusesWhatContradictsItself) {
    {
        H5TestFile file(folder / "w1.h5");
        file.data("/page1/columns/x", std::vector<double>{1, 2});
        file.data("/page1/columns/y", std::vector<double>{1});
    }
    EXPECT_THAT(errorOf({folder / "w1.h5"}), HasSubstr("/page1/columns/y: has 1 values where other"));
    {
        H5TestFile file(folder / "w1.h5");
        file.data("/page1/columns/x", std::vector<double>{1, 2});
        file.data("/page2/columns/y", std::vector<double>{1, 2});
    }
    EXPECT_THAT(errorOf({folder / "w1.h5"}), HasSubstr("not_found: w1.h5:/page2/columns/x"));
    {
        H5TestFile file(folder / "w1.h5");
        file.data("/page1/columns/s", std::vector<double>{1, 2});
    }
    EXPECT_THAT(errorOf({folder / "w1.h5"}), HasSubstr("has no column of a particle"));
}

}  // namespace
}  // namespace mote::test
