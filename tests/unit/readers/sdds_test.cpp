// SPDX-License-Identifier: GPL-3.0-or-later
//
// SDDS data sets: the same particles in every way to store them, units and derived columns, and files that
// are wrong.
#include <gmock/gmock.h>

#include <cmath>
#include <numeric>
#include <random>

#include "preprocess/readers/field_meaning.h"
#include "tests/support/must.h"
#include "tests/support/temp_dir.h"
#include "tests/unit/readers/sdds_test_file.h"
#include "tests/unit/readers/source_test.h"

namespace mote::test {
namespace {

using prep::Column;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::StartsWith;
using SddsErrors = SourceTest;
using SddsRead = SourceTest;
using SddsSeries = SourceTest;
using SddsUnits = SourceTest;

struct StoredAs {
    const char* name;
    SddsForm form;
    bool gzip = false;
};

void PrintTo(const StoredAs& stored, std::ostream* out) {
    *out << stored.name;
}

/// Particles of one page as Mote has them, from the formulas of docs/READERS.md.
struct Expected {
    std::vector<double> z, px, py, pz;

    explicit Expected(const std::vector<SddsParticle>& particles) {
        double mean = 0.0;
        for (const SddsParticle& particle : particles)
            mean += particle.t / static_cast<double>(particles.size());
        for (const SddsParticle& particle : particles) {
            const double along = particle.p / std::hypot(1.0, particle.xp, particle.yp);
            const double beta = along / std::hypot(1.0, particle.p);
            px.push_back(along * particle.xp * prep::electronMass);
            py.push_back(along * particle.yp * prep::electronMass);
            pz.push_back(along * prep::electronMass);
            z.push_back(-beta * prep::speedOfLight * (particle.t - mean));
        }
    }
};

void expectNear(const std::vector<double>& values, const std::vector<double>& expected, double tolerance) {
    ASSERT_EQ(values.size(), expected.size());
    for (std::size_t i = 0; i < values.size(); ++i) {
        ASSERT_NEAR(values[i], expected[i], tolerance) << "row " << i;
    }
}

/// Rows [begin, begin + count) of a step against the particles that were written.
void expectRows(prep::ParticleSource& source, std::size_t step, std::size_t begin, std::size_t count,
                const SddsTestPage& page) {
    prep::ParticleChunk chunk;
    const std::vector<Column> wanted = {Column::t, Column::x,  Column::id, Column::px,    Column::y,
                                        Column::z, Column::py, Column::pz, Column::weight};
    must(source.read(step, begin, count, wanted, chunk));
    const Expected all(page.particles);
    const auto part = [&](const std::vector<double>& values) {
        return std::vector<double>(values.begin() + static_cast<std::ptrdiff_t>(begin),
                                   values.begin() + static_cast<std::ptrdiff_t>(begin + count));
    };
    for (std::size_t i = 0; i < count; ++i) {
        const SddsParticle& particle = page.particles[begin + i];
        ASSERT_EQ(chunk[Column::x][i], particle.x) << "row " << begin + i;
        ASSERT_EQ(chunk[Column::y][i], particle.y);
        ASSERT_EQ(chunk[Column::t][i], particle.t);
        ASSERT_EQ(chunk.id[i], particle.id);
        ASSERT_DOUBLE_EQ(chunk[Column::weight][i], page.charge / static_cast<double>(page.particles.size()));
    }
    // Momenta of 1e8 eV/c to 1e-14 of that, z of 1 mm to 1e-9 of that: the mean of t cancels digits.
    expectNear(chunk[Column::px], part(all.px), 1e-6);
    expectNear(chunk[Column::py], part(all.py), 1e-6);
    expectNear(chunk[Column::pz], part(all.pz), 1e-6);
    expectNear(chunk[Column::z], part(all.z), 1e-12);
}

class Sdds : public testing::TestWithParam<StoredAs> {
  protected:
    std::string bytes(const std::vector<SddsTestPage>& pages) const {
        const std::string plain = sddsFile(GetParam().form, pages);
        return GetParam().gzip ? gzipped(plain) : plain;
    }
};

TEST_P(Sdds, givesTheSameParticlesInEveryStorage) {
    const TempDir folder;
    const auto pages = sddsPages(14, 3, 257);
    writeFile(folder / "beam.w1", bytes(pages));
    NoteKeeper progress;
    MOTE_OPEN(source, {folder / "beam.w1"}, progress);
    EXPECT_EQ(source->format(), "sdds");
    EXPECT_EQ(source->mass(), prep::electronMass);
    EXPECT_EQ(progress.noted("makes sense as big-endian only"), GetParam().form.orderUnsaid);
    ASSERT_EQ(source->steps().size(), pages.size());
    for (std::size_t i = 0; i < prep::columnCount; ++i) EXPECT_TRUE(source->has(static_cast<Column>(i))) << i;
    for (const std::size_t step : {2u, 0u, 1u}) {
        EXPECT_EQ(source->steps()[step].particles, 257u);
        EXPECT_EQ(source->steps()[step].iteration, pages[step].step);
        const double beta = 200.0 / std::hypot(1.0, 200.0);
        EXPECT_NEAR(source->steps()[step].time, pages[step].place / (beta * prep::speedOfLight), 1e-22);
        expectRows(*source, step, 0, 257, pages[step]);
        expectRows(*source, step, 100, 57, pages[step]);
        expectRows(*source, step, 157, 100, pages[step]);
        expectRows(*source, step, 3, 1, pages[step]);
        expectRows(*source, step, 257, 0, pages[step]);
    }
}

TEST_P(Sdds, isEnteredBehindItsMarks) {
    const TempDir folder;
    const std::size_t rows = 140'000;  // more than two marks
    const auto pages = sddsPages(15, 1, rows);
    writeFile(folder / "beam.w1", bytes(pages));
    NoteKeeper progress;
    MOTE_OPEN(source, {folder / "beam.w1"}, progress);
    for (const std::size_t begin : {131'071u, 65'536u, 65'535u, 131'072u, 0u}) {
        expectRows(*source, 0, begin, 100, pages[0]);
    }
}

TEST_P(Sdds, cutAnywhereIsAnErrorOrHasItsFirstPages) {
    const TempDir folder;
    const auto pages = sddsPages(16, 2, 3);
    const std::string whole = bytes(pages);
    const std::size_t first = sddsFile(GetParam().form, {pages[0]}).size();
    const std::size_t header = sddsHeader(GetParam().form).size();
    const bool binary = !GetParam().form.ascii && !GetParam().gzip;
    for (std::size_t size = 0; size < whole.size(); ++size) {
        writeFile(folder / "beam.w1", std::string_view(whole).substr(0, size));
        const std::string error = errorOf({folder / "beam.w1"});
        if (binary && size > header && size != first) {
            // A file that does not say its order may be wrong otherwise in the order that does not fit.
            EXPECT_THAT(error, StartsWith("corrupt: beam.w1: ")) << size;
            if (!GetParam().form.orderUnsaid) {
                EXPECT_THAT(error, HasSubstr("is cut short at byte " + std::to_string(size) +
                                             ", within page " + (size < first ? "1" : "2")));
            }
        }
        if (binary && size == first) {
            EXPECT_EQ(error, "");
        }
        if (GetParam().gzip && size > 10) {
            EXPECT_THAT(error, HasSubstr("gzip data is cut short")) << size;
        }
    }
}

TEST_P(Sdds, withAlteredBytesNeverCrashes) {
    const TempDir folder;
    std::mt19937_64 random(17);
    const std::string whole = bytes(sddsPages(18, 2, 20));
    int refused = 0;
    for (int i = 0; i < 200; ++i) {
        std::string damaged = whole;
        for (std::uint64_t n = 1 + random() % 3; n > 0; --n) {
            damaged[random() % damaged.size()] = static_cast<char>(random() % 256);
        }
        writeFile(folder / "beam.w1", damaged);
        const std::string error = errorOf({folder / "beam.w1"});
        EXPECT_LT(error.size(), 1000u);
        refused += error.empty() ? 0 : 1;
    }
    EXPECT_GT(refused, 10);
}

const SddsForm ascii{.ascii = true};
INSTANTIATE_TEST_SUITE_P(
    Storage, Sdds,
    testing::Values(StoredAs{"BinaryLittle", {}}, StoredAs{"BinaryBig", {.big = true, .additionalLines = 2}},
                    StoredAs{"BinaryBigInComment", {.big = true, .orderInComment = true}},
                    StoredAs{"BinaryBigUnsaid", {.big = true, .orderUnsaid = true}},
                    StoredAs{"ColumnsLittle", {.columnMajor = true, .wideCount = true}},
                    StoredAs{"ColumnsBigTexts", {.big = true, .columnMajor = true, .texts = true}},
                    StoredAs{"RowsTexts", {.texts = true}},
                    StoredAs{"RowsBigTextsGz", {.big = true, .texts = true}, true},
                    StoredAs{"BinaryGz", {.additionalLines = 1}, true},
                    StoredAs{"ColumnsGz", {.columnMajor = true}, true}, StoredAs{"Ascii", {.ascii = true}},
                    StoredAs{"AsciiTextsComments",
                             {.ascii = true, .texts = true, .additionalLines = 3, .comments = true}},
                    StoredAs{"AsciiTwoLines", {.ascii = true, .texts = true, .linesPerRow = 2}},
                    StoredAs{"AsciiFreeLines", {.ascii = true, .linesPerRow = 0, .comments = true}},
                    StoredAs{"AsciiNoCounts", {.ascii = true, .noRowCounts = true}},
                    StoredAs{"AsciiGz", {.ascii = true, .texts = true}, true}),
    [](const auto& test) { return test.param.name; });

std::string table(const std::string& columns, const std::string& rows,
                  const std::string& data = "mode=ascii, no_row_counts=1") {
    return "SDDS1\n" + columns + "&data " + data + " &end\n" + rows;
}

TEST_F(SddsUnits, areThoseOfTheHeaderAndMassThatOfTheJob) {
    writeFile(
        folder / "beam.sdds",
        table("&column name=x units=mm type=double &end &column name=px units=\"m$be$nc\" type=double &end\n"
              "&column name=py units=\"MeV/c\" type=double &end\n&column name=q units=pC type=long &end\n"
              "&column name=lost type=short &end\n&column name=comment type=string &end\n",
              "! nothing yet\n1 2 3 -4 0 a\n\n5 6 7 8 1 \"b c\"\n9 1d1 .5 3 0 \"\"\n"));
    proto::ParticlesJob job;
    job.mutable_impact()->set_mass(938e6);
    MOTE_OPEN(source, {folder / "beam.sdds"}, progress, job);
    ASSERT_EQ(source->steps().size(), 2u);
    EXPECT_EQ(source->mass(), 938e6);
    const auto chunk = chunkOf(*source, 1, {Column::x, Column::px, Column::py, Column::weight, Column::id});
    EXPECT_THAT(chunk[Column::x], ElementsAre(5e-3, 9 * 1e-3));
    EXPECT_THAT(chunk[Column::px], ElementsAre(6 * 938e6, 10 * 938e6));
    EXPECT_THAT(chunk[Column::py], ElementsAre(7e6, 5e5));
    EXPECT_THAT(chunk[Column::weight], ElementsAre(8e-12, 3e-12));
    EXPECT_THAT(chunk.id, ElementsAre(0, 1));
    EXPECT_THAT(chunk.lost, ElementsAre(1, 0));
    EXPECT_THAT(chunkOf(*source, 0, {Column::weight})[Column::weight], ElementsAre(4e-12));
    EXPECT_FALSE(source->has(Column::z));
    EXPECT_FALSE(source->has(Column::pz));
    EXPECT_TRUE(progress.notes.empty());
}

TEST_F(SddsUnits, withoutMassAreTheElectronsWithANote) {
    writeFile(folder / "beam.sdds", sddsFile({}, sddsPages(1, 1, 2)));
    MOTE_OPEN(source, {folder / "beam.sdds"}, progress);
    EXPECT_TRUE(progress.noted("taken for electrons"));
    EXPECT_TRUE(progress.noted("z = -v_z (t - mean of t)"));
}

TEST_F(SddsSeries, ofFilesIsNumberedByTheirNamesWhereTheirStepsAreTheSame) {
    for (const char* name : {"run-010.w", "run-002.w"})
        writeFile(folder / name, sddsFile(ascii, sddsPages(2, 1, 2)));
    MOTE_OPEN(source, {folder / "run-010.w", folder / "run-002.w"}, progress);
    ASSERT_EQ(source->steps().size(), 2u);
    EXPECT_EQ(source->steps()[0].iteration, 2);
    EXPECT_EQ(source->steps()[1].iteration, 10);
}

TEST_F(SddsErrors, areOneSentenceWithThePlace) {
    const std::string x = "&column name=x, units=m, type=double, &end\n";
    const std::pair<std::string, std::string> cases[] = {
        {"SDDS7\n", "unsupported: f.sdds: line 1: has the SDDS version '7'; 1 to 5 are read"},
        {"SDDS1\n" + x,
         "corrupt: f.sdds: is cut short at byte 49, within its SDDS header (no &data command ends it)"},
        {"SDDS1\n&include filename=\"a\" &end\n",
         "unsupported: f.sdds: line 2: includes another file (&include), which is not read; write the header "
         "out in full"},
        {"SDDS1\n&colum name=x &end\n",
         "corrupt: f.sdds: line 2: has the command '&colum', which SDDS does not know"},
        {"SDDS1\nx y\n", "corrupt: f.sdds: line 2: has no command of an SDDS header where one should stand"},
        {"SDDS1\n&column type=double &end\n", "corrupt: f.sdds: line 2: has a &column without a name"},
        {"SDDS1\n&column name=x &end\n", "corrupt: f.sdds: line 2: declares column 'x' without a type"},
        {"SDDS1\n&column name=x type=real &end\n",
         "corrupt: f.sdds: line 2: declares column 'x' with the type 'real', which SDDS does not know"},
        {"SDDS1\n" + x + x, "corrupt: f.sdds: line 3: declares column 'x' twice"},
        {"SDDS1\n&array name=a type=long dimensions=33 &end\n",
         "corrupt: f.sdds: line 2: has dimensions=33; needs a whole number up to 32"},
        {"SDDS1\n&column x &end\n",
         "corrupt: f.sdds: line 2: has a field without '=' in its command &column"},
        {table(x, "", "mode=hex"),
         "corrupt: f.sdds: line 3: has a &data command whose mode is neither ascii nor binary"},
        {table(x, "", "mode=binary, endian=pdp"),
         "corrupt: f.sdds: line 3: has endian=pdp; needs big or little"},
        {table("&column name=x, type=longdouble &end\n", "", "mode=binary"),
         "unsupported: f.sdds: holds 'x' as binary longdouble, whose bytes differ from machine to machine; "
         "convert it "
         "with sddsprocess -cast or to ascii with sddsconvert"},
        {table("&column name=ElementName, type=string &end\n", ""),
         "corrupt: f.sdds: has no column of a particle: none of x, xp, y, yp, t, p (elegant) or z, px, py, "
         "pz"},
        {table("&column name=x, type=string &end\n", ""),
         "unsupported: f.sdds, column 'x': is a text; a number is needed"},
        {table("&column name=x, units=ell, type=double &end\n", ""),
         "unsupported: f.sdds, column 'x': has the unit 'ell', which is not known"},
        {table(x, ""), "corrupt: f.sdds: ends at its header, at byte 88: it has no page"},
        {table(x, "3\n1\n2\n", "mode=ascii"),
         "corrupt: f.sdds: line 6: is cut short: page 1 declares 3 rows and has 2"},
        {table(x, "many\n", "mode=ascii"),
         "corrupt: f.sdds: line 4: has 'many' in place of the number of rows"},
        {table(x, "1\nabc\n", "mode=ascii"),
         "corrupt: f.sdds: line 5: has 'abc' in place of a number of column 'x'"},
        {table(x, "1\n2 3\n", "mode=ascii"),
         "corrupt: f.sdds: line 5: has more values than the data set has columns, 1"},
        {table(x + "&column name=y, type=double &end\n", "1\n2\n", "mode=ascii"),
         "corrupt: f.sdds: line 6: has 1 values in a row of 2 columns"},
        {table(x, "\xfe\xff\xff\xff", "mode=binary, endian=little"),
         "corrupt: f.sdds: declares -2 rows in page 1, at byte 87"},
        {table(x, "\xff\xff\xff\x7f", "mode=binary, endian=little"),
         "corrupt: f.sdds: is cut short at byte 91, within page 1"},
    };
    for (const auto& [bytes, sentence] : cases) {
        writeFile(folder / "f.sdds", bytes);
        EXPECT_EQ(errorOf({folder / "f.sdds"}), sentence) << bytes;
    }
}

TEST_F(SddsErrors, sayWhereALengthCannotBe) {
    const std::string text = "&column name=x, type=double &end\n&parameter name=a, type=string &end\n";
    using namespace std::string_literals;
    writeFile(folder / "f.sdds", table(text, "\x01\0\0\0\xff\xff\xff\xff"s, "mode=binary, endian=little"));
    EXPECT_THAT(errorOf({folder / "f.sdds"}), HasSubstr("has a text of -1 characters at byte"));
    const std::string array =
        "&array name=a, type=double, dimensions=3 &end\n&column name=x, type=double &end\n";
    const std::string huge = "\x01\0\0\0\xff\xff\xff\x7f\xff\xff\xff\x7f\xff\xff\xff\x7f"s;
    writeFile(folder / "f.sdds", table(array, huge, "mode=binary, endian=little"));
    EXPECT_THAT(errorOf({folder / "f.sdds"}), HasSubstr("has an impossible size of array 'a' in page 1"));
    // A gzipped file says only at its end how much it holds.
    writeFile(folder / "f.sdds",
              gzipped(table(text, "\xff\xff\xff\x7f\0\0\0\0"s, "mode=binary, endian=little")));
    EXPECT_THAT(errorOf({folder / "f.sdds"}),
                AllOf(HasSubstr("is cut short at byte"), HasSubstr("within page 1")));
}

TEST_F(SddsRead, givesEveryColumnOfNumbersUnderItsName) {
    const auto pages = sddsPages(3, 2, 5);
    for (const bool ascii : {false, true}) {
        writeFile(folder / "f.sdds", sddsFile({.ascii = ascii, .texts = true}, pages));
        MOTE_OPEN(source, {folder / "f.sdds"}, progress);
        std::vector<double> ids;
        for (const auto& particle : pages[1].particles) ids.push_back(static_cast<double>(particle.id));
        EXPECT_EQ(record(*source, 1, "particleID"), ids);
        ASSERT_EQ(source->records().size(), 1U);
        const auto chunk = chunkOf(*source, 1, {Column::px, prep::recordColumn(0), Column::x});
        EXPECT_EQ(chunk[prep::recordColumn(0)], ids);
        EXPECT_EQ(chunk[Column::x], column(*source, 1, Column::x));
        EXPECT_EQ(chunk[Column::px], column(*source, 1, Column::px));
    }
}

TEST_F(SddsRead, thatIsCancelledSaysSo) {
    writeFile(folder / "f.sdds", sddsFile({}, sddsPages(1, 2, 2)));
    progress.cancel = true;
    const auto source = openFiles({folder / "f.sdds"}, progress);
    ASSERT_FALSE(source);
    EXPECT_EQ(source.error().code, ErrorCode::cancelled);
}

}  // namespace
}  // namespace mote::test
