// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/layers/ink/lower_ink.h"

namespace mote::render {

void lowerInk(const Layer&, const InkStyle&, const MeshSurface&, Lowering&) {}

}  // namespace mote::render
