// SPDX-License-Identifier: GPL-3.0-or-later
//
// DensityLens: a rectangle that the user drags over the picture, and the densities of the particles that are
// seen in it: the curve editors light them. It stays where it is on the screen, so what is seen in it follows
// camera and step. Owned by the viewer; main thread.
#pragma once

#include <cstdint>
#include <glm/vec2.hpp>
#include <optional>
#include <string>
#include <vector>

#include "client/view/numbers/numbers_data.h"
#include "client/view/over_picture.h"
#include "protocol/mote.pb.h"

namespace mote::client {

class ViewModel;

/// Two corners, parts of the picture's width and height.
struct PictureRectangle {
    glm::dvec2 from, to;

    /// Its corners, around it.
    std::vector<glm::dvec2> corners() const { return {from, {to.x, from.y}, to, {from.x, to.y}}; }
    bool operator==(const PictureRectangle&) const = default;
};

/// What is asked for to know the densities of what is seen in a rectangle: particles of the chosen layer at
/// its step, by the scaled log density of their leaf.
proto::Query densitiesIn(const ViewModel& model, double aspect, const PictureRectangle& rectangle,
                         std::uint32_t bins);

class DensityLens {
  public:
    explicit DensityLens(QueryLine line) : query_(std::move(line)) {}

    bool isOn() const { return on_; }
    /// Ended, it has no rectangle.
    void turn(bool on);

    /// True if the mouse is its own and not the camera's.
    bool takeMouse(const PictureArea& area);
    /// Asks for what is seen in it now, unless the picture is under way. `bins`: of the plot's histogram.
    void ask(const ViewModel& model, const PictureArea& area, std::uint32_t bins, bool moving);
    /// The rectangle, and what is to be done.
    void draw(const PictureArea& area) const;
    /// By density, in as many bins as the plot's histogram; none before they are known.
    const std::vector<std::uint64_t>& lit() const { return lit_; }
    /// The server is another one.
    void forget() { query_.drop(); }

  private:
    bool on_ = false, dragging_ = false;
    std::optional<PictureRectangle> rectangle_;
    std::vector<std::uint64_t> lit_;
    std::uint64_t particles_ = 0;
    std::string failure_;
    // Last: no answer comes to what is gone.
    LatestQuery query_;
};

}  // namespace mote::client
