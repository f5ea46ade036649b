// SPDX-License-Identifier: GPL-3.0-or-later
//
// Brush: paints regions onto what a layer in ink is a drawing of (docs/INK.md, "Regions painted by hand").
// The server says which place of the surface lies under the pointer; its answers become dabs, however late
// they come. Main thread, within a Dear ImGui frame; knows no line to a server.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <glm/mat4x4.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "client/view/over_picture.h"
#include "protocol/base/error.h"
#include "protocol/mote.pb.h"
#include "protocol/scene/camera.h"

namespace mote::client {

class ViewModel;
struct LayerPanel;

/// What a stroke paints with.
struct BrushSettings {
    static constexpr double least = 3.0, most = 200.0;  ///< of the radius
    double radius = 24.0;                               ///< screen coordinates at the scale 1
    std::string fill = "ink";                           ///< as InkStyle.Region has it
    std::optional<double> direction;                    ///< of hatches, degrees
    bool whole = false;                                 ///< all of the picture's own region
    bool erases = false;
};

/// A stroke under way or just done: how things stood when it was begun.
struct BrushStroke {
    BrushSettings settings;
    Camera camera;
    double height = 1.0;  ///< of the picture, in the radius' unit
    glm::dmat4 layerToWorld{1.0};
    std::string dataset;
    int layer = 0;
};

/// The radius of a dab at a place of layer space, in its unit.
double dabRadius(const BrushStroke& stroke, const glm::dvec3& place);
/// Paints a place, in the last region if that is alike, else in a new one; near one that is painted there is
/// nothing to do. Errors: resourceExhausted (there are as many regions or dabs as may be); nothing has
/// changed then.
Status paintDab(proto::InkStyle& style, const BrushStroke& stroke, const glm::dvec3& place);
/// Removes what is painted within the radius of a place, and regions of which nothing is left.
void eraseDabs(proto::InkStyle& style, double radius, const glm::dvec3& place);

class Brush {
  public:
    struct Question {
        proto::Query query;
        std::uint64_t id;
    };

    bool on = false;
    BrushSettings settings;

    /// Draws the brush over the picture and lets the mouse have it: true if it is the brush's. `changed`: so
    /// was the layer, also by answers that came since.
    bool takeMouse(ViewModel& model, const PictureArea& area, bool& changed);
    void resize(double turns);
    /// What is to be asked of the server now, each once: few at a time; and its answer.
    std::vector<Question> takeQuestions();
    void hear(std::uint64_t id, const Result<proto::Answer>& answer);
    /// What there is to be said, once.
    std::string takeRefusal() { return std::exchange(refused_, {}); }

  private:
    using Stroke = std::shared_ptr<const BrushStroke>;
    struct Hit {
        Stroke stroke;
        glm::dvec3 place;  ///< layer space
    };

    void begin(const ViewModel& model, const PictureArea& area);
    void ask(const ViewModel& model, const PictureArea& area, glm::dvec2 at);
    void drawRing(const PictureArea& area) const;
    bool paint(ViewModel& model);

    Stroke stroke_;  // the latest
    bool held_ = false;
    glm::dvec2 askedAt_{0.0};  // screen coordinates
    std::uint64_t ids_ = 0;    // of questions that there were
    std::deque<Question> questions_;
    std::map<std::uint64_t, Stroke> strokes_;  // of questions without an answer, by id
    std::size_t underWay_ = 0;                 // of these, that were taken
    std::vector<Hit> hits_;
    std::string refused_;
};

/// A section of the editor of a layer in ink: how it is painted, and what is.
void drawBrush(ViewModel& model, Brush& brush, const LayerPanel& panel);

}  // namespace mote::client
