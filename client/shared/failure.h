// SPDX-License-Identifier: GPL-3.0-or-later
//
// A server's Failure message as the Error that it was there. Pure.
#pragma once

#include "protocol/mote.pb.h"
#include "protocol/scene/error.h"

namespace mote::client {

/// A code that is not known here becomes internal; an empty sentence is filled.
Error toError(const proto::Failure& failure);

}  // namespace mote::client
