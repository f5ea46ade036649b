// SPDX-License-Identifier: GPL-3.0-or-later
//
// An image layer becomes fragments behind everything (docs/PICTURE.md, "Images"). A pure function.
#pragma once

#include <memory>

#include "protocol/scene/view.h"
#include "server/render/layers/lowering.h"
#include "storage/image/image_file.h"

namespace mote::render {

/// The layer's fragments are made where they are drawn.
void lowerImage(const Layer& layer, std::shared_ptr<const storage::ColorImage> image, Lowering& out);

}  // namespace mote::render
