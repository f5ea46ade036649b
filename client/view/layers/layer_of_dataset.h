// SPDX-License-Identifier: GPL-3.0-or-later
//
// As which kind of layer a dataset is shown. The only place of the clients that knows. Pure.
#pragma once

#include <string_view>

#include "protocol/mote.pb.h"

namespace mote::client {

/// `kind`: a manifest's. What no kind of layer draws is asked for as particles, so that the server says why
/// it cannot.
proto::Layer::KindCase layerOfDataset(std::string_view kind);

}  // namespace mote::client
