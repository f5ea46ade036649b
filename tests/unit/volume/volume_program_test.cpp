// SPDX-License-Identifier: GPL-3.0-or-later
//
// mote-prep volume as a user meets it: what is wrong with an input or an option is said in one line, with
// nothing left behind and no memory taken for it; volumes of unusual shapes are made.
#include <gmock/gmock.h>

#include <array>
#include <csignal>
#include <fstream>

#include "storage/verify.h"
#include "tests/e2e/process.h"
#include "tests/support/temp_dir.h"

namespace mote::test {
namespace {

namespace fs = std::filesystem;
using testing::AnyOf;
using testing::HasSubstr;
using testing::IsEmpty;

class VolumeProgram : public testing::Test {
  protected:
    void SetUp() override {
        fs::create_directory(out());
        std::string values;
        for (int i = 0; i < 40 * 30 * 20; ++i) values += static_cast<char>(i * i / 7 % 200);
        write("a.raw", values);
    }

    fs::path out() const { return folder_ / "out"; }
    std::string path(const std::string& name) const { return (folder_ / name).string(); }
    void write(const std::string& name, const std::string& bytes) const {
        std::ofstream(folder_ / name, std::ios::binary) << bytes;
    }
    void writeNrrd(const std::string& name, const std::string& sizes, const std::string& data) const {
        write(name, "NRRD0004\ntype: uchar\ndimension: 3\nsizes: " + sizes + "\nencoding: raw\n\n" + data);
    }

    std::vector<std::string> job(const std::string& input, const std::vector<std::string>& more) const {
        std::vector<std::string> arguments{"volume", path(input), "--quiet", "--out", out() / "a.mote"};
        arguments.insert(arguments.end(), more.begin(), more.end());
        return arguments;
    }
    Finished run(const std::string& input, const std::vector<std::string>& more) const {
        return runProcess(fs::path(MOTE_BIN) / "mote-prep", job(input, more));
    }
    void expectRefused(const std::string& input, const std::vector<std::string>& more,
                       const std::string& sentence, int status = 1) const {
        SCOPED_TRACE(sentence);
        const auto done = run(input, more);
        EXPECT_EQ(done.status, status);
        EXPECT_THAT(done.errors, HasSubstr(sentence));
        EXPECT_EQ(std::count(done.errors.begin(), done.errors.end(), '\n'), 1) << done.errors;
        EXPECT_TRUE(fs::is_empty(out()));
    }
    void expectMade(const std::string& input, const std::vector<std::string>& more) const {
        const auto done = run(input, more);
        ASSERT_EQ(done.status, 0) << done.errors;
        EXPECT_THAT(storage::verifyDataset(out() / "a.mote"), IsEmpty());
        fs::remove_all(out() / "a.mote");
    }

    TempDir folder_;
};

std::vector<std::string> operator+(std::vector<std::string> words, const std::vector<std::string>& more) {
    words.insert(words.end(), more.begin(), more.end());
    return words;
}

const std::vector<std::string> raw{"--dimensions", "40", "30", "20"};
const std::vector<std::string> few{"--threshold", "0.1"};

TEST_F(VolumeProgram, SizesThatTheFileContradictsAreRefused) {
    expectRefused("a.raw", few + std::vector<std::string>{"--dimensions", "40", "30", "21"},
                  "a.raw: its dimensions 40 x 30 x 21 of u8 are 25200 bytes, and it holds 24000");
    expectRefused("a.raw", few + std::vector<std::string>{"--dimensions", "0", "30", "20"}, "no voxels", 2);
    expectRefused("a.raw", few + std::vector<std::string>{"--dimensions", "1000000", "1000000", "1000000"},
                  "at most 65536", 2);
    expectRefused("a.raw", few + std::vector<std::string>{"--dimensions", "65536", "65536", "65536"},
                  "281474976710656 bytes, and it holds 24000");
    writeNrrd("bomb.nrrd", "60000 60000 60000", "x");
    expectRefused("bomb.nrrd", few, "bomb.nrrd: its dimensions");
    writeNrrd("wide.nrrd", "4294967297 2 2", "x");
    expectRefused("wide.nrrd", few, "wide.nrrd: sizes: ");
}

/// 69 bytes: OpenVDB's header, no metadata, one grid, whose name is 2 GiB long.
TEST_F(VolumeProgram, AVdbOfHugeLengthsIsRefused) {
    const std::string_view magic("\x20\x42\x44\x56\0\0\0\0\xe0\0\0\0\x0a\0\0\0\0\0\0\0\1", 21);
    const std::string_view rest("\0\0\0\0\1\0\0\0\xff\xff\xff\x7f", 12);
    write("bomb.vdb", std::string(magic) + "00000000-0000-0000-0000-000000000000" + std::string(rest));
    expectRefused("bomb.vdb", few, "bomb.vdb: asks for more memory than there is");
}

TEST_F(VolumeProgram, WhatIsNoVolumeIsRefused) {
    write("noise", std::string(5000, '\xfe'));
    write("empty", "");
    for (const auto* name : {"noise", "empty"}) {
        expectRefused(name, few, std::string(name) + ": is no NRRD, MetaImage");
    }
    expectRefused("out", few, "out: is a folder without DICOM files, PNG or TIFF pictures");
    expectRefused("nothing.nrrd", few, "nothing.nrrd: cannot be read: No such file");
}

TEST_F(VolumeProgram, OptionsOutOfRangeAreRefused) {
    const auto refused = [&](const std::vector<std::string>& options, const std::string& sentence) {
        expectRefused("a.raw", raw + options, sentence, 2);
    };
    for (const auto* threshold : {"-1", "2", "nan", "inf"}) {
        refused({"--threshold", threshold},
                "volume.threshold: " + std::string(threshold) + " is not a number from 0 to 1");
    }
    for (const auto* most : {"0", "1000000000000000000"}) {
        refused({"--max-points", most}, "is not a number from 1 to 68719476736");
    }
    for (const auto* most :
         {"-1", "99999999999999999999"}) {  // CLI11 before 2.4 takes them for great numbers
        const auto done = run("a.raw", raw + std::vector<std::string>{"--max-points", most});
        EXPECT_EQ(done.status, 2);
        EXPECT_THAT(done.errors, AnyOf(HasSubstr("is not a number from 1 to 68719476736"),
                                       HasSubstr("--max-points: \"" + std::string(most) + "\" is not")));
        EXPECT_TRUE(fs::is_empty(out()));
    }
    for (const auto* filter : {"under:2", "under:nan", "under:", "gauss"}) {
        refused(few + std::vector<std::string>{"--filter", filter}, "volume.filter: must be cubic, box or");
    }
    refused(few + std::vector<std::string>{"--space", "las"}, "space: \"las\" is none of ras, lps and file");
    refused(few + std::vector<std::string>{"--low", "0"}, "volume.low: must be at least 1");
    refused(few + std::vector<std::string>{"--error-grid", "0"}, "volume.errorGrid: must be at least 1");
    refused(few + std::vector<std::string>{"--spacing", "nan", "1", "1"}, "spacing: is not over 0");
    expectRefused("a.raw", raw + few + std::vector<std::string>{"--memory", "64M"},
                  "needs at least 97 MiB of memory where the job may take 64 MiB");
}

TEST_F(VolumeProgram, AnOutputThatIsThereStays) {
    write("out/a.mote", "mine");
    const auto done = run("a.raw", raw + few);
    EXPECT_EQ(done.status, 1);
    EXPECT_THAT(done.errors, HasSubstr("a.mote: exists already and is never replaced"));
    EXPECT_EQ(fs::file_size(out() / "a.mote"), 4U);
}

TEST_F(VolumeProgram, UnusualShapesAreMade) {
    const std::string noise = [] {
        std::string bytes;
        for (unsigned i = 0; i < 600 * 400; ++i) bytes += static_cast<char>(i * 2654435761U >> 24U);
        return bytes;
    }();
    const std::array<std::array<const char*, 3>, 6> shapes{{{"600", "400", "1"},
                                                            {"600", "1", "400"},
                                                            {"1", "400", "600"},
                                                            {"1", "1", "240000"},
                                                            {"2", "2", "60000"},
                                                            {"60000", "4", "1"}}};
    for (const auto& shape : shapes) {
        write("b.raw", noise);
        const std::vector<std::string> options{"--dimensions",     shape[0], shape[1],      shape[2],
                                               "--representation", "both",   "--threshold", "0.2",
                                               "--spacing",        "1",      "1e-6",        "1e6"};
        if (std::string_view(shape[2]) == "240000") {
            expectRefused("b.raw", options, "at most 65536", 2);
        } else {
            expectMade("b.raw", options);
        }
    }
    writeNrrd("two.nrrd", "2 2 2", "abcdefgh");
    expectMade("two.nrrd", {"--threshold", "0", "--representation", "both", "--filter", "under:0"});
    write("one.raw", "x");
    expectMade("one.raw", {"--dimensions", "1", "1", "1", "--max-points", "9", "--representation", "both"});
    for (const auto* low : {"1", "4294967295"}) {
        expectMade("a.raw", raw + few + std::vector<std::string>{"--low", low});
    }
}

class VolumeProgramEnded : public VolumeProgram, public testing::WithParamInterface<int> {};

TEST_P(VolumeProgramEnded, CancelledItLeavesNothing) {
    // Long enough for a signal to meet it: each of many steps is begun anew.
    auto arguments = job("a.raw", raw + std::vector<std::string>{"--threshold", "0", "--low", "4"});
    for (int i = 0; i < 3000; ++i) arguments.insert(arguments.begin() + 2, path("a.raw"));
    Process program(fs::path(MOTE_BIN) / "mote-prep", arguments);
    while (fs::is_empty(out())) ASSERT_FALSE(program.wait(std::chrono::milliseconds(1)).has_value());
    program.signal(GetParam());
    EXPECT_EQ(program.wait(), 128 + GetParam());
    EXPECT_EQ(program.errors(), "mote-prep: cancelled, nothing was made\n");
    EXPECT_TRUE(fs::is_empty(out()));
}

INSTANTIATE_TEST_SUITE_P(Signals, VolumeProgramEnded, testing::Values(SIGINT, SIGTERM));

}  // namespace
}  // namespace mote::test
