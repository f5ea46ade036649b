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
#include <utility>

#include "server/render/layers/hybrid/lower_hybrid.h"
#include "server/render/plan/in_turns.h"
#include "server/render/plan/seen_fields.h"
#include "server/render/plan/work_in_turns.h"

namespace mote::render {
namespace {

constexpr std::size_t mostSightFragments = std::size_t{1} << 26;  // of a layer: 2 GB
// What differs by less is met as one. Between two codes, as samples have whole ones.
constexpr double sameCodes = 1.5;

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

/// Where nobody says which value: where something begins to be seen, if anything is.
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
      pieces_(*field_, isCorrected(style, *field_)),
      ranges_(gridRanges({.grid = field_, .bricks = isCorrected(style, *field_)})),
      transfer_(transferOf(style, *field_)),
      surface_(style.shows == HybridShows::surface),
      isoCode_(field_->codeOf(isovalueOf(style, transfer_))),
      color_(transfer_.color(isovalueOf(style, transfer_))),
      light_(style.light, out.plan.camera.worldToEye(), style.silhouettes),
      opacity_(layer.opacity),
      exact_(out.plan.exact),
      perspective_(out.plan.camera.perspective()),
      nearest_(nearLimit(out.plan.camera)),
      size_(out.plan.width, out.plan.height),
      pixels_(out.plan.height / (2.0 * out.plan.camera.halfHeight())) {
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
    Way way{{glm::dvec3(eyeToCells_ * glm::dvec4(origin, 1.0)), glm::dmat3(eyeToCells_) * perDepth},
            nearest_,
            std::numeric_limits<double>::infinity()};
    for (const auto& side : sides_) {
        const double before = way.enter;
        clipWay({&side, 1}, way.line.origin, way.line.perDepth, way.enter, way.leave);
        if (way.enter > before) way.entered = &side;
    }
    const bool ends = std::isfinite(way.enter) && std::isfinite(way.leave) && way.enter < way.leave;
    return ends ? way : Way{};
}

bool FieldSight::mayReach(std::size_t block, double code) const {
    // Ranges are values in single precision.
    const double little = 1e-6 * (field_->range.high - field_->range.low);
    return double{ranges_.ranges()[block].high} + little >= field_->valueOf(code);
}

std::optional<double> FieldSight::first(const Way& way, double code, double leave) const {
    struct Visitor {
        const FieldSight& sight;
        const double code;
        std::optional<double> found;

        bool enters(std::size_t block) const { return sight.mayReach(block, code); }
        bool wants(double most) const { return most >= code; }
        bool take(const CodePiece& piece, double from, double to) {
            if (const auto share = piece.first(code)) found = std::lerp(from, to, *share);
            return !found;
        }
    };
    Visitor visitor{*this, code, std::nullopt};
    pieces_.along(way.line, way.enter, leave, visitor);
    return visitor.found;
}

FieldSight::Found FieldSight::greatest(const Way& way) const {
    struct Visitor {
        const FieldSight& sight;
        Found best;

        bool enters(std::size_t block) const { return sight.mayReach(block, best.code); }
        bool wants(double most) const { return most > best.code; }
        bool take(const CodePiece& piece, double from, double to) {
            add(piece.at(0.0), from);
            for (const double stop : piece.stops()) add(piece.at(stop), std::lerp(from, to, stop));
            return true;
        }
        void add(double code, double depth) {
            if (code > best.code) best = {depth, code};
        }
    };
    Visitor visitor{*this, {}};
    pieces_.along(way.line, way.enter, way.leave, visitor);
    // Where nearly as much is met: which of many places has the greatest code may be told by rounding.
    Found& best = visitor.best;
    if (const auto met = first(way, best.code - sameCodes, best.depth)) best.depth = *met;
    return best;
}

/// On a side of what stays it has that side's normal.
glm::dvec3 FieldSight::colorAt(const Way& way, double depth) const {
    glm::dvec3 across = slopeToNormal_ * glm::dvec3(samples_.slope(glm::vec3(way.line.at(depth))));
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
        if (const auto depth = first(way, isoCode_, way.leave))
            pixel.add({*depth, sample, colorAt(way, *depth)});
    }
}

void FieldSight::addGreatest(std::uint32_t column, std::uint32_t row, Fragments& fragments) const {
    const Way way = wayThrough(column + 0.5, row + 0.5);
    if (!(way.enter <= way.leave)) return;
    const Found found = greatest(way);
    const double value = field_->valueOf(found.code), most = transfer_.opacity.maximum();
    const auto opacity = static_cast<float>(most > 0.0 ? opacity_ * transfer_.opacity(value) / most : 0.0);
    if (found.code < 0.0 || !(opacity > 0.0F)) return;
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
    const bool none = style.shows == HybridShows::surface && !style.isovalue;
    if (none && !transferOf(style, *field).visible()) return;
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
