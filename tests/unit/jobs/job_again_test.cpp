// SPDX-License-Identifier: GPL-3.0-or-later
//
// The same request is not done twice, unless it is wanted; what failed can be tried again; a run has its
// time; and pages of all jobs.
#include <gmock/gmock.h>

#include <fstream>

#include "tests/unit/jobs/job_fixture.h"

namespace mote::server {
namespace {

using ::testing::HasSubstr;

class JobAgainTest : public JobTest {
  protected:
    /// An image job of data/in.png, whose output the fake publishes.
    proto::JobRequest imageRequest(const std::string& script) const {
        proto::JobRequest request;
        request.set_title(script);
        request.set_output("data/out.mote");
        request.mutable_image()->set_input("data/in.png");
        return request;
    }
    void writeInput(const std::string& text) const { std::ofstream(root_ / "in.png") << text; }
    std::string idOf(const Result<proto::JobStatus>& status) const {
        EXPECT_TRUE(status.ok()) << status.error().toString();
        return status.ok() ? status->id() : std::string();
    }
};

TEST_F(JobAgainTest, TheSameRequestIsNotDoneTwice) {
    startServer();
    makeFifo("go");
    const auto wanted = request("phase:on wait:go publish:");
    const auto id = idOf(queue_->submit(wanted));
    EXPECT_EQ(idOf(queue_->submit(wanted)), id) << "it waits";
    waitForPhase(id, "on");
    EXPECT_EQ(idOf(queue_->submit(wanted)), id) << "it runs";
    startServer();
    EXPECT_EQ(idOf(queue_->submit(wanted)), id) << "another server knows it";
    release("go");
    waitForState(id, State::SUCCEEDED);
    EXPECT_EQ(idOf(queue_->submit(wanted)), id) << "its output is there";
    EXPECT_EQ(queue_->list().size(), 1U);

    // Wanted again, it is done again, as far as nothing is in its way.
    const auto again = queue_->submit(wanted, {true, 0});
    ASSERT_FALSE(again.ok());
    EXPECT_EQ(again.error().code, ErrorCode::alreadyExists);
    std::filesystem::remove(root_ / "run.h5");
    release("go");
    const auto second = idOf(queue_->submit(wanted));
    EXPECT_NE(second, id) << "its output is gone";
    waitForState(second, State::SUCCEEDED);
}

TEST_F(JobAgainTest, AnotherOutputOfThatNameIsNotTakenForItsOwn) {
    startServer();
    const auto wanted = request("publish:");
    waitForState(idOf(queue_->submit(wanted)), State::SUCCEEDED);
    std::filesystem::rename(root_ / "run.h5", root_ / "kept.h5");
    std::filesystem::create_directory(root_ / "run.h5");
    const auto other = queue_->submit(wanted);
    ASSERT_FALSE(other.ok());
    EXPECT_EQ(other.error().code, ErrorCode::alreadyExists);
}

TEST_F(JobAgainTest, StepsOfALiveDatasetWaitForThoseBeforeThem) {
    auto several = settings();
    several.running = 4;
    startServer(several);
    makeFifo("go");
    const auto step = [](const std::string& script, const std::string& output) {
        proto::JobRequest request;
        request.set_title(script);
        request.set_output(output);
        auto& job = *request.mutable_particles();
        for (const char* axis : {"x", "px", "y"}) job.add_axes(axis);
        job.set_append(true);
        job.set_closes(true);
        return request;
    };
    const auto first = idOf(queue_->submit(step("phase:on wait:go exit:1", "data/live.mote")));
    const auto second = idOf(queue_->submit(step("phase:on wait:go exit:1", "data/live.mote")));
    EXPECT_NE(first, second) << "the same request is another step";
    const auto other = idOf(queue_->submit(step("phase:on exit:1", "data/other.mote")));
    waitForPhase(first, "on");
    waitForState(other, State::FAILED);
    EXPECT_EQ(queue_->find(second)->state(), State::QUEUED) << "though there are places";
    release("go");
    waitForState(first, State::FAILED);
    waitForPhase(second, "on");
    auto plain = step("publish:", "data/live.mote");
    plain.mutable_particles()->set_append(false);
    plain.mutable_particles()->set_closes(false);
    plain.mutable_particles()->add_inputs("data");
    EXPECT_EQ(queue_->submit(plain).error().code, ErrorCode::alreadyExists);
    release("go");
    waitForState(second, State::FAILED);
}

TEST_F(JobAgainTest, AnInputThatWasChangedMakesAnotherRequest) {
    startServer();
    writeInput("one");
    const auto wanted = imageRequest("publish:");
    const auto id = idOf(queue_->submit(wanted));
    waitForState(id, State::SUCCEEDED);
    EXPECT_EQ(idOf(queue_->submit(wanted)), id);
    const auto time = std::filesystem::last_write_time(root_ / "in.png");
    writeInput("two");
    std::filesystem::last_write_time(root_ / "in.png", time);
    const auto changed = queue_->submit(wanted);
    ASSERT_FALSE(changed.ok());
    EXPECT_EQ(changed.error().code, ErrorCode::alreadyExists);
}

TEST_F(JobAgainTest, AFilmThatIsThereIsNotMadeTwice) {
    startServer();
    const auto wanted = filmRequest("file:frame-000000.png");
    const auto id = idOf(queue_->submit(wanted));
    waitForState(id, State::SUCCEEDED);
    EXPECT_EQ(idOf(queue_->submit(wanted)), id);
    const auto again = idOf(queue_->submit(wanted, {true, 0}));
    EXPECT_NE(again, id);
    waitForState(again, State::SUCCEEDED);
    EXPECT_NE(idOf(queue_->submit(filmRequest("file:frame-000000.png phase:x"))), id);
}

TEST_F(JobAgainTest, AFilmThatIsThereIsMadeAgainOnRequest) {
    startServer();
    const auto film = idOf(queue_->submit(filmRequest("file:frame-000000.png")));
    waitForState(film, State::SUCCEEDED);
    const auto second = idOf(queue_->retry(film));
    EXPECT_NE(second, film);
    waitForState(second, State::SUCCEEDED);
    const auto dataset = submit("publish:");
    waitForState(dataset, State::SUCCEEDED);
    EXPECT_EQ(queue_->retry(dataset).error().code, ErrorCode::invalidArgument) << "its output is in the way";
}

TEST_F(JobAgainTest, WhatFailedIsTriedAgain) {
    startServer();
    makeFifo("go");
    const auto id = submit("wait:go exit:1");
    EXPECT_EQ(queue_->retry(id).error().code, ErrorCode::invalidArgument) << "it has not ended";
    release("go");
    waitForState(id, State::FAILED);
    const auto second = idOf(queue_->retry(id));
    EXPECT_NE(second, id);
    EXPECT_EQ(idOf(queue_->retry(id)), second) << "that waits or runs already";
    ASSERT_TRUE(queue_->cancel(second).ok());
    waitForState(second, State::CANCELLED);
    EXPECT_NE(idOf(queue_->retry(second)), second);
    EXPECT_EQ(queue_->retry("0123456789abcdef").error().code, ErrorCode::notFound);
}

TEST_F(JobAgainTest, AFilmThatFailedIsTriedAgainWithItsWholeScript) {
    startServer();
    const auto id = submitFilm("exit:1");
    waitForState(id, State::FAILED);
    startServer();
    const auto second = idOf(queue_->retry(id));
    proto::JobRequest kept;
    std::ifstream file(directory_ / "state/jobs" / second / "request.json");
    const std::string text((std::istreambuf_iterator<char>(file)), {});
    EXPECT_THAT(text, HasSubstr("\"width\":64"));
    waitForState(second, State::FAILED);
}

TEST_F(JobAgainTest, ARunEndsWithItsTime) {
    auto limited = settings();
    limited.timeLimit = 1;
    startServer(limited);
    makeFifo("never");
    const auto status = queue_->submit(request("draft: wait:never publish:"), {false, 1000});
    const auto id = idOf(status);
    EXPECT_EQ(status->time_limit_s(), 1U) << "the server's is the greatest";
    const auto late = waitForState(id, State::FAILED);
    EXPECT_THAT(late.error(), HasSubstr("time limit of 1 s"));
    std::filesystem::remove(root_ / "never");
    EXPECT_TRUE(std::filesystem::is_empty(root_)) << "the draft is still there";
}

TEST_F(JobAgainTest, ARootThatIsAwayHoldsItsOwnJobsOnly) {
    const auto other = directory_ / "other";
    std::filesystem::create_directory(other);
    auto two = settings();
    two.roots.push_back("other=" + other.string());
    startServer(two);
    std::filesystem::rename(other, directory_ / "away");
    auto wanted = request("publish:");
    std::filesystem::create_directory(other);
    wanted.set_output("other/run.h5");
    const auto waiting = idOf(queue_->submit(wanted));
    std::filesystem::remove(other);
    const auto going = submit("publish:");
    waitForState(going, State::SUCCEEDED);
    const auto status = waitUntil(waiting, [](const auto& now) { return !now.waits_for().empty(); });
    EXPECT_EQ(status.state(), State::QUEUED);
    EXPECT_THAT(status.waits_for(), HasSubstr("a folder of data is away"));
    std::filesystem::rename(directory_ / "away", other);
    EXPECT_EQ(waitForState(waiting, State::SUCCEEDED).waits_for(), "");
}

TEST_F(JobAgainTest, PagesGoThroughAllJobsOnce) {
    startServer();
    makeFifo("go");
    std::vector<std::string> ids{submit("wait:go publish:")};
    for (int i = 0; i < 30; ++i) ids.push_back(submit("publish:", "data/r" + std::to_string(i) + ".h5"));
    std::vector<std::string> listed;
    for (std::uint64_t first = 0; first < ids.size(); first += 7) {
        const auto page = queue_->page(first, 7);
        EXPECT_EQ(page.total(), ids.size());
        EXPECT_EQ(page.first(), first);
        for (const auto& job : page.jobs()) listed.push_back(job.id());
    }
    std::reverse(listed.begin(), listed.end());
    EXPECT_EQ(listed, ids);
    EXPECT_EQ(queue_->page(ids.size(), 7).jobs_size(), 0);
    EXPECT_EQ(queue_->page(0, 0).jobs_size(), static_cast<int>(ids.size()));
    EXPECT_EQ(queue_->page(~std::uint64_t{0}, ~std::uint32_t{0}).jobs_size(), 0);
    release("go");
    for (const auto& id : ids) waitForState(id, State::SUCCEEDED);
}

}  // namespace
}  // namespace mote::server
