// SPDX-License-Identifier: GPL-3.0-or-later
//
// Archives of NumPy arrays (.npz): what their arrays mean, and archives that lie or are damaged.
#include <gmock/gmock.h>

#include <cstdlib>

#include "tests/support/must.h"
#include "tests/support/random.h"
#include "tests/support/temp_dir.h"
#include "tests/unit/readers/npy_test_file.h"
#include "tests/unit/readers/source_test.h"
#include "tests/unit/readers/zip_test_file.h"

namespace mote::test {
namespace {

using prep::Column;
using testing::ElementsAre;
using testing::HasSubstr;
using Npz = SourceTest;

std::string tuple(std::size_t n) {
    return "(" + std::to_string(n) + ",)";
}

ZipTestFile::Form packedForm() {
    ZipTestFile::Form form;
    form.deflated = true;
    return form;
}

/// The archive as a file of the folder, and its error.
std::string errorOfArchive(const TempDir& folder, const std::string& bytes) {
    writeFile(folder / "beam.npz", bytes);
    return errorOf({folder / "beam.npz"});
}

TEST_F(Npz, readsAnyRowsOfColumnsByName) {
    Random random(1);
    constexpr std::size_t rows = 40'000;  // 320 kB a column: more than any buffer on the way
    const auto x = randomValues(random, rows), px = randomValues(random, rows),
               w = randomValues(random, rows);
    std::vector<double> ids(rows);
    for (std::size_t i = 0; i < rows; ++i) ids[i] = static_cast<double>(3 * i + 7);
    for (const bool deflated : {false, true}) {
        ZipTestFile zip;
        ZipTestFile::Form form;
        form.deflated = deflated;
        zip.add("x.npy", doubles(tuple(rows), x), form);
        zip.add("px [keV/c].npy", doubles(tuple(rows), px), form);
        zip.add("weight.npy", doubles(tuple(rows), w), form);
        zip.add("id.npy",
                npy("{'descr': '>u4', 'fortran_order': False, 'shape': (40000,), }",
                    packed<std::uint32_t>(ids, true)),
                form);
        zip.add("mass.npy", doubles("()", {938.0}), form);
        zip.add("time.npy", doubles("()", {2.5e-9}), form);
        zip.add("iteration.npy",
                npy("{'descr': '<i8', 'fortran_order': False, 'shape': (), }", packed<std::int64_t>({-12.})),
                form);
        zip.add("readme.txt", "not an array", form);
        writeFile(folder / "beam.npz", zip.bytes());
        NoteKeeper notes;
        MOTE_OPEN(source, {folder / "beam.npz"}, notes);
        EXPECT_EQ(source->format(), "npz");
        EXPECT_EQ(source->mass(), 938.0);
        ASSERT_EQ(source->steps().size(), 1u);
        EXPECT_EQ(source->steps()[0].iteration, -12);
        EXPECT_EQ(source->steps()[0].time, 2.5e-9);
        EXPECT_EQ(source->steps()[0].particles, rows);
        EXPECT_FALSE(source->has(Column::t));
        EXPECT_FALSE(source->has(Column::y));
        EXPECT_THAT(notes.notes, testing::ElementsAre("no unit is given for x: taken as m"));
        for (int round = 0; round < 30; ++round) {
            const std::size_t begin = random.below(rows);
            const std::size_t count = round == 0 ? rows - begin : random.below(rows - begin + 1);
            prep::ParticleChunk chunk;
            must(source->read(0, begin, count, {Column::px, Column::x, Column::id, Column::weight}, chunk));
            for (std::size_t i = 0; i < count; ++i) {
                ASSERT_EQ(chunk[Column::x][i], x[begin + i]);
                ASSERT_EQ(chunk[Column::px][i], px[begin + i] * 1e3);
                ASSERT_EQ(chunk[Column::weight][i], std::abs(w[begin + i]));
                ASSERT_EQ(chunk.id[i], 3 * (begin + i) + 7);
            }
        }
    }
}

TEST_F(Npz, readsStepsOfArraysWithTwoDimensions) {
    ZipTestFile zip;
    zip.add("x.npy", doubles("(2, 3)", {1, 2, 3, 4, 5, 6}));
    zip.add("y.npy", npy("{'descr': '<f4', 'fortran_order': True, 'shape': (2, 3), }",
                         packed<float>({1., 4., 2., 5., 3., 6.})));
    zip.add("momentum.npy",
            doubles("(2, 3, 3)", {1, 2, 3, 4, 5, 6, 7, 8, 9,  //
                                  11, 12, 13, 14, 15, 16, 17, 18, 19}),
            packedForm());
    zip.add("weight.npy", doubles("(3,)", {7, 8, 9}));  // of all steps
    zip.add("charge_state.npy", doubles("(5,)", {1, 1, 1, 1, 1}));
    zip.add("z.npy", doubles("()", {0.25}));
    zip.add("time.npy", doubles("(2,)", {1e-9, 3e-9}));
    zip.add("iteration.npy", doubles("(2,)", {100, 300}));
    zip.add("lost.npy", npy("{'descr': '|b1', 'fortran_order': False, 'shape': (2, 3), }",
                            packed<std::uint8_t>({0., 0., 0., 0., 1., 0.})));
    writeFile(folder / "beam.npz", zip.bytes());
    MOTE_OPEN(source, {folder / "beam.npz"}, progress);
    ASSERT_EQ(source->steps().size(), 2u);
    EXPECT_EQ(source->steps()[1].iteration, 300);
    EXPECT_EQ(source->steps()[1].time, 3e-9);
    EXPECT_FALSE(source->has(Column::t));
    EXPECT_THAT(column(*source, 1, Column::x), ElementsAre(4, 5, 6));
    EXPECT_THAT(column(*source, 0, Column::y), ElementsAre(1, 2, 3));
    EXPECT_THAT(column(*source, 1, Column::y), ElementsAre(4, 5, 6));
    EXPECT_THAT(column(*source, 1, Column::z), ElementsAre(0.25, 0.25, 0.25));
    EXPECT_THAT(column(*source, 1, Column::py), ElementsAre(12, 15, 18));
    EXPECT_THAT(column(*source, 0, Column::weight), ElementsAre(7, 8, 9));
    EXPECT_THAT(chunkOf(*source, 0, {}).lost, ElementsAre(0, 0, 0));
    EXPECT_THAT(chunkOf(*source, 1, {}).lost, ElementsAre(0, 1, 0));
}

TEST_F(Npz, ofSeveralFilesIsOneRunInTheOrderOfIterations) {
    const auto write = [&](const char* name, double iteration, double x) {
        ZipTestFile zip;
        zip.add("x.npy", doubles("(1,)", {x}));
        zip.add("time.npy", doubles("(1,)", {x}));  // one particle: its own time
        zip.add("iteration.npy", doubles("()", {iteration}));
        writeFile(folder / name, zip.bytes());
    };
    write("a1.npz", 30, 3);
    write("a2.npz", 10, 1);
    write("a3.npz", 20, 2);
    MOTE_OPEN(source, {folder / "a%T.npz"}, progress);
    ASSERT_EQ(source->steps().size(), 3u);
    for (int i = 0; i < 3; ++i) {
        EXPECT_EQ(source->steps()[i].iteration, 10 * (i + 1));
        EXPECT_THAT(column(*source, i, Column::x), ElementsAre(i + 1));
        EXPECT_THAT(column(*source, i, Column::t), ElementsAre(i + 1));
    }
}

TEST_F(Npz, readsArraysWithoutKnownNamesAndNamedFields) {
    ZipTestFile places;
    places.add("arr_0.npy", doubles("(2, 3)", {1, 2, 3, 4, 5, 6}), packedForm());
    places.add("mass.npy", doubles("()", {5e5}));
    writeFile(folder / "places.npz", places.bytes());
    MOTE_OPEN(source, {folder / "places.npz"}, progress);
    EXPECT_THAT(column(*source, 0, Column::y), ElementsAre(2, 5));
    EXPECT_EQ(source->mass(), 5e5);
    EXPECT_TRUE(progress.noted("without field names"));

    ZipTestFile fields;
    fields.add("beam.npy",
               npy("{'descr': [('x', '<f8'), ('py', '<f4')], 'fortran_order': False, 'shape': (2,)}",
                   packed<double>({1.}) + packed<float>({2.}) + packed<double>({3.}) + packed<float>({4.})),
               packedForm());
    writeFile(folder / "fields.npz", fields.bytes());
    MOTE_OPEN(records, {folder / "fields.npz"}, progress);
    EXPECT_THAT(column(*records, 0, Column::x), ElementsAre(1, 3));
    EXPECT_THAT(column(*records, 0, Column::py), ElementsAre(2, 4));
}

TEST_F(Npz, readsMomentaInUnitsOfItsOwnMass) {
    ZipTestFile zip;
    zip.add("pz (m c).npy", doubles("(1,)", {2}));
    EXPECT_THAT(errorOfArchive(folder, zip.bytes()), HasSubstr("give the particle's mass"));
    zip.add("Mass.npy", doubles("(1,)", {500}));
    EXPECT_EQ(errorOfArchive(folder, zip.bytes()), "");
    MOTE_OPEN(source, {folder / "beam.npz"}, progress);
    EXPECT_THAT(column(*source, 0, Column::pz), ElementsAre(1000));
    proto::ParticlesJob job;
    job.mutable_impact()->set_mass(7);
    MOTE_OPEN(other, {folder / "beam.npz"}, progress, job);
    EXPECT_THAT(column(*other, 0, Column::pz), ElementsAre(14));
}

TEST_F(Npz, ofEveryFormOfArchiveIsRead) {
    const auto check = [&](const std::string& bytes) {
        ASSERT_EQ(errorOfArchive(folder, bytes), "");
        NoteKeeper notes;
        MOTE_OPEN(source, {folder / "beam.npz"}, notes);
        EXPECT_THAT(column(*source, 0, Column::x), ElementsAre(1, 2));
        EXPECT_THAT(column(*source, 0, Column::y), ElementsAre(3, 4));
    };
    for (const bool wideEntry : {false, true}) {
        for (const bool wideArchive : {false, true}) {
            ZipTestFile zip;
            ZipTestFile::Form form;
            form.wide = wideEntry;
            zip.add("x.npy", doubles("(2,)", {1, 2}), form);
            form.deflated = true;
            zip.add("y.npy", doubles("(2,)", {3, 4}), form);
            check(zip.bytes(wideArchive));
            check(zip.bytes(wideArchive, "a comment with PK\x05\x06 in it, and more behind that"));
        }
    }
}

TEST_F(Npz, ofPythonsOwnWriterIsRead) {
    if (std::system("python3 -c 'import zipfile' 2>/dev/null") != 0) GTEST_SKIP() << "no python3 here";
    writeFile(folder / "write.py", R"(
import io, struct, sys, zipfile
values = [0.5 * i for i in range(1000)]
try:
    import numpy
    numpy.savez(sys.argv[1], x=values, y=numpy.arange(1000), time=1e-9)
    numpy.savez_compressed(sys.argv[2], x=values, y=numpy.arange(1000), time=1e-9)
except ImportError:
    def array(descr, shape, data):
        head = str({'descr': descr, 'fortran_order': False, 'shape': shape})
        head += ' ' * (-(len(head) + 11) % 64) + '\n'
        return b'\x93NUMPY\x01\x00' + struct.pack('<H', len(head)) + head.encode() + data
    for name, method in zip(sys.argv[1:], (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED)):
        with zipfile.ZipFile(name, 'w', method) as archive:
            for key, data in (('x', array('<f8', (1000,), struct.pack('<1000d', *values))),
                              ('y', array('<i8', (1000,), struct.pack('<1000q', *range(1000)))),
                              ('time', array('<f8', (), struct.pack('<d', 1e-9)))):
                with archive.open(key + '.npy', 'w', force_zip64=True) as entry:
                    entry.write(data)
)");
    const std::string command = "python3 " + (folder / "write.py").string() + " " +
                                (folder / "a.npz").string() + " " + (folder / "b.npz").string();
    ASSERT_EQ(std::system(command.c_str()), 0);
    for (const char* name : {"a.npz", "b.npz"}) {
        NoteKeeper notes;
        MOTE_OPEN(source, {folder / name}, notes);
        EXPECT_EQ(source->steps()[0].time, 1e-9);
        const auto x = column(*source, 0, Column::x), y = column(*source, 0, Column::y);
        ASSERT_EQ(x.size(), 1000u);
        for (int i = 0; i < 1000; ++i) {
            ASSERT_EQ(x[i], 0.5 * i);
            ASSERT_EQ(y[i], i);
        }
    }
}

TEST_F(Npz, refusesArraysThatContradictEachOther) {
    const auto error = [&](const std::vector<std::pair<const char*, std::string>>& arrays) {
        ZipTestFile zip;
        for (const auto& [name, content] : arrays) zip.add(name + std::string(".npy"), content);
        return errorOfArchive(folder, zip.bytes());
    };
    const std::string two = doubles("(2,)", {1, 2}), three = doubles("(3,)", {1, 2, 3});
    EXPECT_EQ(error({{"x", two}, {"y", two}, {"other", three}}), "");
    EXPECT_THAT(error({{"x", two}, {"y", three}}),
                HasSubstr("corrupt: beam.npz: y: has 3 particles where another array has 2"));
    EXPECT_THAT(error({{"x", doubles("(1, 2)", {1, 2})}, {"y", doubles("(2, 1)", {1, 2})}}),
                HasSubstr("y: has 1 particles where another array has 2"));
    EXPECT_THAT(error({{"x", doubles("(2, 1)", {1, 2})}, {"y", doubles("(3, 1)", {1, 2, 3})}}),
                HasSubstr("y: has 3 steps where another array has 2"));
    EXPECT_THAT(error({{"x", two}, {"X [mm]", two}}), HasSubstr("same meaning"));
    EXPECT_THAT(error({{"x", doubles("(1, 1, 2)", {1, 2})}}), HasSubstr("more than two dimensions"));
    EXPECT_THAT(error({{"x", doubles("(0, 2)", {})}}), HasSubstr("has no step"));
    EXPECT_THAT(error({{"x", two}, {"momentum", doubles("(3, 2)", {1, 2, 3, 4, 5, 6})}}),
                HasSubstr("momentum: has not three numbers"));
    EXPECT_THAT(error({{"x", doubles("(200000, 0)", {})}}), HasSubstr("more than 100000 steps"));
    EXPECT_EQ(error({{"x", doubles("(0,)", {})}}), "");
    EXPECT_THAT(error({{"a", two}, {"b", three}}), HasSubstr("has no array of a name x, y, z"));
    EXPECT_THAT(error({{"a", doubles("(1, 3)", {1, 2, 3})}, {"b", doubles("(1, 3)", {1, 2, 3})}}),
                HasSubstr("has no array of a name x, y, z"));
    EXPECT_THAT(error({{"x", two}, {"mass", doubles("()", {-1})}}), HasSubstr("mass: is no rest mass"));
    EXPECT_THAT(error({{"x", two}, {"iteration", doubles("()", {1.5})}}),
                HasSubstr("iteration: is no whole number"));
    EXPECT_THAT(error({{"x", two}, {"iteration", two}}), HasSubstr("has 2 numbers for 1 steps"));
    EXPECT_THAT(error({{"x", npy("{'descr': '|S4', 'fortran_order': False, 'shape': (1,), }", "abcd")}}),
                HasSubstr("x: holds no integers"));
    // An array of Python's objects beside the columns is none of our business; as the only one it is.
    const std::string object = npy("{'descr': '|O', 'fortran_order': False, 'shape': (), }", "cos\nsystem\n");
    EXPECT_EQ(error({{"meta", object}, {"x", two}}), "");
    EXPECT_THAT(error({{"meta", object}}), HasSubstr("meta: has elements of type '|O'"));
    EXPECT_THAT(error({}), HasSubstr("is a zip archive without arrays"));
}

TEST_F(Npz, refusesArchivesThatLie) {
    const std::string array = doubles("(2,)", {1, 2});
    const auto error = [&](auto change) {
        ZipTestFile zip;
        ZipTestFile::Form form;
        change(form);
        zip.add("x.npy", array, form);
        return errorOfArchive(folder, zip.bytes());
    };
    using Form = ZipTestFile::Form;
    EXPECT_EQ(error([](Form&) {}), "");
    EXPECT_THAT(error([](Form& form) { form.flags = 1; }),
                HasSubstr("unsupported: beam.npz: x.npy: is encrypted"));
    EXPECT_THAT(error([](Form& form) { form.method = 12; }), HasSubstr("is packed by method 12"));
    EXPECT_THAT(error([](Form& form) { form.checksum = 1; }),
                HasSubstr("beam.npz: x: is damaged: its checksum"));
    EXPECT_THAT(error([](Form& form) { form.storedBytes = 1u << 30; }), HasSubstr("does not hold"));
    EXPECT_THAT(error([](Form& form) { form.bytes = 100; }), HasSubstr("stored ones cannot hold"));
    EXPECT_THAT(error([](Form& form) { form.offset = 1; }), HasSubstr("does not begin where"));
    EXPECT_THAT(error([](Form& form) { form.offset = 1u << 30; }), HasSubstr("lies outside"));
    EXPECT_THAT(error([](Form& form) { form.localName = "y.npy"; }),
                HasSubstr("another name in its own header"));
    EXPECT_THAT(error([](Form& form) {
                    form.deflated = true;
                    form.bytes = 0xfffffff0;
                }),
                HasSubstr("stored ones cannot hold"));
    ZipTestFile twice;
    twice.add("x.npy", array);
    twice.add("x.npy", array);
    EXPECT_THAT(errorOfArchive(folder, twice.bytes()), HasSubstr("x.npy: stands twice"));
    // Two names for the same bytes, as bombs have them: the second entry lies within the first.
    ZipTestFile overlapping, inner;
    inner.add("y.npy", array);
    const std::string nested = inner.bytes();
    Form form;
    overlapping.add("x.npy", nested);
    form.offset = static_cast<std::uint32_t>(30 + 5);
    overlapping.add("y.npy", array, form);
    EXPECT_THAT(errorOfArchive(folder, overlapping.bytes()), HasSubstr("y.npy: overlaps another entry"));
    ZipTestFile many;
    for (int i = 0; i < 4097; ++i) many.add(std::to_string(i) + ".npy", array);
    EXPECT_THAT(errorOfArchive(folder, many.bytes()), HasSubstr("holds more than 4096 files"));
}

}  // namespace
}  // namespace mote::test
