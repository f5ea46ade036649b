// SPDX-License-Identifier: GPL-3.0-or-later
//
// A client behind a thin line and one beside the server: what each is sent before its link is known, that the
// stream goes on, and that both end with the same picture. What a measured link gets is decided by how fast
// the machine is, too: tests/unit/session/flow_control_test.cpp asks that of simulated links.
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "client/shared/connection.h"
#include "protocol/wire/address.h"
#include "protocol/wire/connection_file.h"
#include "tests/e2e/station.h"
#include "tests/support/shaped_link.h"

namespace mote::test {
namespace {

using client::Connection;
using client::ReceivedFrame;

proto::View beamAt(double angle) {
    proto::View view;
    view.set_width(1280);
    view.set_height(960);
    for (const double value : {1.5 * std::sin(angle), 0.0, 1.5 * std::cos(angle)}) {
        view.mutable_camera()->add_eye(value);
    }
    for (const double value : {0.0, 0.0, 0.0}) view.mutable_camera()->add_target(value);
    for (const double value : {0.0, 1.0, 0.0}) view.mutable_camera()->add_up(value);
    view.add_layers()->set_dataset("data/beam");
    // Every point a disc with a soft edge: a picture that lossless coding can do little about.
    auto& points = *view.mutable_layers(0)->mutable_particles()->mutable_points();
    points.set_linked(false);
    auto& everything = *points.add_curve();
    everything.set_density(0.0);
    everything.set_fraction(1.0);
    points.set_opacity(0.5);
    points.set_size_pixels(4.5);
    return view;
}

/// Waits for a frame; fails the test where none comes.
ReceivedFrame nextFrame(Connection& connection) {
    const auto end = std::chrono::steady_clock::now() + Process::patience;
    while (std::chrono::steady_clock::now() < end) {
        connection.wait(std::chrono::milliseconds(50));
        connection.poll();
        if (auto frame = connection.takeFrame()) return *std::move(frame);
    }
    ADD_FAILURE() << "no frame came";
    return {};
}

/// Turns the view, at least until the link has been measured; how the pictures in motion were encoded.
std::vector<proto::Frame::Encoding> turn(Connection& connection) {
    std::vector<proto::Frame::Encoding> encodings;
    bool measured = false;
    for (int i = 0; i < 400 && (i < 5 || !measured); ++i) {
        connection.setView(beamAt(0.01 * i), {.moving = true});
        const auto frame = nextFrame(connection);
        if (testing::Test::HasFailure()) break;
        encodings.push_back(frame.message.encoding());
        measured = frame.message.link_bytes_per_second() > 0.0;
    }
    EXPECT_TRUE(measured);
    return encodings;
}

ReceivedFrame atRest(Connection& connection) {
    const auto id = connection.setView(beamAt(1.0), {});
    for (;;) {
        auto frame = nextFrame(connection);
        if (testing::Test::HasFailure()) return frame;
        if (frame.message.view_id() == id && frame.message.final()) return frame;
    }
}

TEST(Link, ThinOrWideItEndsWithTheSamePicture) {
    Station station;
    station.startServer();
    auto file = wire::readConnectionFile(station.connection());
    ASSERT_TRUE(file.ok()) << file.error().toString();
    const auto socket = station.temporary() / "link.sock";
    const ShapedLink link(socket, wire::parseAddress(file->address())->path,
                          {5e5, std::chrono::milliseconds(20)});
    file->set_address("unix:" + socket.string());
    ASSERT_TRUE(wire::writeConnectionFile(station.temporary() / "thin.json", *file).ok());

    Connection thin(station.temporary() / "thin.json", {});
    EXPECT_EQ(turn(thin).at(0), proto::Frame::H264);
    const auto far = atRest(thin);
    Connection wide(station.connection(), {});
    EXPECT_EQ(turn(wide).at(0), proto::Frame::H264);
    const auto near = atRest(wide);
    EXPECT_EQ(far.message.encoding(), proto::Frame::ZSTD);
    EXPECT_EQ(far.pixels.width, 1280u);
    EXPECT_TRUE(far.pixels.bytes == near.pixels.bytes);
    // It is not over: the stream goes on after a picture that was none of it.
    EXPECT_GE(turn(thin).size(), 5u);
}

}  // namespace
}  // namespace mote::test
