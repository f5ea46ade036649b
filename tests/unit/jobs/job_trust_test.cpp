// SPDX-License-Identifier: GPL-3.0-or-later
//
// A state directory that others may have made or filled is not taken over: nothing in it becomes a path.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <sys/stat.h>
#include <unistd.h>

#include <fstream>
#include <random>

#include "server/jobs/job_store.h"
#include "tests/unit/jobs/job_fixture.h"

namespace mote::server {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using ::testing::SizeIs;

class JobTrustTest : public JobTest {
  protected:
    fs::path state(const std::string& name = "") const { return directory_ / "state" / name; }

    /// A state directory as a server leaves it.
    void makeState() {
        startServer();
        waitForState(submit("publish:"), State::SUCCEEDED);
        killServer();
    }

    /// A server does not start, and says of which file and why.
    void expectRefused(const std::string& name, const std::string& why) {
        asio::io_context context;
        JobQueue queue(context, settings());
        const auto started = queue.start();
        ASSERT_FALSE(started.ok()) << name;
        EXPECT_EQ(started.error().code, ErrorCode::permissionDenied);
        EXPECT_THAT(started.error().where, HasSubstr("state" + (name.empty() ? "" : "/" + name)));
        EXPECT_THAT(started.error().message, HasSubstr(why));
    }
};

TEST_F(JobTrustTest, WhatOthersMayWriteIsRefused) {
    makeState();
    for (const std::string name : {"", "jobs", "film", "jobs.sqlite", "jobs.lock"}) {
        struct stat status {};
        ASSERT_EQ(::stat(state(name).c_str(), &status), 0);
        for (const mode_t bit : {0020U, 0002U}) {
            ASSERT_EQ(::chmod(state(name).c_str(), (status.st_mode & 07777U) | bit), 0);
            expectRefused(name, "others may write");
        }
        ASSERT_EQ(::chmod(state(name).c_str(), status.st_mode & 07777U), 0);
    }
    startServer();  // as it was, it is taken
    EXPECT_THAT(queue_->list(), SizeIs(1));
}

TEST_F(JobTrustTest, WhatBelongsToAnotherUserIsRefused) {
    if (::geteuid() != 0) GTEST_SKIP() << "only root can give a file away";
    makeState();
    for (const std::string name : {"", "jobs", "film", "jobs.sqlite", "jobs.lock"}) {
        ASSERT_EQ(::chown(state(name).c_str(), 65534, 65534), 0);
        expectRefused(name, "belongs to another user");
        ASSERT_EQ(::chown(state(name).c_str(), 0, 0), 0);
    }
}

TEST_F(JobTrustTest, LinksInTheStateDirectoryAreRefused) {
    makeState();
    const auto outside = directory_ / "outside";
    for (const std::string name : {"jobs", "film", "jobs.sqlite", "jobs.lock"}) {
        fs::remove_all(outside);
        fs::rename(state(name), outside);
        fs::create_symlink(outside, state(name));
        if (fs::is_directory(outside)) std::ofstream(outside / "precious") << "x";
        expectRefused(name, "link");
        EXPECT_EQ(fs::is_directory(outside), fs::exists(outside / "precious"));
        fs::remove(state(name));
        std::error_code none;
        fs::remove(outside / "precious", none);
        fs::rename(outside, state(name));
    }
}

TEST_F(JobTrustTest, AnIdThatIsNoneNeverBecomesAPath) {
    fs::create_directory(state());
    const auto outside = directory_ / "outside";
    fs::create_directories(outside / "deep");
    std::vector<std::string> ids{"",
                                 ".",
                                 "..",
                                 "../../outside",
                                 outside.string(),
                                 "../jobs",
                                 "0123456789abcde",
                                 "0123456789abcdef0",
                                 "0123456789ABCDEF",
                                 "0123456789abcde/",
                                 std::string("0123456789abcde\0", 16),
                                 "0123456789abcdeg"};
    std::mt19937_64 random(7);
    for (int i = 0; i < 200; ++i) {
        auto id = fmt::format("{:016x}", random());
        id[random() % id.size()] = "/.gGAF \n\x1b-"[random() % 10];
        ids.push_back(id);
    }
    {
        auto store = JobStore::open(state("jobs.sqlite"));
        ASSERT_TRUE(store.ok());
        const std::string good = "00000000deadbeef";
        for (const auto& id : ids) {
            JobRecord record;
            record.status.set_id(id);
            record.status.set_state(State::RUNNING);  // it began and is gone: its draft and files are removed
            record.attempts = 2;
            *record.status.mutable_request() = request("publish:", "data/" + good);
            ASSERT_TRUE(store->insert(record).ok());
        }
        JobRecord record;
        record.status.set_id(good);
        record.status.set_state(State::FAILED);
        *record.status.mutable_request() = request("publish:", "data/" + good);
        ASSERT_TRUE(store->insert(record).ok());
    }
    startServer();
    ASSERT_THAT(queue_->list(), SizeIs(1));
    EXPECT_EQ(queue_->list()[0].id(), "00000000deadbeef");
    EXPECT_TRUE(fs::exists(outside / "deep"));
    EXPECT_TRUE(fs::exists(state("jobs.sqlite")));
}

}  // namespace
}  // namespace mote::server
