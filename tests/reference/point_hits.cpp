// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/reference/point_hits.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <limits>
#include <numbers>
#include <tuple>
#include <utility>

#include "server/render/layers/contrast/lower_contrast.h"
#include "server/render/layers/make_frame_plan.h"
#include "server/render/layers/particles/lower_particles.h"
#include "tests/reference/leaf_points.h"
#include "tests/reference/volume_field.h"

namespace mote::reference {
namespace {

// Written down once more, not taken from the devices' frame plan: see docs/PICTURE.md.
constexpr double nearShare = 1e-3;

// Single precision places a point in a picture of some hundred pixels to about 1e-4 of a pixel (2^-24 of 500
// pixels, a handful of operations); ten times that is beyond doubt.
constexpr double doubtfulPixels = 1e-3;

bool inside(double value, std::uint32_t size) {
    return value >= 0.0 && value < size;
}

/// The pixels of a side that something around `center` may touch, from the first to before the end; of no
/// reach, the one that holds it.
std::pair<std::uint32_t, std::uint32_t> touched(double center, double reach, std::uint32_t side) {
    const double first = std::max(std::floor(reach > 0.0 ? center - reach - 0.5 : center), 0.0);
    const double end = reach > 0.0 ? std::ceil(center + reach + 0.5) : std::floor(center) + 1.0;
    if (!(first < side && end > first)) return {0, 0};
    return {static_cast<std::uint32_t>(first), static_cast<std::uint32_t>(std::min<double>(end, side))};
}

constexpr double none = std::numeric_limits<double>::quiet_NaN();

/// What a point of such a diameter covers, in whole pixels.
double discArea(double size) {
    return size > 1.0 ? std::numbers::pi * (0.25 * size * size + 1.0 / 12.0) : 1.0;
}

/// docs/PICTURE.md, "Colour by a column": of points that a view says to be opaque, the nearest; or as it
/// says.
bool ofNearest(const Layer& layer) {
    const auto& points = layer.particles()->points();
    const auto& said = layer.colorBy->of_pixel();
    return said.empty() ? points.has_opacity() && points.opacity() >= 0.5 : said == "nearest";
}

}  // namespace

bool cutAway(const Layer& layer, const glm::dvec3& place) {
    for (const auto& side : layer.clips()) {
        const glm::dvec3 off = place - side.distance * side.normal;
        if (off.x * side.normal.x + off.y * side.normal.y + off.z * side.normal.z < 0.0) return true;
    }
    return false;
}

double nearestDepth(const Camera& camera) {
    if (!camera.perspective()) return -std::numeric_limits<double>::infinity();
    return std::max(nearShare * glm::length(camera.target - camera.eye), 0.0);
}

PointHits::PointHits(const render::Scene& scene, const Options& options)
    : width_(scene.view.width),
      height_(scene.view.height),
      view_(scene.view),
      placeOf_(options.placeOf),
      colors_(scene.view.layers.size()) {
    ambiguous_.assign(std::size_t{width_} * height_, 0);
    for (std::uint32_t layer = 0; layer < scene.view.layers.size(); ++layer) {
        if (!(scene.view.layers[layer].opacity > 0.0)) continue;
        if (scene.view.layers[layer].particles() != nullptr) {
            addLayer(scene, layer);
            addHighlight(scene, layer);
            addPaths(scene, layer);
        }
        if (scene.view.layers[layer].mesh() != nullptr)
            meshes_.emplace_back(scene.view, scene.view.layers[layer], *scene.layers[layer].mesh);
        if (showsSight(scene.view.layers[layer])) {
            sights_.emplace_back(scene.view, scene.view.layers[layer], *scene.layers[layer].hybrid,
                                 options.samplesPerCell);
        }
        if (scene.view.layers[layer].ink() != nullptr) addInk(scene, layer);
        if (scene.view.layers[layer].image() != nullptr)
            images_.emplace_back(scene.view, scene.view.layers[layer], *scene.layers[layer].image);
    }
    for (const auto& one : options.strokes) strokes_.emplace_back(scene.view, *one);
    if (scene.dots != nullptr) addDots(scene);
    addContrast(scene);
    sort();
}

/// As with ink, which fragments there are tests/unit/render/contrast_test.cpp holds; here they are drawn.
void PointHits::addContrast(const render::Scene& scene) {
    if (!(view_.depthContrast > 0.0)) return;
    const auto plan = render::makeFramePlan(scene, render::Quality::exact());
    const auto contrast = render::depthContrastOf(scene, plan, {});
    if (contrast != nullptr) contrast->make({0, 0, width_, height_}, contrast_);
}

/// Which strokes there are docs/INK.md says, and tests/unit/ink holds that; here they are drawn.
void PointHits::addInk(const render::Scene& scene, std::uint32_t layer) {
    const render::FramePlan plan{.width = scene.view.width,
                                 .height = scene.view.height,
                                 .camera = scene.view.camera,
                                 .background = scene.view.background};
    Layer whole = scene.view.layers[layer];
    const double opacity = std::exchange(whole.opacity, 1.0);
    inks_.push_back(render::inkOf(whole, inkStyleOf(*whole.ink(), whole.inkIsDark),
                                  render::inkDataOf(whole, scene.layers[layer]), plan, 1.0, {}));
    if (inks_.back().wash != nullptr)
        inks_.back().wash->make({0, 0, plan.width, plan.height}, inks_.back().fragments);
    for (auto& fragment : inks_.back().fragments) fragment.opacity *= static_cast<float>(opacity);
    inks_.back().strokes.opacity = static_cast<float>(opacity);
    strokes_.emplace_back(scene.view, inks_.back().strokes);
}

/// As with ink, which strokes there are the functions that make them say; here they are drawn.
void PointHits::addPaths(const render::Scene& scene, std::uint32_t layer) {
    const Layer& of = scene.view.layers[layer];
    if (!of.paths || scene.layers[layer].paths == nullptr) return;
    const render::FramePlan plan{
        .width = scene.view.width, .height = scene.view.height, .camera = scene.view.camera};
    paths_.push_back(render::pathStrokes(of, *of.paths, render::particlesStyleOf(scene, layer).pointColor,
                                         *scene.layers[layer].paths, plan, 1.0));
    if (paths_.back().empty()) return;
    strokes_.emplace_back(scene.view, paths_.back());
    // docs/PICTURE.md, "Paths": the casing lies behind them.
    auto casing = paths_.back();
    for (auto& point : casing.points) point.width += static_cast<float>(scene.view.height) / 360.0F;
    casing.color = glm::vec3(scene.view.background);
    paths_.push_back(std::move(casing));
    strokes_.emplace_back(scene.view, paths_.back());
}

/// docs/PICTURE.md, "Points": where the light of a point is the plot's, so is its size.
PointHits::Look PointHits::lookOf(const View& view, const glm::dmat4& transform,
                                  const ParticlesStyle& style) {
    Look look{style.pointSize, style.pointOpacity, style.pointColor};
    if (!style.opacityByPlot || !(style.pointArea > 0.0)) return look;
    const double unit = std::cbrt(std::abs(glm::determinant(glm::dmat3(transform))));
    const double away = view.camera.perspective() ? glm::length(view.camera.target - view.camera.eye) : 1.0;
    const double pixels = view.height / (2.0 * view.camera.halfHeight() * away);
    look.area = style.pointArea * unit * unit;
    const bool onLight = glm::dot(view.background, glm::dvec3(0.2126, 0.7152, 0.0722)) > 0.21;
    const double disc =
        look.area * pixels * pixels / (onLight ? 2.0 : 0.7);  // so large, a point hides as much
    const double diameter = 2.0 * std::sqrt(std::max(disc / std::numbers::pi - 1.0 / 12.0, 0.0));
    if (style.sizeByPlot) look.size = std::min(disc > discArea(1.0 + 1e-9) ? diameter : 1.0, 64.0);
    look.size = std::max(look.size, 1.0);
    return look;
}

void PointHits::addLayer(const render::Scene& scene, std::uint32_t layer) {
    const View& view = scene.view;
    const storage::ParticleStep& step = *scene.layers[layer].step;
    const ParticlesStyle style = render::particlesStyleOf(scene, layer);
    const glm::dmat4 layerToEye = view.camera.worldToEye() * view.layers[layer].transform;
    const Look look = lookOf(view, view.layers[layer].transform, style);
    const VolumeField volume = volumeOf(scene, layer, style);
    const auto nodes = step.nodes();
    const auto& values = scene.layers[layer].values;
    const bool colored = view.layers[layer].colorBy && values != nullptr;
    const bool shades = !view.layers[layer].colorBy && style.pointShade;
    const PointShade* const shade = shades ? &*style.pointShade : nullptr;
    if (colored) colors_[layer] = {colorMapOf(*view.layers[layer].colorBy), ofNearest(view.layers[layer])};
    if (shades) colors_[layer] = {style.colorMap, false};
    const LogDensity scale = step.logDensity();
    const auto leaves = step.leaves();
    const auto fraction = [&](std::size_t leaf) {
        return 1.0 - (1.0 - style.pointFraction(scale.ofLeaf(leaves.density[leaf]))) * volume.share(leaf);
    };
    // docs/PICTURE.md, "Colour by density": the share of the colour map.
    const auto shareOf = [&](std::size_t leaf) {
        const auto wayOf = [&](double t) {
            return std::clamp((t - shade->t.low) / (shade->t.high - shade->t.low), 0.0, 1.0);
        };
        double way = wayOf(scale.ofLeaf(leaves.density[leaf]));
        if (!volume.empty() && way >= 0.5 / 255.0) {
            const auto node = leaves.node[leaf];
            const double edge = std::ldexp(2.0, -nodes.level[node]);
            glm::dvec3 middle(0.0);
            for (int axis = 0; axis < 3; ++axis)
                middle[axis] = (placeOf(nodes.morton[node], axis) + 0.5) * edge - 1.0;
            way = volume.held(middle) * wayOf(volume.t(middle));
        }
        return shade->colors.low + way * (shade->colors.high - shade->colors.low);
    };
    std::size_t leaf = 0;
    forPoints(step, fraction, [&](std::uint64_t point, const glm::dvec3& place) {
        while (point >= leaves.pointBegin[leaf] + leaves.pointCount[leaf]) ++leaf;
        const double all = leaves.density[leaf] * std::ldexp(1.0, -3 * nodes.level[leaves.node[leaf]]);
        const double weight =
            style.meanWeight > 0.0 ? all / (leaves.pointCount[leaf] * style.meanWeight) : 1.0;
        const auto code = colored ? values->codes.at(point) : render::noValue;
        const double value = shade                     ? shareOf(leaf)
                             : code == render::noValue ? none
                                                       : static_cast<double>(code) / render::greatestValue;
        const glm::dvec3 drawn = placeOf_ ? placeOf_(layer, point, place) : place;
        if (cutAway(view.layers[layer], drawn)) return;
        addPoint(view, layer, look, glm::dvec3(layerToEye * glm::dvec4(drawn, 1.0)), std::nullopt, value,
                 weight);
    });
}

double PointHits::Spot::depthOf(double covered) const {
    return tau >= 0.0 ? tau * covered : -std::log1p(-alpha * covered);
}

/// The disc's edge is softened over a pixel around a radius so chosen that its ink is that of the disc.
void PointHits::addDots(const render::Scene& scene) {
    const View& view = scene.view;
    auto number = static_cast<std::uint32_t>(view.layers.size());
    for (const auto& dot : *scene.dots) {
        const double radius = dot.radius;
        const double soft = std::sqrt(std::max(radius * radius, 1.0 / 3.0) - 1.0 / 12.0);
        const double alpha = dot.opacity * std::min(1.0, 3.0 * radius * radius);
        const bool near = std::isfinite(dot.depth) && dot.depth < nearestDepth(view.camera);
        if (!near && alpha > 0.0)
            spots_.push_back(
                {number, dot.depth, alpha, 1.0, dot.color, none, false, dot.x, dot.y, soft + 0.5});
        ++number;
    }
}

void PointHits::addPoint(const View& view, std::uint32_t layer, const Look& look, const glm::dvec3& inEye,
                         std::optional<double> stands, double value, double weight) {
    const double depth = -inEye.z;
    if (depth < nearestDepth(view.camera) || !(look.opacity > 0.0)) return;
    const double halfHeight = view.camera.halfHeight() * (view.camera.perspective() ? depth : 1.0);
    const double halfWidth = halfHeight * view.aspect();
    const double px = 0.5 * (inEye.x / halfWidth + 1.0) * view.width;
    const double py = 0.5 * (1.0 - inEye.y / halfHeight) * view.height;
    const bool small = look.size <= 1.0;
    const double ink = small ? look.size * look.size : 1.0;
    if (small) markAmbiguous(px, py);
    if (!small && !stands && !std::isnan(value) && colors_[layer].nearest)
        markHalfCovered(px, py, 0.5 * look.size);
    const double pixels = view.height / (2.0 * halfHeight);  // of a unit of the world
    const double tau = look.area > 0.0 ? look.area * pixels * pixels * weight / discArea(look.size) : -1.0;
    spots_.push_back({layer, stands.value_or(depth), ink * look.opacity, view.layers[layer].opacity,
                      look.color, value, stands.has_value(), px, py, small ? 0.0 : 0.5 * look.size + 0.5,
                      tau});
}

void PointHits::markAmbiguous(double px, double py) {
    const double x[] = {std::floor(px - doubtfulPixels), std::floor(px + doubtfulPixels)};
    const double y[] = {std::floor(py - doubtfulPixels), std::floor(py + doubtfulPixels)};
    if (x[0] == x[1] && y[0] == y[1]) return;
    for (const double row : y) {
        for (const double column : x) {
            if (!inside(column, width_) || !inside(row, height_)) continue;
            ambiguous_[static_cast<std::size_t>(row) * width_ + static_cast<std::size_t>(column)] = 1;
        }
    }
}

/// Pixels that a disc covers by half, or a little less: whether it counts there hangs on rounding.
void PointHits::markHalfCovered(double px, double py, double radius) {
    const auto [top, bottom] = touched(py, radius + 0.5, height_);
    const auto [left, right] = touched(px, radius + 0.5, width_);
    for (auto row = top; row < bottom; ++row) {
        for (auto column = left; column < right; ++column) {
            const double away = std::hypot(column + 0.5 - px, row + 0.5 - py);
            if (std::abs(away - radius) < doubtfulPixels) ambiguous_[std::size_t{row} * width_ + column] = 1;
        }
    }
}

void PointHits::sort() {
    // Points of one layer at one depth commute.
    std::stable_sort(spots_.begin(), spots_.end(), [](const Spot& a, const Spot& b) {
        return std::tie(a.depth, a.layer) < std::tie(b.depth, b.layer);
    });
    rows_.resize(height_);
    for (std::uint32_t i = 0; i < spots_.size(); ++i) {
        const auto [first, end] = touched(spots_[i].y, spots_[i].reach, height_);
        for (auto row = first; row < end; ++row) rows_[row].push_back(i);
    }
}

double PointHits::coverage(const Spot& spot, double column, double row) {
    if (spot.reach == 0.0) return 1.0;
    const double dx = column + 0.5 - spot.x, dy = row + 0.5 - spot.y;
    return std::clamp(spot.reach - std::hypot(dx, dy), 0.0, 1.0);
}

/// docs/PICTURE.md, "Colour by a column".
class PointHits::RowColors {
  public:
    RowColors(const std::vector<LayerColors>& colors, std::size_t layers, std::uint32_t width)
        : colors_(colors), pixels_(layers) {
        for (auto& row : pixels_) row.resize(width);
        highlights_.assign(pixels_.size(), std::vector(width, std::tuple(true, 1.0)));
    }

    /// Spots come front to back.
    void add(const Spot& spot, std::uint32_t column, double covered) {
        if (std::isnan(spot.value)) return;
        const bool far = spot.reach > 0.0 && covered < 0.5;
        if (spot.highlighted) {
            auto& nearest = highlights_[spot.layer][column];
            nearest = std::min(nearest, std::tuple(far, spot.value));
            return;
        }
        Pixel& pixel = pixels_[spot.layer][column];
        const double weight = spot.tau >= 0.0 ? covered : spot.depthOf(covered);
        if (!colors_[spot.layer].nearest) {
            pixel.weight += weight;
            pixel.sum += weight * spot.value;
            return;
        }
        const auto rank = std::tuple(far, spot.depth, spot.value);
        if (pixel.weight == 0.0 || rank < pixel.nearest) pixel.nearest = rank;
        pixel.weight = 1.0;
        pixel.sum = std::get<2>(pixel.nearest);
    }

    glm::dvec3 of(const Spot& spot, std::uint32_t column) const {
        if (spot.highlighted) return (1.0 - 0.75 * std::get<1>(highlights_[spot.layer][column])) * spot.color;
        const bool own = spot.layer < pixels_.size();
        if (!own || pixels_[spot.layer][column].weight == 0.0) return spot.color;
        const Pixel& pixel = pixels_[spot.layer][column];
        return colors_[spot.layer].map(pixel.sum / pixel.weight);
    }

  private:
    struct Pixel {
        double weight = 0.0, sum = 0.0;
        std::tuple<bool, double, double> nearest;
    };
    const std::vector<LayerColors>& colors_;
    std::vector<std::vector<Pixel>> pixels_;  // by layer
    /// Likewise: of the highlighted point that shades a pixel, whether it covers little of it, and its depth.
    std::vector<std::vector<std::tuple<bool, double>>> highlights_;
};

RowHits PointHits::row(std::uint32_t row) const {
    RowHits result;
    RowColors colors(colors_, view_.layers.size(), width_);
    const auto forPixels = [&](const Spot& spot, const auto& visit) {
        const auto [first, end] = touched(spot.x, spot.reach, width_);
        for (auto column = first; column < end; ++column) {
            const double covered = coverage(spot, column, row);
            if (covered > 0.0) visit(column, covered);
        }
    };
    for (const auto i : rows_[row])
        forPixels(spots_[i], [&](auto column, double covered) { colors.add(spots_[i], column, covered); });
    for (const auto i : rows_[row]) {
        const Spot& spot = spots_[i];
        forPixels(spot, [&](auto column, double covered) {
            const double alpha = spot.tau >= 0.0
                                     ? -std::expm1(-spot.layerOpacity * spot.depthOf(covered))
                                     : 1.0 - std::pow(1.0 - spot.alpha * covered, spot.layerOpacity);
            if (alpha > 0.0) result.hits_.push_back({column, spot.depth, alpha, colors.of(spot, column)});
        });
    }
    for (const auto& mesh : meshes_) mesh.addRow(row, result.hits_);
    for (const auto& sight : sights_) sight.addRow(row, result.hits_);
    const auto addFragments = [&](const render::Fragments& fragments) {
        for (const auto& fragment : fragments) {
            if (fragment.row != row) continue;
            result.hits_.push_back({fragment.column, fragment.depth, static_cast<double>(fragment.opacity),
                                    glm::dvec3(fragment.color)});
        }
    };
    for (const auto& ink : inks_) addFragments(ink.fragments);
    addFragments(contrast_);
    for (const auto& strokes : strokes_) strokes.addRow(row, result.hits_);
    for (auto image = images_.rbegin(); image != images_.rend(); ++image) image->addRow(row, result.hits_);
    std::stable_sort(result.hits_.begin(), result.hits_.end(), [](const Hit& a, const Hit& b) {
        return std::tie(a.column, a.depth) < std::tie(b.column, b.depth);
    });
    result.begin_.assign(std::size_t{width_} + 1, 0);
    for (const auto& hit : result.hits_) ++result.begin_[hit.column + 1];
    for (std::uint32_t i = 0; i < width_; ++i) result.begin_[i + 1] += result.begin_[i];
    return result;
}

}  // namespace mote::reference
