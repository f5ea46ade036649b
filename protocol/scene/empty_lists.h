// SPDX-License-Identifier: GPL-3.0-or-later
//
// A list of a selection that is there and empty selects nothing, one that is absent selects all; a message
// cannot tell them apart, its JSON text can. What was read from such text is told of them here. Pure
// functions.
#pragma once

#include <google/protobuf/message.h>

#include <string>
#include <string_view>

#include "protocol/scene/error.h"

namespace mote {

/// Sets `nothing` in each proto::Selection within the message where the JSON text that it was parsed from has
/// a list of `ranges`, `ids`, `all` or `any` that came out empty. Errors: unsupported (JSON that cannot be
/// followed).
Status tellEmptyLists(std::string_view text, google::protobuf::Message& message);

/// Takes lists that are empty out of the selections of one line of JSON that was printed with all of its
/// fields: they would select nothing when it is read.
std::string withoutEmptyLists(std::string line, const google::protobuf::Message& message);

}  // namespace mote
