// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/bench/orbit/orbit_client.h"

#include <algorithm>
#include <cmath>
#include <glm/trigonometric.hpp>
#include <stdexcept>

#include "protocol/scene/camera.h"

namespace mote::bench {
namespace {

constexpr std::chrono::minutes patience{1};

client::ConnectionSettings named() {
    client::ConnectionSettings settings;
    settings.client = "bench-orbit";
    return settings;
}

Seen seenOf(const client::ReceivedFrame& frame) {
    const auto& message = frame.message;
    return {frame.latencyMs,
            message.queued_ms(),
            message.plan_ms(),
            message.render_ms(),
            message.encode_ms(),
            frame.decodeMs,
            static_cast<double>(message.width()),
            static_cast<double>(message.points_drawn()),
            message.point_fraction(),
            static_cast<double>(frame.payloadBytes),
            proto::Frame::Encoding_Name(message.encoding()),
            message.final()};
}

double milliseconds(std::chrono::steady_clock::duration time) {
    return std::chrono::duration<double, std::milli>(time).count();
}

}  // namespace

double quantile(std::vector<double> values, double q) {
    if (values.empty()) return 0.0;
    std::sort(values.begin(), values.end());
    return values[static_cast<std::size_t>(std::ceil(q * static_cast<double>(values.size() - 1)))];
}

OrbitClient::OrbitClient(const std::filesystem::path& connectionFile, OrbitSettings settings)
    : settings_(std::move(settings)), connection_(connectionFile, named()) {
    connection_.onViewFailed([this](std::uint64_t, const Error& error) { failure_ = error.toString(); });
    const auto until = Clock::now() + patience;
    while (connection_.state() == client::Connection::State::connecting && Clock::now() < until) {
        connection_.wait(std::chrono::milliseconds(100));
        connection_.poll();
    }
    if (connection_.state() == client::Connection::State::connected) return;
    const auto reason = connection_.lostReason();
    throw std::runtime_error(reason ? reason->toString() : "no connection within a minute");
}

std::uint64_t OrbitClient::show(std::uint32_t step, bool moving) {
    const double seconds = std::chrono::duration<double>(Clock::now() - begun_).count();
    const double angle = glm::radians(settings_.degreesPerSecond * seconds);
    proto::View view;
    view.set_width(settings_.width);
    view.set_height(settings_.height);
    Camera camera = fitCamera(settings_.bounds, double{1.0} * settings_.width / settings_.height);
    const glm::dvec3 arm = (camera.eye - camera.target) / settings_.closer;
    camera.eye = camera.target + glm::dvec3(std::cos(angle) * arm.x + std::sin(angle) * arm.z, arm.y,
                                            std::cos(angle) * arm.z - std::sin(angle) * arm.x);
    *view.mutable_camera() = toProto(camera);
    auto& layer = *view.add_layers();
    layer.set_dataset(settings_.dataset);
    layer.set_step(step);
    setStyle(layer);
    return connection_.setView(view, {.moving = moving});
}

void OrbitClient::setStyle(proto::Layer& layer) const {
    if (settings_.hybrid) {
        *layer.mutable_hybrid() = *settings_.hybrid;
        return;
    }
    if (settings_.ink) {
        *layer.mutable_ink() = *settings_.ink;
        return;
    }
    auto& particles = *layer.mutable_particles();
    if (settings_.allPoints) {
        particles.mutable_volume()->add_curve()->set_opacity(0.0);
        particles.mutable_points()->set_linked(false);
        particles.mutable_points()->add_curve()->set_fraction(1.0);
    }
}

std::optional<client::ReceivedFrame> OrbitClient::next(Clock::time_point until) {
    for (;;) {
        connection_.poll();
        if (failure_) throw std::runtime_error(*failure_);
        if (const auto lost = connection_.lostReason()) throw std::runtime_error(lost->toString());
        if (auto frame = connection_.takeFrame()) return frame;
        const auto now = Clock::now();
        if (now >= until) return std::nullopt;
        // Rounded up: a wait of no milliseconds would spin.
        connection_.wait(std::chrono::ceil<std::chrono::milliseconds>(until - now));
    }
}

client::ReceivedFrame OrbitClient::need(std::uint64_t view, bool final, std::vector<Seen>* seen) {
    const auto until = Clock::now() + patience;
    while (auto frame = next(until)) {
        if (frame->message.view_id() < view) continue;
        if (seen != nullptr) seen->push_back(seenOf(*frame));
        if (!final || frame->message.final()) return *std::move(frame);
    }
    throw std::runtime_error("no frame within a minute");
}

OrbitClient::First OrbitClient::firstPicture() {
    const auto start = Clock::now();
    const std::uint64_t view = show(0, false);
    First first;
    const bool done = need(view, false, nullptr).message.final();
    first.anyMs = first.finalMs = milliseconds(Clock::now() - start);
    if (!done) {
        need(view, true, nullptr);
        first.finalMs = milliseconds(Clock::now() - start);
    }
    return first;
}

OrbitClient::Orbit OrbitClient::orbit(Seconds duration) {
    Orbit seen;
    const auto start = Clock::now();
    const auto end = start + std::chrono::duration_cast<Clock::duration>(duration);
    const auto pause =
        std::chrono::duration_cast<Clock::duration>(Seconds(1.0 / settings_.rate.value_or(1.0)));
    auto due = start;
    while (Clock::now() < end) {
        if (settings_.rate) {
            if (Clock::now() >= due) {
                show(0, true);
                due = std::max(due + pause, Clock::now());
            }
            if (auto frame = next(std::min(due, end))) seen.frames.push_back(seenOf(*frame));
        } else {
            need(show(0, true), false, &seen.frames);
        }
    }
    seen.seconds = std::chrono::duration<double>(Clock::now() - start).count();
    return seen;
}

OrbitClient::Rest OrbitClient::rest() {
    Rest seen;
    const auto start = Clock::now();
    need(show(0, false), true, &seen.frames);
    seen.ms = milliseconds(Clock::now() - start);
    return seen;
}

OrbitClient::Orbit OrbitClient::play(std::uint32_t steps, Seconds duration) {
    Orbit seen;
    const auto start = Clock::now();
    for (std::uint32_t step = 0; Clock::now() - start < duration; step = (step + 1) % steps)
        need(show(step, true), false, &seen.frames);
    seen.seconds = std::chrono::duration<double>(Clock::now() - start).count();
    return seen;
}

}  // namespace mote::bench
