// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/e2e/orbiters.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "client/shared/connection.h"
#include "protocol/base/json.h"

namespace mote::test {
namespace {

using Clock = std::chrono::steady_clock;
using client::Connection;

constexpr std::chrono::minutes patience{1};

proto::View viewOf(std::string json) {
    std::replace(json.begin(), json.end(), '\'', '"');
    proto::View view;
    if (const auto parsed = parseJson(json, view, "view"); !parsed.ok())
        throw std::runtime_error(parsed.error().toString());
    return view;
}

void turn(proto::View& view, double radians) {
    auto& camera = *view.mutable_camera();
    camera.clear_eye();
    camera.add_eye(4.0 * std::sin(radians));
    camera.add_eye(0.0);
    camera.add_eye(4.0 * std::cos(radians));
}

}  // namespace

Orbiters::Orbiters(const std::filesystem::path& connectionFile, const std::string& view, int count)
    : pictures_(static_cast<std::size_t>(count)) {
    for (std::size_t i = 0; i < pictures_.size(); ++i) {
        threads_.emplace_back([this, connectionFile, view, i] { orbit(connectionFile, view, i); });
    }
}

Orbiters::~Orbiters() {
    stop();
}

void Orbiters::orbit(const std::filesystem::path& connectionFile, const std::string& json,
                     std::size_t index) {
    auto view = viewOf(json);
    Connection connection(connectionFile, {});
    connection.onViewFailed(
        [this](std::uint64_t, const Error& error) { complain("a view failed: " + error.toString()); });
    const auto begun = Clock::now();
    std::optional<Clock::time_point> latest;
    Seconds longest{0.0};
    const auto ask = [&] {
        turn(view, Seconds(Clock::now() - begun).count() + static_cast<double>(index));
        connection.setView(view, {.moving = true});
    };
    for (ask(); !stopping_; connection.wait(std::chrono::milliseconds(20))) {
        connection.poll();
        if (connection.state() == Connection::State::lost)
            return complain("lost: " + connection.lostReason().value_or(Error{}).toString());
        if (!connection.takeFrame()) continue;
        const auto now = Clock::now();
        if (latest && latest->time_since_epoch().count() >= since_)
            longest = std::max(longest, Seconds(now - *latest));
        latest = now;
        ++pictures_[index];
        ask();
    }
    const std::lock_guard lock(mutex_);
    longest_ = std::max(longest_, longest);
}

bool Orbiters::awaitPictures(int count) {
    std::vector<int> wanted;
    for (const auto& seen : pictures_) wanted.push_back(seen + count);
    const auto end = Clock::now() + patience;
    const auto all = [&] {
        return std::equal(pictures_.begin(), pictures_.end(), wanted.begin(), std::greater_equal<int>());
    };
    while (!all() && Clock::now() < end) std::this_thread::sleep_for(std::chrono::milliseconds(10));
    return all();
}

void Orbiters::stop() {
    stopping_ = true;
    for (auto& thread : threads_) thread.join();
    threads_.clear();
}

Orbiters::Seconds Orbiters::longestGap() {
    stop();
    return longest_;
}

std::string Orbiters::complaint() const {
    const std::lock_guard lock(mutex_);
    return complaint_;
}

void Orbiters::complain(const std::string& what) {
    const std::lock_guard lock(mutex_);
    complaint_ += what + "\n";
}

}  // namespace mote::test
