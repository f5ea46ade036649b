// SPDX-License-Identifier: GPL-3.0-or-later
#include "protocol/scene/light.h"

#include "protocol/scene/write_fields.h"

namespace mote {

Light lightOf(const proto::Light& message) {
    return {.direction = readVector(message.direction()),
            .fixed = message.fixed(),
            .ambient = message.ambient(),
            .diffuse = message.diffuse(),
            .specular = message.specular(),
            .shadow = message.shadow()};
}

}  // namespace mote
