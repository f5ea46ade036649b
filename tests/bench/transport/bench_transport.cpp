// SPDX-License-Identifier: GPL-3.0-or-later
//
// bench-transport: what TLS on loopback adds to the delay of pictures, held against the Unix socket in the
// same run. A process sends, its child receives.
#include <fmt/format.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <asio/ip/tcp.hpp>
#include <asio/local/stream_protocol.hpp>
#include <cstdio>
#include <filesystem>

#include "protocol/cli/command.h"
#include "protocol/wire/tls.h"
#include "tests/bench/transport/load_ends.h"

namespace mote::test {
namespace {

using Tcp = asio::ip::tcp;
using Unix = asio::local::stream_protocol;

/// What the receiver tells the sender, over a pipe.
struct Received {
    double p50 = 0.0, p99 = 0.0, worst = 0.0;  ///< ms
    std::int64_t count = 0;
    Growth growth;
};

Received summary(std::vector<double> delays, Growth growth) {
    std::sort(delays.begin(), delays.end());
    const auto at = [&](double part) {
        return delays.empty()
                   ? 0.0
                   : delays[static_cast<std::size_t>(part * static_cast<double>(delays.size() - 1))];
    };
    return {at(0.5), at(0.99), at(1.0), static_cast<std::int64_t>(delays.size()), growth};
}

/// The child connects once the listener is there, so it is made before this.
Received measure(const char* name, const Load& load, const Opener& accept, const Opener& connect) {
    std::array<int, 2> pipe{};
    if (::pipe(pipe.data()) != 0) throw std::runtime_error("no pipe");
    const pid_t child = ::fork();
    if (child == 0) {
        std::vector<double> delays;
        const auto growth = receiveLoad(load, connect, delays);
        const Received received = summary(std::move(delays), growth);
        const bool told = ::write(pipe[1], &received, sizeof received) == sizeof received;
        std::_Exit(told ? 0 : 1);
    }
    const Growth sender = sendLoad(load, accept);
    Received received;
    if (::read(pipe[0], &received, sizeof received) != sizeof received)
        throw std::runtime_error("no figures");
    ::waitpid(child, nullptr, 0);
    fmt::print(
        "{:5} {:6} payloads: p50 {:.2f} ms, p99 {:.2f} ms, worst {:.2f} ms; memory of the sender {:+.1f} "
        "MiB, "
        "of the receiver {:+.1f} MiB from a fifth of the time to its end\n",
        name, received.count, received.p50, received.p99, received.worst, sender.lateMiB - sender.earlyMiB,
        received.growth.lateMiB - received.growth.earlyMiB);
    std::fflush(stdout);
    return received;
}

Received measureUnix(const Load& load) {
    std::string folder = (std::filesystem::temp_directory_path() / "mote-bench-XXXXXX").string();
    if (::mkdtemp(folder.data()) == nullptr) throw std::runtime_error("no folder");
    const Unix::endpoint place(folder + "/s");
    asio::io_context io;
    Unix::acceptor acceptor(io, place);
    const auto received = measure(
        "unix", load, [&](asio::io_context& ours) { return wire::MessageStream(acceptor.accept(ours)); },
        [&](asio::io_context& ours) {
            Unix::socket socket(ours);
            socket.connect(place);
            return wire::MessageStream(std::move(socket));
        });
    std::filesystem::remove_all(folder);
    return received;
}

Received measureTls(const Load& load) {
    const auto identity = wire::TlsIdentity::parse(wire::TlsIdentity::makePem().value()).value();
    asio::io_context io;
    Tcp::acceptor acceptor(io, {asio::ip::address_v4::loopback(), 0});
    const auto place = acceptor.local_endpoint();
    return measure(
        "tls", load,
        [&](asio::io_context& ours) {
            auto socket = acceptor.accept(ours);
            socket.set_option(Tcp::no_delay(true));
            return wire::MessageStream(wire::tlsServerStream(std::move(socket), identity));
        },
        [&](asio::io_context& ours) {
            Tcp::socket socket(ours);
            socket.connect(place);
            socket.set_option(Tcp::no_delay(true));
            return wire::MessageStream(wire::tlsClientStream(std::move(socket), identity.fingerprint()));
        });
}

int run(int argc, const char* const* argv) {
    const cli::Program program("What TLS on loopback adds to the delay of pictures.", "bench-transport");
    const auto app = program.command();
    Load load;
    app.option("--clients", load.clients, "connections at a time").range(1, 1000);
    app.option("--payload", load.payload, "bytes of a picture").range(1, 1 << 24);
    app.option("--rate", load.rate, "pictures a second and client");
    app.option("--seconds", load.seconds, "of each of the two measurements");
    if (const auto end = program.parse(argc, argv)) return *end;
    const auto plain = measureUnix(load);
    const auto tls = measureTls(load);
    fmt::print("added by TLS: p50 {:.2f} ms, p99 {:.2f} ms\n", tls.p50 - plain.p50, tls.p99 - plain.p99);
    return tls.count == plain.count && tls.count > 0 ? 0 : 1;
}

}  // namespace
}  // namespace mote::test

int main(int argc, char** argv) {
    try {
        return mote::test::run(argc, argv);
    } catch (const std::exception& failure) {
        fmt::print(stderr, "bench-transport: {}\n", failure.what());
        return 1;
    }
}
