// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/bench/transport/load_ends.h"

#include <unistd.h>

#include <asio/co_spawn.hpp>
#include <asio/detached.hpp>
#include <asio/steady_timer.hpp>
#include <asio/use_awaitable.hpp>
#include <fstream>
#include <list>
#include <random>

#include "protocol/mote.pb.h"

namespace mote::test {
namespace {

using Clock = std::chrono::steady_clock;

double residentMiB() {
    std::ifstream file("/proc/self/statm");
    double size = 0.0, resident = 0.0;
    file >> size >> resident;
    return resident * static_cast<double>(::sysconf(_SC_PAGESIZE)) / (1 << 20);
}

std::vector<std::uint8_t> noise(std::size_t size) {
    std::mt19937 random(1);
    std::vector<std::uint8_t> bytes(size);
    for (auto& byte : bytes) byte = static_cast<std::uint8_t>(random());
    return bytes;
}

asio::awaitable<void> send(wire::MessageStream& stream, const Load& load, Clock::time_point first,
                           const std::vector<std::uint8_t>& payload) {
    asio::steady_timer timer(stream.executor());
    const auto count = static_cast<std::int64_t>(load.seconds * load.rate);
    for (std::int64_t i = 0; i < count; ++i) {
        const auto due = first + std::chrono::duration_cast<Clock::duration>(
                                     std::chrono::duration<double>(static_cast<double>(i) / load.rate));
        timer.expires_at(due);
        co_await timer.async_wait(asio::use_awaitable);
        proto::ServerMessage message;
        message.mutable_frame()->set_asked_ns(due.time_since_epoch() / std::chrono::nanoseconds(1));
        if (!(co_await stream.write(message, payload, wire::serverLimits)).ok()) co_return;
    }
    stream.close();
}

asio::awaitable<void> receive(wire::MessageStream& stream, std::vector<double>& delays) {
    proto::ServerMessage message;
    std::vector<std::uint8_t> payload;
    while ((co_await stream.read(message, payload, wire::serverLimits)).ok()) {
        const Clock::time_point due{std::chrono::nanoseconds(message.frame().asked_ns())};
        delays.push_back(std::chrono::duration<double, std::milli>(Clock::now() - due).count());
    }
}

/// Opened and greeted, one after the other.
std::list<wire::MessageStream> openAll(asio::io_context& io, const Load& load, const Opener& open) {
    std::list<wire::MessageStream> streams;
    for (std::int64_t i = 0; i < load.clients; ++i) {
        auto& stream = streams.emplace_back(open(io));
        asio::co_spawn(
            io,
            [&stream]() -> asio::awaitable<void> {
                const auto version = co_await stream.greet();
                if (!version.ok()) throw std::runtime_error(version.error().toString());
            },
            [](const std::exception_ptr& failure) {
                if (failure) std::rethrow_exception(failure);
            });
        io.restart();
        io.run();
    }
    return streams;
}

/// Runs to the end; looks at the memory after a fifth of it.
Growth runAll(asio::io_context& io, const Load& load) {
    Growth growth;
    asio::steady_timer early(
        io, std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(load.seconds / 5.0)));
    early.async_wait([&](const asio::error_code&) { growth.earlyMiB = residentMiB(); });
    io.restart();
    io.run();
    growth.lateMiB = residentMiB();
    return growth;
}

}  // namespace

Growth sendLoad(const Load& load, const Opener& accept) {
    asio::io_context io(1);
    auto streams = openAll(io, load, accept);
    const auto payload = noise(static_cast<std::size_t>(load.payload));
    const auto start = Clock::now() + std::chrono::milliseconds(100);
    double phase = 0.0;
    for (auto& stream : streams) {
        const auto first = start + std::chrono::duration_cast<Clock::duration>(
                                       std::chrono::duration<double>(phase / load.rate));
        phase += 1.0 / static_cast<double>(load.clients);
        asio::co_spawn(io, send(stream, load, first, payload), asio::detached);
    }
    return runAll(io, load);
}

Growth receiveLoad(const Load& load, const Opener& connect, std::vector<double>& delays) {
    asio::io_context io(1);
    auto streams = openAll(io, load, connect);
    delays.reserve(static_cast<std::size_t>(load.seconds * load.rate) * streams.size());
    for (auto& stream : streams) asio::co_spawn(io, receive(stream, delays), asio::detached);
    return runAll(io, load);
}

}  // namespace mote::test
