// SPDX-License-Identifier: GPL-3.0-or-later
//
// What the user's gestures make of selections: messages that a view keeps, by name. Pure functions; whether
// what they make is valid, parseNamedSelections() says.
#pragma once

#include <glm/mat4x4.hpp>
#include <glm/vec2.hpp>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "client/shared/numbers.h"
#include "protocol/mote.pb.h"
#include "protocol/scene/bounds.h"
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
/// how the particles are cut, `layerToWorld` where they lie.
proto::Selection lassoOn(const Camera& camera, double aspect, const proto::Layer& layer,
                         const glm::dmat4& layerToWorld, std::span<const glm::dvec2> points);
/// Says in which plot a lasso was drawn, at a step, so that it holds the same particles in all plots of the
/// run. It says nothing where the plot has no columns for its axes; nor where each step has bounds of its own
/// and the lasso is not of the particles of this step (`madeHere`): then it stays where it is on the screen.
void sayPlot(const proto::ParticlesManifest& plot, std::uint32_t step, bool madeHere,
             proto::Selection::Lasso& lasso);
/// Asks for the least and the greatest value of a selection along each axis of its plot, at a step.
proto::Query endsOf(const std::string& dataset, const proto::ParticlesManifest& plot, std::uint32_t step,
                    const proto::Selection& selection);
/// The box of them in layer space, in which a plot is a cube; a single place is given some room. Nothing
/// where they are none, or not in the plot.
std::optional<Bounds> boxOf(const StepStatistics& ends, const proto::ParticlesManifest& plot);
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

/// Returns all selections that it names, and those that they name.
std::set<std::string> namesIn(const proto::Selection& selection, const NamedSelectionMessages& named);
/// Puts one name in another's place, in the selection and all that it holds.
void renameIn(proto::Selection& selection, const std::string& from, const std::string& to);

/// Columns and derived quantities that it asks for, by what it names too.
std::set<std::string> columnsIn(const proto::Selection& selection, const NamedSelectionMessages& named);
/// Tells whether it means something else in another plot of the same run: it has a density, or a lasso that
/// does not say its plot.
bool dependsOnPlot(const proto::Selection& selection, const NamedSelectionMessages& named);

/// The corners of a polygon or lasso; those that are no two numbers are left out.
std::vector<glm::dvec2> cornersOf(
    const google::protobuf::RepeatedPtrField<google::protobuf::ListValue>& points);

/// What the mouse does on the picture in place of turning it: it draws a lasso, or picks a point.
/// A value that knows no window; places are parts of the picture's width and height, y down.
class PictureTool {
  public:
    enum class Kind { none, lasso, pick };
    struct Mouse {
        glm::dvec2 at;         ///< a part of the picture
        glm::dvec2 pixel;      ///< the size of a screen pixel, likewise
        bool pressed = false;  ///< in this frame, on the picture
        bool held = false;
        bool picks = false;  ///< a key is held that makes a click a pick
    };
    /// What the hand has finished in this frame.
    struct Done {
        std::vector<glm::dvec2> lasso = {};  ///< empty: none
        std::optional<glm::dvec2> pick = {};
    };

    Kind kind() const { return kind_; }
    /// A lasso under way is given up.
    void setKind(Kind kind);
    void toggle(Kind kind) { setKind(kind == kind_ ? Kind::none : kind); }

    /// The mouse is the tool's and not the camera's.
    bool takes(const Mouse& mouse) const { return kind_ != Kind::none || drawing_ || mouse.picks; }
    Done move(const Mouse& mouse);
    /// The open line of a lasso under way.
    const std::vector<glm::dvec2>& line() const { return line_; }
    bool drawing() const { return drawing_; }

  private:
    void extend(const Mouse& mouse);

    Kind kind_ = Kind::none;
    bool drawing_ = false;
    std::vector<glm::dvec2> line_;
};

}  // namespace mote::client
