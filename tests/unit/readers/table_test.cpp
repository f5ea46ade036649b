// SPDX-License-Identifier: GPL-3.0-or-later
//
// Numbers and rows in text, tables with names (CSV) and NumPy arrays.
#include <gmock/gmock.h>

#include <cmath>
#include <cstring>
#include <limits>

#include "preprocess/readers/field_meaning.h"
#include "preprocess/readers/npy/npy_header.h"
#include "preprocess/readers/text/number.h"
#include "preprocess/readers/text/row_file.h"
#include "tests/support/temp_dir.h"
#include "tests/unit/readers/npy_test_file.h"
#include "tests/unit/readers/source_test.h"

namespace mote::test {
namespace {

using prep::Column;
using testing::ElementsAre;
using testing::HasSubstr;
using CsvSource = SourceTest;
using LineReader = SourceTest;
using NpySource = SourceTest;
using RowFile = SourceTest;

TEST(Number, isReadInAnyForm) {
    using prep::parseNumber;
    EXPECT_EQ(parseNumber("1.5"), 1.5);
    EXPECT_EQ(parseNumber("  -1.5e-3\t"), -1.5e-3);
    EXPECT_EQ(parseNumber("+2"), 2.0);
    EXPECT_EQ(parseNumber(".5"), 0.5);
    EXPECT_EQ(parseNumber("5."), 5.0);
    EXPECT_EQ(parseNumber("1.25D+03"), 1250.0);
    EXPECT_EQ(parseNumber("-6.d-2"), -0.06);
    EXPECT_EQ(parseNumber("0.123-104"), 0.123e-104);
    EXPECT_EQ(parseNumber("0.123+104"), 0.123e104);
    EXPECT_EQ(parseNumber("0.1E-999"), 0.0);
    EXPECT_EQ(parseNumber("-0.1E+999"), -std::numeric_limits<double>::infinity());
    EXPECT_EQ(parseNumber("Infinity"), std::numeric_limits<double>::infinity());
    EXPECT_TRUE(std::isnan(parseNumber("NaN").value()));
    EXPECT_EQ(parseNumber("0.17976931348623157E+309"), std::numeric_limits<double>::max());
    for (const char* wrong :
         {"", " ", "abc", "1.5x", "1.5e", "1.5D", "--1", "+-1", "1 2", "1,5", "*****", "1.5D+", "0.1-"}) {
        EXPECT_FALSE(parseNumber(wrong)) << wrong;
    }
    EXPECT_FALSE(parseNumber("1" + std::string(1000, '0') + "D1"));
    EXPECT_EQ(prep::parseNumberWithComma("-1,5e3"), -1500.0);
}

TEST_F(CsvSource, givesWhatElseItHasUnderItsOwnName) {
    const std::string head = "x,px,y,py,zeta,delta,p0c,mass0,state,at_turn,particle_id,spin_x [hbar],label\n";
    writeFile(folder / "a1.csv", head +
                                     "1e-3,0,0,0,0,0,1e9,938272088.0,1,123456789,4503599627370497,0.5,QF\n"
                                     "2e-3,0,0,0,0,0,1e9,938272088.0,-1,7,2,-0.5,QD\n");
    writeFile(folder / "a2.csv", "x,px,y,py,zeta,delta,p0c,mass0,at_turn\n0,0,0,0,0,0,1e9,938272088.0,9\n");
    MOTE_OPEN(source, {folder / "a1.csv"}, progress);
    EXPECT_THAT(record(*source, 0, "state"), ElementsAre(1, -1));
    EXPECT_THAT(record(*source, 0, "at_turn"), ElementsAre(123456789, 7));
    EXPECT_THAT(record(*source, 0, "particle_id"), ElementsAre(4503599627370497.0, 2));
    EXPECT_THAT(record(*source, 0, "spin_x", "hbar"), ElementsAre(0.5, -0.5));
    EXPECT_THAT(record(*source, 0, "x", "m"), ElementsAre()) << "known quantities stay what they are";
    const auto records = source->records();
    const auto label = std::ranges::find(records, "label", &prep::SourceRecord::name) - records.begin();
    prep::ParticleChunk chunk;
    const auto texts = source->read(0, 0, 2, {prep::recordColumn(static_cast<std::size_t>(label))}, chunk);
    ASSERT_FALSE(texts.ok());
    EXPECT_THAT(texts.error().toString(),
                HasSubstr("a1.csv: line 2, column 13 (label): 'QF' is not a number"));
    // Of several files what all have.
    MOTE_OPEN(both, {folder / "a1.csv", folder / "a2.csv"}, progress);
    EXPECT_THAT(record(*both, 1, "at_turn"), ElementsAre(9));
    EXPECT_THAT(record(*both, 0, "state"), ElementsAre());
}

TEST_F(CsvSource, andSoDoListsInJson) {
    writeFile(folder / "a.json",
              R"({"x": [1e-3, 2e-3], "y": [0, 0], "at_turn": [123456789, 3], "state": [1, 0],
                                     "_rng": [1, 2, 3], "p0c": [1e9, 1e9]})");
    MOTE_OPEN(source, {folder / "a.json"}, progress);
    EXPECT_THAT(record(*source, 0, "at_turn"), ElementsAre(123456789, 3));
    EXPECT_THAT(record(*source, 0, "state"), ElementsAre(1, 0));
    EXPECT_THAT(record(*source, 0, "_rng"), ElementsAre()) << "has not a value for each particle";
}

TEST_F(CsvSource, saysHowManyColumnsCanBeNamed) {
    std::string head = "x,y", row = "1,2";
    for (std::size_t i = 0; i < prep::mostRecords + 3; ++i) {
        head += ",c" + std::to_string(i);
        row += "," + std::to_string(i);
    }
    writeFile(folder / "wide.csv", head + "\n" + row + "\n");
    MOTE_OPEN(source, {folder / "wide.csv"}, progress);
    EXPECT_THAT(record(*source, 0, "c63"), ElementsAre(63));
    EXPECT_TRUE(progress.noted("of 67 columns that are no coordinates the first 64 can be named, up to c63"));
}

TEST(Number, ofAnIdKeepsAllBits) {
    EXPECT_EQ(prep::parseId("18446744073709551615"), 18446744073709551615u);
    EXPECT_EQ(prep::parseId("1.0000E+02"), 100u);
    EXPECT_FALSE(prep::parseId("-1"));
    EXPECT_FALSE(prep::parseId("1.5"));
    EXPECT_FALSE(prep::parseId("18446744073709551616"));
    EXPECT_FALSE(prep::parseId("nan"));
}

TEST(Fields, areSplit) {
    const auto split = [](std::string_view line, char separator) {
        std::string_view fields[4];
        const std::size_t count = prep::splitFields(line, separator, fields);
        std::vector<std::string> result(fields, fields + std::min<std::size_t>(count, 4));
        result.push_back(std::to_string(count));
        return result;
    };
    EXPECT_THAT(split("  1  2\t3 ", ' '), ElementsAre("1", "2", "3", "3"));
    EXPECT_THAT(split("1, 2,3", ' '), ElementsAre("1", "2", "3", "3"));
    EXPECT_THAT(split("1, 2 ,,", ','), ElementsAre("1", "2", "", "", "4"));
    EXPECT_THAT(split("\"a,b\" ; \"c\"", ';'), ElementsAre("a,b", "c", "2"));
    EXPECT_THAT(split("\"a;b\";c", ';'), ElementsAre("a;b", "c", "2"));
    EXPECT_THAT(split("a\t\tc", '\t'), ElementsAre("a", "", "c", "3"));
    EXPECT_THAT(split("1 2 3 4 5 6", ' '), ElementsAre("1", "2", "3", "4", "6")) << "counted beyond the room";
    EXPECT_THAT(split("\"open", ','), ElementsAre("\"open", "1"));
    EXPECT_THAT(split("", ' '), ElementsAre("0"));
}

TEST_F(RowFile, findsAnyRowAgain) {
    // More rows than lie between two of its marks (65536), comments and blank lines among them, no end of
    // line at last.
    std::string text = "# comment\r\n\r\n";
    for (int i = 0; i < 150'000; ++i)
        text += std::to_string(i) + (i % 1000 == 0 ? "\n\n! comment\n" : "\r\n");
    text += "150000";
    writeFile(folder / "rows.txt", text);
    auto file = prep::RowFile::open(folder / "rows.txt", 1, progress);
    ASSERT_TRUE(file.ok());
    EXPECT_EQ(file->rows(), 150'000u);
    for (const std::uint64_t row : {0u, 149'999u, 65'535u, 65'536u, 65'537u, 5u, 131'072u, 131'071u}) {
        ASSERT_TRUE(file->seek(row, progress).ok());
        EXPECT_EQ(*file->next(), std::to_string(row + 1));
    }
    ASSERT_TRUE(file->seek(0, progress).ok());
    ASSERT_TRUE(file->next().ok());
    EXPECT_EQ(file->where(), "rows.txt: line 6");
    writeFile(folder / "rows.txt", "1\n2\n");
    file->close();
    EXPECT_THAT(file->seek(1000, progress).error().toString(), HasSubstr("has changed since it was opened"));
    progress.cancel = true;
    EXPECT_EQ(prep::RowFile::open(folder / "rows.txt", 0, progress).error().code, ErrorCode::cancelled);
}

TEST_F(LineReader, refusesLinesWithoutEnd) {
    writeFile(folder / "long.txt", "1 2 3\n" + std::string(2'000'000, ' '));
    auto reader = prep::LineReader::open(folder / "long.txt");
    ASSERT_TRUE(reader.ok());
    std::string_view line;
    EXPECT_TRUE(*reader->next(line));
    EXPECT_THAT(reader->next(line).error().toString(), HasSubstr("long.txt: line 2: is longer than 64 KiB"));
}

struct Csv {
    const char* what;
    const char* text;
};

class CsvForms : public testing::TestWithParam<Csv> {};

/// The same two particles: x 1 and 2 mm, px 3 and 4 MeV/c, weights 5 and 6, ids 7 and 2^63 + 1.
TEST_P(CsvForms, areReadAlike) {
    const TempDir folder;
    writeFile(folder / "beam_12.csv", GetParam().text);
    NoteKeeper progress;
    MOTE_OPEN(source, {folder / "beam_12.csv"}, progress);
    EXPECT_EQ(source->format(), "csv");
    ASSERT_EQ(source->steps()[0].particles, 2u);
    EXPECT_EQ(source->steps()[0].iteration, 12);
    EXPECT_THAT(column(*source, 0, Column::x), ElementsAre(0.001, 0.002));
    EXPECT_THAT(column(*source, 0, Column::px), ElementsAre(3e6, 4e6));
    EXPECT_THAT(column(*source, 0, Column::weight), ElementsAre(5, 6));
    EXPECT_THAT(chunkOf(*source, 0, {Column::id}).id, ElementsAre(7u, 9223372036854775809u));
    EXPECT_FALSE(source->has(Column::y));
    EXPECT_EQ(source->mass(), 0.0);
}

INSTANTIATE_TEST_SUITE_P(
    All, CsvForms,
    testing::Values(
        Csv{"comma", "x [mm],px [MeV/c],weight,id\n1,3,5,7\n2,4,-6,9223372036854775809\n"},
        Csv{"quotes",
            "\"X (mm)\",\"PX (MeV/c)\",\"Weight\",\"ID\"\r\n1,3,5,7\r\n\"2\",4,6,9223372036854775809\r\n"},
        Csv{"semicolon",
            "id;name;weight;px[eV/c];x[um]\n7;a;5,0;3e6;1e3\n9223372036854775809;\"b;c\";6;4e6;2000,0\n"},
        Csv{"tab",
            "x [um]\tpx [keV/c]\tq [1]\tParticleID\n1000\t3000\t5\t7\n2000\t4000\t6\t9223372036854775809"},
        Csv{"blanks", "x [mm]  px [GeV / c]  weight id\n 1 3e-3 5 7\n 2 4D-3 6 9223372036854775809\n"},
        Csv{"comment",
            "# made by hand\n#  x px weight id\n#\n 0.001 3e6 5 7\n 0.002 4e6 6 9223372036854775809\n"},
        Csv{"mark",
            "\xef\xbb\xbfposition_x,momentum_x,weighting,particle_id,\n.001,3e6,5,7,\n.002,4e6,6,"
            "9223372036854775809,\n"}),
    [](const auto& param) { return std::string(param.param.what); });

TEST_F(CsvSource, readsMomentaInUnitsOfMassWhereItIsGiven) {
    writeFile(folder / "beam.csv", "x,px [mc],pz [kg m/s],t [ps]\n1,2,5.344285992678308e-28,3\n");
    EXPECT_THAT(errorOf({folder / "beam.csv"}),
                HasSubstr("column 2 (px [mc]): is in units of m c; give the particle's mass"));
    proto::ParticlesJob job;
    job.mutable_impact()->set_mass(511e3);
    MOTE_OPEN(source, {folder / "beam.csv"}, progress, job);
    EXPECT_THAT(column(*source, 0, Column::px), ElementsAre(1022e3));
    EXPECT_NEAR(column(*source, 0, Column::pz)[0], 1.0, 1e-9);
    EXPECT_THAT(column(*source, 0, Column::t), ElementsAre(3e-12));
    EXPECT_EQ(source->mass(), 511e3);
}

TEST_F(CsvSource, marksLostParticlesAndMissingValues) {
    writeFile(folder / "beam.csv", "x,status\n1,1\n,2\nNaN,1\n");
    writeFile(folder / "lost.csv", "x,lost\n1,0\n2,1\n");
    writeFile(folder / "alive.csv", "x,alive\n1,0\n2,1\n");
    MOTE_OPEN(source, {folder / "beam.csv"}, progress);
    const auto chunk = chunkOf(*source, 0, {Column::x});
    EXPECT_THAT(chunk.lost, ElementsAre(0, 1, 0));
    EXPECT_TRUE(std::isnan(chunk[Column::x][1]));
    EXPECT_TRUE(std::isnan(chunk[Column::x][2]));
    MOTE_OPEN(lost, {folder / "lost.csv"}, progress);
    EXPECT_THAT(chunkOf(*lost, 0, {Column::x}).lost, ElementsAre(0, 1));
    MOTE_OPEN(alive, {folder / "alive.csv"}, progress);
    EXPECT_THAT(chunkOf(*alive, 0, {Column::x}).lost, ElementsAre(1, 0));
}

TEST_F(CsvSource, namesFileLineAndColumnOfWhatIsWrong) {
    const auto error = [&](const std::string& text) {
        writeFile(folder / "beam.csv", text);
        return errorOf({folder / "beam.csv"});
    };
    EXPECT_THAT(error("# c\nx,y\n1,2\n\n3,four\n"),
                HasSubstr("corrupt: beam.csv: line 5, column 2 (y): 'four' is not a number"));
    EXPECT_THAT(error("x,y\n1,2\n3\n"), HasSubstr("beam.csv: line 3: has 1 fields where the header names 2"));
    EXPECT_THAT(error("x,y,X\n1,2,3\n"), HasSubstr("column 3 (X): means the same as a column before it"));
    EXPECT_THAT(error("x [furlong],y\n1,2\n"),
                HasSubstr("column 1 (x [furlong]): has the unit 'furlong', which is not known"));
    EXPECT_THAT(error("x,id\n1,-5\n"), HasSubstr("line 2, column 2 (id): '-5' is not a number"));
    EXPECT_THAT(error("a,b\n1,2\n"), HasSubstr("unsupported: beam.csv"));
    EXPECT_THAT(error("1,2,3\n4,5,6\n"), HasSubstr("put a line of names over it"));
    EXPECT_THAT(error("\n\n"), HasSubstr("is empty"));
    std::string wide = "x";
    for (int i = 0; i < 1100; ++i) wide += ",a" + std::to_string(i);
    EXPECT_THAT(error(wide + "\n"), HasSubstr("unsupported: beam.csv"));
    proto::ParticlesJob job;
    job.set_format("csv");
    writeFile(folder / "beam.csv", "a,b\n1,2\n");
    EXPECT_THAT(errorOf({folder / "beam.csv"}, job), HasSubstr("names none of the columns x, y, z"));
}

TEST_F(CsvSource, takesManyFilesAsSteps) {
    for (const int i : {2, 10, 1}) {
        writeFile(folder / ("s" + std::to_string(i) + ".csv"), "x,y\n" + std::to_string(i) + ",0\n");
    }
    writeFile(folder / "s3.csv", "x\n3\n");
    MOTE_OPEN(source, {folder / "s10.csv", folder / "s2.csv", folder / "s3.csv", folder / "s1.csv"},
              progress);
    ASSERT_EQ(source->steps().size(), 4u);
    EXPECT_THAT(column(*source, 3, Column::x), ElementsAre(10));
    EXPECT_THAT(column(*source, 0, Column::x), ElementsAre(1));
    EXPECT_FALSE(source->has(Column::y));
}

// ------------------------------------------------------------------------------------------------ NumPy

TEST_F(NpySource, readsPlainArraysOfEveryOrder) {
    const auto check = [&](const std::string& bytes, bool weight) {
        writeFile(folder / "beam.npy", bytes);
        NoteKeeper notes;
        MOTE_OPEN(source, {folder / "beam.npy"}, notes);
        EXPECT_EQ(source->steps()[0].particles, 2u);
        EXPECT_THAT(column(*source, 0, Column::x), ElementsAre(1, 11));
        EXPECT_THAT(column(*source, 0, Column::pz), ElementsAre(6, 16));
        EXPECT_EQ(source->has(Column::weight), weight);
        EXPECT_THAT(column(*source, 0, Column::weight), weight ? ElementsAre(7, 17) : ElementsAre(1, 1));
        EXPECT_TRUE(notes.noted("without field names"));
    };
    const auto six = {1., 2., 3., 4., 5., 6., 11., 12., 13., 14., 15., 16.};
    const auto seven = {1., 2., 3., 4., 5., 6., 7., 11., 12., 13., 14., 15., 16., -17.};
    const auto turned = {1., 11., 2., 12., 3., 13., 4., 14., 5., 15., 6., 16.};
    check(npy("{'descr': '<f8', 'fortran_order': False, 'shape': (2, 6), }", packed<double>(six)), false);
    check(npy("{'descr': '<f4', 'fortran_order': False, 'shape': (2, 6), }", packed<float>(six), 2), false);
    check(npy("{'descr': '>f8', 'fortran_order': False, 'shape': (2, 7), }", packed<double>(seven, true), 3),
          true);
    check(npy("{'descr': '>i4', 'fortran_order': False, 'shape': (2, 6), }", packed<std::int32_t>(six, true)),
          false);
    check(npy("{'descr': '|i1', 'fortran_order': True, 'shape': (2L, 6L)}", packed<std::int8_t>(turned)),
          false);
    check(npy("{\"shape\": (2, 6), \"fortran_order\": True, \"descr\": \"<f8\"}", packed<double>(turned)),
          false);
}

TEST_F(NpySource, readsPlacesAloneAndSteps) {
    writeFile(folder / "places.npy", npy("{'descr': '<f8', 'fortran_order': False, 'shape': (2, 3), }",
                                         packed<double>({1., 2., 3., 11., 12., 13.})));
    MOTE_OPEN(places, {folder / "places.npy"}, progress);
    EXPECT_THAT(column(*places, 0, Column::z), ElementsAre(3, 13));
    EXPECT_FALSE(places->has(Column::px));
    // Two steps of one particle: [step, particle, column], in both orders.
    writeFile(folder / "steps.npy", npy("{'descr': '<f8', 'fortran_order': False, 'shape': (2, 1, 3), }",
                                        packed<double>({1., 2., 3., 11., 12., 13.})));
    writeFile(folder / "turned.npy", npy("{'descr': '<f8', 'fortran_order': True, 'shape': (2, 1, 3), }",
                                         packed<double>({1., 11., 2., 12., 3., 13.})));
    for (const char* name : {"steps.npy", "turned.npy"}) {
        MOTE_OPEN(steps, {folder / name}, progress);
        ASSERT_EQ(steps->steps().size(), 2u);
        EXPECT_EQ(steps->steps()[1].iteration, 1);
        EXPECT_THAT(column(*steps, 0, Column::y), ElementsAre(2));
        EXPECT_THAT(column(*steps, 1, Column::y), ElementsAre(12));
    }
}

TEST_F(NpySource, readsNamedFields) {
    std::string data;
    for (int i = 0; i < 3; ++i) {
        data += packed<double>({i + 0.5});
        data += "text!";
        data += packed<std::uint64_t>({});
        const std::uint64_t id = 18446744073709551615u - static_cast<unsigned>(i);
        data.append(reinterpret_cast<const char*>(&id), 8);
        data += packed<float>({1, 2, i + 3.0});
        data += packed<std::int16_t>({i == 1 ? 5. : 1.}, true);
    }
    writeFile(folder / "run7.npy",
              npy("{'descr': [('x [mm]', '<f8'), ('label', '|S5'), ('id', '<u8'), ('momentum', "
                  "'<f4', (3,)), ('status', '>i2')], 'fortran_order': False, 'shape': (3,)}",
                  data));
    MOTE_OPEN(source, {folder / "run7.npy"}, progress);
    EXPECT_EQ(source->format(), "npy");
    EXPECT_EQ(source->steps()[0].iteration, 7);
    EXPECT_THAT(column(*source, 0, Column::x), ElementsAre(0.0005, 0.0015, 0.0025));
    EXPECT_THAT(column(*source, 0, Column::py), ElementsAre(2, 2, 2));
    EXPECT_THAT(column(*source, 0, Column::pz), ElementsAre(3, 4, 5));
    const auto chunk = chunkOf(*source, 0, {Column::id});
    EXPECT_THAT(chunk.id, ElementsAre(18446744073709551615u, 18446744073709551614u, 18446744073709551613u));
    EXPECT_THAT(chunk.lost, ElementsAre(0, 1, 0));
    EXPECT_FALSE(source->has(Column::y));
    EXPECT_THAT(progress.notes, ElementsAre("no unit is given for momentum: taken as eV/c"));
}

TEST_F(NpySource, refusesWhatContradictsItself) {
    const auto error = [&](const std::string& bytes) {
        writeFile(folder / "beam.npy", bytes);
        return errorOf({folder / "beam.npy"});
    };
    const std::string data(96, '\0');
    const auto array = [&](const std::string& descr, const std::string& shape) {
        return error(npy("{'descr': " + descr + ", 'fortran_order': False, 'shape': " + shape + "}", data));
    };
    EXPECT_EQ(array("'<f8'", "(2, 6)"), "");
    EXPECT_THAT(array("'<f8'", "(3, 6)"), HasSubstr("declares 144 bytes of data, and it holds 96"));
    EXPECT_THAT(array("'<f8'", "(1, 6)"), HasSubstr("declares 48 bytes of data, and it holds 96"));
    EXPECT_THAT(array("'<f8'", "(4611686018427387904, 6)"), HasSubstr("more than 2^64"));
    EXPECT_THAT(array("'<f8'", "(18446744073709551616, 6)"), HasSubstr("header that cannot be read"));
    EXPECT_THAT(array("'<f8'", "(-1, 6)"), HasSubstr("header that cannot be read"));
    EXPECT_THAT(array("'<f8'", "(3, 4)"), HasSubstr("N x 6"));
    EXPECT_THAT(array("'<f8'", "(12,)"), HasSubstr("N x 6"));
    EXPECT_THAT(array("'|O'", "(2, 6)"), HasSubstr("elements of type '|O'"));
    EXPECT_THAT(array("'<c16'", "(1, 6)"), HasSubstr("holds no integers"));
    EXPECT_THAT(array("[('a', '<f8')]", "(12,)"), HasSubstr("none of the fields"));
    EXPECT_THAT(array("[('x', '<f8', (1, 1))]", "(12,)"), "");
    EXPECT_THAT(array("[('x', [('y', '<f8')])]", "(12,)"), HasSubstr("fields within the field 'x'"));
    EXPECT_THAT(array("[('x', '<S8')]", "(12,)"), HasSubstr("holds no integers"));
    EXPECT_THAT(array("[('x', '<f8', (99999999999, 99999999999))]", "(1,)"), HasSubstr("too many numbers"));
    EXPECT_THAT(array("[('x', '<f4'), ('X', '<f4')]", "(12,)"), HasSubstr("two fields of the same meaning"));
    EXPECT_THAT(array("__import__('os')", "(2, 6)"), HasSubstr("header that cannot be read"));
    EXPECT_THAT(error(npy("{'descr': '<f8'}", data)), HasSubstr("without descr, fortran_order or shape"));
    EXPECT_THAT(error(npy("((((((((((((1))))))))))))", data)), HasSubstr("header that cannot be read"));
    EXPECT_THAT(error("\x93NUMPY\x01"), HasSubstr("is no .npy file"));
    EXPECT_THAT(error(std::string("\x93NUMPY\x01\x00\xff\xff{'descr'", 18)), HasSubstr("cut short"));
    EXPECT_THAT(error(std::string("\x93NUMPY\x02\x00\xff\xff\xff\xff{", 13)), HasSubstr("cut short"));
    EXPECT_THAT(error(std::string("\x93NUMPY\x09\x00\x10\x00{'a", 13)), HasSubstr("version 9"));
}

}  // namespace
}  // namespace mote::test
