// SPDX-License-Identifier: GPL-3.0-or-later
//
// Messages of views, filled in and checked by what the schema says of their fields (facts.h): a resolved
// message is valid but for what no single field can say, which stands where its kind is parsed. Pure
// functions.
#pragma once

#include <google/protobuf/message.h>

#include <utility>

#include "protocol/base/error.h"

namespace mote {

/// Fills in every default, and makes unit vectors of directions. Lengths on the screen that are not said stay
/// so: they grow with the picture's height.
void fillIn(google::protobuf::Message& message);

/// Errors name the field, of knots the knot: a number beyond its ends, a list of too few or too many, a word
/// or a colour map that is not known, a direction of length zero, knots that descend.
Status checkFields(const google::protobuf::Message& message);

/// The same of those fields alone that are no messages.
Status checkOwnFields(const google::protobuf::Message& message);

/// The message filled in. Errors as above.
template <class Message>
Result<Message> resolved(Message message) {
    fillIn(message);
    MOTE_RETURN_IF_ERROR(checkFields(message));
    return message;
}

}  // namespace mote
