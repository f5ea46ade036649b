// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/view/numbers/picture_tool.h"

#include <cmath>
#include <utility>

namespace mote::client {
namespace {

constexpr double apart = 2.0;               // screen pixels between corners of a lasso, at least
constexpr std::size_t mostCorners = 10000;  // a message of these is small

}  // namespace

void PictureTool::setKind(Kind kind) {
    kind_ = kind;
    drawing_ = false;
    line_.clear();
}

PictureTool::Done PictureTool::move(const Mouse& mouse) {
    Done done;
    if (mouse.pressed && (mouse.picks || kind_ == Kind::pick)) {
        done.pick = mouse.at;
        return done;
    }
    if (mouse.pressed && kind_ == Kind::lasso) {
        drawing_ = true;
        line_.assign(1, mouse.at);
        return done;
    }
    if (!drawing_) return done;
    extend(mouse);
    if (mouse.held) return done;
    drawing_ = false;
    auto line = std::exchange(line_, {});
    if (line.size() >= 3) done.lasso = std::move(line);  // fewer surround nothing: a click
    return done;
}

void PictureTool::extend(const Mouse& mouse) {
    const glm::dvec2 way = (mouse.at - line_.back()) / mouse.pixel;
    if (std::hypot(way.x, way.y) >= apart && line_.size() < mostCorners) line_.push_back(mouse.at);
}

}  // namespace mote::client
