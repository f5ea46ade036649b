// SPDX-License-Identifier: GPL-3.0-or-later
#include <cmath>

#include "protocol/scene/point_list.h"
#include "protocol/scene/selection.h"
#include "protocol/scene/transform.h"

namespace mote {
namespace {

template <class Value, class Message>
void writeBounds(const Value& value, Message& message) {
    if (std::isfinite(value.min)) message.set_min(value.min);
    if (std::isfinite(value.max)) message.set_max(value.max);
}

void write(const Selection::Polygon& polygon, proto::Selection::Polygon& message) {
    message.add_columns(polygon.first);
    message.add_columns(polygon.second);
    writePoints(polygon.points, message.mutable_points());
}

void write(const Selection::Lasso& lasso, proto::Selection::Lasso& message) {
    *message.mutable_camera() = toProto(lasso.camera);
    message.set_aspect(lasso.aspect);
    writeTransform(lasso.transform, message.mutable_transform());
    writePoints(lasso.points, message.mutable_points());
}

void write(const Selection& selection, proto::Selection& message) {
    for (const auto& range : selection.ranges) {
        auto& added = *message.add_ranges();
        added.set_column(range.column);
        writeBounds(range, added);
    }
    if (selection.density) writeBounds(*selection.density, *message.mutable_density());
    if (selection.polygon) write(*selection.polygon, *message.mutable_polygon());
    if (selection.lasso) write(*selection.lasso, *message.mutable_lasso());
    if (selection.outermost) {
        message.mutable_outermost()->set_plane(std::string(1, selection.outermost->plane));
        message.mutable_outermost()->set_share(selection.outermost->share);
    }
    message.mutable_ids()->Add(selection.ids.begin(), selection.ids.end());
    if (selection.step) message.set_step(*selection.step);
    if (selection.nothing) message.set_nothing(true);
    for (const auto& inner : selection.all) write(inner, *message.add_all());
    for (const auto& inner : selection.any) write(inner, *message.add_any());
    for (const auto& inner : selection.negated) write(inner, *message.mutable_negated());
}

}  // namespace

bool Selection::operator==(const Selection& other) const {
    return ranges == other.ranges && density == other.density && polygon == other.polygon &&
           lasso == other.lasso && outermost == other.outermost && ids == other.ids && step == other.step &&
           all == other.all && any == other.any && negated == other.negated && nothing == other.nothing;
}

std::size_t valueCount(const Selection& selection) {
    std::size_t count = selection.ids.size();
    if (selection.polygon) count += selection.polygon->points.size();
    if (selection.lasso) count += selection.lasso->points.size();
    for (const auto* const list : {&selection.all, &selection.any, &selection.negated}) {
        for (const auto& inner : *list) count += valueCount(inner);
    }
    return count;
}

proto::Selection toProto(const Selection& selection) {
    proto::Selection message;
    write(selection, message);
    return message;
}

}  // namespace mote
