// SPDX-License-Identifier: GPL-3.0-or-later
//
// The listener for metrics: what it answers to right and wrong requests, and that those who say nothing, or
// too much, keep it from nobody.
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <asio/io_context.hpp>
#include <asio/ip/tcp.hpp>
#include <asio/local/stream_protocol.hpp>
#include <asio/post.hpp>
#include <asio/read.hpp>
#include <asio/write.hpp>
#include <fstream>
#include <thread>

#include "server/app/http_listener.h"
#include "server/metrics/http_answer.h"
#include "tests/support/random.h"
#include "tests/support/temp_dir.h"

namespace mote::server {
namespace {

HttpPages pages(std::optional<std::string> trouble = {}) {
    return {[] { return std::string("mote_sessions 1\n"); }, [trouble] { return trouble; }};
}

std::string statusOf(const std::string& answer) {
    return answer.substr(9, 3);
}

TEST(HttpAnswer, IsByTheRequestsLine) {
    const auto status = [](const std::string& line) {
        return statusOf(httpAnswer(line + "\r\nHost: x\r\n\r\n", pages()));
    };
    EXPECT_EQ(status("GET /metrics HTTP/1.1"), "200");
    EXPECT_EQ(status("GET /healthz HTTP/1.0"), "200");
    EXPECT_EQ(status("GET / HTTP/1.1"), "404");
    EXPECT_EQ(status("GET /metrics/.. HTTP/1.1"), "404");
    EXPECT_EQ(status("POST /metrics HTTP/1.1"), "405");
    for (const char* wrong : {"", "GET", "GET /metrics", "GET /metrics HTTP/2", "get  /metrics HTTP/1.1 x"}) {
        EXPECT_EQ(status(wrong), "400") << wrong;
    }
    const auto answer = httpAnswer("GET /healthz HTTP/1.1\r\n\r\n", pages("the server ends"));
    EXPECT_EQ(statusOf(answer), "503");
    EXPECT_NE(answer.find("Content-Length: 16\r\n"), std::string::npos) << answer;
    EXPECT_TRUE(answer.ends_with("\r\n\r\nthe server ends\n"));
}

TEST(HttpAnswer, IsAWholeAnswerWhateverTheBytes) {
    test::Random random(1);
    for (int i = 0; i < 2000; ++i) {
        std::string head;
        for (auto left = random.below(60); left > 0; --left) head += static_cast<char>(random.below(256));
        const auto answer = httpAnswer(head + "\r\n\r\n", pages());
        EXPECT_TRUE(answer.starts_with("HTTP/1.1 4")) << answer;
    }
}

class HttpListenerTest : public testing::Test {
  protected:
    ~HttpListenerTest() override {
        asio::post(io_, [this] {
            listener_.reset();
            io_.stop();
        });
        if (thread_.joinable()) thread_.join();
    }
    std::string start(const std::string& address) {
        auto opened = HttpListener::open(io_, address, pages());
        EXPECT_TRUE(opened.ok()) << opened.error().toString();
        listener_ = *std::move(opened);
        thread_ = std::thread([this] { io_.run(); });
        return listener_->address();
    }
    std::string socketPath() const { return (folder_ / "metrics.sock").string(); }

    test::TempDir folder_;
    asio::io_context io_;
    std::unique_ptr<HttpListener> listener_;
    std::thread thread_;
};

template <class Socket>
std::string ask(Socket& socket, const std::string& request) {
    asio::error_code code;
    asio::write(socket, asio::buffer(request), code);
    std::string answer;
    asio::read(socket, asio::dynamic_buffer(answer), code);
    return answer;
}

TEST_F(HttpListenerTest, AnswersOnTheLoopbackDevice) {
    const auto address = start("127.0.0.1:0");
    asio::io_context io;
    asio::ip::tcp::socket socket(io);
    socket.connect({asio::ip::make_address("127.0.0.1"),
                    static_cast<unsigned short>(std::stoi(address.substr(address.rfind(':') + 1)))});
    const auto answer = ask(socket, "GET /metrics HTTP/1.1\r\n\r\n");
    EXPECT_TRUE(answer.ends_with("\r\n\r\nmote_sessions 1\n")) << answer;
}

TEST_F(HttpListenerTest, AnswersOnASocketForItsUserAlone) {
    start("unix:" + socketPath());
    struct stat status {};
    ASSERT_EQ(::stat(socketPath().c_str(), &status), 0);
    EXPECT_EQ(status.st_mode & 0777, 0600u);
    asio::io_context io;
    using Socket = asio::local::stream_protocol::socket;
    // As many as are let in say nothing; further ones are closed at once, and these go on.
    std::vector<Socket> silent;
    for (int i = 0; i < 8; ++i) silent.emplace_back(io).connect(socketPath());
    Socket further(io);
    further.connect(socketPath());
    EXPECT_EQ(ask(further, ""), "");
    EXPECT_EQ(statusOf(ask(silent[3], "GET /healthz HTTP/1.1\r\n\r\n")), "200");
    EXPECT_EQ(statusOf(ask(silent[4], std::string(5000, 'x'))), "431");
}

TEST_F(HttpListenerTest, TakesNoLivePlaceAndNoPlaceForOthers) {
    const auto code = [this](const std::string& address) {
        const auto opened = HttpListener::open(io_, address, pages());
        return opened.ok() ? std::string("ok") : std::string(name(opened.error().code));
    };
    for (const char* wrong : {"0.0.0.0:0", "192.0.2.1:80", "localhost:0", "127.0.0.1", "127.0.0.1:x", ":0",
                              "", "unix:", "pigeon:x"}) {
        EXPECT_EQ(code(wrong), "invalid_argument") << wrong;
    }
    std::ofstream(folder_ / "file") << "x";
    EXPECT_EQ(code("unix:" + (folder_ / "file").string()), "already_exists");
    start("unix:" + socketPath());
    EXPECT_EQ(code("unix:" + socketPath()), "already_exists");
}

TEST_F(HttpListenerTest, TakesTheSocketOfADeadServer) {
    {
        asio::io_context io;
        asio::local::stream_protocol::acceptor dead(io, socketPath());
    }
    ASSERT_TRUE(std::filesystem::exists(socketPath()));
    start("unix:" + socketPath());
}

}  // namespace
}  // namespace mote::server
