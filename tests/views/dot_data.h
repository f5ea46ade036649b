// SPDX-License-Identifier: GPL-3.0-or-later
//
// Dots of generated views, in place of those that a stipple layer would choose: on a sphere or a plane of
// layer space, before and behind everything, many at one depth. Pure functions.
#pragma once

#include <span>
#include <string>
#include <string_view>

#include "protocol/scene/view.h"
#include "server/render/plan/dot.h"

namespace mote::test {

std::span<const std::string_view> dotForms();

/// Appends the dots of a stipple layer. `form`: one of dotForms().
void addDots(const std::string& form, std::uint32_t number, const Layer& layer, const View& view,
             render::Dots& dots);

}  // namespace mote::test
