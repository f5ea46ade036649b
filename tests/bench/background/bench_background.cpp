// SPDX-License-Identifier: GPL-3.0-or-later
//
// bench-background: how much a film that is made in the background takes from a hand that orbits: pictures a
// second, and how late a picture is of a hand that moves now and then; each beside what it is without the
// film, and the film's own pictures a second beside those of a film that has the server to itself. A table
// for people.
#include <fmt/format.h>

#include <atomic>
#include <cmath>
#include <thread>

#include "client/shared/server_line.h"
#include "protocol/cli/command.h"
#include "protocol/wire/address.h"
#include "protocol/wire/connection_file.h"
#include "tests/bench/orbit/orbit_client.h"
#include "tests/unit/session/test_client.h"

namespace mote::bench {
namespace {

struct Options {
    OrbitSettings orbit;
    std::filesystem::path dataset;
    std::optional<std::filesystem::path> connection;
    std::string device = "cpu";
    double seconds = 4.0;
    int rounds = 5;
};

constexpr std::chrono::seconds settling{1};
constexpr double nowAndThen = 2.0;  // views a second

/// Film: a client that asks for exact pictures of a turning view, as many at a time as may wait, on a thread
/// of its own.
class Film {
  public:
    Film(const proto::ConnectionFile& connection, const OrbitSettings& view)
        : client_(wire::parseAddress(connection.address())->path), view_(view) {
        if (!client_.connect(connection.token(), true).message.has_welcome())
            throw std::runtime_error("the film is not welcome");
        for (std::uint32_t i = 0; i < wire::maxQueuedViews; ++i) ask();
        thread_ = std::thread([this] { make(); });
    }
    ~Film() {
        client_.shutdownSend();
        thread_.join();
    }
    Film(const Film&) = delete;
    Film& operator=(const Film&) = delete;

    int pictures() const { return pictures_; }

  private:
    void ask() {
        proto::ClientMessage message;
        auto& set = *message.mutable_set_view();
        set.set_view_id(++asked_);
        set.set_final_only(true);
        set.set_queued(true);
        auto& view = *set.mutable_view();
        view.set_width(view_.width);
        view.set_height(view_.height);
        const double angle = 0.02 * static_cast<double>(asked_);
        for (const double value : {4.0 * std::sin(angle), 0.5, 4.0 * std::cos(angle)})
            view.mutable_camera()->add_eye(value);
        for (const double value : {0.0, 0.0, 0.0}) view.mutable_camera()->add_target(value);
        for (const double value : {0.0, 1.0, 0.0}) view.mutable_camera()->add_up(value);
        view.add_layers()->set_dataset(view_.dataset);
        view.mutable_layers(0)->mutable_particles();
        client_.send(message);
    }

    void make() {
        try {
            while (const auto received = client_.receive()) {
                if (received->message.has_failure()) {
                    fmt::print(stderr, "bench-background: {}\n", received->message.failure().message());
                }
                if (!received->message.has_frame()) continue;
                ++pictures_;
                client_.credit(1);
                ask();
            }
        } catch (const std::exception& failure) {
            fmt::print(stderr, "bench-background: the film: {}\n", failure.what());
        }
    }

    test::TestClient client_;
    OrbitSettings view_;
    std::uint64_t asked_ = 0;
    std::atomic<int> pictures_ = 0;
    std::thread thread_;
};

struct Hand {
    double rate = 0.0, median = 0.0, late = 0.0, worst = 0.0;  ///< pictures a second; ms
};

/// Series: what the rounds gave of one situation.
struct Series {
    std::vector<Hand> hands;
    std::vector<double> films;  ///< pictures a second

    void add(const std::optional<Hand>& hand, std::optional<double> film) {
        if (hand) hands.push_back(*hand);
        if (film) films.push_back(*film);
    }
    double middle(double Hand::*value) const {
        std::vector<double> values;
        for (const auto& hand : hands) values.push_back(hand.*value);
        return quantile(values, 0.5);
    }
    void print(const char* what) const {
        fmt::print("{:34}", what);
        for (const auto value : {&Hand::rate, &Hand::median, &Hand::late, &Hand::worst})
            fmt::print(" {:>8}", hands.empty() ? "" : fmt::format("{:.1f}", middle(value)));
        fmt::print(" {:>8}\n", films.empty() ? "" : fmt::format("{:.2f}", quantile(films, 0.5)));
    }
};

class Bench {
  public:
    Bench(std::filesystem::path connectionFile, const Options& options)
        : file_(std::move(connectionFile)), options_(options) {
        const auto connection = wire::readConnectionFile(file_);
        if (!connection.ok()) throw std::runtime_error(connection.error().toString());
        connection_ = *connection;
    }

    /// In turns, as the machine may have other work: what is told is the median of the rounds.
    void run() {
        OrbitClient(file_, options_.orbit).firstPicture();
        Series alone, beside, aloneNow, besideNow, filmAlone;
        std::vector<double> ratios;
        for (int round = 0; round < options_.rounds; ++round) {
            alone.add(hand({}), {});
            Hand seen;
            const double film = filmWhile([&] { seen = hand({}); });
            beside.add(seen, film);
            ratios.push_back(beside.hands.back().rate / alone.hands.back().rate);
            aloneNow.add(hand(nowAndThen), {});
            const double filmNow = filmWhile([&] { seen = hand(nowAndThen); });
            besideNow.add(seen, filmNow);
            filmAlone.add(std::nullopt, filmWhile([&] { std::this_thread::sleep_for(duration()); }));
        }
        fmt::print("{:34} {:>8} {:>8} {:>8} {:>8} {:>8}\n", "", "hand, /s", "p50 ms", "p99 ms", "worst",
                   "film, /s");
        alone.print("a hand that orbits");
        beside.print("  beside a film");
        aloneNow.print("a hand that moves now and then");
        besideNow.print("  beside a film");
        filmAlone.print("a film alone");
        fmt::print("frame rate beside a film, of that without: {:.0f}% ({:.0f}% to {:.0f}%)\n",
                   100.0 * quantile(ratios, 0.5), 100.0 * quantile(ratios, 0.0),
                   100.0 * quantile(ratios, 1.0));
    }

  private:
    OrbitClient::Seconds duration() const { return OrbitClient::Seconds(options_.seconds); }

    Hand hand(std::optional<double> rate) {
        auto settings = options_.orbit;
        settings.rate = rate;
        OrbitClient client(file_, settings);
        client.orbit(settling);
        const auto seen = client.orbit(duration());
        std::vector<double> late;
        for (const auto& frame : seen.frames) late.push_back(frame.latencyMs);
        return {static_cast<double>(seen.frames.size()) / seen.seconds, quantile(late, 0.5),
                quantile(late, 0.99), quantile(late, 1.0)};
    }

    /// The film's pictures a second while something is done.
    template <class Work>
    double filmWhile(Work work) {
        Film made(connection_, options_.orbit);
        std::this_thread::sleep_for(settling);
        const int before = made.pictures();
        const auto begun = std::chrono::steady_clock::now();
        work();
        return (made.pictures() - before) /
               OrbitClient::Seconds(std::chrono::steady_clock::now() - begun).count();
    }

    std::filesystem::path file_;
    Options options_;
    proto::ConnectionFile connection_;
};

int measure(Options options) {
    options.orbit.dataset = "data/" + options.dataset.stem().string();
    if (options.connection) {
        Bench(*options.connection, options).run();
        return 0;
    }
    const client::Interrupt interrupt;
    const auto folder = std::filesystem::canonical(options.dataset).parent_path();
    auto server = client::PrivateServer::start(
        "mote-bench", {client::serverBesideUs(), {"data=" + folder.string()}, options.device}, interrupt);
    if (!server.ok()) throw std::runtime_error(server.error().toString());
    Bench((*server)->connectionFile(), options).run();
    return 0;
}

}  // namespace
}  // namespace mote::bench

int main(int argc, char** argv) {
    mote::bench::Options options;
    const mote::cli::Program commandLine("A hand orbits while a film is made in the background",
                                         "bench-background");
    const auto app = commandLine.command();
    app.option("dataset", options.dataset, "the folder NAME.mote of particles").required();
    app.option("--connect", options.connection, "a running server that has it beneath its root \"data\"");
    app.option("--device", options.device, "of a private server");
    app.option("--seconds", options.seconds, "of each part").range(1.0, 600.0);
    app.option("--rounds", options.rounds).range(1, 100);
    app.option("--width", options.orbit.width).range(16, 4096);
    app.option("--height", options.orbit.height).range(16, 4096);
    if (const auto end = commandLine.parse(argc, argv)) return *end;
    try {
        return mote::bench::measure(std::move(options));
    } catch (const std::exception& failure) {
        fmt::print(stderr, "bench-background: {}\n", failure.what());
        return 1;
    }
}
