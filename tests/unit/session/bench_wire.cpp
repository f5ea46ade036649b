// SPDX-License-Identifier: GPL-3.0-or-later
//
// bench-wire: from a view to its frame, over a running server's socket, against what rendering and encoding
// took of it: alone, and beside a second client that asks and never reads. Not a test: a table.
//
//   bench-wire CONNECTION.json [DATASET] [FRAMES]
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <optional>

#include "protocol/wire/address.h"
#include "protocol/wire/connection_file.h"
#include "server/frames/view_task.h"
#include "tests/unit/session/test_client.h"

namespace mote::test {
namespace {

using server::Clock;

struct Samples {
    std::vector<double> values;

    double quantile(double q) {
        std::sort(values.begin(), values.end());
        return values[static_cast<std::size_t>(q * static_cast<double>(values.size() - 1))];
    }
};

proto::ClientMessage viewOf(const std::optional<std::string>& dataset, std::uint64_t id, double angle) {
    proto::ClientMessage message;
    auto& set = *message.mutable_set_view();
    set.set_view_id(id);
    set.set_moving(true);
    auto& view = *set.mutable_view();
    view.set_width(1280);
    view.set_height(720);
    for (const double value : {4.0 * std::sin(angle), 0.5, 4.0 * std::cos(angle)}) {
        view.mutable_camera()->add_eye(value);
    }
    for (const double value : {0.0, 0.0, 0.0}) view.mutable_camera()->add_target(value);
    for (const double value : {0.0, 1.0, 0.0}) view.mutable_camera()->add_up(value);
    if (!dataset) return message;
    view.add_layers()->set_dataset(*dataset);
    view.mutable_layers(0)->mutable_particles();
    return message;
}

void measure(const char* name, const proto::ConnectionFile& connection,
             const std::optional<std::string>& dataset, int frames) {
    TestClient client(wire::parseAddress(connection.address())->path);
    if (!client.connect(connection.token()).message.has_welcome()) throw std::runtime_error("not welcome");
    Samples latency, work, wire, bytes, fraction, width;
    for (int i = 0; i < frames + 20; ++i) {
        const auto begun = Clock::now();
        client.send(viewOf(dataset, static_cast<std::uint64_t>(i), 0.01 * i));
        const auto received =
            client.receive([](const auto& message) { return message.has_frame() || message.has_failure(); });
        const double ms = server::milliseconds(Clock::now() - begun);
        if (received.message.has_failure()) throw std::runtime_error(received.message.failure().message());
        client.credit(1);
        if (i < 20) continue;  // the quality settles first
        const auto& frame = received.message.frame();
        const double own = frame.plan_ms() + frame.render_ms() + frame.encode_ms();
        latency.values.push_back(ms);
        work.values.push_back(own);
        wire.values.push_back(ms - own);
        fraction.values.push_back(frame.point_fraction());
        width.values.push_back(frame.width());
        bytes.values.push_back(static_cast<double>(received.payload.size()) / 1024.0);
    }
    std::printf("%-28s %8.2f %8.2f   %8.2f %8.2f   %8.2f %8.2f   %6.2f   %7.0f %8.3f %6.0f\n", name,
                latency.quantile(0.5), latency.quantile(0.99), work.quantile(0.5), work.quantile(0.99),
                wire.quantile(0.5), wire.quantile(0.99), latency.quantile(0.99) / work.quantile(0.5),
                bytes.quantile(0.5), fraction.quantile(0.5), width.quantile(0.5));
}

int run(int argc, char** argv) {
    if (argc < 2) {
        std::fprintf(stderr, "usage: bench-wire CONNECTION.json [DATASET] [FRAMES]\n");
        return 2;
    }
    const auto connection = wire::readConnectionFile(argv[1]);
    if (!connection.ok()) throw std::runtime_error(connection.error().toString());
    const auto dataset = argc > 2 && *argv[2] ? std::optional<std::string>(argv[2]) : std::nullopt;
    const int frames = argc > 3 ? std::atoi(argv[3]) : 300;
    std::printf("1280 x 720, %s, %d frames, ms     view to frame       frame time         wire alone\n",
                dataset ? dataset->c_str() : "no layer", frames);
    std::printf("%-28s %8s %8s   %8s %8s   %8s %8s   %6s   %7s\n", "", "p50", "p99", "p50", "p99", "p50",
                "p99", "ratio", "KiB");
    measure("alone", *connection, dataset, frames);
    TestClient stalled(wire::parseAddress(connection->address())->path);
    stalled.connect(connection->token());
    for (int i = 0; i < 200; ++i) {
        stalled.trySend(viewOf(dataset, static_cast<std::uint64_t>(i), 0.3 * i));
    }
    measure("beside one that never reads", *connection, dataset, frames);
    measure("alone again (noise)", *connection, dataset, frames);
    return 0;
}

}  // namespace
}  // namespace mote::test

int main(int argc, char** argv) {
    try {
        return mote::test::run(argc, argv);
    } catch (const std::exception& failure) {
        std::fprintf(stderr, "bench-wire: %s\n", failure.what());
        return 1;
    }
}
