// SPDX-License-Identifier: GPL-3.0-or-later
//
// What keeps a message as it was loaded, though controls that hold less of it (floats, angles, every default
// said) write it anew: of what they write only that is taken which is not what they wrote at first. Pure
// functions.
#pragma once

#include <google/protobuf/message.h>

namespace mote::client {

/// Changes in `message` what differs between `before` and `after`, field by field, and nothing else. All
/// three are of one type. A list of numbers is one field; in a list of messages those stay as they are that
/// were neither changed nor moved.
void applyEdits(const google::protobuf::Message& before, const google::protobuf::Message& after,
                google::protobuf::Message& message);

}  // namespace mote::client
