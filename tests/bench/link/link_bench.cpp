// SPDX-License-Identifier: GPL-3.0-or-later
//
// bench-link: a client that orbits a dataset through a shaped link, beside what the pictures have lost.
// Prints frames a second, from view to frame, bytes and PSNR; asserts nothing.
//
//   bench-link CONNECTION.json DATASET [--mbit 20] [--rtt 100] [--rate 60] [--seconds 10]
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <thread>

#include "client/shared/connection.h"
#include "protocol/cli/command.h"
#include "protocol/wire/address.h"
#include "protocol/wire/connection_file.h"
#include "tests/support/shaped_link.h"
#include "tests/support/temp_dir.h"

namespace mote::bench {
namespace {

using client::Connection;
using client::ReceivedFrame;
using Clock = std::chrono::steady_clock;

struct Settings {
    std::string connection, dataset;
    double megabits = 20.0;
    int roundTripMs = 100;
    double viewsPerSecond = 60.0;
    double seconds = 10.0;
};

struct Samples {
    std::vector<double> values;

    void add(double value) { values.push_back(value); }
    double quantile(double q) {
        if (values.empty()) return 0.0;
        std::sort(values.begin(), values.end());
        return values[static_cast<std::size_t>(q * static_cast<double>(values.size() - 1))];
    }
};

proto::View viewAt(const std::string& dataset, double angle) {
    proto::View view;
    view.set_width(1280);
    view.set_height(720);
    for (const double value : {4.0 * std::sin(angle), 0.5, 4.0 * std::cos(angle)}) {
        view.mutable_camera()->add_eye(value);
    }
    for (const double value : {0.0, 0.0, 0.0}) view.mutable_camera()->add_target(value);
    for (const double value : {0.0, 1.0, 0.0}) view.mutable_camera()->add_up(value);
    view.add_layers()->set_dataset(dataset);
    view.mutable_layers(0)->mutable_particles();
    return view;
}

/// A picture of less resolution is stretched, as the client does.
double psnr(const client::FramePixels& seen, const client::FramePixels& exact) {
    double sum = 0.0;
    for (std::size_t y = 0; y < exact.height; ++y) {
        for (std::size_t x = 0; x < exact.width; ++x) {
            const std::size_t from =
                y * seen.height / exact.height * seen.width + x * seen.width / exact.width;
            const std::size_t to = y * exact.width + x;
            for (std::size_t c = 0; c < 3; ++c) {
                const double difference = double{1.0} * seen.bytes[4 * from + c] - exact.bytes[4 * to + c];
                sum += difference * difference;
            }
        }
    }
    const auto samples = 0.75 * static_cast<double>(exact.bytes.size());
    return 10.0 * std::log10(255.0 * 255.0 * samples / std::max(sum, 1e-9));
}

ReceivedFrame await(Connection& connection, std::uint64_t view) {
    for (;;) {
        connection.wait(std::chrono::milliseconds(1000));
        connection.poll();
        if (connection.state() == Connection::State::lost)
            throw std::runtime_error(connection.lostReason()->toString());
        auto frame = connection.takeFrame();
        if (frame && frame->message.view_id() == view && frame->message.final()) return *std::move(frame);
    }
}

class LinkBench {
  public:
    explicit LinkBench(Settings settings) : settings_(std::move(settings)) {}

    void run() {
        auto server = wire::readConnectionFile(settings_.connection);
        if (!server.ok()) throw std::runtime_error(server.error().toString());
        const auto target = wire::parseAddress(server->address());
        if (!target.ok()) throw std::runtime_error(target.error().toString());
        const test::ShapedLink link(
            folder_ / "link.sock", target->path,
            {settings_.megabits * 1e6, std::chrono::milliseconds(settings_.roundTripMs / 2)});
        server->set_address("unix:" + (folder_ / "link.sock").string());
        const auto written = wire::writeConnectionFile(folder_ / "connection.json", *server);
        if (!written.ok()) throw std::runtime_error(written.error().toString());
        Connection connection(folder_ / "connection.json", {});
        orbit(connection, 2.0);  // quality and link are measured
        orbit(connection, settings_.seconds);
        report();
        rest(connection);
        compare();
    }

  private:
    void orbit(Connection& connection, double seconds) {
        frames_ = 0;
        latency_ = server_ = decode_ = bytes_ = {};
        encodings_.clear();
        const auto begun = Clock::now();
        const auto period = std::chrono::duration<double>(1.0 / settings_.viewsPerSecond);
        auto next = begun;
        while (Clock::now() - begun < std::chrono::duration<double>(seconds)) {
            while (Clock::now() < next) {
                connection.wait(
                    std::max(std::chrono::duration_cast<std::chrono::milliseconds>(next - Clock::now()),
                             std::chrono::milliseconds(1)));
                connection.poll();
                if (auto frame = connection.takeFrame()) take(*std::move(frame));
            }
            next += std::chrono::duration_cast<Clock::duration>(period);
            angle_ += 0.5 / settings_.viewsPerSecond;  // half a radian a second
            angles_[connection.setView(viewAt(settings_.dataset, angle_), {.moving = true})] = angle_;
        }
        seconds_ = seconds;
    }

    void take(ReceivedFrame frame) {
        const auto& m = frame.message;
        ++frames_;
        latency_.add(frame.latencyMs);
        server_.add(m.plan_ms() + m.render_ms() + m.encode_ms());
        decode_.add(frame.decodeMs);
        bytes_.add(static_cast<double>(frame.payloadBytes) / 1024.0);
        encodings_[proto::Frame::Encoding_Name(m.encoding())] += 1;
        linkRate_ = m.link_bytes_per_second();
        if (frames_ % 30 == 5 && kept_.size() < 8) kept_.push_back(std::move(frame));
    }

    void report() {
        fmt::print("{} Mbit/s, round trip {} ms, {} views/s, {}: the server measures {:.1f} Mbit/s\n",
                   settings_.megabits, settings_.roundTripMs, settings_.viewsPerSecond, settings_.dataset,
                   8e-6 * linkRate_);
        fmt::print(
            "  frames/s {:.1f}; ms p50/p99: view to frame {:.1f}/{:.1f}, plan+render+encode {:.1f}/{:.1f}, "
            "decode {:.1f}/{:.1f}\n",
            static_cast<double>(frames_) / seconds_, latency_.quantile(0.5), latency_.quantile(0.99),
            server_.quantile(0.5), server_.quantile(0.99), decode_.quantile(0.5), decode_.quantile(0.99));
        fmt::print("  KiB a frame p50/p99 {:.0f}/{:.0f};", bytes_.quantile(0.5), bytes_.quantile(0.99));
        for (const auto& [name, count] : encodings_) fmt::print(" {} {}", count, name);
        fmt::print("\n");
    }

    /// From the last view in motion to the exact picture.
    void rest(Connection& connection) {
        const auto begun = Clock::now();
        const auto frame = await(connection, connection.setView(viewAt(settings_.dataset, angle_), {}));
        fmt::print("  at rest: exact and lossless ({} KiB) after {:.0f} ms\n", frame.payloadBytes / 1024,
                   std::chrono::duration<double, std::milli>(Clock::now() - begun).count());
    }

    /// Without the link between, the exact pictures of some views that were seen in motion.
    void compare() {
        Connection direct(settings_.connection, {});
        double sum = 0.0, fraction = 0.0, width = 0.0;
        for (const auto& seen : kept_) {
            const double angle = angles_.at(seen.message.view_id());
            const auto exact =
                await(direct, direct.setView(viewAt(settings_.dataset, angle), {.finalOnly = true}));
            sum += psnr(seen.pixels, exact.pixels);
            fraction += seen.message.point_fraction();
            width += seen.message.width();
        }
        const auto count = static_cast<double>(std::max<std::size_t>(kept_.size(), 1));
        fmt::print(
            "  PSNR in motion against the exact pictures {:.1f} dB, {:.2f} of the points, {:.0f} pixels wide "
            "({} frames)\n",
            sum / count, fraction / count, width / count, kept_.size());
    }

    const Settings settings_;
    const test::TempDir folder_;
    double angle_ = 0.0, seconds_ = 0.0, linkRate_ = 0.0;
    std::size_t frames_ = 0;
    Samples latency_, server_, decode_, bytes_;
    std::map<std::string, int> encodings_;
    std::map<std::uint64_t, double> angles_;  // by view
    std::vector<ReceivedFrame> kept_;
};

}  // namespace
}  // namespace mote::bench

int main(int argc, char** argv) {
    mote::bench::Settings settings;
    const mote::cli::Program commandLine("Orbits a dataset through a link of some rate and delay.",
                                         "bench-link");
    const auto app = commandLine.command();
    app.option("connection", settings.connection, "connection file of a running server").required();
    app.option("dataset", settings.dataset, "ROOT/NAME").required();
    app.option("--mbit", settings.megabits, "rate of the link, Mbit/s");
    app.option("--rtt", settings.roundTripMs, "round trip of the link, ms");
    app.option("--rate", settings.viewsPerSecond, "views a second that the hand asks for");
    app.option("--seconds", settings.seconds, "measured");
    if (const auto end = commandLine.parse(argc, argv)) return *end;
    try {
        mote::bench::LinkBench(settings).run();
        return 0;
    } catch (const std::exception& failure) {
        fmt::print(stderr, "bench-link: {}\n", failure.what());
        return 1;
    }
}
