// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/shared/picked_point.h"

#include <algorithm>
#include <cmath>

namespace mote::client {
Result<std::optional<PickedPoint>> pickedOf(const QueryAnswer& answer, const proto::PickQuery& asked) {
    if (!answer.message.has_picked())
        return corrupt("answer.picked", "the server answered with something else");
    const auto& message = answer.message.picked();
    if (!message.found()) return std::optional<PickedPoint>();
    if (message.layer() >= static_cast<std::uint32_t>(asked.view().layers_size()))
        return corrupt("answer.picked", "the server picked a point of a layer that there is not");
    const bool place = message.position_size() == 3 &&
                       std::ranges::all_of(message.position(), [](double x) { return std::isfinite(x); });
    if (!place || !std::isfinite(message.distance()))
        return corrupt("answer.picked", "the server's point has no place");
    const int count = message.names_size();
    if (message.units_size() != count || message.values_size() != count)
        return corrupt("answer.picked", "the server's values do not belong to their names");
    PickedPoint picked;
    picked.step = answer.message.step();
    picked.layer = message.layer();
    picked.point = message.point();
    picked.row = message.row();
    picked.distance = message.distance();
    picked.position = {message.position(0), message.position(1), message.position(2)};
    picked.density = message.density();
    for (int i = 0; i < count; ++i)
        picked.values.push_back({message.names(i), message.units(i), message.values(i)});
    if (message.has_id()) picked.id = message.id();
    return std::optional(std::move(picked));
}

}  // namespace mote::client
