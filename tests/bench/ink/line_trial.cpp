// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/bench/ink/line_trial.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <stdexcept>

namespace mote::bench {
namespace {

constexpr double tile = 4.0;      // pixels
constexpr double border = 128.0;  // pixels beside the picture that tiles cover

}  // namespace

LineTrial::LineTrial(const storage::SurfaceMesh& mesh, const Camera& camera, std::uint32_t width,
                     std::uint32_t height)
    : mesh_(mesh),
      perspective_(camera.perspective()),
      width_(width),
      height_(height),
      unit_(0.5 * height / camera.halfHeight()),
      columns_(static_cast<std::size_t>((width + 2.0 * border) / tile) + 1),
      rows_(static_cast<std::size_t>((height + 2.0 * border) / tile) + 1),
      tiles_(columns_ * rows_) {
    const glm::dmat4 toEye = camera.worldToEye();
    glm::dvec3 least(HUGE_VAL), most(-HUGE_VAL);
    for (const auto& at : mesh.positions) {
        eye_.emplace_back(toEye * glm::dvec4(glm::dvec3(at), 1.0));
        least = glm::min(least, eye_.back());
        most = glm::max(most, eye_.back());
        if (perspective_ && !(eye_.back().z < 0.0))
            throw std::invalid_argument("the mesh reaches behind the eye");
    }
    gap_ = 1e-6 * glm::distance(least, most);
    for (std::uint32_t i = 0; i < mesh.triangles.size(); ++i) {
        glm::dvec2 low(HUGE_VAL), high(-HUGE_VAL);
        for (const auto corner : mesh.triangles[i]) {
            low = glm::min(low, onScreen(eye_[corner]));
            high = glm::max(high, onScreen(eye_[corner]));
        }
        if (high.x < -border || high.y < -border || low.x > width_ + border || low.y > height_ + border)
            continue;
        const std::size_t first = tileOf(low), last = tileOf(high);
        for (std::size_t row = first / columns_; row <= last / columns_; ++row) {
            for (std::size_t column = first % columns_; column <= last % columns_; ++column)
                tiles_[row * columns_ + column].push_back(i);
        }
    }
}

std::size_t LineTrial::tileOf(const glm::dvec2& place) const {
    const auto held = [](double at, std::size_t count) {
        return static_cast<std::size_t>(
            std::clamp((at + border) / tile, 0.0, static_cast<double>(count - 1)));
    };
    return held(place.y, rows_) * columns_ + held(place.x, columns_);
}

glm::dvec2 LineTrial::onScreen(const glm::dvec3& inEye) const {
    const double unit = perspective_ ? unit_ / -inEye.z : unit_;
    return {0.5 * width_ + unit * inEye.x, 0.5 * height_ - unit * inEye.y};
}

int LineTrial::side(std::uint32_t triangle) const {
    const auto& corners = mesh_.triangles[triangle];
    const glm::dvec3 a = eye_[corners[0]], u = eye_[corners[1]] - a, v = eye_[corners[2]] - a;
    const glm::dvec3 area = glm::cross(u, v);
    const glm::dvec3 way = perspective_ ? -a : glm::dvec3(0.0, 0.0, 1.0);
    const double cosine = glm::dot(area, way) / (glm::length(area) * glm::length(way));
    return cosine > 1e-7 ? 1 : cosine < -1e-7 ? -1 : 0;
}

bool LineTrial::seen(const glm::dvec3& at, const std::array<std::uint32_t, 2>& own) const {
    const glm::dvec3 towards = perspective_ ? glm::normalize(-at) : glm::dvec3(0.0, 0.0, 1.0);
    for (const std::uint32_t i : tiles_[tileOf(onScreen(at))]) {
        if (i == own[0] || i == own[1]) continue;
        const auto& corners = mesh_.triangles[i];
        const glm::dvec3 a = eye_[corners[0]], u = eye_[corners[1]] - a, v = eye_[corners[2]] - a;
        const glm::dvec3 p = glm::cross(towards, v);
        const double turn = glm::dot(u, p);
        if (turn == 0.0) continue;
        const glm::dvec3 off = at - a, q = glm::cross(off, u);
        const double one = glm::dot(off, p) / turn, other = glm::dot(towards, q) / turn;
        if (one < 0.0 || other < 0.0 || one + other > 1.0) continue;
        if (glm::dot(v, q) / turn > gap_) return false;
    }
    return true;
}

}  // namespace mote::bench
