// SPDX-License-Identifier: GPL-3.0-or-later
//
// The server's life: it ends when told to, and its jobs outlive it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <csignal>
#include <optional>

#include "client/shared/connection.h"
#include "tests/e2e/conversation.h"
#include "tests/e2e/station.h"

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

}  // namespace
}  // namespace mote::test
