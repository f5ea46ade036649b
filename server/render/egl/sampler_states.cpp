// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/egl/sampler_states.h"

namespace mote::render {

void setSamplerStates(ShaderLibrary& shaders, const GlTexture& volume) {
    constexpr GLuint places = 16;  // that GL has at least; as many as any program reads
    const GlBuffer sums(sizeof(float));
    for (GLuint unit = 0; unit < places; ++unit) glBindTextureUnit(unit, volume.get());
    sums.bindStorage(0);
    glUseProgram(shaders.program("sampler_states", {}));
    glDispatchCompute(1, 1, 1);
}

}  // namespace mote::render
