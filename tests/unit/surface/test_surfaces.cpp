// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/unit/surface/test_surfaces.h"

#include <array>
#include <cmath>
#include <glm/geometric.hpp>

namespace mote::test {

prep::TriangleMesh gridMesh(int columns, int rows, const std::function<glm::vec3(float, float)>& place) {
    prep::TriangleMesh mesh;
    for (int y = 0; y <= rows; ++y) {
        for (int x = 0; x <= columns; ++x) {
            mesh.positions.push_back(place(static_cast<float>(x) / static_cast<float>(columns),
                                           static_cast<float>(y) / static_cast<float>(rows)));
        }
    }
    const auto at = [&](int x, int y) { return static_cast<std::uint32_t>(y * (columns + 1) + x); };
    for (int y = 0; y < rows; ++y) {
        for (int x = 0; x < columns; ++x) {
            mesh.triangles.push_back({at(x, y), at(x + 1, y), at(x + 1, y + 1)});
            mesh.triangles.push_back({at(x, y), at(x + 1, y + 1), at(x, y + 1)});
        }
    }
    return mesh;
}

prep::TriangleMesh together(prep::TriangleMesh first, const prep::TriangleMesh& second) {
    const auto begin = static_cast<std::uint32_t>(first.positions.size());
    first.positions.insert(first.positions.end(), second.positions.begin(), second.positions.end());
    for (const auto& [a, b, c] : second.triangles) {
        first.triangles.push_back({a + begin, b + begin, c + begin});
    }
    return first;
}

prep::TriangleMesh sphere(int times) {
    prep::TriangleMesh mesh;
    mesh.positions = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
    mesh.triangles = {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4}, {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}};
    for (int i = 0; i < times; ++i) {
        prep::TriangleMesh finer;
        for (const auto& triangle : mesh.triangles) {
            std::array<glm::vec3, 6> p;
            for (std::size_t k = 0; k < 3; ++k) p[k] = mesh.positions[triangle[k]];
            for (std::size_t k = 0; k < 3; ++k) p[3 + k] = glm::normalize(p[k] + p[(k + 1) % 3]);
            const auto begin = static_cast<std::uint32_t>(finer.positions.size());
            finer.positions.insert(finer.positions.end(), p.begin(), p.end());
            for (const auto& [a, b, c] : {prep::Triangle{0, 3, 5}, prep::Triangle{3, 1, 4},
                                          prep::Triangle{5, 4, 2}, prep::Triangle{3, 4, 5}}) {
                finer.triangles.push_back({begin + a, begin + b, begin + c});
            }
        }
        mesh = std::move(finer);
    }
    return mesh;
}

prep::TriangleMesh torus() {
    return gridMesh(96, 48, [](float u, float v) {
        // The ends of the grid are one place: the angle is taken round so that they are so to the last bit.
        const float a = 6.2831853F * (u < 1.0F ? u : 0.0F);
        const float b = 6.2831853F * (v < 1.0F ? v : 0.0F);
        const float r = 1.0F + 0.4F * std::cos(b);
        return glm::vec3(r * std::cos(a), r * std::sin(a), 0.4F * std::sin(b));
    });
}

prep::TriangleMesh square(float height, bool turned) {
    return gridMesh(
        8, 8, [=](float u, float v) { return turned ? glm::vec3(v, u, height) : glm::vec3(u, v, height); });
}

}  // namespace mote::test
