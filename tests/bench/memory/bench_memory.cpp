// SPDX-License-Identifier: GPL-3.0-or-later
//
// bench-memory: what a client sees of data that is not in memory, over a running server's socket.
//
//   bench-memory CONNECTION.json first DATASET           first picture, and the full one
//   bench-memory CONNECTION.json orbit DATASET [FRAMES]  frames a second, from the first on
//   bench-memory CONNECTION.json play DATASET [FRAMES]   steps a second, one after the other
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <string>

#include "protocol/wire/address.h"
#include "protocol/wire/connection_file.h"
#include "server/frames/view_task.h"
#include "tests/unit/session/test_client.h"

namespace mote::test {
namespace {

using server::Clock;

struct Bench {
    explicit Bench(const proto::ConnectionFile& connection)
        : pid(connection.pid()), client(wire::parseAddress(connection.address())->path) {
        if (!client.connect(connection.token()).message.has_welcome())
            throw std::runtime_error("not welcome");
    }

    void ask(const std::string& dataset, std::uint32_t step, double angle, bool moving) {
        proto::ClientMessage message;
        auto& set = *message.mutable_set_view();
        set.set_view_id(++views);
        set.set_moving(moving);
        auto& view = *set.mutable_view();
        view.set_width(1280);
        view.set_height(720);
        for (const double value : {4.0 * std::sin(angle), 0.5, 4.0 * std::cos(angle)}) {
            view.mutable_camera()->add_eye(value);
        }
        for (const double value : {0.0, 0.0, 0.0}) view.mutable_camera()->add_target(value);
        for (const double value : {0.0, 1.0, 0.0}) view.mutable_camera()->add_up(value);
        auto& layer = *view.add_layers();
        layer.set_dataset(dataset);
        layer.set_step(step);
        layer.mutable_particles();
        client.send(message);
    }

    proto::Frame frame() {
        const auto received =
            client.receive([](const auto& message) { return message.has_frame() || message.has_failure(); });
        if (received.message.has_failure()) {
            throw std::runtime_error(received.message.failure().ShortDebugString());
        }
        client.credit(1);
        return received.message.frame();
    }

    /// MiB that the server holds, of them those of mapped files.
    void printMemory() const {
        std::ifstream status("/proc/" + std::to_string(pid) + "/status");
        for (std::string line; std::getline(status, line);) {
            if (line.starts_with("VmHWM") || line.starts_with("VmRSS") || line.starts_with("RssFile") ||
                line.starts_with("RssAnon")) {
                std::printf("%s  ", line.c_str());
            }
        }
        std::printf("\n");
    }

    std::int64_t pid;
    TestClient client;
    std::uint64_t views = 0;
};

void print(const char* what, double ms, const proto::Frame& frame) {
    std::printf("%-10s %8.1f ms  plan %7.1f render %7.1f encode %5.1f  width %5u  share %.4f  points %lu\n",
                what, ms, frame.plan_ms(), frame.render_ms(), frame.encode_ms(), frame.width(),
                frame.point_fraction(), static_cast<unsigned long>(frame.points_drawn()));
}

void first(Bench& bench, const std::string& dataset) {
    const auto begun = Clock::now();
    bench.ask(dataset, 0, 0.0, false);
    for (bool last = false; !last;) {
        const auto frame = bench.frame();
        last = frame.final();
        print(last ? "full" : "picture", server::milliseconds(Clock::now() - begun), frame);
    }
}

void run(Bench& bench, const std::string& dataset, int frames, std::uint32_t steps) {
    std::vector<double> times;
    double share = 0.0;
    const auto begun = Clock::now();
    for (int i = 0; i < frames; ++i) {
        const auto asked = Clock::now();
        bench.ask(dataset, static_cast<std::uint32_t>(i) % steps, 0.01 * i, true);
        const auto frame = bench.frame();
        times.push_back(server::milliseconds(Clock::now() - asked));
        share += frame.point_fraction() / frames;
        if (i < 3 || i % 50 == 0) print(std::to_string(i).c_str(), times.back(), frame);
    }
    const double seconds = server::milliseconds(Clock::now() - begun) / 1e3;
    std::sort(times.begin(), times.end());
    const auto at = [&](double q) { return times[static_cast<std::size_t>(q * (frames - 1))]; };
    std::printf("%d pictures, %.1f a second; view to frame p50 %.1f p99 %.1f max %.1f ms; mean share %.4f\n",
                frames, frames / seconds, at(0.5), at(0.99), times.back(), share);
}

int run(int argc, char** argv) {
    if (argc < 4) {
        std::fprintf(stderr, "usage: bench-memory CONNECTION.json first|orbit|play DATASET [FRAMES]\n");
        return 2;
    }
    const auto connection = wire::readConnectionFile(argv[1]);
    if (!connection.ok()) throw std::runtime_error(connection.error().toString());
    Bench bench(*connection);
    const int frames = argc > 4 ? std::max(1, std::atoi(argv[4])) : 300;
    if (std::strcmp(argv[2], "first") == 0) first(bench, argv[3]);
    if (std::strcmp(argv[2], "orbit") == 0) run(bench, argv[3], frames, 1);
    if (std::strcmp(argv[2], "play") == 0) {
        proto::ClientMessage describe;
        describe.mutable_describe()->set_dataset(argv[3]);
        const auto reply = bench.client.ask(describe);
        const auto steps = reply.message.description().manifest().particles().steps_size();
        run(bench, argv[3], frames, static_cast<std::uint32_t>(std::max(1, steps)));
    }
    bench.printMemory();
    return 0;
}

}  // namespace
}  // namespace mote::test

int main(int argc, char** argv) {
    try {
        return mote::test::run(argc, argv);
    } catch (const std::exception& failure) {
        std::fprintf(stderr, "bench-memory: %s\n", failure.what());
        return 1;
    }
}
