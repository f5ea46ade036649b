// SPDX-License-Identifier: GPL-3.0-or-later
//
// What the parts of the panel are made of. Main thread, within the panel's window.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <glm/vec3.hpp>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "client/view/hand/named_cameras.h"
#include "client/view/knot_curve.h"
#include "client/view/replot.h"
#include "client/view/slider_values.h"

namespace google::protobuf {
class Message;
}

namespace mote::client {

/// What the user asked for in this frame.
struct PanelActions {
    bool viewChanged = false;  ///< the model was edited
    bool editing = false;      ///< and a control is still held
    std::optional<std::filesystem::path> openViewFrom, saveViewTo, openStyleFrom, saveStyleTo, savePictureTo;
    const char* command = nullptr;         ///< a name of the viewer's list
    std::optional<AxisNames> plot;         ///< other axes of the shown run
    std::optional<std::string> cancelJob;  ///< an id
    std::optional<std::string> retryJob;   ///< an id
    std::optional<std::string> openDataset;
    bool moreJobs = false;                ///< the next page of them
    std::string refused;                  ///< why what was typed is not taken
    std::optional<std::string> saveFilm;  ///< an id
    std::optional<CameraWish> camera;     ///< of the active pane's dataset
    std::optional<float> panelWidth;      ///< screen coordinates at a content scale of 1
};

void text(const std::string& line);
/// A line in faint letters, wrapped.
void dim(const std::string& line);
/// Letters of what is wrong, until ImGui::PopStyleColor().
void pushWarningColor();
/// A part that can be folded, at first open; true if it is.
bool section(const char* title);

/// A number of things with a metric prefix and three digits: "1.23 M points", "512 B/s".
std::string metric(double value, const char* unit);

/// Ends the popup that is drawn if Escape is pressed.
void endByEscape();

/// Notes that the last widget changed the view, and whether it is still held.
void note(PanelActions& actions, bool changed);
/// The same of a curve, which is more than one widget.
void noteCurve(PanelActions& actions, bool changed);

/// Says what the last widget is once the pointer rests on it, until it moves or presses: no other is hidden
/// from a hand at work.
void helpAtRest(const std::string& said);
/// The same, with what the schema says of a field. The message has the field.
void fieldHelp(const google::protobuf::Message& message, int field);

// Controls of the view; each notes what the user does.

void checkbox(PanelActions& actions, const char* label, bool& value);
void colorBox(PanelActions& actions, const char* label, std::array<float, 3>& color);
/// That of a view's background.
void backgroundBox(PanelActions& actions, std::array<float, 3>& color);
void slider(PanelActions& actions, const char* label, float& value, float least, float most,
            const char* format = "%.2f");
/// A slider that moves by the logarithm.
void logSlider(PanelActions& actions, const char* label, float& value, float least, float most,
               const char* format);
/// Two numbers, low < high, that are dragged between the ends of an axis, a pixel being a `parts`-th of it.
void rangeBox(PanelActions& actions, const char* label, double& low, double& high, const Interval& ends,
              double parts);
/// A slider of a double, with digits enough to tell its ends apart.
void wideSlider(PanelActions& actions, const char* label, double& value, const Interval& ends);
/// Returns a format of printf's with digits enough to tell a thousandth of `span` at `place`.
std::string formatFor(double span, double place);
/// Two sliders, "NAME across" and "NAME above".
void angleSliders(PanelActions& actions, const char* name, LightAngles& angles);
/// Three numbers that are typed; true once they are.
bool typeNumbers(const char* label, glm::dvec3& numbers);
/// A list of names.
void nameList(PanelActions& actions, const char* label, std::string& chosen,
              std::span<const std::string_view> names);

/// The list alone; true if another one was chosen.
bool chooseName(const char* label, std::string& chosen, std::span<const std::string_view> names);

/// A list of colour maps, each with its colours; true if another one was chosen.
bool chooseColorMap(const char* label, std::string& chosen);
/// The same, noted.
void colorMapList(PanelActions& actions, const char* label, std::string& chosen);

struct CurveEditorLook {
    const char* xName;
    const char* yName;
    bool rootAxis;                                  ///< y is spread by its square root: opacities
    float height;                                   ///< pixels
    Interval axis = {};                             ///< of x
    std::span<const std::uint64_t> histogram = {};  ///< even bins over histogramRange
    std::span<const std::uint64_t> lit = {};        ///< a part of what they count, in the same bins
    Interval histogramRange = {};
    /// x is drawn by exp(bend x), so that its axis is even in that; 0: in x itself.
    double bend = 0.0;
    std::function<std::string(double)> said = {};  ///< of x, in place of its number
    std::function<glm::dvec3(double)> color = {};  ///< of x, linear RGB, drawn as a strip below
};

/// Draws a transfer function as a widget, with a histogram behind it, over the width that is left: a knot is
/// dragged, a click on the curve adds one, a right click on a knot removes it; below it are the numbers of
/// the knot that was last taken hold of, to be typed. True if the curve was changed.
bool curveEditor(const char* id, EditedCurve& curve, const CurveEditorLook& look);

}  // namespace mote::client
