// SPDX-License-Identifier: GPL-3.0-or-later
//
// Accepting goes on, whatever happens to one connection or to the process.
#include "server/app/listener.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <asio/local/stream_protocol.hpp>
#include <asio/write.hpp>
#include <stdexcept>

#include "server/app/entrance.h"
#include "tests/support/temp_dir.h"

namespace mote::server {
namespace {

using Client = asio::generic::stream_protocol::socket;

class ListenerTest : public testing::Test {
  protected:
    wire::Address unixAddress() const { return wire::Address::unixAt((folder_ / "s").string()); }

    std::unique_ptr<Client> connect(const Listener& listener) {
        auto client = std::make_unique<Client>(io_);
        client->connect(*endpointOf(io_, listener.address()));
        return client;
    }
    void runUntil(const std::function<bool()>& done) {
        while (!done()) ASSERT_EQ(io_.run_one_for(std::chrono::seconds(60)), 1u);
    }

    test::TempDir folder_;
    asio::io_context io_{1};
    int accepted_ = 0, refused_ = 0;
    bool crowded_ = false;
    std::function<void()> onAccepted_ = [] {};
    Listener::Events events_{.accepted =
                                 [this](const Listener::Socket&) {
                                     ++accepted_;
                                     onAccepted_();
                                 },
                             .refused = [this](const Listener::Socket&) { ++refused_; },
                             .crowded = [this] { return crowded_; }};
};

TEST_F(ListenerTest, ItsUnixSocketIsForItsOwnerAlone) {
    Listener listener(io_, events_);
    ASSERT_TRUE(listener.listen(unixAddress()).ok());
    struct stat status {};
    ASSERT_EQ(::stat((folder_ / "s").c_str(), &status), 0);
    EXPECT_EQ(status.st_mode & 0777, 0600u);
}

TEST_F(ListenerTest, APortOfZeroBecomesARealOne) {
    Listener listener(io_, events_);
    const auto listening = listener.listen(*wire::parseAddress("tcp:127.0.0.1:0"));
    ASSERT_TRUE(listening.ok()) << listening.error().toString();
    EXPECT_NE(listener.address().port, 0);
    listener.accept();
    const auto client = connect(listener);
    runUntil([&] { return accepted_ == 1; });
}

TEST_F(ListenerTest, WhatCannotBeListenedToIsSaid) {
    Listener one(io_, events_), two(io_, events_), three(io_, events_);
    ASSERT_TRUE(one.listen(unixAddress()).ok());
    EXPECT_FALSE(two.listen(unixAddress()).ok());
    EXPECT_FALSE(three.listen(*wire::parseAddress("tcp:host.invalid:0")).ok());
}

TEST_F(ListenerTest, AConnectionThatCannotBeServedIsNotTheLast) {
    Listener listener(io_, events_);
    ASSERT_TRUE(listener.listen(unixAddress()).ok());
    listener.accept();
    onAccepted_ = [this] {
        if (accepted_ <= 2) throw std::bad_alloc();
    };
    std::vector<std::unique_ptr<Client>> clients;
    for (int i = 0; i < 4; ++i) clients.push_back(connect(listener));
    runUntil([&] { return accepted_ == 4; });
}

TEST_F(ListenerTest, ACrowdIsTakenAllTheSame) {
    crowded_ = true;
    Listener listener(io_, events_);
    ASSERT_TRUE(listener.listen(unixAddress()).ok());
    listener.accept();
    std::vector<std::unique_ptr<Client>> clients;
    for (int i = 0; i < 20; ++i) clients.push_back(connect(listener));
    runUntil([&] { return accepted_ == 20; });
}

/// As many descriptors as are open may be open, for a while.
class NoDescriptors {
  public:
    NoDescriptors() {
        ::getrlimit(RLIMIT_NOFILE, &before_);
        const int lowest = ::open("/dev/null", O_RDONLY | O_CLOEXEC);
        ::close(lowest);
        rlimit limit = before_;
        limit.rlim_cur = static_cast<rlim_t>(lowest);
        ::setrlimit(RLIMIT_NOFILE, &limit);
    }
    ~NoDescriptors() { ::setrlimit(RLIMIT_NOFILE, &before_); }
    NoDescriptors(const NoDescriptors&) = delete;
    NoDescriptors& operator=(const NoDescriptors&) = delete;

  private:
    rlimit before_{};
};

TEST_F(ListenerTest, WithoutDescriptorsWhoComesIsToldAndThoseAfterThatAreTaken) {
    Listener listener(io_, events_);
    ASSERT_TRUE(listener.listen(unixAddress()).ok());
    listener.accept();
    std::vector<std::unique_ptr<Client>> clients;
    for (int i = 0; i < 3; ++i) clients.push_back(connect(listener));
    {
        const NoDescriptors none;
        runUntil([&] { return refused_ == 3; });
        EXPECT_EQ(accepted_, 0);
    }
    clients.push_back(connect(listener));
    runUntil([&] { return accepted_ == 1; });
}

class IdentityFile : public testing::Test {
  protected:
    test::TempDir folder_;
};

TEST_F(IdentityFile, IsMadeOnceForItsOwnerAlone) {
    const auto made = readIdentity(folder_.path());
    ASSERT_TRUE(made.ok()) << made.error().toString();
    const auto again = readIdentity(folder_.path());
    ASSERT_TRUE(again.ok()) << again.error().toString();
    EXPECT_EQ(again->fingerprint(), made->fingerprint());
    struct stat status {};
    ASSERT_EQ(::stat((folder_ / "tls.pem").c_str(), &status), 0);
    EXPECT_EQ(status.st_mode & 07777, 0600u);
}

TEST_F(IdentityFile, ThatOthersMayReadOrThatIsDamagedIsRefused) {
    ASSERT_TRUE(readIdentity(folder_.path()).ok());
    ::chmod((folder_ / "tls.pem").c_str(), 0640);
    const auto open = readIdentity(folder_.path());
    ASSERT_FALSE(open.ok());
    EXPECT_EQ(open.error().code, ErrorCode::permissionDenied);
    ::chmod((folder_ / "tls.pem").c_str(), 0600);
    std::filesystem::resize_file(folder_ / "tls.pem", 100);
    const auto damaged = readIdentity(folder_.path());
    ASSERT_FALSE(damaged.ok());
    EXPECT_EQ(damaged.error().code, ErrorCode::corrupt);
}

}  // namespace
}  // namespace mote::server
