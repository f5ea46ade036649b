// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/support/shaped_link.h"

#include <array>
#include <asio/io_context.hpp>
#include <asio/local/stream_protocol.hpp>
#include <asio/post.hpp>
#include <asio/steady_timer.hpp>
#include <asio/write.hpp>
#include <atomic>
#include <deque>
#include <functional>
#include <thread>
#include <vector>

namespace mote::test {
namespace {

using Protocol = asio::local::stream_protocol;
using Clock = std::chrono::steady_clock;

constexpr std::size_t chunk = 4096;  // bytes that pass at once: 1.6 ms at 20 Mbit/s

/// One direction of one connection: chunks wait for the rate, then for the delay, then they are written.
class Direction : public std::enable_shared_from_this<Direction> {
  public:
    Direction(std::shared_ptr<Protocol::socket> from, std::shared_ptr<Protocol::socket> to,
              const LinkShape& shape, const std::atomic<double>& rate)
        : from_(std::move(from)),
          to_(std::move(to)),
          shape_(shape),
          rate_(rate),
          timer_(from_->get_executor()) {}

    void read() {
        if (reading_ || waiting() >= shape_.mostWaiting) return;
        reading_ = true;
        from_->async_read_some(asio::buffer(buffer_),
                               [self = shared_from_this()](const asio::error_code& code, std::size_t size) {
                                   self->reading_ = false;
                                   if (code) return self->close();
                                   self->pass(size);
                                   self->read();
                               });
    }

  private:
    struct Chunk {
        std::vector<std::uint8_t> bytes;
        Clock::time_point through;  // the rate's part is done
    };

    void pass(std::size_t size) {
        const auto seconds = std::chrono::duration<double>(8.0 * static_cast<double>(size) / rate_);
        idle_ = std::max(idle_, Clock::now()) + std::chrono::duration_cast<Clock::duration>(seconds);
        chunks_.push_back({{buffer_.begin(), buffer_.begin() + static_cast<std::ptrdiff_t>(size)}, idle_});
        if (!writing_) write();
    }

    /// Bytes that the rate has not let through yet.
    std::size_t waiting() const {
        const std::chrono::duration<double> left = idle_ - Clock::now();
        return static_cast<std::size_t>(std::max(0.0, left.count()) * rate_ / 8.0);
    }

    void write() {
        writing_ = !chunks_.empty();
        if (!writing_) return;
        timer_.expires_at(chunks_.front().through + shape_.oneWay);
        timer_.async_wait([self = shared_from_this()](const asio::error_code& code) {
            if (code) return;
            self->read();
            asio::async_write(*self->to_, asio::buffer(self->chunks_.front().bytes),
                              [self](const asio::error_code& failed, std::size_t) {
                                  if (failed) return self->close();
                                  self->chunks_.pop_front();
                                  self->write();
                              });
        });
    }

    void close() {
        asio::error_code ignored;
        from_->close(ignored);
        to_->close(ignored);
        timer_.cancel();
    }

    const std::shared_ptr<Protocol::socket> from_, to_;
    const LinkShape shape_;
    const std::atomic<double>& rate_;
    asio::steady_timer timer_;
    std::array<std::uint8_t, chunk> buffer_{};
    std::deque<Chunk> chunks_;
    Clock::time_point idle_;
    bool reading_ = false, writing_ = false;
};

}  // namespace

class ShapedLink::Impl {
  public:
    Impl(std::filesystem::path from, std::filesystem::path to, const LinkShape& shape)
        : from_(std::move(from)), to_(std::move(to)), shape_(shape), rate_(shape.bitsPerSecond) {
        acceptor_.open();
        acceptor_.bind(Protocol::endpoint(from_.string()));
        acceptor_.listen();
        accept();
        thread_ = std::thread([this] { context_.run(); });
    }

    ~Impl() {
        context_.stop();
        thread_.join();
        std::error_code ignored;
        std::filesystem::remove(from_, ignored);
    }

    void reshape(double bitsPerSecond) { rate_ = bitsPerSecond; }

  private:
    void accept() {
        acceptor_.async_accept([this](const asio::error_code& code, Protocol::socket client) {
            if (code) return;
            auto near = std::make_shared<Protocol::socket>(std::move(client));
            auto far = std::make_shared<Protocol::socket>(context_);
            asio::error_code failed;
            far->connect(Protocol::endpoint(to_.string()), failed);
            if (!failed) {
                std::make_shared<Direction>(near, far, shape_, rate_)->read();
                std::make_shared<Direction>(far, near, shape_, rate_)->read();
            }
            accept();
        });
    }

    const std::filesystem::path from_, to_;
    const LinkShape shape_;
    std::atomic<double> rate_;
    asio::io_context context_{1};
    Protocol::acceptor acceptor_{context_};
    std::thread thread_;
};

ShapedLink::ShapedLink(std::filesystem::path from, std::filesystem::path to, const LinkShape& shape)
    : impl_(std::make_unique<Impl>(std::move(from), std::move(to), shape)) {}
ShapedLink::~ShapedLink() = default;

void ShapedLink::reshape(double bitsPerSecond) {
    impl_->reshape(bitsPerSecond);
}

}  // namespace mote::test
