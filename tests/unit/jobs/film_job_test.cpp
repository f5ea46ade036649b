// SPDX-License-Identifier: GPL-3.0-or-later
//
// Films: made beside other jobs, kept, fetched, and gone on with whatever happens to processes and servers.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <signal.h>
#include <sys/stat.h>

#include <fstream>
#include <random>
#include <sstream>

#include "protocol/base/json.h"
#include "tests/unit/jobs/job_fixture.h"

namespace mote::server {
namespace {

using ::testing::HasSubstr;

class FilmJobTest : public JobTest {
  protected:
    struct Processes {
        int frames = 0;
        int supervisor = 0;
    };

    Processes processesOf(const std::string& id, int after = 0) {
        Processes found;
        waitUntil(id, [&](const auto& status) {
            std::istringstream words(status.phase());
            return words >> found.frames >> found.supervisor && found.frames != after;
        });
        return found;
    }

    /// Runs the queue until nothing of what the job made is there.
    void waitUntilGone(const std::string& id) {
        const auto jobs = directory_ / "state/jobs";
        const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(30);
        while (std::filesystem::exists(jobs / id / "film") ||
               std::filesystem::exists(jobs / (id + ".gone"))) {
            ASSERT_LT(std::chrono::steady_clock::now(), end);
            settle();
        }
    }

    /// Bytes that say where they lie.
    std::vector<std::uint8_t> writeFile(const std::string& id, const std::string& name, std::size_t size) {
        std::minstd_rand random(static_cast<unsigned>(size));
        std::vector<std::uint8_t> bytes(size);
        for (auto& byte : bytes) byte = static_cast<std::uint8_t>(random() >> 8);
        std::ofstream(filmFile(id, name), std::ios::binary)
            .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(size));
        return bytes;
    }
};

TEST_F(FilmJobTest, aFilmIsMadeAndStays) {
    startServer();
    const auto id = submitFilm("half:drawing file:frame-000000.png");
    const auto done = waitForState(id, State::SUCCEEDED);
    EXPECT_EQ(done.progress(), 1.0);
    struct stat status {};
    ASSERT_EQ(stat(filmFile(id, "").c_str(), &status), 0);
    EXPECT_EQ(status.st_mode & 0777, 0700u);
    EXPECT_TRUE(std::filesystem::exists(filmFile(id, "frame-000000.png")));
    EXPECT_FALSE(std::filesystem::exists(directory_ / "state/jobs" / id / "log"));
    const auto piece = fetchPicture(id, 0);
    ASSERT_TRUE(piece.ok()) << piece.error().toString();
    EXPECT_EQ(piece->message.name(), "frame-000000.png");
    EXPECT_EQ(piece->bytes, std::vector<std::uint8_t>{'x'});
}

TEST_F(FilmJobTest, theProgramHasTheWholeScriptAndNobodyElse) {
    startServer();
    auto request = filmRequest("pids: wait:go file:frame-000000.png");
    std::mt19937 random(5);
    for (int i = 0; i < 2000; ++i) {
        auto& view = *request.mutable_film()->mutable_script()->add_views();
        view.set_width(random() % 1000 + 1);
        view.set_height(random() % 1000 + 1);
        for (int j = 0; j < 3; ++j) {
            auto& layer = *view.add_layers();
            layer.set_dataset("data/" + std::string(100, static_cast<char>('a' + random() % 26)));
            layer.mutable_particles();
        }
    }
    ASSERT_GT(request.ByteSizeLong(), 600'000u);
    const auto submitted = queue_->submit(request);
    ASSERT_TRUE(submitted.ok()) << submitted.error().toString();
    const auto id = submitted->id();
    processesOf(id);
    proto::JobRequest kept;
    ASSERT_TRUE(readJsonFile(directory_ / "state/jobs" / id / "request.json", kept).ok());
    EXPECT_EQ(kept.SerializeAsString(), request.SerializeAsString());
    const auto small = [](const proto::JobStatus& status) { return status.ByteSizeLong() < 4096; };
    EXPECT_TRUE(small(*submitted));
    EXPECT_TRUE(small(queue_->list().front()));
    EXPECT_TRUE(small(*queue_->find(id)));
    EXPECT_TRUE(queue_->find(id)->request().has_film());
    releaseFilm(id, "go");
    waitForState(id, State::SUCCEEDED);
    settle();
    for (const auto& change : changes_) EXPECT_TRUE(small(change));
}

TEST_F(FilmJobTest, aFilmHoldsUpNoOtherJobAndOneIsMadeAtATime) {
    startServer();
    const auto film = submitFilm("phase:on wait:go file:frame-000000.png");
    const auto second = submitFilm("file:frame-000000.png");
    waitForPhase(film, "on");
    waitForState(submit("publish:"), State::SUCCEEDED);
    EXPECT_EQ(queue_->find(second)->state(), State::QUEUED);
    releaseFilm(film, "go");
    waitForState(film, State::SUCCEEDED);
    waitForState(second, State::SUCCEEDED);
}

TEST_F(FilmJobTest, aFailureIsOneSentenceAndNothingStays) {
    startServer();
    const auto id = submitFilm("file:frame-000000.png print:mote-frames:_no_space_left_on_the_disk exit:1");
    EXPECT_EQ(waitForState(id, State::FAILED).error(), "mote-frames:_no_space_left_on_the_disk");
    waitUntilGone(id);
    const auto none = waitForState(submitFilm("file:draft"), State::FAILED);
    EXPECT_THAT(none.error(), HasSubstr("its film is not there"));
    const auto fetched = fetchPicture(id, 0);
    ASSERT_FALSE(fetched.ok());
    EXPECT_THAT(fetched.error().message, HasSubstr("it failed: "));
}

TEST_F(FilmJobTest, aVideoThatIsMissingIsNoSuccess) {
    startServer();
    auto request = filmRequest("file:frame-000000.png");
    request.mutable_film()->set_video("webm");
    EXPECT_EQ(waitForState(queue_->submit(request)->id(), State::FAILED).error(),
              "mote-frames ended without an error, but its film is not there");
    request.set_title("file:film.webm");
    const auto id = queue_->submit(request)->id();
    waitForState(id, State::SUCCEEDED);
    EXPECT_EQ(fetchVideo(id)->message.name(), "film.webm");
}

TEST_F(FilmJobTest, aFilmThatIsKilledGoesOnWhereItWas) {
    startServer();
    // Its first attempt finds no fifo that is written to and is killed there; so is the second.
    const auto id = submitFilm("file:frame-000000.png pids: wait:go file:frame-000001.png");
    int before = 0;
    for (const bool supervisorToo : {false, true}) {
        const auto processes = processesOf(id, before);
        before = processes.frames;
        kill(supervisorToo ? processes.supervisor : processes.frames, SIGKILL);
        waitForEnd(processes.frames);
    }
    processesOf(id, before);
    releaseFilm(id, "go");
    waitForState(id, State::SUCCEEDED);
    EXPECT_EQ(fetchPicture(id, 0)->bytes.size(), 3u) << "each attempt adds a byte: what was made stayed";
    EXPECT_EQ(fetchPicture(id, 1)->bytes.size(), 1u);
}

TEST_F(FilmJobTest, aFilmThatAlwaysDiesFailsInTheEnd) {
    startServer();
    const auto id = submitFilm("file:frame-000000.png die:10");
    const auto failed = waitForState(id, State::FAILED);
    EXPECT_THAT(failed.error(), HasSubstr("interrupted 10 times"));
    EXPECT_THAT(failed.error(), HasSubstr("signal 10"));
    waitUntilGone(id);
}

TEST_F(FilmJobTest, aFilmOutlivesItsServerAndTheNextOneTakesItUp) {
    startServer();
    const auto id = submitFilm("pids: wait:go file:frame-000000.png wait:end");
    const auto before = processesOf(id);
    killServer();
    releaseFilm(id, "go");
    startServer();
    EXPECT_EQ(queue_->find(id)->state(), State::RUNNING);
    EXPECT_EQ(processesOf(id).frames, before.frames) << "it was started a second time";
    while (!std::filesystem::exists(filmFile(id, "end"))) settle();
    releaseFilm(id, "end");
    waitForState(id, State::SUCCEEDED);
    EXPECT_EQ(fetchPicture(id, 0)->bytes.size(), 1u);
}

TEST_F(FilmJobTest, aFilmThatIsDoneCanStillBeFetchedFromTheNextServer) {
    startServer();
    const auto kept = submitFilm("file:frame-000000.png");
    waitForState(kept, State::SUCCEEDED);
    const auto stray = directory_ / "state/jobs/0123456789abcdef";
    std::filesystem::create_directories(stray / "film");
    startServer();
    EXPECT_TRUE(fetchPicture(kept, 0).ok());
    waitUntilGone("0123456789abcdef");
}

TEST_F(FilmJobTest, cancellingEndsItAndItsFilesGo) {
    startServer();
    const auto running = submitFilm("file:frame-000000.png phase:on wait:never");
    const auto waiting = submitFilm("file:frame-000000.png");
    waitForPhase(running, "on");
    ASSERT_TRUE(queue_->cancel(waiting).ok());
    EXPECT_EQ(queue_->find(waiting)->state(), State::CANCELLED);
    ASSERT_TRUE(queue_->cancel(running).ok());
    waitForState(running, State::CANCELLED);
    for (const auto& id : {running, waiting}) {
        waitUntilGone(id);
        EXPECT_THAT(fetchPicture(id, 0).error().message, HasSubstr("it was cancelled"));
    }
}

TEST_F(FilmJobTest, aFilmThatIsDoneIsThrownAwayByCancellingOrForgetting) {
    auto few = settings();
    few.kept = 2;
    startServer(few);
    std::vector<std::string> ids;
    for (int i = 0; i < 3; ++i) {
        ids.push_back(submitFilm(fmt::format("file:frame-000000.png phase:{}", i)));
        waitForState(ids.back(), State::SUCCEEDED);
    }
    waitUntilGone(ids[0]);
    EXPECT_FALSE(std::filesystem::exists(directory_ / "state/jobs" / ids[0]));
    EXPECT_THAT(fetchPicture(ids[0], 0).error().message, HasSubstr("there is no job"));
    ASSERT_TRUE(queue_->cancel(ids[1]).ok());
    waitUntilGone(ids[1]);
    EXPECT_EQ(queue_->find(ids[1])->state(), State::SUCCEEDED) << "it was made";
    EXPECT_THAT(fetchPicture(ids[1], 0).error().message, HasSubstr("it was made, and thrown away since"));
    EXPECT_TRUE(fetchPicture(ids[2], 0).ok());
}

TEST_F(FilmJobTest, aProgramThatIsNotThereIsAFailure) {
    auto broken = settings();
    broken.frames = directory_ / "nothing";
    startServer(broken);
    EXPECT_THAT(waitForState(submitFilm("file:frame-000000.png"), State::FAILED).error(),
                HasSubstr("cannot be started"));
}

TEST_F(FilmJobTest, filesAreFetchedPieceByPiece) {
    startServer();
    auto request = filmRequest("file:film.mp4 file:frame-000000.exr");
    request.mutable_film()->set_format("exr");
    request.mutable_film()->set_video("mp4");
    const auto id = queue_->submit(request)->id();
    waitForState(id, State::SUCCEEDED);
    for (const std::size_t size :
         {std::size_t{0}, std::size_t{1}, largestArtifactPiece - 1, largestArtifactPiece,
          largestArtifactPiece + 1, 3 * largestArtifactPiece + 77}) {
        const auto bytes = writeFile(id, "film.mp4", size);
        std::vector<std::uint8_t> got;
        do {
            const auto piece = fetchVideo(id, got.size());
            ASSERT_TRUE(piece.ok()) << piece.error().toString();
            EXPECT_EQ(piece->message.size(), size);
            EXPECT_EQ(piece->message.begin(), got.size());
            EXPECT_LE(piece->bytes.size(), largestArtifactPiece);
            got.insert(got.end(), piece->bytes.begin(), piece->bytes.end());
        } while (got.size() < size);
        EXPECT_EQ(got, bytes);
        EXPECT_EQ(fetchVideo(id, size + 1).error().where, "begin");
        EXPECT_THAT(fetchVideo(id, ~std::uint64_t{0}).error().message, HasSubstr("beyond"));
    }
    EXPECT_EQ(fetchPicture(id, 0)->message.name(), "frame-000000.exr");
}

TEST_F(FilmJobTest, whatCannotBeFetchedIsSaidInOneSentence) {
    startServer();
    const auto wrong = [&](const Result<ArtifactPiece>& piece, ErrorCode code, const std::string& where,
                           const std::string& words) {
        ASSERT_FALSE(piece.ok()) << words;
        EXPECT_EQ(piece.error().code, code) << words;
        EXPECT_EQ(piece.error().where, where) << words;
        EXPECT_THAT(piece.error().message, HasSubstr(words));
    };
    wrong(fetchVideo("0123456789abcdef"), ErrorCode::notFound, "id", "there is no job");
    wrong(fetchVideo("../../etc"), ErrorCode::notFound, "id", "there is no job");
    const auto dataset = submit("publish:");
    waitForState(dataset, State::SUCCEEDED);
    wrong(fetchVideo(dataset), ErrorCode::invalidArgument, "id", "makes no film");

    const auto film = submitFilm("half:drawing wait:go file:frame-000000.png");
    wrong(fetchVideo(film), ErrorCode::notFound, "id", "waits");
    waitForPhase(film, "drawing");
    wrong(fetchPicture(film, 0), ErrorCode::notFound, "id", "50% of it are made");
    releaseFilm(film, "go");
    waitForState(film, State::SUCCEEDED);
    wrong(fetchVideo(film), ErrorCode::notFound, "frame", "has no video");
    // However many there are, and whatever number is asked for.
    for (int count = 1; count <= 20; ++count) {
        writeFile(film, fmt::format("frame-{:06}.png", count - 1), 10);
        const auto words = fmt::format("has {} pictures, the last of them number {}", count, count - 1);
        for (const auto frame : {static_cast<std::uint32_t>(count), 999'999U, 1'000'000U, ~0U})
            wrong(fetchPicture(film, frame), ErrorCode::notFound, "frame", words);
        EXPECT_TRUE(fetchPicture(film, static_cast<std::uint32_t>(count - 1)).ok());
    }
}

TEST_F(FilmJobTest, aLinkOrAPipeInAFilesPlaceIsNotFollowed) {
    startServer();
    const auto id = submitFilm("file:frame-000000.png");
    waitForState(id, State::SUCCEEDED);
    std::ofstream(directory_ / "secret") << "secret";
    std::filesystem::create_symlink(directory_ / "secret", filmFile(id, "frame-000001.png"));
    ASSERT_EQ(mkfifo(filmFile(id, "frame-000002.png").c_str(), 0600), 0);
    std::filesystem::create_directory(filmFile(id, "frame-000003.png"));
    for (std::uint32_t frame = 1; frame <= 3; ++frame) EXPECT_FALSE(fetchPicture(id, frame).ok()) << frame;
}

}  // namespace
}  // namespace mote::server
