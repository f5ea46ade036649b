// SPDX-License-Identifier: GPL-3.0-or-later
//
// setSamplerStates: Mesa's software rasteriser compiles a program for the samplers' states that it finds,
// also for texel buffers, which have none: they find what another program left there. So each program was
// compiled twice, in the first frame and in the second. Once one program has read a volume in every place,
// all find the same for good.
#pragma once

#include "server/render/egl/gl_objects.h"
#include "server/render/egl/shader_library.h"

namespace mote::render {

/// Sets them for all programs of the current context. `volume`: any that shaders may read.
void setSamplerStates(ShaderLibrary& shaders, const GlTexture& volume);

}  // namespace mote::render
