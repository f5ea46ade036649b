// SPDX-License-Identifier: GPL-3.0-or-later
//
// Regions of generated scenes against their parts: how much of the boundaries is the same, and what the ways
// to find them cost. The last one is none: squares of a grid, what a wrong one is worth.
//   bench-segments [--scenes N] [--size COLUMNS ROWS] [--pictures FOLDER]
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <string>
#include <vector>

#include "server/render/ink/segments.h"
#include "server/render/ink/show.h"
#include "tests/unit/ink/part_scenes.h"

namespace mote::bench {
namespace {

using namespace render;
using Clock = std::chrono::steady_clock;

constexpr double tolerance = 2.0;  // pixels

struct Way {
    const char* name;
    Segmentation method;
    bool grid = false;
    double precision = 0.0, recall = 0.0, f = 0.0, least = 1.0, ms = 0.0;
};

Segments squares(const Modalities& modalities) {
    constexpr std::uint32_t side = 40;
    Segments made{Raster<std::uint32_t>(modalities.grey.width, modalities.grey.height), 0};
    for (std::uint32_t row = 0; row < modalities.grey.height; ++row) {
        for (std::uint32_t column = 0; column < modalities.grey.width; ++column)
            made.label.at(column, row) = row / side * 1000 + column / side;
    }
    return made;
}

void write(const std::string& folder, const std::string& name, const Raster<glm::vec3>& picture) {
    if (folder.empty()) return;
    std::ofstream out(folder + "/" + name + ".ppm", std::ios::binary);
    out << "P6 " << picture.width << ' ' << picture.height << " 255\n";
    for (const auto& color : picture.values) {
        for (int i = 0; i < 3; ++i)
            out.put(static_cast<char>(static_cast<unsigned char>(255.0F * std::sqrt(color[i]))));
    }
}

void measure(Way& way, const test::PartScene& scene, const std::string& picture, const std::string& folder) {
    const auto begun = Clock::now();
    SegmentOptions options;
    options.method = way.method;
    const auto segments = way.grid ? squares(scene.modalities) : segmentsOf(scene.modalities, options, {});
    way.ms += std::chrono::duration<double, std::milli>(Clock::now() - begun).count();
    const auto found = test::compareBoundaries(segments.label, scene.part, tolerance);
    way.precision += found.precision;
    way.recall += found.recall;
    way.f += found.f();
    way.least = std::min(way.least, found.f());
    write(folder, picture + "-" + way.name, labelPicture(segments.label));
}

int run(int count, char** arguments) {
    std::uint64_t scenes = 20;
    std::uint32_t columns = 480, rows = 360;
    std::string folder;
    for (int i = 1; i < count; ++i) {
        const std::string word = arguments[i];
        if (word == "--scenes" && i + 1 < count) scenes = std::strtoull(arguments[++i], nullptr, 10);
        if (word == "--pictures" && i + 1 < count) folder = arguments[++i];
        if (word == "--size" && i + 2 < count) {
            columns = static_cast<std::uint32_t>(std::atoi(arguments[++i]));
            rows = static_cast<std::uint32_t>(std::atoi(arguments[++i]));
        }
    }
    for (const auto relief : {test::Relief::smooth, test::Relief::rough}) {
        std::vector<Way> ways{{"growing", Segmentation::growing},
                              {"graph", Segmentation::graph},
                              {"cut", Segmentation::cut},
                              {"texture", Segmentation::texture},
                              {"squares", Segmentation::growing, true}};
        const std::string kind = relief == test::Relief::smooth ? "smooth" : "rough";
        for (std::uint64_t i = 0; i < scenes; ++i) {
            test::Random random(i, 1);
            const auto scene = test::partScene(random, columns, rows, relief);
            const auto name = fmt::format("{}-{:02}", kind, i);
            write(folder, name + "-grey", greyPicture(scene.modalities.grey));
            write(folder, name + "-parts", labelPicture(scene.part));
            for (auto& way : ways) measure(way, scene, name, folder);
        }
        const auto n = static_cast<double>(scenes);
        for (const auto& way : ways)
            fmt::print("{:6} {:8} precision {:.3f} recall {:.3f} F {:.3f} least {:.3f} {:8.1f} ms\n", kind,
                       way.name, way.precision / n, way.recall / n, way.f / n, way.least, way.ms / n);
    }
    return 0;
}

}  // namespace
}  // namespace mote::bench

int main(int count, char** arguments) {
    return mote::bench::run(count, arguments);
}
