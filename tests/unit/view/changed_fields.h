// SPDX-License-Identifier: GPL-3.0-or-later
//
// In which fields two messages differ, by their paths: "layers[0].particles.points.opacity". A list of
// numbers is one field, and so is a list of messages where it grew or shrank. Pure functions.
#pragma once

#include <google/protobuf/message.h>

#include <set>
#include <string>

namespace mote::client {

std::set<std::string> changedFields(const google::protobuf::Message& before,
                                    const google::protobuf::Message& after);

}  // namespace mote::client
