// SPDX-License-Identifier: GPL-3.0-or-later
//
// Handles: by what the chosen layer is taken hold of in the picture: the faces of the box and the planes that
// cut away of it; arrows, rings and a square that shift, turn and stretch it. The same numbers are sections
// of its editor; a section that is unfolded has its handles in the picture. Main thread, within a Dear ImGui
// frame.
#pragma once

#include <glm/mat4x4.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <optional>
#include <string>
#include <vector>

#include "client/view/hand/brush.h"
#include "client/view/over_picture.h"
#include "protocol/mote.pb.h"
#include "protocol/scene/bounds.h"

namespace mote::client {

class ViewModel;
struct LayerPanel;

class Handles {
  public:
    bool cuts = false;    ///< those that cut away are shown
    bool places = false;  ///< those that place the layer
    Brush brush;          ///< of a layer in ink

    /// Draws what is shown over the picture and lets the mouse have it. True while the mouse holds a handle:
    /// it turns no camera then. `changed`: so was the layer.
    bool draw(ViewModel& model, const PictureArea& area, bool& changed);

  private:
    enum class Of { boxFace, planeShift, planeTurn, shift, shiftFreely, turn, stretch };
    struct Handle {
        Of of;
        int index;         ///< of a face (2 axis + 1 at its upper end), a plane, an axis
        glm::dvec3 place;  ///< world
        glm::dvec3 along;  ///< where it goes, world
        glm::dvec2 at;     ///< on the screen
    };
    /// A handle in the hand, and all as it was when it was taken.
    struct Held {
        Handle handle;
        glm::dvec2 from;
        proto::Clip clip;
        glm::dmat4 transform;     ///< the layer's own
        glm::dmat4 layerToWorld;  ///< with what a view in metres adds
    };
    struct Picture;

    void addCuts(const ViewModel& model, const Picture& picture, std::vector<Handle>& handles) const;
    void addPlaces(const ViewModel& model, const Picture& picture, std::vector<Handle>& handles) const;
    bool pull(ViewModel& model, const Picture& picture, glm::dvec2 to) const;
    bool pullFace(ViewModel& model, double way) const;
    bool pullPlane(ViewModel& model, const Picture& picture, glm::dvec2 to) const;
    glm::dmat4 placed(const Picture& picture, glm::dvec2 to) const;
    std::string said(const ViewModel& model) const;

    std::optional<Held> held_;
};

/// Adds a plane through the middle of `bounds` that cuts away what lies on the side of `eye`, layer space.
/// False where there are as many as may be, or the eye is in the middle.
bool cutBeforeMiddle(proto::Clip& clip, const Bounds& bounds, const glm::dvec3& eye);
/// The box that cuts, or the dataset's, which holds something.
Bounds clipBoxOf(const proto::Clip& clip, const Bounds& bounds);
void setClipBox(proto::Clip& clip, const Bounds& box);

/// Shift, turns about x, then y, then z in degrees, and stretch along the layer's own axes.
struct Placement {
    glm::dvec3 shift{0.0}, turn{0.0}, stretch{1.0};

    /// Nothing of one that makes right angles oblique.
    static std::optional<Placement> of(const glm::dmat4& transform);
    glm::dmat4 transform() const;
};

// Sections of the chosen layer's editor.

void drawCutAway(ViewModel& model, Handles& handles, const LayerPanel& panel);
void drawPlacement(ViewModel& model, Handles& handles, const LayerPanel& panel);

}  // namespace mote::client
