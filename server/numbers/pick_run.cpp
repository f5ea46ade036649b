// SPDX-License-Identifier: GPL-3.0-or-later
//
// A pick: docs/SELECTIONS.md, "Picking".
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <glm/matrix.hpp>
#include <thread>

#include "protocol/scene/ink_style.h"
#include "protocol/scene/particles_style.h"
#include "protocol/scene/plot_density.h"
#include "protocol/scene/space/metres.h"
#include "protocol/scene/view_message.h"
#include "protocol/scene/view_parts.h"
#include "server/data/load_hybrid.h"
#include "server/data/load_mesh.h"
#include "server/numbers/nearest_point.h"
#include "server/numbers/query_run.h"
#include "server/render/layers/ink/ink_data.h"
#include "server/render/layers/ink/lower_ink.h"
#include "server/render/plan/frame_plan.h"
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
            for (std::size_t i = 0; i < view_.layers.size() && !layer_; ++i) {
                const auto status = lookAtDrawing(i, cancelled);
                MOTE_RETURN_IF_ERROR(status, fmt::format("query.pick.view.layers[{}]", i));
            }
            QueryAnswer answer;
            answer.message.set_last(true);
            auto& picked = *answer.message.mutable_picked();
            if (layer_) MOTE_RETURN_IF_ERROR(tell(answer.message, picked));
            if (drawn_ && !layer_) tellDrawn(picked);
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

    struct Drawn {
        std::size_t layer;
        double depth;
        glm::dvec3 position;  ///< layer space
    };

    /// Of drawings in ink that which is nearest at the place itself.
    Status lookAtDrawing(std::size_t index, const Cancelled& cancelled) {
        const auto& layer = view_.layers[index];
        if (layer.ink() == nullptr || !(layer.opacity > 0.0)) return success();
        MOTE_ASSIGN_OR_RETURN(const auto entry, context_.runs.dataset(layer.dataset));
        MOTE_ASSIGN_OR_RETURN(const auto data, drawnOf(entry, layer, cancelled));
        MOTE_ASSIGN_OR_RETURN(const auto transform, placeOf(layer, *entry.manifest));
        render::FramePlan plan;
        plan.width = view_.width;
        plan.height = view_.height;
        plan.camera = view_.camera;
        const auto depth =
            render::depthAt(data, transform, inkStyleOf(*layer.ink()), plan, {place_.x, place_.y});
        if (!depth || (drawn_ && drawn_->depth <= *depth)) return success();
        drawn_ = Drawn{index, *depth, inLayer(transform, *depth)};
        return success();
    }

    /// What a drawing is of. Errors: of its files; invalidArgument (of another kind); cancelled.
    Result<render::InkData> drawnOf(const storage::Catalogue::Entry& entry, const Layer& layer,
                                    const Cancelled& cancelled) const {
        render::LayerData data;
        const auto& kind = entry.manifest->kind();
        if (kind == "mesh" || kind == "stipple") {
            MOTE_ASSIGN_OR_RETURN(data.mesh, loaded(meshSurface(entry, layer.clips()), cancelled));
        } else if (kind == "particles") {
            MOTE_ASSIGN_OR_RETURN(data.density, loaded(stepDensity(entry, layer.step), cancelled));
        } else {
            MOTE_ASSIGN_OR_RETURN(
                data.hybrid, loaded(hybridStep(entry, layer.step, HybridRepresentation::best), cancelled));
        }
        return render::inkDataOf(layer, data);
    }

    /// Waits for what pictures have in memory, which nobody says to a question when it comes.
    template <class T>
    Result<std::shared_ptr<const T>> loaded(const Result<Loadable<T>>& what,
                                            const Cancelled& cancelled) const {
        constexpr std::chrono::milliseconds pause{10};
        constexpr int most = 3000;
        MOTE_RETURN_IF_ERROR(what);
        for (int i = 0; i < most; ++i) {
            MOTE_ASSIGN_OR_RETURN(const auto found, context_.runs.resident(*what));
            if (found.value) return std::static_pointer_cast<const T>(found.value);
            if (cancelled()) return Error{ErrorCode::cancelled, "", "cancelled"};
            std::this_thread::sleep_for(pause);
        }
        return Error{ErrorCode::resourceExhausted, "dataset", "it did not come into memory in time"};
    }

    /// What lies so deep at the place.
    glm::dvec3 inLayer(const glm::dmat4& transform, double depth) const {
        const double half = view_.camera.halfHeight() * (view_.camera.perspective() ? depth : 1.0);
        const glm::dvec4 inEye((2.0 * place_.x / view_.width - 1.0) * view_.aspect() * half,
                               (1.0 - 2.0 * place_.y / view_.height) * half, -depth, 1.0);
        return glm::dvec3(glm::inverse(view_.camera.worldToEye() * transform) * inEye);
    }

    void tellDrawn(proto::Picked& picked) const {
        picked.set_found(true);
        picked.set_layer(static_cast<std::uint32_t>(drawn_->layer));
        for (int axis = 0; axis < 3; ++axis) picked.add_position(drawn_->position[axis]);
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

    Result<glm::dmat4> placeOf(const Layer& layer, const proto::Manifest& manifest) const {
        if (!view_.metres) return layer.transform;
        return layerToWorld(layer, *view_.metres, [&](const std::string& name, std::uint32_t step) {
            return placeInMetres(manifest, step, name);
        });
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
    std::optional<Drawn> drawn_;        // where there is no point
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
