// SPDX-License-Identifier: GPL-3.0-or-later
//
// mote-prep as its users meet it: a process with arguments, output, errors and an exit status.
#include <fcntl.h>
#include <gmock/gmock.h>
#include <sysexits.h>
#include <unistd.h>

#include <csignal>
#include <fstream>

#include "protocol/base/json.h"
#include "protocol/mote.pb.h"
#include "storage/manifest.h"
#include "tests/e2e/process.h"
#include "tests/support/temp_dir.h"

namespace mote::test {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::EndsWith;
using testing::HasSubstr;
using testing::StartsWith;

class MotePrep : public testing::Test {
  protected:
    void SetUp() override {
        writeTable(dir_ / "run.csv", 2000);
        fs::create_directory(dir_ / "plots");
    }

    static void writeTable(const fs::path& path, int rows) {
        std::ofstream table(path);
        table << "x [m],y [m],z [m],px [eV/c],py [eV/c],pz [eV/c]\n";
        for (int i = 0; i < rows; ++i) {
            table << 1e-3 * (i % 97) << ',' << 1e-3 * (i % 89) << ',' << 1e-3 * (i % 83) << ',' << i % 101
                  << ',' << i % 103 << ",1e6\n";
        }
    }

    static Finished run(const std::vector<std::string>& arguments, const ProcessOptions& options = {}) {
        return runProcess(fs::path(MOTE_BIN) / "mote-prep", arguments, options);
    }
    std::string path(const std::string& name) const { return (dir_ / name).string(); }
    std::vector<std::string> particles(const std::string& out,
                                       const std::vector<std::string>& more = {}) const {
        std::vector<std::string> arguments{"particles", path("run.csv"), "--axes",
                                           "x,px,y",    "--out",         path(out)};
        arguments.insert(arguments.end(), more.begin(), more.end());
        return arguments;
    }
    /// What lies beneath the test's folder: names, sorted.
    std::vector<std::string> entries() const {
        std::vector<std::string> names;
        for (const auto& entry : fs::recursive_directory_iterator(dir_.path())) {
            names.push_back(entry.path().lexically_relative(dir_.path()).string());
        }
        std::sort(names.begin(), names.end());
        return names;
    }
    /// One line on stderr with all the words, nothing on stdout, nothing left behind.
    void expectFailure(const std::vector<std::string>& arguments, int status,
                       const std::vector<std::string>& words, const ProcessOptions& options = {}) const {
        const auto before = entries();
        const auto done = run(arguments, options);
        EXPECT_EQ(done.status, status) << done.errors;
        EXPECT_EQ(done.output, "");
        if (status != 2) {  // of wrong usage more is said
            EXPECT_EQ(std::count(done.errors.begin(), done.errors.end(), '\n'), 1) << done.errors;
        }
        for (const auto& word : words) EXPECT_THAT(done.errors, HasSubstr(word));
        EXPECT_EQ(entries(), before);
    }

    TempDir dir_;
};

TEST_F(MotePrep, MakesInspectsVerifiesAndExports) {
    const auto made = run(particles("a.mote", {"--json"}));
    ASSERT_EQ(made.status, 0) << made.errors;
    EXPECT_THAT(made.output, AllOf(StartsWith("{\"output\": \"" + path("a.mote") + "\""),
                                   HasSubstr("\"particles\": 2000"), EndsWith("}\n")));
    const auto info = run({"info", path("a.mote"), "--json"});
    proto::Manifest manifest;
    ASSERT_TRUE(parseJson(info.output, manifest, "info").ok());
    EXPECT_EQ(manifest.particles().steps(0).particles(), 2000U);
    EXPECT_THAT(run({"info", path("a.mote")}).output, AllOf(HasSubstr("run.csv"), HasSubstr("eV/c")));
    EXPECT_EQ(run({"verify", path("a.mote")}).output, path("a.mote") + ": whole\n");
    EXPECT_THAT(run({"verify", path("a.mote"), "--json"}).output, HasSubstr("\"whole\": true"));
    EXPECT_EQ(run({"export", path("a.mote"), "--vdb", path("a.vdb"), "--quiet"}).output, "");
    EXPECT_GT(fs::file_size(dir_ / "a.vdb"), 1000U);
}

TEST_F(MotePrep, VerifyFindsDamageAndExportRefusesIt) {
    ASSERT_EQ(run(particles("a.mote")).status, 0);
    {
        const auto file = dir_ / "a.mote" / "step-000000.h5";
        std::fstream stream(file, std::ios::binary | std::ios::in | std::ios::out);
        // The volume is 1 MiB large, and little lies behind it.
        stream.seekp(-500000, std::ios::end);
        stream.write("damaged", 7);
    }
    const auto verified = run({"verify", path("a.mote"), "--json"});
    EXPECT_EQ(verified.status, 1);
    EXPECT_THAT(verified.output,
                AllOf(HasSubstr("\"whole\": false"), HasSubstr("step-000000.h5:/volume/density")));
    EXPECT_THAT(verified.errors, HasSubstr("at byte 0 of the array"));
    expectFailure({"export", path("a.mote"), "--vdb", path("a.vdb")}, 1, {"/volume/density"});
}

TEST_F(MotePrep, HelpHasExamples) {
    for (const std::vector<std::string>& command :
         {std::vector<std::string>{}, {"particles"}, {"info"}, {"verify"}, {"export"}, {"job"}}) {
        auto arguments = command;
        arguments.emplace_back("--help");
        const auto help = run(arguments);
        EXPECT_EQ(help.status, 0);
        EXPECT_THAT(help.output, AllOf(HasSubstr("Example"), HasSubstr("mote-prep")));
        EXPECT_EQ(help.errors, "");
    }
    EXPECT_THAT(run({"--version"}).output, StartsWith("mote-prep "));
}

TEST_F(MotePrep, WrongUsageIsTwo) {
    expectFailure({}, 2, {"subcommand"});
    expectFailure({"volume", "x"}, 2, {});
    expectFailure({"particles", path("run.csv"), "--out", path("a.mote")}, 2, {"--axes"});
    expectFailure(particles("a.mote", {"--no-such"}), 2, {"no-such"});
    expectFailure(particles("a.mote", {"--threads", "0"}), 2, {"--threads"});
    expectFailure(particles("a.mote", {"--memory", "much"}), 2, {"--memory"});
    expectFailure(particles("a.mote", {"--format", "vtk"}), 2, {"--format"});
    expectFailure(particles("a.mote", {"--steps", "1:0"}), 2, {"steps"});
    expectFailure(particles("a.mote", {"--volume-level", "9"}), 2, {"volumeLevel"});
    expectFailure(particles("a.mote", {"--bounds", "x=1"}), 2, {"AXIS=MIN:MAX"});
    expectFailure(particles("a.mote", {"--bounds", "x=a:b"}), 2, {"AXIS=MIN:MAX"});
    expectFailure(particles("a.mote", {"--bounds", "z=0:1"}), 2, {"bounds"});
    expectFailure({"particles", path("run.csv"), "--axes", "x,px,w", "--out", path("a.mote")}, 1,
                  {"axis w", "neither a column of the run"});
    expectFailure(particles("a.h5"), 2, {".mote"});
}

TEST_F(MotePrep, WhatCannotBeIsOneSentence) {
    expectFailure({"particles", path("none.h5"), "--axes", "x,px,y", "--out", path("a.mote")}, 1,
                  {"none.h5"});
    expectFailure({"particles", path("run.csv"), "--axes", "x,y,t", "--out", path("a.mote")}, 1, {"axis t"});
    expectFailure(particles("plots"), 2, {".mote"});
    expectFailure(particles("nowhere/a.mote"), 1, {"nowhere"});
    expectFailure(particles("a.mote", {"--memory", "2M"}), 1, {"memory"});
    ProcessOptions small;
    small.fileSizeLimit = 5000;
    expectFailure(particles("a.mote"), EX_TEMPFAIL, {"a.mote", "File too large"}, small);
    expectFailure({"info", path("plots")}, 1, {"is no dataset", "NAME.mote"});
    expectFailure({"export", path("plots"), "--vdb", path("a.vdb")}, 1, {"manifest.json"});
    ASSERT_EQ(run(particles("a.mote")).status, 0);
    expectFailure(particles("a.mote"), 1, {"exists already"});
    expectFailure({"export", path("a.mote"), "--vdb", path("a.vdb"), "--step", "1"}, 1, {"1 step"});
    expectFailure({"export", path("a.mote"), "--vdb", path("nowhere/a.vdb")}, 1, {"nowhere"});
    expectFailure({"export", path("a.mote"), "--vdb", path("a.vdb")}, EX_TEMPFAIL, {"a.vdb"}, small);
}

TEST_F(MotePrep, BoundsTitleAndSelectionArrive) {
    ASSERT_EQ(
        run(particles("a.mote", {"--bounds", "x=-1e-1:0.05", "--bounds", "px=0:200", "--title", "A \"b\"",
                                 "--steps", "0", "--leaf-capacity", "8", "--max-level", "5"}))
            .status,
        0);
    const auto manifest = *storage::readManifest(dir_ / "a.mote");
    EXPECT_EQ(manifest.particles().axes(0).min(), -0.1);
    EXPECT_EQ(manifest.particles().axes(1).max(), 200.0);
    EXPECT_GT(manifest.particles().steps(0).outside(), 0U);
    EXPECT_EQ(manifest.title(), "A \"b\"");
    EXPECT_EQ(manifest.particles().leaf_capacity(), 8U);
    EXPECT_EQ(manifest.request().particles().inputs(0), "run.csv");
}

class MotePrepJob : public MotePrep {
  protected:
    std::string request(const std::string& json) const {
        std::ofstream(dir_ / "request.json") << json;
        return path("request.json");
    }
    std::string root() const { return "data=" + dir_.path().string(); }
};

TEST_F(MotePrepJob, NamesBeneathRootsAndProgressLines) {
    const auto file = request(R"({"output": "data/plots/a.mote", "particles": {"inputs": ["data/run.csv"],
                                  "axes": ["x", "px", "y"]}})");
    // Descriptor 1 is the one that the test can read.
    const auto done = run({"job", file, "--root", root(), "--progress-fd", "1", "--quiet"});
    ASSERT_EQ(done.status, 0) << done.errors;
    std::istringstream lines(done.output);
    std::string line;
    double before = 0.0;
    while (std::getline(lines, line)) {
        proto::JobProgress progress;
        ASSERT_TRUE(parseJson(line, progress, "progress").ok()) << line;
        EXPECT_GE(progress.progress(), before);
        EXPECT_FALSE(progress.phase().empty());
        before = progress.progress();
    }
    EXPECT_EQ(before, 1.0);
    EXPECT_EQ(storage::readManifest(dir_ / "plots" / "a.mote")->request().particles().inputs(0),
              "../run.csv");
}

TEST_F(MotePrepJob, TheSameBytesAsTheCommandLine) {
    const auto file = request(R"({"output": "data/a.mote", "particles": {"inputs": ["data/run.csv"],
                                  "axes": ["x", "px", "y"]}})");
    ASSERT_EQ(run({"job", file, "--root", root()}).status, 0);
    ASSERT_EQ(run(particles("b.mote")).status, 0);
    EXPECT_EQ(toJson(*storage::readManifest(dir_ / "a.mote")),
              toJson(*storage::readManifest(dir_ / "b.mote")));
}

TEST_F(MotePrepJob, BadRequestsNameTheirField) {
    const auto refused = [&](const std::string& json, int status, const std::vector<std::string>& words) {
        expectFailure({"job", request(json), "--root", root()}, status, words);
    };
    request("");  // so that the file is there before each comparison
    refused("{", 2, {"request.json"});
    refused(R"({"output": "data/a.mote", "particles": {"colour": 1}})", 2, {"colour"});
    refused(R"({"output": "data/a.mote"})", 2, {"no job"});
    refused(R"({"particles": {"inputs": ["data/run.csv"], "axes": ["x", "px", "y"]}})", 2, {"output"});
    refused(R"({"output": "data/a.mote", "particles": {"inputs": ["data/run.csv"], "axes": ["x", "px"]}})", 2,
            {"particles.axes"});
    refused(R"({"output": "../a.mote", "particles": {"inputs": ["data/run.csv"], "axes": ["x", "px", "y"]}})",
            2, {"output"});
    refused(R"({"output": "data/a.mote", "particles": {"inputs": ["data/../x"], "axes": ["x", "px", "y"]}})",
            2, {"particles.inputs[0]"});
    refused(
        R"({"output": "data/a.mote", "particles": {"inputs": ["/etc/passwd"], "axes": ["x", "px", "y"]}})", 2,
        {"particles.inputs[0]"});
    expectFailure({"job", path("request.json"), "--progress-fd", "99"}, 2, {"--progress-fd"});
    expectFailure({"job", path("request.json"), "--root", "data"}, 2, {"NAME=DIR"});
    expectFailure({"job", path("none.json")}, 1, {"none.json"});
}

class MotePrepSignal : public MotePrep, public testing::WithParamInterface<int> {};

TEST_P(MotePrepSignal, CancelsWithoutDebris) {
    // Long enough that the signal comes before the end: it goes out at the first line of progress.
    writeTable(dir_ / "run.csv", 300000);
    std::ofstream(dir_ / "request.json")
        << R"({"output": ")" << path("a.mote") << R"(", "particles": {"inputs": [")" << path("run.csv")
        << R"("], "axes": ["x", "px", "y"], "leafCapacity": 1, "volumeLevel": 8}})";
    const auto before = entries();
    Process process(fs::path(MOTE_BIN) / "mote-prep", {"job", path("request.json"), "--progress-fd", "1"});
    ASSERT_TRUE(process.waitForOutput("bounds"));
    process.signal(GetParam());
    EXPECT_EQ(process.wait(), 128 + GetParam()) << process.errors();
    EXPECT_THAT(process.errors(), HasSubstr("cancelled"));
    EXPECT_EQ(entries(), before);
}

INSTANTIATE_TEST_SUITE_P(Signals, MotePrepSignal, testing::Values(SIGINT, SIGTERM));

}  // namespace
}  // namespace mote::test
