// SPDX-License-Identifier: GPL-3.0-or-later
//
// OrbitClient: a hand that orbits a dataset through a real connection, and what it sees: how many pictures a
// second, how late, how good. One owner, one thread.
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "client/shared/connection.h"
#include "protocol/scene/bounds.h"

namespace mote::bench {

struct OrbitSettings {
    std::string dataset;  ///< "ROOT/NAME"
    std::uint32_t width = 1280;
    std::uint32_t height = 720;
    Bounds bounds{glm::dvec3(-1.0), glm::dvec3(1.0)};  ///< of the dataset, layer space
    std::optional<proto::HybridStyle> hybrid;          ///< of a hybrid volume; absent: of particles
    std::optional<proto::InkStyle> ink;                ///< of a mesh, likewise
    bool allPoints = false;        ///< of particles: no volume, every point; else the default style
    double degreesPerSecond = 30;  ///< of the hand
    double closer = 1;             ///< how many times nearer than where all of the dataset is seen
    std::optional<double> rate;    ///< views a second; absent: a new view for each frame that came
};

/// One frame as it arrived.
struct Seen {
    double latencyMs = 0.0;  ///< from its view to the decoded picture
    double queuedMs = 0.0, planMs = 0.0, renderMs = 0.0, encodeMs = 0.0, decodeMs = 0.0;
    double width = 0.0;  ///< pixels
    double pointsDrawn = 0.0;
    double pointFraction = 0.0;
    double payloadBytes = 0.0;
    std::string encoding;
    bool final = false;
};

class OrbitClient {
  public:
    using Seconds = std::chrono::duration<double>;

    /// Throws std::runtime_error where there is no connection.
    OrbitClient(const std::filesystem::path& connectionFile, OrbitSettings settings);

    struct First {
        double anyMs = 0.0;    ///< until a picture
        double finalMs = 0.0;  ///< until the exact one
    };
    /// These throw std::runtime_error: the connection was lost, a view failed, or nothing came for a minute.
    First firstPicture();
    struct Orbit {
        std::vector<Seen> frames;
        double seconds = 0.0;
    };
    Orbit orbit(Seconds duration);
    /// From the last moving view to the exact picture; all frames on the way, the exact one last.
    struct Rest {
        double ms = 0.0;
        std::vector<Seen> frames;
    };
    Rest rest();
    /// Steps 0 to `steps`, again and again; the next where the one before is seen.
    Orbit play(std::uint32_t steps, Seconds duration);

  private:
    using Clock = std::chrono::steady_clock;

    std::uint64_t show(std::uint32_t step, bool moving);
    void setStyle(proto::Layer& layer) const;
    std::optional<client::ReceivedFrame> next(Clock::time_point until);
    /// Waits for a frame of this view or a later one, an exact one if asked for.
    client::ReceivedFrame need(std::uint64_t view, bool final, std::vector<Seen>* seen);

    OrbitSettings settings_;
    std::optional<std::string> failure_;
    Clock::time_point begun_ = Clock::now();
    client::Connection connection_;
};

/// The value below which a share `q` of them lie; 0 where there are none.
double quantile(std::vector<double> values, double q);

}  // namespace mote::bench
