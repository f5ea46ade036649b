// SPDX-License-Identifier: GPL-3.0-or-later
//
// What is counted of messages, and the text that Prometheus reads.
#include <gtest/gtest.h>

#include <sstream>

#include "server/metrics/exposition.h"
#include "server/metrics/metrics.h"

namespace mote::server {
namespace {

proto::ServerMessage frame(bool final, std::uint64_t begin) {
    proto::ServerMessage message;
    auto& frame = *message.mutable_frame();
    frame.set_final(final);
    frame.set_render_ms(30.0);
    frame.set_total_ms(120000.0);
    frame.set_payload_begin(begin);
    return message;
}

/// The value of a series, as its line has it.
double valueOf(const std::string& text, const std::string& series) {
    std::istringstream lines(text);
    for (std::string line; std::getline(lines, line);) {
        if (line.starts_with(series + " ")) return std::stod(line.substr(series.size() + 1));
    }
    ADD_FAILURE() << series << " is not in\n" << text;
    return -1.0;
}

TEST(Metrics, CountFramesOnceAndBytesOfAllPieces) {
    Metrics metrics;
    metrics.countSent(frame(false, 0), 1000);
    metrics.countSent(frame(true, 0), 1000);
    metrics.countSent(frame(true, 1000), 500);
    EXPECT_EQ(metrics.framesMoving.value(), 1u);
    EXPECT_EQ(metrics.framesFinal.value(), 1u);
    EXPECT_GT(metrics.bytesSent.value(), 2500u);
    const auto text = toPrometheus(metrics, {});
    EXPECT_EQ(valueOf(text, "mote_frame_seconds_bucket{part=\"render\",le=\"0.02\"}"), 0);
    EXPECT_EQ(valueOf(text, "mote_frame_seconds_bucket{part=\"render\",le=\"0.05\"}"), 2);
    EXPECT_EQ(valueOf(text, "mote_frame_seconds_count{part=\"render\"}"), 2);
    EXPECT_NEAR(valueOf(text, "mote_frame_seconds_sum{part=\"render\"}"), 0.06, 1e-5);
    EXPECT_EQ(valueOf(text, "mote_frame_seconds_bucket{part=\"total\",le=\"60\"}"), 0);
    EXPECT_EQ(valueOf(text, "mote_frame_seconds_bucket{part=\"total\",le=\"+Inf\"}"), 2);
    EXPECT_EQ(valueOf(text, "mote_frames_total{final=\"true\"}"), 1);
}

TEST(Metrics, CountFailuresByTheirCode) {
    Metrics metrics;
    proto::ServerMessage message;
    message.mutable_failure()->set_code("not_found");
    metrics.countSent(message, 0);
    message.mutable_failure()->set_code("internal");
    metrics.countSent(message, 0);
    metrics.countSent(message, 0);
    const auto text = toPrometheus(metrics, {});
    EXPECT_EQ(valueOf(text, "mote_errors_total{code=\"not_found\"}"), 1);
    EXPECT_EQ(valueOf(text, "mote_errors_total{code=\"internal\"}"), 2);
    EXPECT_EQ(valueOf(text, "mote_errors_total{code=\"corrupt\"}"), 0);
}

TEST(Metrics, TellWhatIsNow) {
    Gauges gauges;
    gauges.version = "0.1";
    gauges.device = "a \"device\"\n of \\ odd name";
    gauges.sessions = 3;
    gauges.jobs = {{"queued", 2}, {"running", 1}};
    gauges.dataLimit = std::uint64_t{1} << 40;
    gauges.healthy = false;
    const auto text = toPrometheus(Metrics(), gauges);
    EXPECT_EQ(valueOf(text, "mote_sessions"), 3);
    EXPECT_EQ(valueOf(text, "mote_jobs{state=\"queued\"}"), 2);
    EXPECT_EQ(valueOf(text, "mote_data_limit_bytes"), 0x1p40);
    EXPECT_EQ(valueOf(text, "mote_healthy"), 0);
    EXPECT_GT(valueOf(text, "process_resident_memory_bytes"), 1e6);
    EXPECT_GT(valueOf(text, "process_open_fds"), 2);
    EXPECT_EQ(valueOf(text, R"(mote_info{version="0.1",device="a \"device\"\n of \\ odd name"})"), 1);
}

}  // namespace
}  // namespace mote::server
