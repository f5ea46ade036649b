// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/view/stipple_controls.h"

#include <algorithm>
#include <glm/vec3.hpp>

#include "protocol/scene/srgb.h"
#include "protocol/scene/stipple_style.h"

namespace mote::client {

StippleControls::StippleControls() {
    read({});
}

void StippleControls::write(proto::StippleStyle& style) const {
    style.set_spacing_pixels(std::clamp(spacing, 0.5F, 1000.0F));
    style.set_dot_pixels(std::clamp(dotSize, 0.1F, 64.0F));
    style.clear_color();
    for (const float value : color) {
        if (ownColor) style.add_color(std::clamp(value, 0.0F, 1.0F));
    }
    auto& light = *style.mutable_light();
    assign(light.mutable_direction(), angles.direction());
    const double shade = std::clamp(static_cast<double>(ambient), 0.0, 1.0);
    light.set_ambient(shade);
    light.set_diffuse(1.0 - shade);
    light.set_shadow(shadow);
    style.set_jitter(std::clamp(jitter, 0.0F, 4.0F));
    style.set_soft(soft);
    style.set_see_through(seeThrough);
    style.set_invert(invert);
    style.set_gamma(std::clamp(gamma, 0.05F, 20.0F));
    style.set_image(image);
}

void StippleControls::read(const proto::StippleStyle& message) {
    const auto style = parseStippleStyle(message, glm::dvec3(0.0)).value();
    spacing = static_cast<float>(style.spacing);
    dotSize = static_cast<float>(style.dotSize);
    ownColor = !message.color().empty();
    const glm::dvec3 encoded = linearToSrgb(style.color);
    for (std::size_t i = 0; i < 3; ++i) color[i] = static_cast<float>(encoded[static_cast<int>(i)]);
    angles = LightAngles::of(style.light.direction);
    ambient = static_cast<float>(style.light.ambient);
    shadow = style.light.shadow;
    jitter = static_cast<float>(style.jitter);
    soft = style.soft;
    seeThrough = style.seeThrough;
    invert = message.invert();
    gamma = static_cast<float>(style.gamma);
    image = style.image;
}

}  // namespace mote::client
