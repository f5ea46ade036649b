// SPDX-License-Identifier: GPL-3.0-or-later
//
// bench-stipple-tone: stippled photographs against what others do, in tone and time.
//
//   bench-stipple-tone HIERARCHY.mote [--dots N] [--pictures DIR] [--levels] [PICTURE...]
//
// Each PICTURE (an image file; besides, a gradient made on the spot) is cut to its middle square, brought to
// 800 x 800 and drawn with about N dots (12,000 unless given) of 4 pixels: its ink is wanted to be k (1 -
// luminance), with k such that N are wanted. PSNR of the drawing against the wanted ink, both blurred with a
// sigma of 4 and 8 pixels. --levels: ink and count of even tones instead.
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <functional>
#include <numbers>
#include <optional>

#include "preprocess/image/read_picture.h"
#include "server/render/layers/stipple/photograph.h"
#include "server/render/layers/stipple/tone.h"
#include "storage/manifest.h"
#include "storage/stipple/stipple_hierarchy.h"
#include "tests/bench/stipple_tone/reference_stipples.h"
#include "tests/bench/stipple_tone/tone_measure.h"
#include "tests/unit/particles/quiet_progress.h"

namespace mote::bench {
namespace {

constexpr std::uint32_t side = 800;  // pixels
constexpr double dotSize = 4.0;      // pixels
const double dotArea = std::numbers::pi / 4.0 * dotSize * dotSize;

struct Options {
    std::string hierarchy;
    std::vector<std::string> pictures;
    std::string folder;  // of pictures to write
    double dots = 12000.0;
    bool levels = false;
};

struct Subject {
    std::string name;
    render::PixelMap luminance;
};

render::PixelMap square(const storage::Luminance& picture) {
    const auto size = std::min(picture.width, picture.height);
    const std::size_t left = (picture.width - size) / 2, top = (picture.height - size) / 2;
    std::vector<float> values;
    for (std::size_t y = 0; y < size; ++y) {
        for (std::size_t x = 0; x < size; ++x) values.push_back(picture.at(left + x, top + y));
    }
    return {size, size, std::move(values)};
}

Subject gradient() {
    std::vector<float> values;
    for (std::uint32_t y = 0; y < side; ++y) {
        for (std::uint32_t x = 0; x < side; ++x) values.push_back((static_cast<float>(x) + 0.5F) / side);
    }
    return {"gradient", {side, side, std::move(values)}};
}

std::vector<Subject> subjectsOf(const Options& options) {
    std::vector<Subject> subjects;
    subjects.push_back(gradient());
    for (const auto& path : options.pictures) {
        test::QuietProgress progress;
        auto picture = prep::readPicture(path, 0, progress);
        if (!picture.ok()) {
            fmt::print(stderr, "{}: left out\n", picture.error().toString());
            continue;
        }
        subjects.push_back({std::filesystem::path(path).stem().string(), square(picture->luminance)});
    }
    return subjects;
}

/// The spacing that asks for so many dots.
render::PhotographTone toneFor(const render::PixelMap& luminance, double dots) {
    render::PhotographTone tone;
    tone.dot = dotSize;
    double low = 1.0, high = 100.0;
    for (int i = 0; i < 40; ++i) {
        tone.spacing = std::sqrt(low * high);
        (render::wantedDensity(luminance, side, side, tone).total() > dots ? low : high) = tone.spacing;
    }
    return tone;
}

void writePicture(const Options& options, const std::string& name, const Grid& ink) {
    if (options.folder.empty()) return;
    const auto path = options.folder + "/" + name + ".png";
    if (!writeInk(ink, path)) fmt::print(stderr, "{}: cannot be written\n", path);
}

class ToneBench {
  public:
    ToneBench(Options options, render::PlaneTiles tiles)
        : options_(std::move(options)), tiles_(std::move(tiles)) {}

    void run(const Subject& subject) {
        tone_ = toneFor(subject.luminance, options_.dots);
        frame_ = {tone_.fullDensity()};
        const auto wanted = render::wantedDensity(subject.luminance, side, side, tone_);
        const auto ink = wantedInk(wanted, dotSize);
        fmt::print("\n{}: {:.1f} dots wanted, spacing {:.3f}, full ink {:.3f}\n", subject.name,
                   wanted.total(), tone_.spacing, render::inkOfCover(tone_.fullDensity() * dotArea));
        fmt::print("{:<44} {:>7} {:>7} {:>7} {:>7} {:>9}\n", "", "dots", "count", "s=4 dB", "s=8 dB", "ms");
        writePicture(options_, subject.name + "-wanted", ink);
        const auto hierarchy = [&](const std::string& name, render::TileFrame frame,
                                   render::PhotographEffort effort) {
            measure(
                subject, name, wanted, ink,
                [&] { return placesOf(render::stipplePhotograph(tiles_, wanted, frame, effort)); }, 9);
        };
        hierarchy("hierarchy, one sample a point", {tone_.fullDensity(), 0.0}, {false, 0});
        hierarchy("area-sampled", frame_, {false, 0});
        hierarchy("area-sampled, weighted", frame_, render::quickPhotograph);
        for (const int steps : {1, 2, 3, 4, 6, 8, 12, 20}) {
            hierarchy(fmt::format("and balanced, {} relaxations", steps), frame_, {true, steps});
        }
        measure(
            subject, "Secord, 50 steps", wanted, ink, [&] { return secord(wanted, 50, 1); }, 1);
        measure(
            subject, "Linde-Buzo-Gray, at most 50 steps", wanted, ink,
            [&] { return lindeBuzoGray(wanted, 50, 1); }, 1);
    }

    /// Even tones of all densities: the ink that dots make and their count.
    void levels() {
        fmt::print("{:>7} {:>8} {:>8} {:>9}\n", "cover", "ink", "formula", "count");
        for (double cover = 0.05; cover < 1.8; cover += 0.05) {
            const double density = cover / dotArea;
            const render::PixelMap wanted(
                side, side, std::vector<float>(std::size_t{side} * side, static_cast<float>(density)));
            const auto dots =
                placesOf(render::stipplePhotograph(tiles_, wanted, {1.8 / dotArea}, {false, 0}));
            const auto drawn = drawDots(side, side, dots, dotSize);
            double ink = 0.0;
            for (const float value : drawn.values) ink += value;
            fmt::print("{:>7.2f} {:>8.4f} {:>8.4f} {:>8.3f}%\n", cover, ink / (side * side),
                       render::inkOfCover(cover),
                       100.0 * (static_cast<double>(dots.size()) / wanted.total() - 1.0));
        }
    }

  private:
    static std::vector<glm::vec2> placesOf(const std::vector<render::TileDot>& dots) {
        std::vector<glm::vec2> places;
        for (const auto& dot : dots) places.push_back(dot.place);
        return places;
    }

    void measure(const Subject& subject, const std::string& name, const render::PixelMap& wanted,
                 const Grid& ink, const std::function<std::vector<glm::vec2>()>& make, int runs) {
        std::vector<double> times;
        std::vector<glm::vec2> dots;
        for (int i = 0; i < runs; ++i) {
            const auto begin = std::chrono::steady_clock::now();
            dots = make();
            times.push_back(
                std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin).count());
        }
        std::nth_element(times.begin(), times.begin() + runs / 2, times.end());
        const auto drawn = drawDots(side, side, dots, dotSize);
        fmt::print("{:<44} {:>7} {:>6.2f}% {:>7.2f} {:>7.2f} {:>9.2f}\n", name, dots.size(),
                   100.0 * (static_cast<double>(dots.size()) / wanted.total() - 1.0), psnr(drawn, ink, 4.0),
                   psnr(drawn, ink, 8.0), times[static_cast<std::size_t>(runs / 2)]);
        writePicture(options_, subject.name + "-" + name, drawn);
    }

    Options options_;
    render::PlaneTiles tiles_;
    render::PhotographTone tone_;
    render::TileFrame frame_;
};

std::optional<Options> parse(int argc, char** argv) {
    Options options;
    for (int i = 1; i < argc; ++i) {
        const std::string argument = argv[i];
        if (argument == "--dots" && i + 1 < argc) {
            options.dots = std::stod(argv[++i]);
        } else if (argument == "--pictures" && i + 1 < argc) {
            options.folder = argv[++i];
        } else if (argument == "--levels") {
            options.levels = true;
        } else if (options.hierarchy.empty()) {
            options.hierarchy = argument;
        } else {
            options.pictures.push_back(argument);
        }
    }
    if (options.hierarchy.empty()) return std::nullopt;
    return options;
}

int run(int argc, char** argv) {
    const auto options = parse(argc, argv);
    if (!options) {
        fmt::print(stderr,
                   "bench-stipple-tone HIERARCHY.mote [--dots N] [--pictures DIR] [--levels] [PICTURE...]\n");
        return 2;
    }
    const auto manifest = storage::readManifest(options->hierarchy);
    auto hierarchy = manifest.ok() ? storage::readHierarchy(options->hierarchy, *manifest)
                                   : Result<storage::StippleHierarchy>(manifest.error());
    if (!hierarchy.ok()) {
        fmt::print(stderr, "{}\n", hierarchy.error().toString());
        return 1;
    }
    ToneBench bench(*options, render::PlaneTiles(
                                  std::make_shared<const storage::StippleHierarchy>(*std::move(hierarchy))));
    if (options->levels) {
        bench.levels();
        return 0;
    }
    for (const auto& subject : subjectsOf(*options)) bench.run(subject);
    return 0;
}

}  // namespace
}  // namespace mote::bench

int main(int argc, char** argv) {
    return mote::bench::run(argc, argv);
}
