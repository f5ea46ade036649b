// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/views/number_data.h"

#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "server/render/layers/particles/point_data.h"
#include "server/render/layers/particles/usual_range.h"
#include "storage/numbers/point_places.h"
#include "storage/numbers/select_points.h"
#include "storage/particles/selected_step.h"
#include "tests/support/any_selection.h"
#include "tests/views/random_curves.h"

namespace mote::test {
namespace {

using Step = std::shared_ptr<const storage::ParticleStep>;

/// What of a layer's points is chosen; the step itself where all are, as the server has it.
Result<Step> chosen(const Selection& selection, const MemoryRun& run, std::uint32_t index, const Step& whole,
                    std::vector<std::uint32_t>* sources) {
    MOTE_ASSIGN_OR_RETURN(const auto mask, storage::selectPoints(selection, run, index, {}));
    if (mask.count() == mask.size()) return whole;
    constexpr std::uint32_t leafCapacity = 64;
    MOTE_ASSIGN_OR_RETURN(const auto some, storage::SelectedStep::make(*whole, mask, leafCapacity, {}));
    if (sources != nullptr) sources->assign(some->sources().begin(), some->sources().end());
    return Step(some);
}

proto::Selection anySelectionMessage(Random& random, std::uint32_t steps) {
    SelectionShape shape{.columns = {{"x", 0.0, 1.0}, {"y", 0.0, 1.0}, {"z", 0.0, 1.0}, {"px", -1.0, 1.0}},
                         .planes = "",
                         .ids = 2000,
                         .steps = steps,
                         .depth = 2};
    return toProto(anySelection(random, shape));
}

}  // namespace

MemoryRun::Step withNumbers(std::shared_ptr<const MemoryStep> step) {
    const auto points = step->pointCount();
    std::vector<MemoryColumns::Column> columns{{{"x", "m", 0.5}, {}},
                                               {{"y", "m", 0.5}, {}},
                                               {{"z", "m", 0.5}, {}},
                                               {{"px", "eV/c"}, {}},
                                               {{"constant", "1", 3.0}, {}}};
    const auto rows = step->rows(0, points);
    std::vector<std::uint64_t> ids(rows.begin(), rows.end());
    const storage::LeafWalk walk(*step);
    for (std::uint64_t point = 0; point < points; ++point) {
        const auto place = walk.cell(walk.leafOf(point)).at(step->positions(point, 1).front());
        for (int axis = 0; axis < 3; ++axis)
            columns[static_cast<std::size_t>(axis)].values.push_back(static_cast<float>(0.5 * place[axis]));
        Random random(ids[point], 3);
        const double some = random.between(-1.0, 1.0);
        const bool none = random.chance(0.02);
        columns[3].values.push_back(none ? std::numeric_limits<float>::quiet_NaN()
                                         : static_cast<float>(some));
        columns[4].values.push_back(0.0F);
    }
    auto numbers = std::make_shared<const MemoryColumns>(points, std::move(columns), std::move(ids));
    return {std::move(step), std::move(numbers)};
}

Status addNumbers(const Layer& layer, const MemoryRun& run, render::LayerData& data) {
    const Step whole = data.step;
    std::vector<std::uint32_t> sources;
    if (layer.select) {
        const auto step = chosen(*layer.select, run, layer.step, whole, &sources);
        MOTE_RETURN_IF_ERROR(step, "select");
        data.step = *step;
    }
    if (layer.highlight) {
        Selection both;
        both.all = {layer.select.value_or(Selection()), layer.highlight->selection};
        auto step = chosen(both, run, layer.step, whole, nullptr);
        MOTE_RETURN_IF_ERROR(step, "highlight");
        data.highlight = *std::move(step);
    }
    if (layer.colorBy) {
        const std::string& column = layer.colorBy->column();
        auto range = colorRangeOf(*layer.colorBy);
        if (!range) {
            MOTE_ASSIGN_OR_RETURN(range, render::usualRange(run, column, {}));
        }
        MOTE_ASSIGN_OR_RETURN(const auto numbers, run.step(layer.step));
        auto values = render::pointValues(numbers, column, *range, sources, {});
        MOTE_RETURN_IF_ERROR(values, "colorBy");
        if (data.step->pointCount() == 0) values = std::make_shared<const render::PointValues>();
        data.values = *std::move(values);
    }
    if (layer.paths) {
        const std::vector<std::uint64_t> ids(layer.paths->ids().begin(), layer.paths->ids().end());
        auto paths = render::pointPaths(run, ids, {});
        MOTE_RETURN_IF_ERROR(paths, "paths");
        data.paths = *std::move(paths);
    }
    return success();
}

void setAnyNumbers(Random& random, std::uint32_t steps, proto::Layer& layer) {
    if (random.chance(0.5)) *layer.mutable_select() = anySelectionMessage(random, steps);
    if (random.chance(0.5)) {
        auto& highlight = *layer.mutable_highlight();
        *highlight.mutable_selection() = anySelectionMessage(random, steps);
        if (random.chance(0.5)) setAnyColor(random, highlight.mutable_color());
        if (random.chance(0.5))
            highlight.set_size_pixels(random.between(0.25, random.chance(0.2) ? 40.0 : 4.0));
        if (random.chance(0.5)) highlight.set_opacity(anyShare(random));
    }
    if (random.chance(0.6)) {
        auto& colorBy = *layer.mutable_color_by();
        colorBy.set_column(random.oneOf({"x", "y", "z", "px", "constant", "r"}));
        if (random.chance(0.5)) {
            const double low = random.between(-1.0, 1.0);
            colorBy.add_range(low);
            colorBy.add_range(low + random.magnitude(-6, 2));
        }
        if (random.chance(0.7)) colorBy.set_color_map(anyColorMap(random));
        colorBy.set_of_pixel(random.oneOf({"", "mean", "nearest"}));
    }
    if (random.chance(0.3)) {
        auto& paths = *layer.mutable_paths();
        for (auto count = random.below(8); count > 0; --count) paths.add_ids(random.below(2000));
        if (random.chance(0.5)) setAnyColor(random, paths.mutable_color());
        if (random.chance(0.5)) paths.set_width(random.between(0.25, 6.0));
    }
}

}  // namespace mote::test
