// SPDX-License-Identifier: GPL-3.0-or-later
//
// bench-survival: clients orbit a dataset while another asks for a view that kills the server; how long the
// longest of their waits for a picture was. A line for people.
#include <fmt/format.h>

#include <filesystem>
#include <thread>

#include "client/shared/connection.h"
#include "client/shared/server_line.h"
#include "protocol/cli/command.h"
#include "tests/e2e/orbiters.h"

namespace mote::bench {
namespace {

struct Options {
    std::filesystem::path dataset;
    std::string device = "cpu";
    int clients = 4, width = 1280, height = 720;
};

constexpr std::chrono::seconds settling{3};

/// 13 pixels wide: test-deadly-server dies of it.
void killUntilRefused(const std::filesystem::path& connectionFile) {
    client::Connection connection(connectionFile, {});
    std::optional<Error> refusal;
    connection.onViewFailed([&](std::uint64_t, const Error& error) { refusal = error; });
    proto::View view;
    view.set_width(13);
    view.set_height(16);
    connection.setView(view, {});
    while (!refusal) {
        connection.wait(std::chrono::milliseconds(20));
        connection.poll();
        if (connection.state() == client::Connection::State::lost)
            throw std::runtime_error("the server is gone");
    }
    fmt::print("the view that kills: {}\n", refusal->toString());
}

std::string viewOf(const Options& options) {
    return fmt::format(
        "{{'width': {}, 'height': {}, 'camera': {{'eye': [0, 0, 4], 'target': [0, 0, 0], 'up': [0, 1, 0]}}, "
        "'layers': [{{'dataset': 'data/{}', 'particles': {{}}}}]}}",
        options.width, options.height, options.dataset.stem().string());
}

int measure(const Options& options) {
    const client::Interrupt interrupt;
    const auto folder = std::filesystem::canonical(options.dataset).parent_path();
    const auto program = client::serverBesideUs().replace_filename("test-deadly-server");
    auto server = client::PrivateServer::start(
        "mote-bench", {program, {"data=" + folder.string()}, options.device}, interrupt);
    if (!server.ok()) throw std::runtime_error(server.error().toString());
    const auto connectionFile = (*server)->connectionFile();
    const auto run = [&](bool kills) {
        test::Orbiters orbiters(connectionFile, viewOf(options), options.clients);
        std::this_thread::sleep_for(settling);
        orbiters.forget();
        std::this_thread::sleep_for(settling);
        if (kills) killUntilRefused(connectionFile);
        std::this_thread::sleep_for(settling);
        const double gap = 1e3 * orbiters.longestGap().count();
        if (!orbiters.complaint().empty()) throw std::runtime_error(orbiters.complaint());
        return gap;
    };
    const double undisturbed = run(false);
    const double disturbed = run(true);
    fmt::print("{} clients, {} x {}: longest time without a picture {:.0f} ms; undisturbed {:.0f} ms\n",
               options.clients, options.width, options.height, disturbed, undisturbed);
    return 0;
}

}  // namespace
}  // namespace mote::bench

int main(int argc, char** argv) {
    mote::bench::Options options;
    const mote::cli::Program commandLine(
        "Clients orbit while a view kills the server: their longest wait for a picture", "bench-survival");
    const auto app = commandLine.command();
    app.option("dataset", options.dataset, "the folder NAME.mote of particles").required().folder();
    app.option("--device", options.device, "of the server");
    app.option("--clients", options.clients).range(1, 32);
    app.option("--width", options.width).range(16, 4096);
    app.option("--height", options.height).range(16, 4096);
    if (const auto end = commandLine.parse(argc, argv)) return *end;
    try {
        return mote::bench::measure(options);
    } catch (const std::exception& failure) {
        fmt::print(stderr, "bench-survival: {}\n", failure.what());
        return 1;
    }
}
