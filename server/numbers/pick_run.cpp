// SPDX-License-Identifier: GPL-3.0-or-later
//
// A pick: docs/SELECTIONS.md, "Picking".
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "protocol/scene/particles_style.h"
#include "protocol/scene/plot_density.h"
#include "protocol/scene/space/metres.h"
#include "protocol/scene/view_message.h"
#include "protocol/scene/view_parts.h"
#include "server/numbers/nearest_point.h"
#include "server/numbers/query_run.h"
#include "storage/beam/quantity_reader.h"
#include "storage/storage_error.h"

namespace mote::server {
namespace {

constexpr double defaultRadius = 8.0, greatestRadius = 1024.0;  // pixels

class PickRun final : public QueryRun {
  public:
    PickRun(QueryContext& context, View view, PicturePlace place, double radius)
        : context_(context), view_(std::move(view)), place_(place), radius_(radius) {}

    Result<QueryAnswer> next(const Cancelled& cancelled) override {
        best_.distance = std::nextafter(radius_, INFINITY);  // what is as far belongs to it
        try {
            for (std::size_t i = 0; i < view_.layers.size(); ++i) {
                const auto status = lookAt(i, cancelled);
                MOTE_RETURN_IF_ERROR(status, fmt::format("query.pick.view.layers[{}]", i));
            }
            QueryAnswer answer;
            answer.message.set_last(true);
            auto& picked = *answer.message.mutable_picked();
            if (layer_) MOTE_RETURN_IF_ERROR(tell(answer.message, picked));
            return answer;
        } catch (const storage::StorageError& error) {
            return error.error();
        }
    }

  private:
    /// Points of a layer are its own, or the chosen ones, and those that are highlighted.
    Status lookAt(std::size_t index, const Cancelled& cancelled) {
        const auto& layer = view_.layers[index];
        if (layer.particles() == nullptr || !(layer.opacity > 0.0)) return success();
        const auto style = particlesStyleOf(*layer.particles(), view_.height);
        MOTE_ASSIGN_OR_RETURN(const auto run, context_.runs.run(layer.dataset));
        MOTE_ASSIGN_OR_RETURN(const auto numbers, run->step(layer.step));
        if (style.pointOpacity > 0.0) {
            const auto drawn = [&](const storage::ParticleStep& points) {
                return drawnFraction(style, run->manifest(), layer, points.pointCount());
            };
            MOTE_RETURN_IF_ERROR(
                find(index, run, numbers, layer.select ? *layer.select : Selection(), drawn, cancelled));
        }
        if (layer.highlight && layer.highlight->opacity > 0.0) {
            Selection both = layer.highlight->selection;
            if (layer.select) {
                both = Selection();
                both.all = {*layer.select, layer.highlight->selection};
            }
            const auto all = [](const storage::ParticleStep&) { return Curve::constant(1.0); };
            MOTE_RETURN_IF_ERROR(find(index, run, numbers, both, all, cancelled));
        }
        return success();
    }

    /// What of a leaf's points is drawn, of so many points of a layer: what the view says, or its plot.
    static Curve drawnFraction(ParticlesStyle style, const proto::ParticlesManifest& manifest,
                               const Layer& layer, std::uint64_t points) {
        auto plot = PlotDensity::of(manifest, layer.step);
        if (layer.select && !layer.select->everything()) plot.particles = points;
        resolveByPlot(style, plot);
        return std::move(style.pointFraction);
    }

    /// `drawn` gives of points what of a leaf's is drawn.
    template <class Drawn>
    Status find(std::size_t index, const SelectionResults::Run& run, const storage::StepNumbers& numbers,
                const Selection& selection, const Drawn& drawn, const Cancelled& cancelled) {
        const auto& layer = view_.layers[index];
        MOTE_ASSIGN_OR_RETURN(const auto selected,
                              context_.selections.chosen(run, layer.step, selection, cancelled));
        const storage::ParticleStep& points = selected ? *selected : *numbers.points;
        auto found = best_;
        MOTE_ASSIGN_OR_RETURN(const auto place, placeOf(layer, run->manifest()));
        if (!findNearest(points, drawn(points), view_, place, layer.clips(), place_, cancelled, found))
            return Error{ErrorCode::cancelled, "", "cancelled"};
        if (!found.before(best_)) return success();
        if (selected) found.point = selected->sources()[found.point];
        best_ = found;
        layer_ = index;
        run_ = run;
        numbers_ = numbers;
        return success();
    }

    /// Layer to world.
    Result<glm::dmat4> placeOf(const Layer& layer, const proto::ParticlesManifest& plot) const {
        if (!view_.metres) return layer.transform;
        return layerToWorld(layer, *view_.metres, [&](const std::string& name, std::uint32_t step) {
            return plotInMetres(plot, step, name);
        });
    }

    Status tell(proto::Answer& answer, proto::Picked& picked) const {
        const auto step = view_.layers[*layer_].step;
        const auto& entry = run_->manifest().steps(static_cast<int>(step));
        answer.set_step(step);
        answer.set_iteration(entry.iteration());
        answer.set_time(entry.time());
        picked.set_found(true);
        picked.set_layer(static_cast<std::uint32_t>(*layer_));
        picked.set_point(best_.point);
        picked.set_row(numbers_.points->rows(best_.point, 1)[0]);
        picked.set_distance(best_.distance);
        for (int axis = 0; axis < 3; ++axis) picked.add_position(best_.position[axis]);
        picked.set_density(best_.density);
        if (!numbers_.columns) return success();
        const auto& columns = *numbers_.columns;
        for (std::size_t i = 0; i < columns.columns().size(); ++i) {
            const auto& info = columns.columns()[i];
            picked.add_names(info.name);
            picked.add_units(info.unit);
            picked.add_values(columns.value(i, best_.point));
        }
        if (columns.hasIds()) picked.set_id(columns.ids(best_.point, 1)[0]);
        columns.check();
        return success();
    }

    QueryContext& context_;
    const View view_;
    const PicturePlace place_;
    const double radius_;
    NearestPoint best_;
    std::optional<std::size_t> layer_;  // of the best
    SelectionResults::Run run_;         // likewise
    storage::StepNumbers numbers_;      // likewise
};

}  // namespace

Result<std::unique_ptr<QueryRun>> makePickRun(const proto::PickQuery& query, QueryContext& context) {
    auto view = parseView(query.view());
    MOTE_RETURN_IF_ERROR(view, "view");
    // Between steps the nearer one is picked from.
    view = viewAt(lengthsInPixels(*std::move(view)), nearestPlace);
    if (view->cameraFitted) return invalid("view.camera", "a pick needs the camera of its picture");
    if (!std::isfinite(query.x()) || !std::isfinite(query.y()))
        return invalid(std::isfinite(query.x()) ? "y" : "x", "must be a finite number of pixels");
    const double radius = query.has_radius() ? query.radius() : defaultRadius;
    if (!(radius > 0.0 && radius <= greatestRadius))
        return invalid("radius", fmt::format("must lie above 0 and be at most {} pixels", greatestRadius));
    return Result<std::unique_ptr<QueryRun>>(
        std::make_unique<PickRun>(context, *std::move(view), PicturePlace{query.x(), query.y()}, radius));
}

}  // namespace mote::server
