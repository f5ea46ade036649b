// SPDX-License-Identifier: GPL-3.0-or-later
//
// What a dataset has to make quantities from, as its manifest tells. A pure function; a manifest that nobody
// has checked does no harm.
#pragma once

#include "protocol/mote.pb.h"
#include "protocol/quantity/quantity.h"

namespace mote {

RunColumns columnsOf(const proto::ParticlesManifest& manifest);

}  // namespace mote
