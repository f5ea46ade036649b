// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/layers/hybrid/field_sight.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <glm/matrix.hpp>
#include <limits>
#include <new>
#include <tuple>
#include <utility>

#include "server/render/layers/hybrid/lower_hybrid.h"
#include "server/render/plan/in_turns.h"
#include "server/render/plan/seen_fields.h"
#include "server/render/plan/work_in_turns.h"

namespace mote::render {
namespace {

constexpr double exactSightStep = 0.25, movingSightStep = 1.0;    // cells
constexpr std::size_t mostSightFragments = std::size_t{1} << 26;  // of a layer: 2 GB
constexpr int halvings = 14;                                      // of a step, to where a surface is

HalfSpaces cellSides(const glm::dvec3& cells) {
    HalfSpaces sides;
    for (int axis = 0; axis < 3; ++axis) {
        glm::dvec3 normal(0.0);
        normal[axis] = 1.0;
        sides.push_back({normal, 0.0});
        sides.push_back({-normal, -cells[axis]});
    }
    return sides;
}

bool isCorrected(const HybridStyle& style, const GridField& field) {
    return resolved(style.representation, field) != HybridRepresentation::volume;
}

/// Where nobody says which value: where something begins to be seen.
double isovalueOf(const HybridStyle& style, const TransferFunction& transfer) {
    if (style.isovalue) return *style.isovalue;
    const auto& knots = transfer.opacity.knots();
    const auto seen = std::find_if(knots.begin(), knots.end(), [](const auto& knot) { return knot.y > 0.0; });
    if (seen == knots.begin() || seen == knots.end()) return knots.front().x;
    return std::prev(seen)->x;
}

}  // namespace

FieldSight::FieldSight(const Layer& layer, const HybridStyle& style, std::shared_ptr<const GridField> field,
                       const Lowering& out)
    : field_(std::move(field)),
      samples_(*field_, isCorrected(style, *field_)),
      ranges_(gridRanges({.grid = field_, .bricks = isCorrected(style, *field_)})),
      transfer_(transferOf(style, *field_)),
      surface_(style.shows == HybridShows::surface),
      isoCode_(static_cast<float>(field_->codeOf(isovalueOf(style, transfer_)))),
      color_(transfer_.color(isovalueOf(style, transfer_))),
      light_(style.light, out.plan.camera.worldToEye(), style.silhouettes),
      opacity_(layer.opacity),
      exact_(out.plan.exact),
      perspective_(out.plan.camera.perspective()),
      nearest_(nearLimit(out.plan.camera)),
      size_(out.plan.width, out.plan.height),
      pixels_(out.plan.height / (2.0 * out.plan.camera.halfHeight())) {
    step_ = exact_ ? exactSightStep : movingSightStep;
    const glm::dvec3 ratio = samples_.cells() / glm::dvec3(field_->coarse.size);
    coarseStep_ = step_ * std::min({ratio.x, ratio.y, ratio.z});
    const glm::dmat4 cellsToLayer = glm::scale(field_->boxToLayer, 1.0 / samples_.cells());
    const glm::dmat4 cellsToEye = out.plan.camera.worldToEye() * layer.transform * cellsToLayer;
    const Bounds inEye = Bounds{glm::dvec3(0.0), samples_.cells()}.transformed(cellsToEye);
    gap_ = inEye.size().z / out.slabs;
    eyeToCells_ = glm::inverse(cellsToEye);
    slopeToNormal_ = -glm::transpose(glm::dmat3(eyeToCells_));
    sides_ = cellSides(samples_.cells());
    const auto clips = inSpace(layer.clips(), cellsToLayer);
    sides_.insert(sides_.end(), clips.begin(), clips.end());
}

FieldSight::Way FieldSight::wayThrough(double x, double y) const {
    const glm::dvec2 window = glm::dvec2(x - 0.5 * size_.x, 0.5 * size_.y - y) / pixels_;
    const glm::dvec3 origin = perspective_ ? glm::dvec3(0.0) : glm::dvec3(window, 0.0);
    const glm::dvec3 perDepth = perspective_ ? glm::dvec3(window, -1.0) : glm::dvec3(0.0, 0.0, -1.0);
    Way way{glm::dvec3(eyeToCells_ * glm::dvec4(origin, 1.0)), glm::dmat3(eyeToCells_) * perDepth, nearest_,
            std::numeric_limits<double>::infinity()};
    for (const auto& side : sides_) {
        const double before = way.enter;
        clipWay({&side, 1}, way.origin, way.direction, way.enter, way.leave);
        if (way.enter > before) way.entered = &side;
    }
    const bool ends = std::isfinite(way.enter) && std::isfinite(way.leave) && way.enter < way.leave;
    return ends ? way : Way{};
}

float FieldSight::codeAt(const Way& way, double depth) const {
    return samples_.code(glm::vec3(way.origin + depth * way.direction));
}

FieldSight::Block FieldSight::blockAt(const Way& way, double depth) const {
    const double edge = 1U << ranges_.edgeBits();
    const glm::dvec3 sample = way.origin + depth * way.direction - 0.5;
    const glm::ivec3 last = glm::ivec3(ranges_.count()) - 1;
    const glm::ivec3 block = glm::clamp(glm::ivec3(glm::floor(sample / edge)), glm::ivec3(0), last);
    const auto [x, y, z] = std::tuple<std::size_t, std::size_t, std::size_t>(block.x, block.y, block.z);
    Block found{(z * ranges_.count().y + y) * ranges_.count().x + x, way.leave};
    for (int axis = 0; axis < 3; ++axis) {
        const double speed = way.direction[axis];
        // The outermost blocks reach to the box's sides.
        if (speed == 0.0 || block[axis] == (speed > 0.0 ? last[axis] : 0)) continue;
        const double border = (block[axis] + (speed > 0.0 ? 1 : 0)) * edge;
        found.end = std::min(found.end, depth + (border - sample[axis]) / speed);
    }
    found.end = std::max(found.end, depth);
    return found;
}

bool FieldSight::mayExceed(const Block& block, float code) const {
    // Ranges are values in single precision.
    const double little = 1e-6 * (field_->range.high - field_->range.low);
    return double{ranges_.ranges()[block.index].high} + little > field_->valueOf(double{code});
}

double FieldSight::stepIn(const Block& block, const Way& way) const {
    return (ranges_.fine(block.index) ? step_ : coarseStep_) / glm::length(way.direction);
}

/// No step leads past where another kind of block begins.
double FieldSight::next(const Way& way, const Block& block, double depth) const {
    const double least = 0.5 * step_ / glm::length(way.direction);
    return std::min({depth + stepIn(block, way), std::max(block.end, depth + least), way.leave});
}

std::optional<FieldSight::Found> FieldSight::first(const Way& way) const {
    const float below = std::nextafter(isoCode_, -1.0F);
    double before = way.enter;
    for (double depth = way.enter;;) {
        const Block block = blockAt(way, depth);
        if (!mayExceed(block, below)) {
            before = depth = block.end;
        } else if (codeAt(way, depth) >= isoCode_) {
            if (depth == way.enter) return Found{depth, isoCode_};
            for (int i = 0; i < halvings; ++i) {
                const double middle = 0.5 * (before + depth);
                (codeAt(way, middle) >= isoCode_ ? depth : before) = middle;
            }
            return Found{depth, isoCode_};
        } else {
            before = depth;
        }
        if (!(depth < way.leave)) return std::nullopt;
        depth = next(way, block, depth);
    }
}

FieldSight::Found FieldSight::greatest(const Way& way) const {
    double step = 0.0;
    Found best;
    for (double depth = way.enter;;) {
        const Block block = blockAt(way, depth);
        if (!mayExceed(block, best.code)) {
            depth = block.end;
        } else if (const float code = codeAt(way, depth); code > best.code) {
            best = {depth, code};
            step = stepIn(block, way);
        }
        if (!(depth < way.leave)) break;
        depth = next(way, block, depth);
    }
    // Between the samples around it.
    for (double reach = 0.5 * step; reach > 0.02 * step && best.code >= 0.0F; reach *= 0.5) {
        for (const double depth : {best.depth - reach, best.depth + reach}) {
            if (depth < way.enter || depth > way.leave) continue;
            if (const float code = codeAt(way, depth); code > best.code) best = {depth, code};
        }
    }
    return best;
}

/// On a side of what stays it has that side's normal.
glm::dvec3 FieldSight::colorAt(const Way& way, double depth) const {
    glm::dvec3 across =
        slopeToNormal_ * glm::dvec3(samples_.slope(glm::vec3(way.origin + depth * way.direction)));
    if (depth == way.enter && way.entered != nullptr) across = slopeToNormal_ * way.entered->normal;
    const double length = glm::length(across);
    const Shade shade = length > 0.0 ? light_.of(across / length) : light_.flat();
    return color_ * double{shade.diffuse} + double{shade.specular};
}

void FieldSight::addSurface(std::uint32_t column, std::uint32_t row, PixelFragments& pixel) const {
    for (std::uint32_t sample = 0; sample < pixel.samples(); ++sample) {
        const auto [x, y] = pixel.samples() == 1 ? std::array{0, 0} : PixelFragments::places[sample];
        const Way way = wayThrough(column + 0.5 + x / 16.0, row + 0.5 + y / 16.0);
        if (!(way.enter <= way.leave)) continue;
        if (const auto found = first(way)) pixel.add({found->depth, sample, colorAt(way, found->depth)});
    }
}

void FieldSight::addGreatest(std::uint32_t column, std::uint32_t row, Fragments& fragments) const {
    const Way way = wayThrough(column + 0.5, row + 0.5);
    if (!(way.enter <= way.leave)) return;
    const Found found = greatest(way);
    const double value = field_->valueOf(double{found.code}), most = transfer_.opacity.maximum();
    const auto opacity = static_cast<float>(most > 0.0 ? opacity_ * transfer_.opacity(value) / most : 0.0);
    if (found.code < 0.0F || !(opacity > 0.0F)) return;
    fragments.push_back({column, row, found.depth, opacity, glm::vec3(transfer_.color(value))});
}

void FieldSight::addRow(std::uint32_t row, Fragments& fragments) const {
    PixelFragments pixel(exact_ ? PixelFragments::mostSamples : 1, opacity_, gap_);
    for (std::uint32_t column = 0; column < static_cast<std::uint32_t>(size_.x); ++column) {
        if (!surface_) {
            addGreatest(column, row, fragments);
            continue;
        }
        addSurface(column, row, pixel);
        pixel.take(column, row, fragments);
    }
}

void lowerSight(const Layer& layer, const HybridStyle& style, const std::shared_ptr<const GridField>& field,
                Lowering& out) {
    const Bounds inEye = field->bounds().transformed(out.plan.camera.worldToEye() * layer.transform);
    if (!(-inEye.min.z >= nearLimit(out.plan.camera))) return;
    const FieldSight sight(layer, style, field, out);
    std::vector<Fragments> rows(out.plan.height);
    std::atomic<std::size_t> count{0};
    forRangesInTurns(rows.size(), 1, [&](const auto& range) {
        for (auto row = range.begin(); row != range.end() && !isStopped(out.stop); ++row) {
            sight.addRow(static_cast<std::uint32_t>(row), rows[row]);
            if (count += rows[row].size(); count > mostSightFragments) throw std::bad_alloc();
        }
    });
    auto all = std::make_shared<Fragments>();
    all->reserve(count);
    for (const auto& row : rows) all->insert(all->end(), row.begin(), row.end());
    if (all->empty()) return;
    out.addDots(-inEye.max.z, -inEye.min.z);
    out.plan.fragments.push_back(std::move(all));
}

}  // namespace mote::render
