// SPDX-License-Identifier: GPL-3.0-or-later
//
// Films that are left with a server: they go on without client and without server, and are fetched whole.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <csignal>
#include <fstream>
#include <map>
#include <thread>

#include "protocol/wire/connection_file.h"
#include "tests/e2e/conversation.h"
#include "tests/e2e/station.h"

namespace mote::test {
namespace {

using testing::HasSubstr;

class DetachedFilms : public testing::Test {
  protected:
    void SetUp() override { station_.startServer(); }

    std::filesystem::path script(int frames, int width = 64) const {
        std::string json = "{'fps': 25, 'view': {'width': " + std::to_string(width) +
                           ", 'height': 48, 'layers': [{'dataset': 'data/beam', 'particles': {}}]}, 'moves': "
                           "[{'turn': {'degrees': 360}, 'seconds': " +
                           std::to_string(frames / 25.0) + "}]}";
        std::replace(json.begin(), json.end(), '\'', '"');
        return station_.writeScript(json);
    }
    Finished run(std::vector<std::string> words) const {
        words.insert(words.end(), {"--connect", station_.connection().string(), "--quiet"});
        return runProcess(program("mote-frames"), words);
    }
    std::string detach(int frames, std::vector<std::string> more = {}) const {
        more.insert(more.end(), {script(frames).string(), "--detach"});
        const auto done = run(more);
        EXPECT_EQ(done.status, 0) << done.errors;
        EXPECT_EQ(done.output.size(), 17U) << done.output;
        return done.output.substr(0, 16);
    }
    proto::JobStatus await(const std::string& id) const {
        client::Connection connection(station_.connection(), {});
        return ended(connection, id);
    }
    Finished fetch(const std::string& id, std::vector<std::string> more) const {
        more.insert(more.end(), {"--fetch", id});
        return run(more);
    }

    /// And waits until it is.
    void cancel(const std::string& id) const {
        EXPECT_EQ(run({"--cancel", id}).status, 0);
        const auto followed = run({"--follow", id});
        EXPECT_EQ(followed.status, 1);
        EXPECT_THAT(followed.errors, HasSubstr("the job was cancelled"));
    }

    Station station_;
    TempDir folder_;
};

TEST_F(DetachedFilms, AreThePicturesThatARunMakes) {
    const auto id = detach(10);
    const auto job = await(id);
    ASSERT_EQ(job.state(), proto::JobStatus::SUCCEEDED) << job.error();
    ASSERT_EQ(fetch(id, {"--out", (folder_ / "fetched").string()}).status, 0);
    ASSERT_EQ(run({script(10).string(), "--out", (folder_ / "drawn").string()}).status, 0);
    const auto names = namesIn(folder_ / "drawn");
    ASSERT_EQ(names.size(), 10U);
    EXPECT_EQ(namesIn(folder_ / "fetched"), names);
    for (const auto& name : names)
        EXPECT_EQ(bytesOf(folder_ / "fetched" / name), bytesOf(folder_ / "drawn" / name));
    // A video is made of them here, too.
    ASSERT_EQ(fetch(id, {"--video", (folder_ / "film.mp4").string()}).status, 0);
    EXPECT_GT(bytesOf(folder_ / "film.mp4").size(), 1000U);
}

TEST_F(DetachedFilms, AreEncodedWhereTheyAreMade) {
    const auto id = detach(10, {"--video", "mp4", "--crf", "20"});
    ASSERT_EQ(await(id).state(), proto::JobStatus::SUCCEEDED);
    ASSERT_EQ(fetch(id, {"--video", (folder_ / "fetched.mp4").string()}).status, 0);
    ASSERT_EQ(run({script(10).string(), "--video", (folder_ / "drawn.mp4").string(), "--crf", "20"}).status,
              0);
    EXPECT_EQ(bytesOf(folder_ / "fetched.mp4"), bytesOf(folder_ / "drawn.mp4"));
    const auto pictures = fetch(id, {"--out", (folder_ / "pictures").string()});
    EXPECT_EQ(pictures.status, 1);
    EXPECT_THAT(pictures.errors, HasSubstr("mp4"));
}

/// Each frame is drawn once, though the server is killed in the midst of it.
TEST_F(DetachedFilms, OutliveTheirServer) {
    constexpr int frames = 200;
    const auto id = detach(frames);
    const auto folder = station_.connection().parent_path() / "state/jobs" / id / "film";
    std::map<std::string, std::filesystem::file_time_type> made;
    const auto look = [&] {
        for (const auto& name : namesIn(folder)) {
            if (name.front() == '.') continue;
            const auto time = std::filesystem::last_write_time(folder / name);
            EXPECT_EQ(made.emplace(name, time).first->second, time) << name << " was made twice";
        }
    };
    for (int i = 0; i < 2000 && namesIn(folder).size() < 20; ++i)
        std::this_thread::sleep_for(std::chrono::milliseconds(20));
    look();
    ASSERT_GE(made.size(), 10U);
    ASSERT_LT(made.size(), frames - 20U) << "the film was done before the server could be killed";
    // Not the one that watches, which would start another: the one that draws.
    const auto file = wire::readConnectionFile(station_.connection());
    ASSERT_TRUE(file.ok());
    station_.server().signal(SIGKILL);
    ::kill(static_cast<pid_t>(file->pid()), SIGKILL);
    station_.server().wait();
    look();
    station_.startServer();
    const auto job = await(id);
    ASSERT_EQ(job.state(), proto::JobStatus::SUCCEEDED) << job.error();
    look();
    EXPECT_EQ(made.size(), static_cast<std::size_t>(frames));
    ASSERT_EQ(fetch(id, {"--out", (folder_ / "fetched").string()}).status, 0);
    EXPECT_EQ(namesIn(folder_ / "fetched").size(), static_cast<std::size_t>(frames));
}

TEST_F(DetachedFilms, AreListedFollowedAndTriedAgain) {
    const auto id = detach(4, {"--job-time", "600"});
    const auto followed = run({"--follow", id});
    EXPECT_EQ(followed.status, 0) << followed.errors;
    const auto longer = detach(2000);
    cancel(longer);
    const auto again = run({"--retry", longer});
    ASSERT_EQ(again.status, 0) << again.errors;
    const auto second = again.output.substr(0, 16);
    EXPECT_NE(second, longer);
    cancel(second);
    EXPECT_EQ(run({"--retry", id}).status, 1) << "it succeeded";
    const auto list = run({"--list-jobs"});
    EXPECT_THAT(list.output, testing::MatchesRegex(second + "  cancelled[^\n]*\n" + longer +
                                                   "  cancelled[^\n]*\n" + id + "  succeeded[^\n]*\n"));
    EXPECT_THAT(run({"--list-jobs", "--json"}).output, HasSubstr("\"timeLimitS\":600"));
}

TEST_F(DetachedFilms, ThatCannotBeFetchedSayWhy) {
    const auto none = fetch("0123456789abcdef", {"--out", (folder_ / "out").string()});
    EXPECT_EQ(none.status, 1);
    EXPECT_THAT(none.errors, HasSubstr("0123456789abcdef"));
    const auto id = detach(2000);
    const auto early = fetch(id, {"--out", (folder_ / "out").string()});
    EXPECT_EQ(early.status, 1);
    EXPECT_THAT(early.errors, testing::AnyOf(HasSubstr("queued"), HasSubstr("running"), HasSubstr("%")));
    cancel(id);
    EXPECT_EQ(fetch(id, {"--out", (folder_ / "out").string()}).status, 1);
    EXPECT_TRUE(namesIn(folder_ / "out").empty());
    const auto wrong = run({script(10, 63).string(), "--detach", "--video", "mp4"});
    EXPECT_TRUE(wrong.status == 1 || await(wrong.output.substr(0, 16)).state() == proto::JobStatus::FAILED);
}

}  // namespace
}  // namespace mote::test
