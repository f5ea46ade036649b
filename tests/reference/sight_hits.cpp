// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/reference/sight_hits.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <limits>
#include <utility>

namespace mote::reference {
namespace {

/// Sixteenths of a pixel from its centre: written down once more, see PICTURE.md.
constexpr std::array<std::array<double, 2>, 8> looks{
    {{1, -3}, {-1, 3}, {5, 1}, {-3, -5}, {-5, 5}, {-7, -1}, {3, 7}, {7, -7}}};

Layer smoothed(Layer layer) {
    auto& style = std::get<proto::HybridStyle>(layer.style);
    style.set_point_shape("gaussian");
    style.set_point_opacity(1.0);
    return layer;
}

/// The value behind which a curve is above 0; infinite where it is nowhere.
double beginOf(const Curve& opacity) {
    double begin = opacity.knots().front().x;
    for (const auto& knot : opacity.knots()) {
        if (knot.y > 0.0) return begin;
        begin = knot.x;
    }
    return std::numeric_limits<double>::infinity();
}

}  // namespace

SightHits::SightHits(const View& view, const Layer& layer, const render::GridField& step,
                     double samplesPerCell)
    : view_(view),
      layer_(smoothed(layer)),
      style_(hybridStyleOf(*layer_.hybrid())),
      samplesPerCell_(samplesPerCell),
      field_(std::make_unique<const HybridField>(step, layer_, view.camera)),
      transfer_(render::transferOf(style_, step)),
      codeStep_((step.range.high - step.range.low) / 65535.0),
      isovalue_(style_.isovalue.value_or(beginOf(transfer_.opacity))),
      layerToEye_(view.camera.worldToEye() * layer.transform),
      within_(field_->within()) {
    const auto clips = layer.clips();
    within_.insert(within_.end(), clips.begin(), clips.end());
}

SightHits::Ray SightHits::through(double x, double y) const {
    const double pixels = view_.height / (2.0 * view_.camera.halfHeight());
    const double right = (x - 0.5 * view_.width) / pixels, up = (0.5 * view_.height - y) / pixels;
    const bool perspective = view_.camera.perspective();
    const glm::dmat4 back = glm::inverse(layerToEye_);
    Ray ray{glm::dvec3(back * (perspective ? glm::dvec4(0, 0, 0, 1) : glm::dvec4(right, up, 0, 1))),
            glm::dvec3(back * (perspective ? glm::dvec4(right, up, -1, 0) : glm::dvec4(0, 0, -1, 0))),
            nearestDepth(view_.camera), std::numeric_limits<double>::infinity(), std::nullopt};
    for (const auto& [normal, distance] : within_) {
        const double speed = glm::dot(normal, ray.perDepth), height = glm::dot(normal, ray.origin) - distance;
        if (speed == 0.0 && height < 0.0) ray.leave = -std::numeric_limits<double>::infinity();
        if (speed < 0.0) ray.leave = std::min(ray.leave, -height / speed);
        if (!(speed > 0.0) || -height / speed <= ray.enter) continue;
        ray.enter = -height / speed;
        ray.side = normal;
    }
    return ray;
}

double SightHits::step(const Ray& ray) const {
    return field_->cellEdge() / (samplesPerCell_ * glm::length(ray.perDepth));
}

double SightHits::summit(const Ray& ray, double from, double to) const {
    constexpr double golden = 0.6180339887498949;
    double one = to - golden * (to - from), other = from + golden * (to - from);
    double atOne = value(ray, one), atOther = value(ray, other);
    for (int i = 0; i < 40; ++i) {
        if (atOne >= atOther) {
            to = std::exchange(other, one);
            atOther = std::exchange(atOne, value(ray, one = to - golden * (to - from)));
        } else {
            from = std::exchange(one, other);
            atOne = std::exchange(atOther, value(ray, other = from + golden * (to - from)));
        }
    }
    return 0.5 * (from + to);
}

double SightHits::crossing(const Ray& ray, double below, double above, double least) const {
    for (int i = 0; i < 40; ++i) {
        const double middle = 0.5 * (below + above);
        (value(ray, middle) >= least ? above : below) = middle;
    }
    return above;
}

std::optional<double> SightHits::first(const Ray& ray, double least, double end) const {
    const double count = std::ceil((end - ray.enter) / step(ray));
    const auto at = [&](double i) { return ray.enter + (end - ray.enter) * i / std::max(count, 1.0); };
    double before = -std::numeric_limits<double>::infinity(), last = before;
    for (double i = 0.0; i <= count; ++i) {
        const double here = value(ray, at(i));
        // Between three samples, of which none may reach as high as what is between them.
        if (i > 1.0 && last >= before && last >= here && last < least) {
            const double top = summit(ray, at(i - 2.0), at(i));
            if (value(ray, top) >= least) return crossing(ray, at(i - 2.0), top, least);
        }
        if (here >= least) return i > 0.0 ? crossing(ray, at(i - 1.0), at(i), least) : ray.enter;
        before = std::exchange(last, here);
    }
    return std::nullopt;
}

std::optional<SightHits::Met> SightHits::surface(const Ray& ray) const {
    if (!(ray.enter < ray.leave)) return std::nullopt;
    const auto met = first(ray, isovalue_, ray.leave);
    if (!met) return std::nullopt;
    const double depth = *met;
    const glm::dmat3 toEye = glm::inverse(glm::transpose(glm::dmat3(layerToEye_)));
    glm::dvec3 normal = -ray.side.value_or(glm::dvec3(0.0));
    if (depth > ray.enter || !ray.side) normal = field_->falling(ray.origin + depth * ray.perDepth);
    const bool flat = normal == glm::dvec3(0.0);
    const Shade shade = shadeOf(flat ? normal : glm::normalize(toEye * normal), style_.light, view_.camera,
                                style_.silhouettes);
    return Met{depth, transfer_.color(isovalue_) * shade.diffuse + shade.specular};
}

std::optional<Hit> SightHits::greatest(std::uint32_t column, std::uint32_t row) const {
    const Ray ray = through(column + 0.5, row + 0.5);
    if (!(ray.enter < ray.leave)) return std::nullopt;
    const double count = std::ceil((ray.leave - ray.enter) / step(ray));
    const auto at = [&](double i) { return ray.enter + (ray.leave - ray.enter) * i / count; };
    double best = -std::numeric_limits<double>::infinity(), place = 0.0;
    for (double i = 0.0; i <= count; ++i) {
        if (const double v = value(ray, at(i)); v > best) {
            best = v;
            place = i;
        }
    }
    double depth = at(place);
    const double top = summit(ray, at(std::max(place - 1.0, 0.0)), at(std::min(place + 1.0, count)));
    if (const double v = value(ray, top); v > best) {
        best = v;
        depth = top;
    }
    if (const auto met = first(ray, best - 1.5 * codeStep_, depth)) depth = *met;
    const double most = transfer_.opacity.maximum();
    const double opacity = most > 0.0 ? layer_.opacity * transfer_.opacity(best) / most : 0.0;
    if (!(opacity > 0.0)) return std::nullopt;
    return Hit{column, depth, opacity, transfer_.color(best)};
}

void SightHits::addRow(std::uint32_t row, std::vector<Hit>& hits) const {
    for (std::uint32_t column = 0; column < view_.width; ++column) {
        if (style_.shows == HybridShows::maximum) {
            if (const auto hit = greatest(column, row)) hits.push_back(*hit);
            continue;
        }
        std::vector<Met> met;
        for (const auto& [x, y] : looks) {
            if (const auto one = surface(through(column + 0.5 + x / 16.0, row + 0.5 + y / 16.0)))
                met.push_back(*one);
        }
        std::stable_sort(met.begin(), met.end(),
                         [](const Met& a, const Met& b) { return a.depth < b.depth; });
        double left = 8.0;
        for (const auto& one : met) {
            hits.push_back({column, one.depth, std::min(layer_.opacity / left, 1.0), one.color});
            left -= layer_.opacity;
        }
    }
}

}  // namespace mote::reference
