// SPDX-License-Identifier: GPL-3.0-or-later
//
// What goes wrong: bad requests, outputs that exist or cannot be, cancelling, full disks. No debris in any
// case.
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/resource.h>

#include <fstream>
#include <limits>

#include "preprocess/synth/beam_run.h"
#include "preprocess/synth/openpmd_writer.h"
#include "recording_progress.h"
#include "tests/support/temp_dir.h"

namespace mote::prep {
namespace {

namespace fs = std::filesystem;
using test::RecordingProgress;

proto::SynthBeamJob job(std::uint64_t particles, std::uint32_t steps) {
    proto::SynthBeamJob result;
    result.set_particles(particles);
    result.set_steps(steps);
    return result;
}

ErrorCode codeOf(const Status& status) {
    EXPECT_FALSE(status.ok());
    return status.ok() ? ErrorCode::internal : status.error().code;
}

std::size_t openFiles() {
    return static_cast<std::size_t>(
        std::distance(fs::directory_iterator("/proc/self/fd"), fs::directory_iterator()));
}

/// The kernel refuses files longer than `bytes` while this lives, as on a full disk.
class SmallDisk {
  public:
    explicit SmallDisk(rlim_t bytes) {
        getrlimit(RLIMIT_FSIZE, &before_);
        handler_ = signal(SIGXFSZ, SIG_IGN);
        const rlimit small{bytes, before_.rlim_max};
        setrlimit(RLIMIT_FSIZE, &small);
    }
    ~SmallDisk() {
        setrlimit(RLIMIT_FSIZE, &before_);
        signal(SIGXFSZ, handler_);
    }

  private:
    rlimit before_{};
    void (*handler_)(int) = nullptr;
};

TEST(Output, badRequestsNameTheirField) {
    const test::TempDir folder;
    RecordingProgress progress;
    const auto refused = [&](const proto::SynthBeamJob& request, const char* field) {
        const Status status = synthesizeBeam(request, folder / "run.h5", progress);
        EXPECT_EQ(codeOf(status), ErrorCode::invalidArgument);
        EXPECT_EQ(status.error().where, field);
    };
    refused(job(0, 1), "synthBeam.particles");
    refused(job(std::numeric_limits<std::uint64_t>::max(), 1), "synthBeam.particles");
    refused(job(1, 0), "synthBeam.steps");
    refused(job(1, 10'001), "synthBeam.steps");
    for (const double mismatch : {0.0, 0.4, 3.0, -1.5, std::numeric_limits<double>::quiet_NaN()}) {
        auto request = job(1, 1);
        request.set_mismatch(mismatch);
        refused(request, "synthBeam.mismatch");
    }
    EXPECT_TRUE(fs::is_empty(folder.path()));
}

TEST(Output, everyMismatchAllowedRuns) {
    for (const double mismatch : {0.5, 0.75, 1.0, 1.25, 2.0, 2.5}) {
        const auto plan = planChannel(mismatched({}, mismatch), 10);
        EXPECT_TRUE(plan.ok()) << mismatch;
    }
}

TEST(Output, anExistingFileIsRefusedAndKept) {
    const test::TempDir folder;
    std::ofstream(folder / "run.h5") << "mine";
    RecordingProgress progress;
    EXPECT_EQ(codeOf(synthesizeBeam(job(10, 1), folder / "run.h5", progress)), ErrorCode::alreadyExists);
    EXPECT_EQ(fs::file_size(folder / "run.h5"), 4u);
    fs::create_symlink("nowhere", folder / "link.h5");
    EXPECT_EQ(codeOf(synthesizeBeam(job(10, 1), folder / "link.h5", progress)), ErrorCode::alreadyExists);
}

TEST(Output, aMissingFolderIsNotMade) {
    const test::TempDir folder;
    RecordingProgress progress;
    EXPECT_EQ(codeOf(synthesizeBeam(job(10, 1), folder / "none" / "run.h5", progress)), ErrorCode::notFound);
    EXPECT_FALSE(fs::exists(folder / "none"));
}

TEST(Output, aCancelledRunLeavesNothing) {
    const test::TempDir folder;
    const std::size_t before = openFiles();
    for (const int questions : {0, 1, 5}) {
        RecordingProgress progress(questions);
        EXPECT_EQ(codeOf(synthesizeBeam(job(20'000, 4), folder / "run.h5", progress)), ErrorCode::cancelled);
        EXPECT_TRUE(fs::is_empty(folder.path()));
        EXPECT_LT(progress.fractions().back(), 1.0);
    }
    EXPECT_EQ(openFiles(), before);
}

TEST(Output, aFullDiskIsSeenBeforeTheWork) {
    const test::TempDir folder;
    const std::size_t before = openFiles();
    RecordingProgress progress;
    const SmallDisk disk(200'000);  // room for the structure, not for 44 bytes times 100 000
    const Status status = synthesizeBeam(job(100'000, 2), folder / "run.h5", progress);
    EXPECT_EQ(codeOf(status), ErrorCode::resourceExhausted) << status.error().toString();
    EXPECT_EQ(progress.fractions().back(), 0.0);
    EXPECT_TRUE(fs::is_empty(folder.path()));
    EXPECT_EQ(openFiles(), before);
}

// A file system that reserves nothing shows it only while writing: the writer alone, without the reservation.
// HDF5 1.10 crashes at the end of the process where the close of a file failed; this process has to end well
// after this.
TEST(Output, aDiskThatFillsWhileWritingIsResourceExhausted) {
    const test::TempDir folder;
    const std::size_t before = openFiles();
    const auto plan = planChannel(mismatched({}, 1.5), 2).value();
    {
        auto writer = OpenPmdWriter::create(folder / "run.h5");
        ASSERT_TRUE(writer.ok());
        ASSERT_TRUE(writer->layOut(plan, 100'000, 1).ok());
        const SmallDisk disk(200'000);
        EXPECT_EQ(codeOf(writer->write(1, 0, 100'000, BeamColumns(100'000))), ErrorCode::resourceExhausted);
    }
    EXPECT_EQ(openFiles(), before);
}

TEST(Output, theReservationIsTheFilesSize) {
    const test::TempDir folder;
    RecordingProgress progress;
    for (const std::uint32_t steps : {1u, 10u, 100u}) {
        const auto path = folder / std::to_string(steps);
        ASSERT_TRUE(synthesizeBeam(job(100, steps), path, progress).ok());
        const auto plan = planChannel(mismatched({}, 1.5), steps).value();
        const auto size = static_cast<double>(fs::file_size(path));
        EXPECT_NEAR(static_cast<double>(OpenPmdWriter::fileBytes(plan, 100)) / size, 1.0, 0.1) << size;
        EXPECT_GE(OpenPmdWriter::fileBytes(plan, 100), fs::file_size(path));
    }
}

TEST(Output, aWildMismatchIsNoted) {
    const test::TempDir folder;
    RecordingProgress progress;
    ASSERT_TRUE(synthesizeBeam(job(10, 1), folder / "default.h5", progress).ok());
    EXPECT_TRUE(progress.notes().empty());
    auto wild = job(10, 1);
    wild.set_mismatch(2.5);
    ASSERT_TRUE(synthesizeBeam(wild, folder / "wild.h5", progress).ok());
    EXPECT_EQ(progress.notes().size(), 1u);
}

}  // namespace
}  // namespace mote::prep
