// SPDX-License-Identifier: GPL-3.0-or-later
//
// What films need of a session: views in a queue, and pictures that give way to everybody else's.
#include <algorithm>
#include <random>

#include "storage/storage_error.h"
#include "tests/unit/session/session_fixture.h"

namespace mote::test {
namespace {

class SessionFilms : public SessionFixture {
  protected:
    /// mote-frames is a program that makes one picture, and a video of two and a half pieces.
    void makeFilms() {
        settings_.prep = MOTE_BIN "/mote-prep";  // mote-supervise lies beside it
        std::filesystem::create_directory(folder_ / "bin");
        settings_.frames = folder_ / "bin/frames";
        std::ofstream(settings_.frames) << "#!/bin/sh\n"
                                           "cd \"${2%/request.json}/film\" || exit 1\n"
                                           "echo picture > frame-000000.png\n"
                                           "i=0\n"  // a job starts no other programs
                                           "while [ $i -lt 40960 ]; do\n"
                                           "    printf '%063d\\n' $i; i=$((i+1))\n"
                                           "done > film.mp4\n";
        std::filesystem::permissions(settings_.frames, std::filesystem::perms::owner_all);
    }

    /// Submits a film and waits until it is done; its id.
    std::string makeFilm(TestClient& client) {
        proto::ClientMessage watch, submit;
        watch.mutable_watch_jobs();
        client.ask(watch);
        auto& film = *submit.mutable_submit_job()->mutable_job()->mutable_film();
        auto& view = *film.mutable_script()->add_views();
        view.set_width(64);
        view.set_height(48);
        film.set_video("mp4");
        const auto id = client.ask(submit).message.job().id();
        const auto done = client.receive([&](const auto& message) {
            return message.job().id() == id && message.job().state() > proto::JobStatus::RUNNING;
        });
        EXPECT_EQ(done.message.job().state(), proto::JobStatus::SUCCEEDED) << done.message.ShortDebugString();
        return id;
    }

    static proto::ClientMessage fetch(const std::string& id, std::uint64_t begin) {
        proto::ClientMessage message;
        message.mutable_fetch_film()->set_id(id);
        message.mutable_fetch_film()->set_begin(begin);
        return message;
    }

    static std::vector<std::uint8_t> fetchAll(TestClient& client, const std::string& id) {
        std::vector<std::uint8_t> bytes;
        for (std::uint64_t size = 1; bytes.size() < size;) {
            const auto got = client.ask(fetch(id, bytes.size()));
            EXPECT_TRUE(got.message.has_film_piece()) << got.message.ShortDebugString();
            EXPECT_EQ(got.message.film_piece().begin(), bytes.size());
            if (got.payload.empty()) break;
            size = got.message.film_piece().size();
            bytes.insert(bytes.end(), got.payload.begin(), got.payload.end());
        }
        return bytes;
    }

    std::vector<std::uint8_t> videoOf(const std::string& id) const {
        std::ifstream file(settings_.stateDirectory / "jobs" / id / "film/film.mp4", std::ios::binary);
        return {std::istreambuf_iterator<char>(file), {}};
    }
};

proto::Failure failureOf(TestClient& client, std::uint64_t request) {
    return client.receiveReply(request).message.failure();
}

TEST_F(SessionFilms, QueuedViewsAreAllAnsweredInTheirOrder) {
    start();
    const auto film = client();
    std::uint64_t asked = 0, seen = 0;
    while (asked < wire::maxQueuedViews) film->queueView(++asked, 40);
    while (seen < 200) {
        const auto frame = film->receiveFrame().message.frame();
        ASSERT_EQ(frame.view_id(), ++seen);
        EXPECT_TRUE(frame.final());
        if (asked < 200) film->queueView(++asked, 40);
        film->credit(1);
    }
    EXPECT_EQ(control_->renders().size(), 200u);
}

TEST_F(SessionFilms, OneTooManyIsRefusedAndTheOthersStay) {
    start();
    control_->closeGate();
    const auto film = client();
    for (std::uint64_t id = 1; id <= wire::maxQueuedViews; ++id) film->queueView(id, 40);
    const auto failure = failureOf(*film, film->queueView(99, 40));
    EXPECT_EQ(failure.code(), "resource_exhausted");
    EXPECT_EQ(failure.where(), "queued");
    EXPECT_FALSE(failure.fatal());
    control_->openGate();
    for (std::uint64_t id = 1; id <= wire::maxQueuedViews; ++id) {
        EXPECT_EQ(film->receiveFrame().message.frame().view_id(), id);
        film->credit(1);
    }
}

TEST_F(SessionFilms, OnlyExactPicturesCanBeQueued) {
    start();
    const auto film = client();
    const auto failure = failureOf(*film, film->queueView(1, 40, false));
    EXPECT_EQ(failure.code(), "invalid_argument");
    EXPECT_EQ(failure.where(), "queued");
    film->queueView(2, 40);
    EXPECT_EQ(film->receiveFrame().message.frame().view_id(), 2u);
}

TEST_F(SessionFilms, EachQueuedViewThatFailsIsToldAndTheNextGoesOn) {
    start();
    control_->closeGate();
    const auto film = client();
    // What fails is random; the answers must say just that.
    std::mt19937 random(3);
    std::map<std::uint64_t, std::uint64_t> requests;  // the view of each
    std::vector<bool> fails;
    for (std::uint64_t id = 1; id <= wire::maxQueuedViews; ++id) {
        fails.push_back(random() % 2 == 0);
        if (fails.back()) {
            control_->failNext([] {
                throw storage::StorageError({ErrorCode::corrupt, "step.h5", "differs"});
            });
        } else {
            control_->failNext([] {});
        }
        requests[film->queueView(id, 40)] = id;
    }
    const auto wrong = std::count(fails.begin(), fails.end(), true);
    ASSERT_GT(wrong, 3);
    control_->openGate();
    std::vector<bool> failed(fails.size(), false);
    std::uint64_t latest = 0;
    for (std::size_t i = 0; i < fails.size(); ++i) {
        const auto got =
            film->receive([](const auto& message) { return message.has_frame() || message.has_failure(); });
        if (got.message.has_failure()) {
            EXPECT_EQ(got.message.failure().code(), "corrupt");
            failed[requests.at(got.message.reply_to()) - 1] = true;
        } else {
            EXPECT_GT(got.message.frame().view_id(), latest);
            latest = got.message.frame().view_id();
            film->credit(1);
        }
    }
    EXPECT_EQ(failed, fails);
}

TEST_F(SessionFilms, FailuresOfAClientThatDoesNotReadTakeNoMemory) {
    start();
    const auto film = client();
    proto::ClientMessage message;
    auto& set = *message.mutable_set_view();
    set.set_final_only(true);
    set.set_queued(true);
    set.mutable_view()->set_width(64);
    set.mutable_view()->set_height(64);
    set.mutable_view()->add_layers()->set_dataset("data/" + std::string(200, 'x'));
    set.mutable_view()->mutable_layers(0)->mutable_particles();
    int taken = 0;
    for (int i = 0; i < 20'000; ++i) taken += film->trySend(message) ? 1 : 0;
    EXPECT_LT(taken, 20'000) << "it reads on and on";
    client()->barrier();
}

TEST_F(SessionFilms, AViewThatIsNotQueuedReplacesTheQueue) {
    start();
    control_->closeGate();
    const auto film = client();
    for (std::uint64_t id = 1; id <= 5; ++id) film->queueView(id, 40);
    control_->awaitBegun(1);
    film->setView(9, 50);
    control_->awaitBegun(2);
    control_->openGate();
    EXPECT_EQ(film->receiveFrame().message.frame().view_id(), 9u);
    EXPECT_EQ(control_->renders().size(), 2u);
}

TEST_F(SessionFilms, TheNextPictureIsDrawnWhileNobodyTookTheOneBefore) {
    start();
    const auto film = client();
    for (std::uint64_t id = 1; id <= 5; ++id) film->queueView(id, 40);
    control_->awaitBegun(2);  // two credits; a third picture would be one too many
    const auto other = client();
    other->setView(1, 32);
    other->receiveFrame();
    EXPECT_EQ(control_->renders().size(), 3u);
}

TEST_F(SessionFilms, AViewThatEndedServersIsRefusedAmongOthersOfItsFilm) {
    server::CrashRecord crashes;
    settings_.render.crashes = &crashes;
    proto::View view;
    view.set_width(65);
    view.set_height(65);
    for (int i = 0; i < 2; ++i) crashes.count(view.SerializeAsString());
    start();
    const auto film = client();
    film->queueView(1, 64);
    EXPECT_EQ(failureOf(*film, film->queueView(2, 65)).code(), "internal");
    film->queueView(3, 66);
    // The first may have been received while the failure was waited for.
    EXPECT_EQ(film->receive([](const auto& message) { return message.frame().view_id() == 3; })
                  .message.frame()
                  .width(),
              66u);
}

TEST_F(SessionFilms, APictureInTheBackgroundGivesWayToAnybodysAndIsMadeAfterwards) {
    start();
    control_->closeGate();
    const auto film = client(true);
    const auto script = client();
    film->queueView(1, 64);
    control_->awaitBegun(1);
    script->setView(1, 65, false, true);
    control_->awaitBegun(2);  // without a stop, the first would wait at the gate for ever
    control_->openGate();
    EXPECT_EQ(script->receiveFrame().message.frame().width(), 65u);
    EXPECT_EQ(film->receiveFrame().message.frame().width(), 64u);
    const auto renders = control_->renders();
    ASSERT_EQ(renders.size(), 3u);
    EXPECT_TRUE(renders[0].stopped);
}

TEST_F(SessionFilms, AFilmIsFetchedPieceByPieceAlsoFromTheNextServer) {
    makeFilms();
    start();
    auto one = client();
    const auto id = makeFilm(*one);
    const auto video = videoOf(id);
    ASSERT_EQ(video.size(), 2'621'440u);
    EXPECT_EQ(fetchAll(*one, id), video);
    stop();
    start();
    one = client();
    EXPECT_EQ(fetchAll(*one, id), video);
    auto picture = fetch(id, 0);
    picture.mutable_fetch_film()->set_frame(0);
    const auto first = one->ask(picture);
    EXPECT_EQ(first.message.film_piece().name(), "frame-000000.png");
    EXPECT_EQ(std::string(first.payload.begin(), first.payload.end()), "picture\n");
}

TEST_F(SessionFilms, WhatCannotBeFetchedIsAFailureOfThatRequestAlone) {
    makeFilms();
    start();
    const auto one = client();
    const auto unknown = one->ask(fetch("none", 0)).message.failure();
    EXPECT_EQ(unknown.code(), "not_found");
    EXPECT_EQ(unknown.where(), "id");
    EXPECT_FALSE(unknown.fatal());
    const auto id = makeFilm(*one);
    EXPECT_EQ(one->ask(fetch(id, 2'621'441)).message.failure().where(), "begin");
    EXPECT_TRUE(one->ask(fetch(id, 2'621'440)).payload.empty());
}

TEST_F(SessionFilms, PiecesThatNobodyReadsHoldUpNobodyElse) {
    makeFilms();
    start();
    const auto stalled = client(), other = client();
    const auto id = makeFilm(*other);
    int sent = 0;
    for (int i = 0; i < 10'000; ++i) sent += stalled->trySend(fetch(id, 0)) ? 1 : 0;
    EXPECT_LT(sent, 10'000) << "it is asked on and on";
    for (std::uint64_t view = 1; view <= 10; ++view) {
        other->setView(view, 40);
        EXPECT_EQ(other->receiveFrame().message.frame().view_id(), view);
        other->credit(1);
    }
    // It reads again: what it asked for comes.
    for (int i = 0; i < sent; ++i) {
        const auto piece = stalled->receive([](const auto& message) { return message.has_film_piece(); });
        EXPECT_EQ(piece.payload.size(), std::size_t{1} << 20);
    }
}

TEST_F(SessionFilms, TheirProgramFindsTheServerByAFileOfItsOwn) {
    start();
    const auto file = settings_.stateDirectory / "film/connection.json";
    const auto content = wire::readConnectionFile(file);  // refuses a file that others may read
    ASSERT_TRUE(content.ok()) << content.error().toString();
    EXPECT_EQ(content->SerializeAsString(), connection_.SerializeAsString());
    stop();
    EXPECT_FALSE(std::filesystem::exists(file));
}

}  // namespace
}  // namespace mote::test
