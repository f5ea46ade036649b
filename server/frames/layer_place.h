// SPDX-License-Identifier: GPL-3.0-or-later
//
// Where an error of a layer belongs. A pure function.
#pragma once

#include <cstddef>
#include <string>

#include "protocol/scene/error.h"

namespace mote::server {

/// A field gets its place in the view, a file keeps its own.
inline Error inLayer(std::size_t index, const Error& error) {
    const bool field = error.where.find('/') == std::string::npos;
    return field ? error.within("layers[" + std::to_string(index) + "]") : error;
}

}  // namespace mote::server
