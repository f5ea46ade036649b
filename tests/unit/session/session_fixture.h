// SPDX-License-Identifier: GPL-3.0-or-later
//
// SessionFixture: a whole server with a fake device on a thread of the test, its folders fresh.
#pragma once

#include <gtest/gtest.h>

#include <fstream>
#include <optional>
#include <thread>

#include "protocol/wire/address.h"
#include "protocol/wire/connection_file.h"
#include "server/app/server.h"
#include "tests/support/temp_dir.h"
#include "tests/unit/frames/fake_device.h"
#include "tests/unit/session/test_client.h"

namespace mote::test {

class SessionFixture : public testing::Test {
  protected:
    SessionFixture() {
        std::filesystem::create_directory(folder_ / "data");
        settings_.roots = {"data=" + (folder_ / "data").string()};
        settings_.stateDirectory = folder_ / "state";
        settings_.connectionFile = folder_ / "connection.json";
        settings_.prep = "/bin/false";
        settings_.staleAfter = std::chrono::hours(1);  // a slow machine drops no frames that tests count
    }
    ~SessionFixture() override { stop(); }

    void start() {
        server_.emplace(settings_, [control = control_] { return std::make_unique<FakeDevice>(control); });
        const auto started = server_->start();
        ASSERT_TRUE(started.ok()) << started.error().toString();
        const auto file = wire::readConnectionFile(settings_.connectionFile);
        ASSERT_TRUE(file.ok()) << file.error().toString();
        connection_ = *file;
        thread_ = std::thread([this] { server_->run(); });
    }

    void stop() {
        control_->openGate();
        if (thread_.joinable()) {
            server_->stop();
            thread_.join();
        }
        server_.reset();
    }

    std::filesystem::path socket() const { return wire::parseAddress(connection_.address())->path; }

    /// A client that is welcome.
    std::unique_ptr<TestClient> client(bool background = false) {
        auto made = std::make_unique<TestClient>(socket());
        const auto welcome = made->connect(connection_.token(), background);
        EXPECT_TRUE(welcome.message.has_welcome()) << welcome.message.ShortDebugString();
        return made;
    }

    TempDir folder_;
    server::ServerSettings settings_;
    std::shared_ptr<FakeControl> control_ = std::make_shared<FakeControl>();
    std::optional<server::Server> server_;
    proto::ConnectionFile connection_;
    std::thread thread_;
};

}  // namespace mote::test
