// SPDX-License-Identifier: GPL-3.0-or-later
//
// What the user's gestures make of selections: messages that a view keeps, by name. Pure functions; whether
// what they make is valid, parseNamedSelections() says.
#pragma once

#include <glm/vec2.hpp>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "protocol/mote.pb.h"
#include "protocol/scene/camera.h"
#include "protocol/scene/selection.h"

namespace mote::client {

/// What becomes of the chosen selection by a gesture that gives another.
enum class Combine {
    fresh,    ///< it stays; the gesture's is a selection of its own
    both,     ///< what both hold
    either,   ///< what either holds
    without,  ///< what it holds and the gesture's does not
};

/// What a closed line on a picture surrounds: points as parts of its width and height, y down. `layer` says
/// where the particles lie.
proto::Selection lassoOn(const Camera& camera, double aspect, const proto::Layer& layer,
                         std::span<const glm::dvec2> points);
/// What lies in a polygon in the plane of two columns.
proto::Selection polygonIn(const std::string& first, const std::string& second,
                           std::span<const glm::dvec2> points);
/// One of the view's selections.
proto::Selection reference(const std::string& name);

/// Neither of them loses the step in which it was made. Not of Combine::fresh.
proto::Selection combined(const proto::Selection& present, Combine how, const proto::Selection& gesture);

/// "x from 0.001, not lasso of 12 corners", for people; one line.
std::string describe(const proto::Selection& selection);

/// `wish`, or with the first number behind it that no selection has.
std::string freshName(const NamedSelectionMessages& named, const std::string& wish);

/// All selections that it names, theirs too.
std::set<std::string> namesIn(const proto::Selection& selection, const NamedSelectionMessages& named);
/// Puts one name in another's place, in the selection and all that it holds.
void renameIn(proto::Selection& selection, const std::string& from, const std::string& to);

/// Columns and derived quantities that it asks for, by what it names too.
std::set<std::string> columnsIn(const proto::Selection& selection, const NamedSelectionMessages& named);
/// Whether it means something else in another plot of the same run: it has a lasso or a density.
bool dependsOnPlot(const proto::Selection& selection, const NamedSelectionMessages& named);

/// The corners of a polygon or lasso; those that are no two numbers are left out.
std::vector<glm::dvec2> cornersOf(
    const google::protobuf::RepeatedPtrField<google::protobuf::ListValue>& points);

}  // namespace mote::client
