// SPDX-License-Identifier: GPL-3.0-or-later
//
// What a new view of a stippled surface costs, step by step, and what becomes of its dots when it is turned
// by one degree: how many appear and vanish, and how far those that stay move over the surface, in distances
// of neighbours at the wanted density. The jitter allows for half of one.
//   bench-stipple-view NAME.mote [SPACING] [WIDTH HEIGHT]
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <glm/geometric.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <map>
#include <vector>

#include "server/render/layers/stipple/surface_dots.h"
#include "storage/manifest.h"
#include "storage/mesh/mesh_file.h"
#include "storage/stipple/stipple_hierarchy.h"

namespace mote {
namespace {

using Clock = std::chrono::steady_clock;

template <class T>
T valueOrExit(Result<T> result) {
    if (result.ok()) return *std::move(result);
    fmt::print(stderr, "bench-stipple-view: {}\n", result.error().toString());
    std::exit(1);
}

render::StippleSurface read(const std::filesystem::path& dataset) {
    const auto manifest = valueOrExit(storage::readManifest(dataset));
    const auto mesh = valueOrExit(storage::readMesh(dataset, manifest));
    Bounds bounds{};
    for (int i = 0; i < 3; ++i) {
        bounds.min[i] = manifest.mesh().bounds_min(i);
        bounds.max[i] = manifest.mesh().bounds_max(i);
    }
    return {render::StippleReplay(valueOrExit(storage::readHierarchy(dataset, manifest))),
            render::SurfaceRays(mesh.positions, mesh.triangles), bounds, manifest.stipple().area()};
}

double median(std::vector<double> values) {
    std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2),
                     values.end());
    return values[values.size() / 2];
}

struct Times {
    std::vector<double> choose, hide, project;  ///< ms
};

struct SeenDot {
    render::Dot dot;
    glm::vec3 position;  ///< on the surface, without jitter
    double spacing;      ///< of neighbours at the wanted density, world units
};

std::map<std::uint32_t, SeenDot> draw(const render::StippleSurface& surface, View view, double degrees,
                                      Times& times) {
    const glm::dvec3 centre = surface.bounds().center();
    glm::dmat4 turn = glm::translate(glm::dmat4(1.0), centre);
    turn = glm::rotate(turn, glm::radians(degrees), glm::dvec3(0.0, 1.0, 0.0));
    turn = glm::translate(turn, -centre);
    const render::SurfaceDots layer(surface, *view.layers[0].stipple(), view, turn);
    const auto ms = [](auto from, auto to) {
        return std::chrono::duration<double, std::milli>(to - from).count();
    };
    const auto begun = Clock::now();
    const auto chosen = layer.chosen();
    const auto placed = Clock::now();
    const auto seen = layer.seen(chosen);
    const auto hidden = Clock::now();
    const auto dots = layer.onScreen(seen);
    times.choose.push_back(ms(begun, placed));
    times.hide.push_back(ms(placed, hidden));
    times.project.push_back(ms(hidden, Clock::now()));
    std::map<std::uint32_t, SeenDot> result;
    const render::SurfaceView screen(view, turn);
    const render::WantedDensity wanted(surface, *view.layers[0].stipple(), screen);
    for (std::size_t i = 0; i < dots.size(); ++i) {
        const double share = std::min<double>(wanted.at(seen[i].point).share, 1.0);
        const double spacing = std::sqrt(2.0 / (std::sqrt(3.0) * share * surface.density()));
        result.emplace(seen[i].point, SeenDot{dots[i], seen[i].position, spacing});
    }
    return result;
}

void run(const render::StippleSurface& surface, const View& view) {
    Times times;
    std::size_t dots = 0, born = 0, gone = 0;
    double farthest = 0.0;
    std::vector<double> ways;
    std::map<std::uint32_t, SeenDot> before;
    constexpr int views = 120;
    for (int i = 0; i < views; ++i) {
        auto now = draw(surface, view, i, times);
        dots += now.size();
        for (const auto& [point, dot] : now) {
            const auto found = before.find(point);
            if (found == before.end()) {
                ++born;
            } else {
                const auto& old = found->second;
                farthest =
                    std::max<double>(farthest, std::hypot(dot.dot.x - old.dot.x, dot.dot.y - old.dot.y));
                ways.push_back(glm::distance(dot.position, old.position) / dot.spacing);
            }
        }
        for (const auto& [point, dot] : before) gone += now.contains(point) ? 0 : 1;
        if (i == 0) born = 0;
        before = std::move(now);
    }
    fmt::print("{} points, {} dots a view\n", surface.replay().size(), dots / views);
    fmt::print("select and place {:.2f} ms, hidden {:.2f} ms, to the screen {:.2f} ms (medians)\n",
               median(times.choose), median(times.hide), median(times.project));
    fmt::print("a degree: {:.2f}% appear, {:.2f}% vanish; the farthest way of a dot that stays {:.1f} px\n",
               100.0 * static_cast<double>(born) / static_cast<double>(dots),
               100.0 * static_cast<double>(gone) / static_cast<double>(dots), farthest);
    std::sort(ways.begin(), ways.end());
    const auto beyond = ways.end() - std::upper_bound(ways.begin(), ways.end(), 0.5);
    fmt::print("over the surface, in spacings: 99% below {:.3f}, the longest {:.2f}; {} of {} above 0.5\n",
               ways[ways.size() * 99 / 100], ways.back(), beyond, ways.size());
}

}  // namespace
}  // namespace mote

int main(int argc, char** argv) {
    if (argc < 2) {
        fmt::print(stderr, "usage: bench-stipple-view NAME.mote [SPACING] [WIDTH HEIGHT]\n");
        return 2;
    }
    mote::proto::View message;
    message.set_width(argc > 4 ? static_cast<std::uint32_t>(std::atoi(argv[3])) : 1280);
    message.set_height(argc > 4 ? static_cast<std::uint32_t>(std::atoi(argv[4])) : 720);
    auto& layer = *message.add_layers();
    layer.set_dataset("bench/surface");
    layer.mutable_stipple()->set_spacing_pixels(argc > 2 ? std::atof(argv[2]) : 5.0);
    auto view = mote::valueOrExit(mote::parseView(message));
    const auto surface = mote::read(argv[1]);
    view.camera = mote::fitCamera(surface.bounds(), view.aspect());
    mote::run(surface, view);
    return 0;
}
