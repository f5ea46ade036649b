// SPDX-License-Identifier: GPL-3.0-or-later
//
// bench-orbit: what a client sees of a real server on this machine's loopback: the first picture, an orbit,
// the way to the exact picture once the hand rests, and what the server then still takes; or the steps of a
// dataset, played. Of a mesh, a drawing in ink. A table for people.
#include <fmt/format.h>

#include <map>
#include <thread>

#include "client/shared/server_line.h"
#include "protocol/cli/command.h"
#include "protocol/scene/dataset.h"
#include "protocol/wire/connection_file.h"
#include "server/render/layers/hybrid/hybrid_load.h"
#include "storage/manifest.h"
#include "tests/bench/orbit/orbit_client.h"
#include "tests/bench/orbit/page_cache.h"
#include "tests/bench/orbit/server_watch.h"

namespace mote::bench {
namespace {

struct Options {
    OrbitSettings orbit;
    std::filesystem::path dataset;
    std::optional<std::filesystem::path> connection;
    std::string device = "cpu", representation;
    double seconds = 5.0;
    bool cold = false, play = false, ink = false;
};

/// The settling of quality is left out.
constexpr std::chrono::seconds settling{1};
constexpr std::chrono::seconds resting{2};

template <class Get>
double middle(const std::vector<Seen>& frames, Get get, double q = 0.5) {
    std::vector<double> values;
    values.reserve(frames.size());
    for (const auto& frame : frames) values.push_back(frame.*get);
    return quantile(std::move(values), q);
}

std::string encodings(const std::vector<Seen>& frames) {
    std::map<std::string, std::size_t> counts;
    for (const auto& frame : frames) ++counts[frame.encoding];
    std::string text;
    for (const auto& [name, count] : counts) text += fmt::format(" {} {}", name, count);
    return text;
}

void print(const char* what, const OrbitClient::Orbit& seen) {
    const auto& f = seen.frames;
    fmt::print("{}: {:.1f} a second ({} in {:.1f} s)\n", what, static_cast<double>(f.size()) / seen.seconds,
               f.size(), seen.seconds);
    fmt::print("  view to frame, ms: p50 {:.1f}, p99 {:.1f}, worst {:.1f}\n", middle(f, &Seen::latencyMs),
               middle(f, &Seen::latencyMs, 0.99), middle(f, &Seen::latencyMs, 1.0));
    fmt::print(
        "  of which, medians: queued {:.2f}, plan {:.2f}, render {:.2f}, encode {:.2f}, decode {:.2f}\n",
        middle(f, &Seen::queuedMs), middle(f, &Seen::planMs), middle(f, &Seen::renderMs),
        middle(f, &Seen::encodeMs), middle(f, &Seen::decodeMs));
    fmt::print("  quality, medians: {:.0f} pixels wide, {:.0f} points ({:.1f}%), {:.0f} KB;{}\n",
               middle(f, &Seen::width), middle(f, &Seen::pointsDrawn),
               100.0 * middle(f, &Seen::pointFraction), middle(f, &Seen::payloadBytes) / 1e3, encodings(f));
}

void printServer(pid_t server) {
    const auto memory = residentMemory(server);
    fmt::print("server's memory: {:.0f} MB of its own, {:.0f} MB of files\n",
               static_cast<double>(memory.anonymous) / 1e6, static_cast<double>(memory.mapped) / 1e6);
}

void printRest(OrbitClient& client, pid_t server) {
    const auto rest = client.rest();
    const auto& last = rest.frames.back();
    fmt::print(
        "from rest to the exact picture: {:.0f} ms in {} frames; the last: render {:.0f} ms, {:.0f} points\n",
        rest.ms, rest.frames.size(), last.renderMs, last.pointsDrawn);
    std::this_thread::sleep_for(settling);
    const auto before = processorTime(server);
    std::this_thread::sleep_for(resting);
    fmt::print("at rest the server takes {:.1f}% of a core\n",
               100.0 * (processorTime(server) - before) / std::chrono::duration<double>(resting));
}

/// The whole of a dataset, in the style that was asked for.
OrbitSettings settingsOf(const Options& options, const proto::Manifest& manifest) {
    OrbitSettings settings = options.orbit;
    if (manifest.kind() == "mesh") settings.bounds = datasetBounds(manifest);
    if (manifest.has_hybrid()) settings.bounds = render::hybridBounds(manifest.hybrid());
    if (options.ink || manifest.kind() == "mesh") {
        settings.ink.emplace();
    } else if (manifest.has_hybrid()) {
        settings.hybrid.emplace().set_representation(options.representation);
    }
    return settings;
}

/// Throws std::runtime_error.
int measure(const Options& options, const std::filesystem::path& connection) {
    const auto file = wire::readConnectionFile(connection);
    if (!file.ok()) throw std::runtime_error(file.error().toString());
    const auto server = static_cast<pid_t>(file->pid());
    const auto manifest = storage::readManifest(options.dataset);
    if (!manifest.ok()) throw std::runtime_error(manifest.error().toString());
    OrbitClient client(connection, settingsOf(options, *manifest));
    if (options.cold) evict(options.dataset);
    fmt::print("{} x {}, {}; {:.0f}% of it in the page cache\n", options.orbit.width, options.orbit.height,
               options.dataset.filename().string(), 100.0 * cachedShare(options.dataset));
    const auto first = client.firstPicture();
    fmt::print("first picture after {:.0f} ms, the exact one after {:.0f} ms\n", first.anyMs, first.finalMs);
    const OrbitClient::Seconds duration(options.seconds);
    if (options.play) {
        const int ofHybrid = manifest->hybrid().steps_size();
        const auto steps =
            static_cast<std::uint32_t>(ofHybrid > 0 ? ofHybrid : manifest->particles().steps_size());
        client.play(steps, settling);
        print("steps played", client.play(steps, duration));
    } else {
        client.orbit(settling);
        print("frames of an orbit", client.orbit(duration));
        printRest(client, server);
    }
    printServer(server);
    return 0;
}

int serveAndMeasure(const Options& options) {
    if (options.connection) return measure(options, *options.connection);
    const client::Interrupt interrupt;
    const auto folder = std::filesystem::canonical(options.dataset).parent_path();
    auto server = client::PrivateServer::start(
        "mote-bench", {client::serverBesideUs(), {"data=" + folder.string()}, options.device}, interrupt);
    if (!server.ok()) throw std::runtime_error(server.error().toString());
    return measure(options, (*server)->connectionFile());
}

void addOptions(const mote::cli::Command& app, Options& options) {
    app.option("dataset", options.dataset, "the folder NAME.mote").required().folder();
    app.option("--connect", options.connection,
               "a running server's file; the dataset's folder is its root \"data\"");
    app.option("--device", options.device, "of the server that is started here: cpu, egl or auto");
    app.option("--seconds", options.seconds, "of the orbit").range(0.5, 3600.0);
    app.option("--rate", options.orbit.rate, "views a second; otherwise a new one for each frame")
        .range(1.0, 1000.0);
    app.option("--width", options.orbit.width, "pixels").range(16, 8192);
    app.option("--height", options.orbit.height, "pixels").range(16, 4096);
    app.option("--degrees", options.orbit.degreesPerSecond, "a second, of the hand").range(0.0, 720.0);
    app.option("--closer", options.orbit.closer, "how many times nearer than where all of it is seen")
        .range(0.1, 100.0);
    app.option("--representation", options.representation,
               "of a hybrid volume: points, residual or volume; else the best that it has");
    app.flag("--ink", options.ink, "a drawing of it, as of a mesh");
    app.flag("--all-points", options.orbit.allPoints,
             "of particles: every point and no volume; else the default style");
    app.flag("--cold", options.cold, "take the dataset out of the page cache first");
    app.flag("--play", options.play, "play the dataset's steps instead");
}

}  // namespace
}  // namespace mote::bench

int main(int argc, char** argv) {
    mote::bench::Options options;
    const mote::cli::Program commandLine("What a client sees of a real server on loopback", "bench-orbit");
    const auto app = commandLine.command();
    mote::bench::addOptions(app, options);
    if (const auto end = commandLine.parse(argc, argv)) return *end;
    options.orbit.dataset =
        "data/" + std::filesystem::path(options.dataset / "").parent_path().stem().string();
    try {
        return mote::bench::serveAndMeasure(options);
    } catch (const std::exception& failure) {
        fmt::print(stderr, "bench-orbit: {}\n", failure.what());
        return 1;
    }
}
