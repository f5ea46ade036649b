// SPDX-License-Identifier: GPL-3.0-or-later
//
// bench-stipple-quality: the measures of docs/STIPPLES.md for hierarchies on the plane, against white noise,
// a static hierarchy and Lloyd's method; dots at uneven density; spectra as pictures.
#include <fmt/format.h>

#include <chrono>
#include <random>

#include "preprocess/job.h"
#include "preprocess/stipple/stipple_job.h"
#include "preprocess/stipple/thinning.h"
#include "protocol/cli/command.h"
#include "tests/bench/stipple_quality/plane_levels.h"
#include "tests/bench/stipple_quality/quality_pictures.h"
#include "tests/bench/stipple_quality/uneven_tone.h"

namespace {

using namespace mote;
using namespace mote::bench;

class Silent final : public prep::Progress {
  public:
    void report(double, std::string_view) override {}
    void note(std::string_view) override {}
    bool cancelled() const override { return false; }
};

struct Options {
    std::uint32_t points = 5000;
    std::uint64_t seeds = 5;
    std::string pictures;
};

std::vector<glm::dvec2> whiteNoise(std::size_t points, std::uint64_t seed) {
    std::mt19937_64 random(seed);
    std::uniform_real_distribution<double> uniform;
    std::vector<glm::dvec2> made(points);
    for (auto& point : made) point = {uniform(random), uniform(random)};
    return made;
}

std::vector<glm::dvec2> lloyd(std::size_t points, std::uint64_t seed) {
    auto made = whiteNoise(points, seed);
    for (int i = 0; i < 50; ++i) made = prep::relaxOnce(made, 1.0);
    return made;
}

void printRow(const std::string& name, const test::PlaneMeasures& m) {
    fmt::print("{:<34} {:6.3f} {:6.3f} {:7.4f} {:7.4f} {:8.4f}  {}\n", name, m.rho, m.nearest, m.energy,
               m.areaCv, m.lowEnergy, meetsBars(m) ? "" : "below the bars");
}

void printHead(const char* title) {
    fmt::print("\n{:<34} {:>6} {:>6} {:>7} {:>7} {:>8}\n", title, "rho", "NN", "E", "areaCV", "lowE");
}

struct Built {
    storage::StippleHierarchy hierarchy;
    double seconds = 0.0;
};

Built build(const Options& options, std::uint64_t seed, const prep::ThinningOptions& thinning) {
    Silent progress;
    const auto begin = std::chrono::steady_clock::now();
    const auto start = prep::evenPoints(options.points, seed, 0.5, progress);
    auto made = prep::thinPlane(*start, thinning, 0.5, progress);
    const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - begin;
    return {*std::move(made), seconds.count()};
}

/// The worst of all seeds and levels of a kind of hierarchy; each level's worst where `each`.
void measureHierarchy(const Options& options, const std::string& name, const prep::ThinningOptions& thinning,
                      bool each) {
    const auto shares = levels(options.points);
    std::vector<std::vector<test::PlaneMeasures>> byLevel(shares.size());
    for (std::uint64_t seed = 1; seed <= options.seeds; ++seed) {
        const render::StippleReplay replay(build(options, seed, thinning).hierarchy);
        for (std::size_t i = 0; i < shares.size(); ++i) {
            byLevel[i].push_back(test::measurePlane(drawnAt(replay, shares[i])));
        }
    }
    std::vector<test::PlaneMeasures> all;
    for (std::size_t i = 0; i < shares.size(); ++i) {
        all.push_back(worst(byLevel[i]));
        if (each) printRow(fmt::format("  at {:.2f}", shares[i]), all.back());
    }
    printRow(name, worst(all));
}

void measureSets(const Options& options) {
    printHead(fmt::format("{} points, worst of {} seeds", options.points, options.seeds).c_str());
    std::vector<test::PlaneMeasures> noise;
    std::vector<test::PlaneMeasures> relaxed;
    for (std::uint64_t seed = 1; seed <= options.seeds; ++seed) {
        noise.push_back(test::measurePlane(whiteNoise(options.points, seed)));
        relaxed.push_back(test::measurePlane(lloyd(options.points, seed)));
    }
    printRow("white noise", worst(noise));
    printRow("Lloyd, 50 steps, one density", worst(relaxed));
    fmt::print("hierarchies, worst of all levels:\n");
    measureHierarchy(options, "static", {0, 1.0}, false);
    measureHierarchy(options, "one ring", {1, 1.6}, false);
    measureHierarchy(options, "two rings", {2, 1.6}, true);
}

/// Dots at uneven density: of constant size, and, more strictly, as wide as the wanted density leaves room
/// for.
struct Uneven {
    double count = 0.0;  ///< |drawn / wanted - 1|
    double close[3] = {};
    double closeInTone[3] = {};
};

Uneven measureTone(const storage::StippleHierarchy& hierarchy, const Tone& tone) {
    const render::StippleReplay replay(hierarchy);
    const double diameter = dotDiameter(hierarchy.size());
    Uneven result;
    for (const auto rule : {Rule::prefix, Rule::mean, Rule::last}) {
        const auto dots = drawUneven(hierarchy, replay, tone, rule);
        const auto i = static_cast<std::size_t>(rule);
        result.close[i] = closeShare(dots, [&](glm::dvec2) { return diameter; });
        result.closeInTone[i] =
            closeShare(dots, [&](glm::dvec2 at) { return diameter / std::sqrt(tone(at)); });
        if (rule == Rule::prefix) result.count = std::abs(countError(hierarchy, dots, tone));
    }
    return result;
}

void measureUneven(const Options& options) {
    fmt::print("\n{:<14} {:>9} | closer than .75 diameters, by rule | the same of the wanted spacing\n", "",
               "");
    fmt::print("{:<14} {:>9} {:>11} {:>11} {:>11} {:>11} {:>11} {:>11}\n", "uneven tone, %", "count",
               "prefix", "mean", "last", "prefix", "mean", "last");
    std::vector<storage::StippleHierarchy> hierarchies;
    for (std::uint64_t seed = 1; seed <= options.seeds; ++seed) {
        hierarchies.push_back(build(options, seed, prep::thinningOptions({})).hierarchy);
    }
    for (const auto& [name, tone] : tones()) {
        Uneven sum;
        for (const auto& hierarchy : hierarchies) {
            const auto one = measureTone(hierarchy, tone);
            sum.count += one.count;
            for (std::size_t i = 0; i < 3; ++i) {
                sum.close[i] += one.close[i];
                sum.closeInTone[i] += one.closeInTone[i];
            }
        }
        const double percent = 100.0 / static_cast<double>(options.seeds);
        fmt::print("{:<14} {:>9.3f} {:>11.3f} {:>11.2f} {:>11.2f} {:>11.3f} {:>11.2f} {:>11.2f}\n", name,
                   percent * sum.count, percent * sum.close[0], percent * sum.close[1],
                   percent * sum.close[2], percent * sum.closeInTone[0], percent * sum.closeInTone[1],
                   percent * sum.closeInTone[2]);
    }
}

int writePictures(const Options& options) {
    const auto write = [&](const test::Image& image, const std::string& name) {
        const auto written = test::writePng(image, std::filesystem::path(options.pictures) / name);
        if (!written.ok()) fmt::print(stderr, "{}\n", written.error().toString());
        return written.ok();
    };
    const auto hierarchy = build(options, 1, prep::thinningOptions({})).hierarchy;
    const render::StippleReplay replay(hierarchy);
    const render::StippleReplay fixed(build(options, 1, {0, 1.0}).hierarchy);
    bool good = true;
    for (const double share : {0.5, 0.25, 0.2}) {
        const int percent = static_cast<int>(100.0 * share);
        good &= write(spectrumPicture(drawnAt(replay, share)), fmt::format("spectrum-{}.png", percent));
        good &= write(dotPicture(drawnAt(replay, share), 800, 6.0), fmt::format("dots-{}.png", percent));
        good &= write(spectrumPicture(drawnAt(fixed, share)), fmt::format("static-spectrum-{}.png", percent));
        good &=
            write(dotPicture(drawnAt(fixed, share), 800, 6.0), fmt::format("static-dots-{}.png", percent));
    }
    good &= write(spectrumPicture(whiteNoise(options.points / 2, 1)), "noise-spectrum.png");
    for (const auto& [name, tone] : tones()) {
        good &= write(dotPicture(drawUneven(hierarchy, replay, tone, Rule::prefix), 800, 4.0),
                      fmt::format("{}.png", name));
    }
    return good ? 0 : 1;
}

void printCosts(const Options& options) {
    const auto built = build(options, 1, prep::thinningOptions({}));
    const auto& h = built.hierarchy;
    fmt::print(
        "\nbuilt in {:.2f} s; {:.2f} moves a point, the longest {:.3f} spacings ({:.3f} with the last "
        "30 points)\n",
        built.seconds, static_cast<double>(h.moveNeighbour.size()) / static_cast<double>(h.size()),
        longestMove(h, 30), longestMove(h, 0));
    const render::StippleReplay replay(h);
    fmt::print("{:.1f} bytes a point in memory\n",
               static_cast<double>(replay.bytes()) / static_cast<double>(h.size()));
    const std::vector<float> shares(h.size(), 0.3F);
    const auto begin = std::chrono::steady_clock::now();
    constexpr int times = 100;
    std::size_t dots = 0;
    for (int i = 0; i < times; ++i) dots += replay.place(replay.select(shares)).size();
    const std::chrono::duration<double, std::milli> spent = std::chrono::steady_clock::now() - begin;
    fmt::print("{} dots selected and placed in {:.3f} ms\n", dots / times, spent.count() / times);
}

}  // namespace

int main(int argc, char** argv) {
    Options options;
    const mote::cli::Program commandLine("How even the dots of stipple hierarchies on the plane are",
                                         "bench-stipple-quality");
    const auto program = commandLine.command();
    program.option("--points", options.points, "Points of a hierarchy; default 5000").range(250, 10000000);
    program.option("--seeds", options.seeds, "Hierarchies of each kind; default 5").range(1, 1000);
    program.option("--pictures", options.pictures, "Write dots and spectra there, and nothing else");
    if (const auto end = commandLine.parse(argc, argv)) return *end;
    if (!options.pictures.empty()) return writePictures(options);
    measureSets(options);
    measureUneven(options);
    printCosts(options);
    return 0;
}
