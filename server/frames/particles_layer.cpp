// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <memory>
#include <optional>
#include <queue>
#include <utility>

#include "protocol/scene/plot_density.h"
#include "protocol/scene/srgb.h"
#include "server/data/load_points.h"
#include "server/frames/layer_kinds.h"
#include "storage/numbers/point_places.h"

namespace mote::server {
namespace {

struct Gathered {
    render::LayerData drawn;               ///< what is on its way is null
    std::optional<ValueRange> valueRange;  ///< that the colours of values stand for
    PlotDensity plot;                      ///< of a selection as many particles as it holds
    bool waits = false;
};

/// Asks for all that is missing, not only for what is missing first.
class Gathering {
  public:
    explicit Gathering(const LayerRequest& asked)
        : layer_(asked.layer), stage_(asked.job.stage), data_(asked.data) {}

    Result<Gathered> gather() {
        MOTE_ASSIGN_OR_RETURN(out_.drawn.step, data_.step(layer_.dataset, layer_.step));
        MOTE_ASSIGN_OR_RETURN(entry_, data_.dataset(layer_.dataset));
        out_.plot = PlotDensity::of(entry_.manifest->particles(), layer_.step);
        if (layer_.towards) MOTE_RETURN_IF_ERROR(gatherWays(layer_.towards->step), "towards");
        if (!layer_.select && !layer_.highlight && !layer_.colorBy && !layer_.paths) return out_;
        const auto whole = out_.drawn.step;
        MOTE_RETURN_IF_ERROR(gatherChosen(whole));
        MOTE_RETURN_IF_ERROR(gatherHighlight(whole));
        MOTE_RETURN_IF_ERROR(gatherValues(), "colorBy");
        if (layer_.paths)
            MOTE_RETURN_IF_ERROR(take(pathsOf(entry_, *layer_.paths), out_.drawn.paths), "paths");
        return out_;
    }

  private:
    using Step = std::shared_ptr<const storage::ParticleStep>;

    template <class T>
    Status take(const Result<Loadable<T>>& what, std::shared_ptr<const T>& to) {
        MOTE_ASSIGN_OR_RETURN(to, data_.get(what));
        out_.waits = out_.waits || to == nullptr;
        return success();
    }

    /// The points of a selection as a step: the whole one where it holds all.
    Status takeChosen(const Selection& selection, const Step& whole,
                      std::shared_ptr<const ChosenPoints>& held, Step& to) {
        MOTE_RETURN_IF_ERROR(take(chosenPoints(entry_, layer_.step, selection), held));
        if (held != nullptr) to = held->step != nullptr ? Step(held, held->step.get()) : whole;
        return success();
    }

    Status gatherChosen(const Step& whole) {
        if (!layer_.select || layer_.select->everything()) return success();
        MOTE_RETURN_IF_ERROR(takeChosen(*layer_.select, whole, chosen_, out_.drawn.step), "select");
        out_.plot.particles = out_.drawn.step->pointCount();
        return success();
    }

    /// Of the points that are drawn.
    Status gatherHighlight(const Step& whole) {
        if (!layer_.highlight) return success();
        Selection selection = layer_.highlight->selection;
        if (layer_.select) {
            Selection both;
            both.all = {*layer_.select, std::move(selection)};
            selection = std::move(both);
        }
        std::shared_ptr<const ChosenPoints> held;
        MOTE_RETURN_IF_ERROR(takeChosen(selection, whole, held, out_.drawn.highlight), "highlight.selection");
        return success();
    }

    /// Without them, as where there are no ids or there is no room for them, nothing moves. A view in motion
    /// does not wait for them.
    Status gatherWays(std::uint32_t other) {
        if (!entry_.manifest->particles().ids()) return success();
        const bool onwards = layer_.step < other;
        const auto held =
            data_.get(waysBetween(entry_, std::min(layer_.step, other), std::max(layer_.step, other)));
        if (!held.ok() && held.error().code == ErrorCode::resourceExhausted) return success();
        MOTE_RETURN_IF_ERROR(held);
        const auto& ways = *held;
        if (ways == nullptr) out_.waits = out_.waits || stage_ != Stage::quick;
        if (ways != nullptr && ways->moving > 0)
            out_.drawn.ways = {ways, onwards ? &ways->there : &ways->back};
        return success();
    }

    Status gatherValues() {
        if (!layer_.colorBy) return success();
        const bool some = layer_.select && !layer_.select->everything();
        if (some && chosen_ == nullptr) return success();
        auto range = colorRangeOf(*layer_.colorBy);
        if (!range) {
            std::shared_ptr<const KnownRange> known;
            MOTE_RETURN_IF_ERROR(take(rangeOf(entry_, layer_.colorBy->column()), known));
            if (known == nullptr) return success();
            range = known->range;
        }
        out_.valueRange = range;
        return take(valuesOf(entry_, layer_.step, layer_.colorBy->column(), *range, chosen_,
                             some ? keyOf(*layer_.select) : std::string()),
                    out_.drawn.values);
    }

    const Layer& layer_;
    const Stage stage_;
    StepSource& data_;
    storage::Catalogue::Entry entry_;
    std::shared_ptr<const ChosenPoints> chosen_;
    Gathered out_;
};

/// Tells a camera the points of leaves that may be seen.
class SeenLeaves {
  public:
    SeenLeaves(const storage::ParticleStep& step, const ParticlesStyle& style, HalfSpaces clips,
               CameraFit& fit)
        : step_(step),
          style_(style),
          clips_(std::move(clips)),
          walk_(step),
          fit_(fit),
          found_(walk_.nodes().size(), Found::unknown) {}

    /// Along each direction from the outermost cell of the octree on, as long as one reaches farther than all
    /// points before: few are looked at, of however many.
    void add() {
        if (walk_.leaves().size() == 0 || !isSeen(0)) return;
        for (int i = 0; i < CameraFit::directions; ++i) {
            std::priority_queue<std::pair<double, std::uint32_t>> cells;
            const auto put = [&](std::uint32_t node) {
                const double reach = fit_.reach(i, boxOf(node));
                if (reach > 0.0 && isSeen(node)) cells.emplace(reach, node);
            };
            put(0);
            while (!cells.empty()) {
                const auto node = cells.top().second;
                cells.pop();
                if (!(fit_.reach(i, boxOf(node)) > 0.0)) continue;  // others have reached farther since
                const auto children = walk_.nodes().childCount[node];
                if (children == 0) addPoints(walk_.nodes().firstChild[node]);
                for (std::uint32_t k = 0; k < children; ++k) put(walk_.nodes().firstChild[node] + k);
            }
        }
    }

  private:
    enum class Found : std::uint8_t { unknown, seen, unseen };

    Bounds boxOf(std::uint32_t node) const {
        const auto cell = walk_.cellOf(node);
        return {cell.low, cell.low + cell.edge};
    }
    /// Whether a leaf of a node may be seen; looked for once.
    bool isSeen(std::uint32_t node) {
        if (found_[node] == Found::unknown) found_[node] = lookBelow(node) ? Found::seen : Found::unseen;
        return found_[node] == Found::seen;
    }
    bool lookBelow(std::uint32_t node) {
        if (allCut(clips_, boxOf(node))) return false;
        const auto first = walk_.nodes().firstChild[node];
        const std::uint32_t children = walk_.nodes().childCount[node];
        for (std::uint32_t k = 0; k < children; ++k) {
            if (isSeen(first + k)) return true;
        }
        if (children > 0) return false;
        const double t = step_.logDensity().ofLeaf(static_cast<double>(walk_.leaves().density[first]));
        return style_.pointFraction(t) > 0.0 || style_.volumeOpacity(t) > 0.0;
    }
    void addPoints(std::uint32_t leaf) {
        const auto cell = walk_.cell(leaf);
        const auto& leaves = walk_.leaves();
        for (const auto& point : step_.positions(leaves.pointBegin[leaf], leaves.pointCount[leaf])) {
            const auto place = cell.at(point);
            if (fit_.takes(place)) fit_.add(place);
        }
    }

    const storage::ParticleStep& step_;
    const ParticlesStyle& style_;
    const HalfSpaces clips_;
    const storage::LeafWalk walk_;
    CameraFit& fit_;
    std::vector<Found> found_;  // of each node
};

}  // namespace

/// What does not come in is read on the spot: a view in motion has a camera.
Result<bool> shownOf(const proto::ParticlesStyle& said, const ShownLayer& shown, StepSource& data,
                     CameraFit& fit) {
    MOTE_ASSIGN_OR_RETURN(auto step, data.step(shown.layer.dataset, shown.step));
    MOTE_ASSIGN_OR_RETURN(const auto entry, data.dataset(shown.layer.dataset));
    auto plot = PlotDensity::of(entry.manifest->particles(), shown.step);
    std::shared_ptr<const ChosenPoints> chosen;
    if (shown.layer.select && !shown.layer.select->everything()) {
        MOTE_ASSIGN_OR_RETURN(chosen, data.get(chosenPoints(entry, shown.step, *shown.layer.select)));
        if (chosen == nullptr) return false;
        if (chosen->step != nullptr) step = {chosen, chosen->step.get()};
        plot.particles = step->pointCount();
    }
    if (!step->octreeReady() && data.want(*step, {.octree = true})) return false;
    auto style = particlesStyleOf(said);
    resolveByPlot(style, plot, shown.onLight);
    SeenLeaves(*step, style, shown.layer.clips(), fit).add();
    return true;
}

Result<LayerPart> partOf(const proto::ParticlesStyle& said, const LayerRequest& asked) {
    MOTE_ASSIGN_OR_RETURN(auto found, Gathering(asked).gather());
    if (found.waits) return LayerPart();
    auto style = particlesStyleOf(said, asked.view.height);
    resolveByPlot(style, found.plot, isLight(asked.view.background));
    return LayerPart([data = std::move(found), style = std::move(style)](render::Scene& scene,
                                                                         std::size_t index, const auto&) {
        scene.layers[index] = data.drawn;
        scene.layers[index].particles = style;
        if (data.valueRange) {  // a colour bar tells it
            auto& range = *scene.view.layers[index].colorBy->mutable_range();
            range.Clear();
            range.Add(data.valueRange->low);
            range.Add(data.valueRange->high);
        }
        return DotHistory::Layer();
    });
}

}  // namespace mote::server
