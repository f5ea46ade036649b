// SPDX-License-Identifier: GPL-3.0-or-later
//
// Where memory is short: who waits for something is told an error, or loses its connection; it never waits in
// vain.
#include <gtest/gtest.h>
#include <sys/socket.h>

#include <asio/executor_work_guard.hpp>
#include <asio/local/stream_protocol.hpp>
#include <asio/post.hpp>
#include <new>
#include <optional>
#include <thread>

#include "server/app/run_through.h"
#include "server/session/session.h"
#include "tests/support/temp_dir.h"
#include "tests/unit/frames/fake_device.h"
#include "tests/unit/session/short_executor.h"
#include "tests/unit/session/test_client.h"
#include "tests/unit/storage/tiny_dataset.h"

namespace mote::test {
namespace {

using namespace server;

class SessionShortage : public testing::Test {
  protected:
    SessionShortage() {
        TinyDataset().write(folder_ / "a.mote");
        context_.render = &render_;
        context_.datasets = &datasets_;
        context_.parked = &parked_;
        context_.following = &following_;
        context_.closed = [this](SessionId) { shortage_.forAll = false; };
        thread_ = std::thread([this] {
            runThrough(
                io_, [] {}, [] { return false; });
        });
    }
    ~SessionShortage() override {
        asio::post(io_, [this] { session_->leave({ErrorCode::cancelled, "connection", "closed"}); });
        kept_.reset();
        thread_.join();
    }

    /// A session on the context's thread, and its client.
    std::unique_ptr<TestClient> connect(const ParkedSessions::Admission& admission = {}) {
        const auto path = (folder_ / "socket").string();
        asio::local::stream_protocol::acceptor acceptor(io_, {path});
        auto client = std::make_unique<TestClient>(path);
        wire::MessageStream::Socket socket(ShortExecutor(io_, shortage_), {AF_UNIX, 0},
                                           acceptor.accept().release());
        session_ =
            std::make_shared<Session>(own, wire::MessageStream(std::move(socket)), context_, Role::owner);
        asio::post(io_, [this, admission] {
            proto::ClientMessage hello;
            hello.mutable_hello();
            session_->start(hello, admission);
        });
        return client;
    }
    /// As the server does now and then; here until it helps.
    void closeInVain() {
        session_->closeIfInVain();
        if (!session_->closed()) asio::post(io_, [this] { closeInVain(); });
    }

    static proto::ClientMessage list() {
        proto::ClientMessage message;
        message.mutable_list_datasets();
        return message;
    }
    static void expectShort(TestClient& client, const proto::ClientMessage& message) {
        const auto answer = client.ask(message).message;
        EXPECT_EQ(answer.failure().code(), "resource_exhausted") << answer.ShortDebugString();
        EXPECT_FALSE(answer.failure().fatal());
    }

    static constexpr SessionId own = 1, other = 2;
    TempDir folder_;
    Shortage shortage_;
    std::atomic<bool> cannotLook_{false};
    asio::io_context io_{1};
    std::optional<asio::executor_work_guard<asio::io_context::executor_type>> kept_{io_.get_executor()};
    DatasetService datasets_{*storage::Roots::parse({"data=" + folder_.path().string()}),
                             [this] {
                                 if (cannotLook_) throw std::bad_alloc();
                             },
                             std::uint64_t{1} << 28, [] {}};
    RenderService render_{[] { return std::make_unique<FakeDevice>(std::make_shared<FakeControl>()); },
                          datasets_};
    ParkedSessions parked_;
    Following following_;
    SessionContext context_;
    std::shared_ptr<Session> session_;
    std::thread thread_;
};

TEST_F(SessionShortage, WhatCannotBeLookedForIsAnErrorAndFoundLater) {
    cannotLook_ = true;
    const auto client = connect();
    proto::ClientMessage describe, query, view;
    describe.mutable_describe()->set_dataset("data/none");
    query.mutable_query()->set_dataset("data/none");
    view.mutable_set_view()->mutable_view()->set_width(16);
    view.mutable_set_view()->mutable_view()->set_height(16);
    auto& layer = *view.mutable_set_view()->mutable_view()->add_layers();
    layer.set_dataset("data/none");
    layer.mutable_particles();
    for (const auto& message : {list(), describe, query, view}) expectShort(*client, message);
    cannotLook_ = false;
    EXPECT_EQ(client->ask(list()).message.catalogue().datasets_size(), 1);
    EXPECT_EQ(client->ask(describe).message.failure().code(), "not_found");
}

TEST_F(SessionShortage, AnAnswerThatCannotBeToldEndsTheConnection) {
    const auto client = connect();
    ASSERT_TRUE(client->receive()->message.has_welcome());
    shortage_.forOthers = true;
    client->send(list());
    asio::post(io_, [this] { closeInVain(); });
    EXPECT_TRUE(client->atEnd());
}

/// Its first step throws, and then whoever would tell of that.
TEST_F(SessionShortage, ASessionThatCannotBeginEndsTheConnection) {
    following_.enter(own, "test");
    const auto show = [this](const proto::Followed& followed) {
        if (!followed.has_view()) return;
        shortage_.forAll = true;
        throw std::bad_alloc();
    };
    ASSERT_TRUE(following_.follow(other, own, show).ok());
    ParkedSessions::Admission admission;
    admission.state.view.emplace();
    admission.state.view->mutable_view()->set_width(16);
    admission.state.view->mutable_view()->set_height(16);
    EXPECT_TRUE(connect(admission)->atEnd());
}

}  // namespace
}  // namespace mote::test
