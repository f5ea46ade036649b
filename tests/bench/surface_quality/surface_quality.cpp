// SPDX-License-Identifier: GPL-3.0-or-later
//
// bench-surface-quality DATASET.mote [--splats FOLDER]: how even the points of a surface hierarchy are,
// measured at first hand from the points that the server's replay draws, at many levels. With --splats, the
// points of some levels as text, "x y z nx ny nz" a line, for pictures.
#include <fmt/format.h>

#include <array>
#include <cmath>
#include <fstream>
#include <glm/geometric.hpp>
#include <numeric>

#include "preprocess/mesh/surface_topology.h"
#include "server/render/layers/stipple/replay.h"
#include "storage/manifest.h"
#include "storage/mesh/mesh_file.h"
#include "storage/stipple/stipple_hierarchy.h"
#include "tests/support/surface_measures.h"

namespace mote::test {
namespace {

namespace fs = std::filesystem;

constexpr std::array levels{1.0, 0.95, 0.9, 0.8, 0.7, 0.6, 0.5, 0.4, 0.3, 0.2, 0.15, 0.1, 0.05};

struct Surface {
    storage::SurfaceMesh mesh;
    storage::StippleHierarchy hierarchy;
};

Result<Surface> load(const fs::path& directory) {
    const auto manifest = storage::readManifest(directory);
    if (!manifest.ok()) return manifest.error();
    auto mesh = storage::readMesh(directory, *manifest);
    if (!mesh.ok()) return mesh.error();
    auto hierarchy = storage::readHierarchy(directory, *manifest);
    if (!hierarchy.ok()) return hierarchy.error();
    return Surface{*std::move(mesh), *std::move(hierarchy)};
}

void printMoves(const storage::StippleHierarchy& h, double area) {
    // Against the spacing at which the point's neighbour was removed: as many points as its removal leaves.
    double longest = 0.0;
    for (std::size_t p = 0; p < h.size(); ++p) {
        auto from = h.positions[p];
        for (auto m = h.movesBegin[p]; m < h.movesBegin[p + 1]; ++m) {
            const auto left = h.size() - h.removal[h.moveNeighbour[m]];
            const double spacing = std::sqrt(2.0 / std::sqrt(3.0) * area / static_cast<double>(left));
            const auto to = h.movePosition[m];
            longest = std::max(longest, static_cast<double>(glm::distance(from, to)) / spacing);
            from = to;
        }
    }
    const auto locked = std::accumulate(h.locked.begin(), h.locked.end(), std::uint64_t{0});
    fmt::print("{} points, {:.1f} moves a point, the longest {:.2f} spacings; locked {:.1f}%\n", h.size(),
               static_cast<double>(h.moveNeighbour.size()) / static_cast<double>(h.size()), longest,
               100.0 * static_cast<double>(locked) / static_cast<double>(h.size()));
}

void writeSplats(const fs::path& path, const prep::PointSet& set) {
    std::ofstream out(path);
    for (std::size_t i = 0; i < set.points.size(); ++i) {
        const auto& p = set.points[i].position;
        const auto& n = set.normals[i];
        out << fmt::format("{} {} {} {} {} {}\n", p.x, p.y, p.z, n.x, n.y, n.z);
    }
}

int run(const fs::path& directory, const fs::path& splats) {
    auto surface = load(directory);
    if (!surface.ok()) {
        fmt::print(stderr, "{}\n", surface.error().toString());
        return 1;
    }
    const prep::WalkMesh mesh(surface->mesh, prep::neighboursOf(surface->mesh));
    const NearestTriangle nearest(surface->mesh);
    printMoves(surface->hierarchy, mesh.area());
    const render::StippleReplay replay(std::move(surface->hierarchy));
    fmt::print("{:>6} {:>9} {:>7} {:>6} {:>6} {:>6} {:>7} {:>7}\n", "level", "points", "flat", "rho", "NN",
               "E", "areaCV", "largest");
    for (const double level : levels) {
        const auto drawn = replay.select(std::vector<float>(replay.size(), static_cast<float>(level)));
        std::vector<glm::vec3> positions;
        for (const auto& placed : replay.place(drawn)) positions.push_back(placed.position);
        const auto set = placeOnSurface(mesh, nearest, positions);
        const auto m = measureSurface(mesh, set);
        fmt::print("{:>6.2f} {:>9} {:>6.1f}% {:>6.3f} {:>6.3f} {:>6.3f} {:>7.4f} {:>7.2f}\n", level, m.points,
                   100.0 * static_cast<double>(m.flat) / static_cast<double>(m.points), m.rho, m.nearest,
                   m.energy, m.areaCv, m.worstArea);
        if (!splats.empty()) writeSplats(splats / fmt::format("level-{:.2f}.txt", level), set);
    }
    return 0;
}

}  // namespace
}  // namespace mote::test

int main(int argc, char** argv) {
    const bool wanted = argc == 4 && std::string_view(argv[2]) == "--splats";
    if (argc != 2 && !wanted) {
        fmt::print(stderr, "usage: bench-surface-quality DATASET.mote [--splats FOLDER]\n");
        return 2;
    }
    return mote::test::run(argv[1], wanted ? argv[3] : "");
}
