// SPDX-License-Identifier: GPL-3.0-or-later
//
// The server's life: it ends when told to, and its jobs outlive it.
#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/file.h>
#include <unistd.h>
#include <cmath>
#include <csignal>
#include <fstream>
#include <optional>
#include <vector>

#include "client/shared/connection.h"
#include "protocol/wire/address.h"
#include "protocol/wire/connection_file.h"
#include "tests/e2e/station.h"
#include "tests/support/shaped_link.h"

namespace mote::test {
namespace {

using client::Connection;
using testing::Contains;

proto::JobRequest plotRequest(const std::string& output) {
    proto::JobRequest request;
    request.set_title("another plot");
    request.set_output(output);
    request.mutable_particles()->add_inputs("data/run.h5");
    for (const char* axis : {"x", "y", "z"}) request.mutable_particles()->add_axes(axis);
    return request;
}

class Server : public testing::Test {
  protected:
    void SetUp() override {
        station_.startServer();
        connection_.emplace(station_.connection(), client::ConnectionSettings{});
    }

    std::string submit(const proto::JobRequest& request) { return test::submit(*connection_, request); }
    proto::JobStatus ended(const std::string& id) { return test::ended(*connection_, id); }

    Station station_;
    std::optional<Connection> connection_;
};

TEST_F(Server, AJobsPlotAppearsInTheCatalogueAndIsDrawn) {
    bool heard = false;
    connection_->onCatalogue([&](const proto::Catalogue& catalogue) {
        for (const auto& entry : catalogue.datasets()) heard = heard || entry.name() == "data/second";
    });
    const auto id = submit(plotRequest("data/second.mote"));
    const auto job = ended(id);
    EXPECT_EQ(job.state(), proto::JobStatus::SUCCEEDED) << job.error();
    EXPECT_EQ(job.progress(), 1.0);
    EXPECT_TRUE(eventually(*connection_, [&] { return heard; }));
    EXPECT_THAT(datasets(*connection_), Contains("data/second"));
    const auto done = station_.frames(scriptOf({beamView(64, 1, 4, "data/second")}));
    EXPECT_EQ(done.status, 0) << done.errors;
    const auto description = answer<proto::Description>(
        *connection_, [&](auto reply) { connection_->describe("data/second", reply); });
    ASSERT_TRUE(description.ok()) << description.error().toString();
    EXPECT_EQ(description->manifest().particles().axes(2).name(), "z");
    // Its columns lie beside its points: the run need not be read again.
    EXPECT_EQ(description->replot().particles().inputs(0), "data/second.mote");
}

TEST_F(Server, BadRequestsAreRefusedWithTheirField) {
    const auto refused = [&](const proto::JobRequest& request) {
        const auto job = answer<proto::JobStatus>(
            *connection_, [&](auto reply) { connection_->submitJob(request, reply); });
        EXPECT_FALSE(job.ok());
        return job.ok() ? Error{} : job.error();
    };
    EXPECT_EQ(refused(plotRequest("data/beam.mote")).code, ErrorCode::alreadyExists);
    EXPECT_EQ(refused(plotRequest("/tmp/out.mote")).where, "job.output");
    EXPECT_EQ(refused(plotRequest("data/../../out.mote")).where, "job.output");
    auto request = plotRequest("data/x.mote");
    request.mutable_particles()->set_axes(1, "x");
    EXPECT_THAT(refused(request).where, testing::HasSubstr("axes"));
    const auto unknown =
        answer<proto::JobStatus>(*connection_, [&](auto reply) { connection_->cancelJob("none", reply); });
    ASSERT_FALSE(unknown.ok());
    EXPECT_EQ(unknown.error().code, ErrorCode::notFound);
}

TEST_F(Server, AFailedJobSaysWhy) {
    auto request = plotRequest("data/x.mote");
    request.mutable_particles()->set_inputs(0, "data/beam.mote/manifest.json");
    request.mutable_particles()->set_format("openpmd");
    const auto job = ended(submit(request));
    EXPECT_EQ(job.state(), proto::JobStatus::FAILED);
    EXPECT_FALSE(job.error().empty());
    EXPECT_FALSE(std::filesystem::exists(station_.root() / "x.mote"));
}

TEST_F(Server, KilledAndStartedAgainItKnowsItsJobs) {
    const auto done = submit(plotRequest("data/second.mote"));
    EXPECT_EQ(ended(done).state(), proto::JobStatus::SUCCEEDED);
    const auto open = submit(plotRequest("data/third.mote"));
    station_.server().signal(SIGKILL);
    EXPECT_EQ(station_.server().wait(), 128 + SIGKILL);
    ASSERT_TRUE(eventually(*connection_, [&] { return connection_->state() == Connection::State::lost; }));
    station_.startServer();
    connection_->reconnect();  // the new server has a new token; the connection file is read again
    const auto jobs = answer<proto::Jobs>(*connection_, [&](auto reply) { connection_->watchJobs(reply); });
    ASSERT_TRUE(jobs.ok()) << jobs.error().toString();
    std::vector<std::string> ids;
    for (const auto& job : jobs->jobs()) ids.push_back(job.id());
    EXPECT_THAT(ids, Contains(done));
    EXPECT_THAT(ids, Contains(open));
    EXPECT_EQ(ended(open).state(), proto::JobStatus::SUCCEEDED);  // it went on, or was started again
    EXPECT_THAT(datasets(*connection_), Contains("data/third"));
}

TEST_F(Server, SigtermWhileDrawingEndsInTimeAndKeepsWhatIsFinished) {
    std::vector<std::string> views;
    for (int i = 0; i < 5000; ++i) views.push_back(beamView(320, i % 2, 3.0 + 0.0001 * i));
    Process frames(program("mote-frames"), station_.framesArguments(scriptOf(views), {"--json"}));
    ASSERT_TRUE(frames.waitForOutput("\n")) << frames.errors();
    station_.server().signal(SIGTERM);
    EXPECT_EQ(station_.server().wait(std::chrono::seconds(10)), 0) << "it must drain and end within 10 s";
    EXPECT_EQ(frames.wait(), 1);
    EXPECT_THAT(frames.errors(), testing::HasSubstr("server"));
    const auto names = namesIn(station_.out());
    EXPECT_THAT(names, Contains("frame-000000.png"));
    for (const auto& name : names) EXPECT_THAT(name, testing::StartsWith("frame-"));
    EXPECT_FALSE(std::filesystem::exists(station_.connection()))
        << "a connection file of no server is a trap";
}

TEST_F(Server, TwoServersDoNotShareAState) {
    const auto second =
        runProcess(program("mote-server"), {"--root", "data=" + station_.root().string(), "--state",
                                            (station_.connection().parent_path() / "state").string(),
                                            "--connection", (station_.temporary() / "c.json").string()});
    EXPECT_EQ(second.status, 1);
    EXPECT_FALSE(second.errors.empty());
    EXPECT_FALSE(datasets(*connection_).empty());
}

// mote-frames --spawn: a private server that leaves nothing behind.

using testing::HasSubstr;
using testing::IsEmpty;

class Spawn : public testing::Test {
  protected:
    ProcessOptions options() const { return {{{"TMPDIR", station_.temporary().string()}}, {}}; }
    std::vector<std::string> spawn(std::vector<std::string> more = {}) const {
        more.insert(more.end(), {"--spawn", "data=" + station_.root().string()});
        return more;
    }

    /// A script that takes long enough to be interrupted: a minute and more on any device.
    static std::string longScript() {
        std::vector<std::string> views;
        for (int i = 0; i < 5000; ++i) views.push_back(beamView(320, i % 2, 3.0 + 0.0001 * i));
        return scriptOf(views);
    }

    /// The private server's process, while mote-frames runs.
    pid_t serverOf() const {
        for (const auto& name : namesIn(station_.temporary())) {
            const auto file = wire::readConnectionFile(station_.temporary() / name / "connection.json");
            if (file.ok()) return static_cast<pid_t>(file->pid());
        }
        ADD_FAILURE() << "no private server to be found";
        return -1;
    }

    Station station_;
};

TEST_F(Spawn, DrawsTheSameBytesAsAServerThatRuns) {
    const auto script = scriptOf({beamView(160), beamView(160, 1)});
    const auto done = station_.frames(script, spawn(), options());
    ASSERT_EQ(done.status, 0) << done.errors;
    EXPECT_EQ(done.output, "");
    EXPECT_THAT(namesIn(station_.temporary()), IsEmpty());
    const auto first = bytesOf(station_.out() / "frame-000000.png");
    EXPECT_FALSE(first.empty());
    station_.startServer();
    ASSERT_EQ(station_.frames(script).status, 0);
    EXPECT_EQ(bytesOf(station_.out() / "frame-000000.png"), first);
}

/// A program that was killed cannot remove its server's folder.
TEST_F(Spawn, RemovesWhatItsLikeLeftBehind) {
    const auto leave = [&](const std::string& name, int hours) {
        const auto log = station_.temporary() / name / "log";
        std::filesystem::create_directories(station_.temporary() / name / "state");
        std::ofstream(log) << "the server ends\n";
        std::filesystem::last_write_time(
            log, std::filesystem::file_time_type::clock::now() - std::chrono::hours(hours));
        return log;
    };
    leave("mote-frames-Killed", 30);
    leave("mote-frames-Recent", 1);
    leave("mote-frames-another", 30);
    leave("mote-view-Viewer", 30);
    const int held = ::open(leave("mote-frames-InUse0", 30).c_str(), O_RDONLY | O_CLOEXEC);
    ASSERT_EQ(::flock(held, LOCK_EX | LOCK_NB), 0);
    const auto done = station_.frames(scriptOf({beamView(32)}), spawn(), options());
    ::close(held);
    EXPECT_EQ(done.status, 0) << done.errors;
    EXPECT_THAT(namesIn(station_.temporary()),
                testing::UnorderedElementsAre("mote-frames-Recent", "mote-frames-another", "mote-view-Viewer",
                                              "mote-frames-InUse0"));
}

TEST_F(Spawn, TakesSeveralRootsAndADevice) {
    const auto second = station_.root() / "inner";
    std::filesystem::create_directory(second);
    std::filesystem::rename(station_.root() / "beam.mote", second / "moved.mote");
    const auto done =
        station_.frames(scriptOf({beamView(32, 0, 4, "more/moved")}),
                        spawn({"--spawn", "more=" + second.string(), "--device", "egl"}), options());
    EXPECT_EQ(done.status, 0) << done.errors;
    const auto wrong = station_.frames(scriptOf({beamView(32)}), spawn({"--device", "abacus"}), options());
    EXPECT_NE(wrong.status, 0);
    EXPECT_THAT(wrong.errors, HasSubstr("abacus"));
    EXPECT_THAT(namesIn(station_.temporary()), IsEmpty());
}

TEST_F(Spawn, CleansUpAfterErrors) {
    const auto done = station_.frames(scriptOf({beamView(32, 0, 4, "data/none")}), spawn(), options());
    EXPECT_EQ(done.status, 1);
    EXPECT_THAT(done.errors, HasSubstr("views[0].layers[0].dataset"));
    const auto root =
        station_.frames(scriptOf({beamView(32)}), {"--spawn", "data=/no/such/folder"}, options());
    EXPECT_EQ(root.status, 1);
    EXPECT_THAT(root.errors, HasSubstr("/no/such/folder"));
    EXPECT_THAT(namesIn(station_.temporary()), IsEmpty());
    EXPECT_FALSE(std::filesystem::exists(station_.out()));
}

TEST_F(Spawn, CleansUpAfterCtrlC) {
    for (const int signal : {SIGINT, SIGTERM}) {
        Process frames(program("mote-frames"), station_.framesArguments(longScript(), spawn({"--json"})),
                       options());
        ASSERT_TRUE(frames.waitForOutput("\n")) << frames.errors();
        const pid_t server = serverOf();
        frames.signal(signal);
        EXPECT_EQ(frames.wait(), 128 + signal);
        EXPECT_THAT(namesIn(station_.temporary()), IsEmpty());
        EXPECT_EQ(::kill(server, 0), -1) << "the private server still runs";
        // What was finished stays, and is whole.
        const auto names = namesIn(station_.out());
        ASSERT_FALSE(names.empty());
        for (const auto& name : names) EXPECT_THAT(name, testing::StartsWith("frame-"));
    }
}

TEST_F(Spawn, TheServerEndsWhereItsClientIsKilled) {
    Process frames(program("mote-frames"), station_.framesArguments(longScript(), spawn({"--json"})),
                   options());
    ASSERT_TRUE(frames.waitForOutput("\n")) << frames.errors();
    const pid_t server = serverOf();
    frames.signal(SIGKILL);
    frames.wait();
    EXPECT_TRUE(waitForEnd(server));
}

// A client behind a thin line and one beside the server: what each is sent before its link is known, that the
// stream goes on, and that both end with the same picture. What a measured link gets is decided by how fast
// the machine is, too: tests/unit/session/flow_control_test.cpp asks that of simulated links.

using client::ReceivedFrame;

proto::View beamAt(double angle) {
    proto::View view;
    view.set_width(1280);
    view.set_height(960);
    for (const double value : {1.5 * std::sin(angle), 0.0, 1.5 * std::cos(angle)}) {
        view.mutable_camera()->add_eye(value);
    }
    for (const double value : {0.0, 0.0, 0.0}) view.mutable_camera()->add_target(value);
    for (const double value : {0.0, 1.0, 0.0}) view.mutable_camera()->add_up(value);
    view.add_layers()->set_dataset("data/beam");
    // Every point a disc with a soft edge: a picture that lossless coding can do little about.
    auto& points = *view.mutable_layers(0)->mutable_particles()->mutable_points();
    points.set_linked(false);
    auto& everything = *points.add_curve();
    everything.set_density(0.0);
    everything.set_fraction(1.0);
    points.set_opacity(0.5);
    points.set_size_pixels(4.5);
    return view;
}

/// Waits for a frame; fails the test where none comes.
ReceivedFrame nextFrame(Connection& connection) {
    const auto end = std::chrono::steady_clock::now() + Process::patience;
    while (std::chrono::steady_clock::now() < end) {
        connection.wait(std::chrono::milliseconds(50));
        connection.poll();
        if (auto frame = connection.takeFrame()) return *std::move(frame);
    }
    ADD_FAILURE() << "no frame came";
    return {};
}

/// Turns the view, at least until the link has been measured; how the pictures in motion were encoded.
std::vector<proto::Frame::Encoding> turn(Connection& connection) {
    std::vector<proto::Frame::Encoding> encodings;
    bool measured = false;
    for (int i = 0; i < 400 && (i < 5 || !measured); ++i) {
        connection.setView(beamAt(0.01 * i), {.moving = true});
        const auto frame = nextFrame(connection);
        if (testing::Test::HasFailure()) break;
        encodings.push_back(frame.message.encoding());
        measured = frame.message.link_bytes_per_second() > 0.0;
    }
    EXPECT_TRUE(measured);
    return encodings;
}

ReceivedFrame atRest(Connection& connection) {
    const auto id = connection.setView(beamAt(1.0), {});
    for (;;) {
        auto frame = nextFrame(connection);
        if (testing::Test::HasFailure()) return frame;
        if (frame.message.view_id() == id && frame.message.final()) return frame;
    }
}

TEST(Link, ThinOrWideItEndsWithTheSamePicture) {
    Station station;
    station.startServer();
    auto file = wire::readConnectionFile(station.connection());
    ASSERT_TRUE(file.ok()) << file.error().toString();
    const auto socket = station.temporary() / "link.sock";
    const ShapedLink link(socket, wire::parseAddress(file->address())->path,
                          {5e5, std::chrono::milliseconds(20)});
    file->set_address("unix:" + socket.string());
    ASSERT_TRUE(wire::writeConnectionFile(station.temporary() / "thin.json", *file).ok());

    Connection thin(station.temporary() / "thin.json", {});
    EXPECT_EQ(turn(thin).at(0), proto::Frame::H264);
    const auto far = atRest(thin);
    Connection wide(station.connection(), {});
    EXPECT_EQ(turn(wide).at(0), proto::Frame::H264);
    const auto near = atRest(wide);
    EXPECT_EQ(far.message.encoding(), proto::Frame::ZSTD);
    EXPECT_EQ(far.pixels.width, 1280u);
    EXPECT_TRUE(far.pixels.bytes == near.pixels.bytes);
    // It is not over: the stream goes on after a picture that was none of it.
    EXPECT_GE(turn(thin).size(), 5u);
}

}  // namespace
}  // namespace mote::test
