// SPDX-License-Identifier: GPL-3.0-or-later
//
// What a client has sent for a job is that job's, whatever the client does then, and goes with it.
#include <gmock/gmock.h>

#include <fstream>
#include <optional>

#include "server/jobs/uploads.h"
#include "tests/unit/jobs/job_fixture.h"

namespace mote::server {
namespace {

namespace fs = std::filesystem;
using ::testing::Contains;
using ::testing::HasSubstr;

class JobUploadsTest : public JobTest {
  protected:
    fs::path uploads(const std::string& name = "") const { return directory_ / "state/uploads" / name; }

    static void send(Uploads& client, const std::string& name, const std::string& content) {
        proto::Upload part;
        part.set_name(name);
        part.set_data(content);
        part.set_size(content.size());
        ASSERT_TRUE(client.add(part).ok());
    }

    Result<proto::JobStatus> plot(const Uploads& client, const std::string& script,
                                  const std::string& output = "data/plot.mote") {
        proto::JobRequest request;
        request.set_title(script);
        request.set_output(output);
        request.mutable_particles()->add_inputs("uploads/a.npz");
        for (const char* axis : {"x", "px", "y"}) request.mutable_particles()->add_axes(axis);
        const auto resolved = client.resolve(request);
        return resolved.ok() ? queue_->submit(*resolved) : Result<proto::JobStatus>(resolved.error());
    }
};

TEST_F(JobUploadsTest, AJobKeepsWhatItWasSubmittedWith) {
    startServer();
    makeFifo("go");
    const auto before = submit("wait:go publish:");
    std::optional<Uploads> client(std::in_place, queue_->uploads());
    send(*client, "a.npz", "first");
    const auto job = plot(*client, "input: publish:");
    ASSERT_TRUE(job.ok()) << job.error().toString();
    EXPECT_EQ(job->request().particles().inputs(0), "uploads/" + job->id() + "/a.npz");
    send(*client, "a.npz", "other");
    client.reset();
    fs::create_directories(uploads("0123456789abcdef/left"));
    startServer();
    EXPECT_TRUE(comes([&] { return !fs::exists(uploads("0123456789abcdef")); }));
    Uploads next(queue_->uploads());
    send(next, "a.npz", "other");
    release("go");
    waitForState(before, State::SUCCEEDED);
    EXPECT_THAT(waitForState(job->id(), State::SUCCEEDED).log(), Contains("input: first"));
    EXPECT_TRUE(comes([&] { return !fs::exists(uploads(job->id())); }));
}

TEST_F(JobUploadsTest, AJobReadsNoOthersUploads) {
    startServer();
    Uploads other(queue_->uploads());
    send(other, "secret", "secret");
    const auto folder = fs::directory_iterator(uploads())->path();
    ASSERT_TRUE(fs::exists(folder / "secret"));
    Uploads client(queue_->uploads());
    send(client, "a.npz", "own");
    const auto job = plot(client, "input: read:" + (folder / "secret").string() + " publish:");
    ASSERT_TRUE(job.ok()) << job.error().toString();
    const auto log = waitForState(job->id(), State::SUCCEEDED).log();
    EXPECT_THAT(log, Contains("input: own"));
    EXPECT_THAT(log, Contains("read: Permission denied"));
}

TEST_F(JobUploadsTest, TheSameUploadIsTheSameJob) {
    startServer();
    makeFifo("go");
    Uploads client(queue_->uploads());
    send(client, "a.npz", "first");
    const auto first = plot(client, "wait:go publish:");
    ASSERT_TRUE(first.ok()) << first.error().toString();
    EXPECT_EQ(plot(client, "wait:go publish:")->id(), first->id());
    // What is sent anew is another file, whatever it holds.
    send(client, "a.npz", "first");
    const auto second = plot(client, "wait:go publish:");
    ASSERT_FALSE(second.ok());
    EXPECT_THAT(second.error().message, HasSubstr(first->id() + " makes it already"));
    release("go");
    waitForState(first->id(), State::SUCCEEDED);
}

TEST_F(JobUploadsTest, WhatIsGoneCannotBeTriedAgain) {
    startServer();
    Uploads client(queue_->uploads());
    send(client, "a.npz", "first");
    const auto job = plot(client, "exit:1");
    ASSERT_TRUE(job.ok()) << job.error().toString();
    waitForState(job->id(), State::FAILED);
    const auto again = queue_->retry(job->id());
    ASSERT_FALSE(again.ok());
    EXPECT_EQ(again.error().code, ErrorCode::notFound);
    EXPECT_THAT(again.error().message, HasSubstr("was uploaded"));
    const auto anew = plot(client, "publish:");
    ASSERT_TRUE(anew.ok()) << anew.error().toString();
    waitForState(anew->id(), State::SUCCEEDED);
}

}  // namespace
}  // namespace mote::server
