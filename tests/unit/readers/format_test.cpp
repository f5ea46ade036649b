// SPDX-License-Identifier: GPL-3.0-or-later
//
// H5Part runs, and what is said about inputs that are not read.
#include <gmock/gmock.h>
#include <sys/stat.h>

#include "preprocess/readers/adios2/bp_file.h"
#include "preprocess/readers/format_detection.h"
#include "preprocess/readers/series_source.h"
#include "tests/support/temp_dir.h"
#include "tests/unit/readers/h5_test_file.h"
#include "tests/unit/readers/source_test.h"

namespace mote::test {
namespace {

using prep::Column;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using Format = SourceTest;
using H5Part = SourceTest;

TEST_F(H5Part, readsStepsInTheOrderOfTheirNumbers) {
    {
        H5TestFile file(folder / "beam.h5");
        for (const int i : {10, 2, 1}) {
            const std::string step = "/Step#" + std::to_string(i);
            for (const char* name : {"x", "y", "z", "px", "py", "pz"}) {
                file.data(step + "/" + name, std::vector<double>{i + 0.0, i + 0.5});
            }
            file.data(step + "/q", std::vector<float>{-2.0f, 2.0f});
            file.data(step + "/id", std::vector<std::int64_t>{4, 5});
            file.attribute(step, "TIME", i * 1e-9);
        }
    }
    MOTE_OPEN(source, {folder / "beam.h5"}, progress);
    EXPECT_EQ(source->format(), "h5part");
    ASSERT_EQ(source->steps().size(), 3u);
    EXPECT_EQ(source->steps()[2].iteration, 10);
    EXPECT_DOUBLE_EQ(source->steps()[2].time, 1e-8);
    EXPECT_THAT(column(*source, 1, Column::pz), ElementsAre(2, 2.5));
    const auto chunk = chunkOf(*source, 0, {Column::weight, Column::id});
    EXPECT_THAT(chunk[Column::weight], ElementsAre(2, 2));
    EXPECT_THAT(chunk.id, ElementsAre(4, 5));
    EXPECT_TRUE(progress.noted("names no units"));
    EXPECT_FALSE(source->has(Column::t));
}

TEST_F(H5Part, takesUnitsFromAttributes) {
    const auto write = [&](bool mass) {
        H5TestFile file(folder / "opal.h5");
        file.data("/Step#0/x", std::vector<double>{1000});
        file.data("/Step#0/px", std::vector<double>{2});
        file.text("/", "xUnit", "mm");
        file.text("/", "pxUnit", "#beta#gamma");
        if (mass) file.attribute("/Step#0", "MASS", std::vector<double>{0.938});
    };
    write(false);
    EXPECT_THAT(errorOf({folder / "opal.h5"}),
                HasSubstr("invalid_argument: opal.h5:/@pxUnit: is in units of m c"));
    write(true);
    MOTE_OPEN(source, {folder / "opal.h5"}, progress);
    EXPECT_THAT(column(*source, 0, Column::x), ElementsAre(1.0));
    EXPECT_THAT(column(*source, 0, Column::px), ElementsAre(testing::DoubleNear(2 * 0.938e9, 1e-3)));
    EXPECT_NEAR(source->mass(), 0.938e9, 1e-3);
    EXPECT_TRUE(progress.notes.empty());
}

TEST_F(H5Part, givesWhatElseItHasUnderItsOwnName) {
    {
        H5TestFile file(folder / "a.h5");
        for (int step = 0; step < 2; ++step) {
            const auto group = "/Step#" + std::to_string(step);
            for (const char* name : {"/x", "/px", "/y"}) file.data(group + name, std::vector{1.0, 2.0});
            file.data(group + "/turn", std::vector<std::int64_t>{123456789, 8 + step});
            file.data(group + "/dt", std::vector{1e-12, -1e-12});
        }
        file.text("/", "dtUnit", "s");
        file.data("/Step#1/bin", std::vector<std::int32_t>{1, 2});
    }
    MOTE_OPEN(source, {folder / "a.h5"}, progress);
    EXPECT_THAT(record(*source, 1, "turn"), ElementsAre(123456789, 9));
    EXPECT_THAT(record(*source, 0, "dt", "s"), ElementsAre(1e-12, -1e-12));
    EXPECT_EQ(source->records().size(), 2U) << "bin is not in every step";
}

TEST_F(H5Part, refusesColumnsOfDifferentLengths) {
    {
        H5TestFile file(folder / "beam.h5");
        file.data("/Step#0/x", std::vector<double>{1, 2});
        file.data("/Step#0/y", std::vector<double>{1});
    }
    EXPECT_THAT(errorOf({folder / "beam.h5"}), HasSubstr("corrupt: beam.h5:/Step#0/y: has 1 values"));
}

TEST_F(Format, ofAnInputThatIsNotReadIsNamedWithAWayOut) {
    std::filesystem::create_directory(folder / "run.bp");
    writeFile(folder / "run.bp" / "md.idx", "x");
    if (prep::openBp() != nullptr) {  // ADIOS2 is there, and its index is not
        EXPECT_THAT(errorOf({folder / "run.bp"}), HasSubstr("corrupt: run.bp"));
    } else {
        EXPECT_THAT(errorOf({folder / "run.bp"}),
                    AllOf(HasSubstr("unsupported: run.bp: is an ADIOS2 BP4 file"),
                          HasSubstr("openpmd-pipe --infile run.bp --outfile run.h5")));
        writeFile(folder / "run.bp" / "mmd.0", "x");
        EXPECT_THAT(errorOf({folder / "run.bp"}), HasSubstr("BP5"));
    }
    std::filesystem::create_directory(folder / "plain");
    EXPECT_THAT(errorOf({folder / "plain"}), HasSubstr("is a folder without files"));
    writeFile(folder / "md.0", "ADIOS-BP v2.8.3 Metadata\x01");
    EXPECT_THAT(errorOf({folder / "md.0"}), HasSubstr("openpmd-pipe"));
    writeFile(folder / "beam.npz", "PK\x03\x04....");
    EXPECT_THAT(errorOf({folder / "beam.npz"}), HasSubstr("zip archive that is cut short"));
    writeFile(folder / "noise", std::string("\x00\x01\x02\x03 noise", 10));
    EXPECT_THAT(errorOf({folder / "noise"}), HasSubstr("unsupported: noise: is of no known format"));
    writeFile(folder / "empty", "");
    EXPECT_THAT(errorOf({folder / "empty"}), HasSubstr("empty: is empty"));
    EXPECT_THAT(errorOf({folder / "absent"}), HasSubstr("not_found: absent"));
    EXPECT_THAT(errorOf({}), HasSubstr("invalid_argument: inputs"));
    { H5TestFile file(folder / "other.h5"); }
    EXPECT_THAT(errorOf({folder / "other.h5"}), HasSubstr("neither openPMD"));
    ASSERT_EQ(mkfifo((folder / "pipe").c_str(), 0600), 0);
    EXPECT_THAT(errorOf({folder / "pipe"}), HasSubstr("is not a regular file"));
}

TEST_F(Format, thatIsNamedGoesBeforeWhatTheFileLooksLike) {
    writeFile(folder / "beam.txt", "x y z px py pz\n1 2 3 4 5 6\n");
    proto::ParticlesJob job;
    job.set_format("openpmd");
    EXPECT_THAT(errorOf({folder / "beam.txt"}, job), HasSubstr("is not an HDF5 file"));
    job.set_format("npy");
    EXPECT_THAT(errorOf({folder / "beam.txt"}, job), HasSubstr("is no .npy file"));
    job.set_format("auto");
    EXPECT_EQ(errorOf({folder / "beam.txt"}, job), "");
    job.set_format("hdf4");
    EXPECT_THAT(errorOf({folder / "beam.txt"}, job),
                HasSubstr("invalid_argument: format: 'hdf4' is none of auto"));
    job.set_format("sdds");
    EXPECT_THAT(errorOf({folder / "beam.txt"}, job), HasSubstr("is not the beginning of an SDDS data set"));
    job.set_format("csv");
    job.set_species("e");
    EXPECT_THAT(errorOf({folder / "beam.txt"}, job), HasSubstr("species: only openPMD files have species"));
}

TEST_F(Format, ofAllFilesIsOne) {
    writeFile(folder / "a1.csv", "x,y\n1,2\n");
    {
        H5TestFile file(folder / "a2.h5");
        file.data("/Step#0/x", std::vector<double>{1});
    }
    EXPECT_THAT(errorOf({folder / "a1.csv", folder / "a2.h5"}),
                HasSubstr("a2.h5: is of another format than a1.csv"));
}

TEST_F(Format, ofAFolderIsThatOfMostFiles) {
    writeFile(folder / "a.csv", "x,y\n1,2\n");
    writeFile(folder / "b.json", R"({"x": [1], "y": [2]})");
    EXPECT_THAT(errorOf({folder.path()}), HasSubstr("as many files of csv as of json; choose with --format"));
    writeFile(folder / "c.json", R"({"x": [1], "y": [2]})");
    EXPECT_EQ(errorOf({folder.path()}), "");
    // IMPACT's own tables beside its particles have as many columns.
    const TempDir impact;
    for (const char* name : {"fort.18", "fort.24", "fort.40", "fort.50"})
        writeFile(impact / name, "2\n1e-3 0 1e-3 0 1e-3 1\n2e-3 0 2e-3 0 2e-3 1\n");
    writeFile(impact / "ImpactT.in", "1 1\n");
    proto::ParticlesJob job;
    NoteKeeper notes;
    const auto files = prep::inputFiles({impact.path()});
    const auto found = prep::detectFormat(job, *files, notes);
    ASSERT_TRUE(found.ok());
    ASSERT_EQ(found->paths.size(), 2U);
    EXPECT_EQ(found->paths.front().filename(), "fort.40");
}

TEST(FileNumber, isTheLastOneBeforeTheEndings) {
    EXPECT_EQ(prep::fileNumber("a/fort.101.txt.gz"), 101);
    EXPECT_EQ(prep::fileNumber("beam_0003.csv"), 3);
    EXPECT_EQ(prep::fileNumber("run2_step40.h5"), 40);
    EXPECT_EQ(prep::fileNumber("fort.50"), 50);
    EXPECT_EQ(prep::fileNumber("12"), 12);
    EXPECT_EQ(prep::fileNumber("beam.h5"), std::nullopt);
    EXPECT_EQ(prep::fileNumber("99999999999999999999.csv"), std::nullopt);
}

}  // namespace
}  // namespace mote::test
