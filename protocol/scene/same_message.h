// SPDX-License-Identifier: GPL-3.0-or-later
//
// Messages as values: equal where they say the same. Pure functions.
#pragma once

#include <google/protobuf/message.h>

#include <concepts>

namespace mote::proto {

template <std::derived_from<google::protobuf::Message> Message>
bool operator==(const Message& a, const Message& b) {
    return a.SerializeAsString() == b.SerializeAsString();
}

}  // namespace mote::proto
