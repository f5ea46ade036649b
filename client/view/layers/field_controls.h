// SPDX-License-Identifier: GPL-3.0-or-later
//
// Controls of a message's fields, drawn by what the schema says of them (protocol/options.proto): labels,
// ends, words, tooltips. What a message does not say is shown as it is by default, and said once it is
// edited. Main thread, within the panel's window.
#pragma once

#include <google/protobuf/message.h>

#include <functional>
#include <string_view>

#include "client/view/panel_widgets.h"

namespace mote::client {

/// By its name in JSON, whether a field of the message is drawn; of a message within: "light.ambient".
using FieldFilter = std::function<bool(std::string_view name)>;

/// Draws those fields that have a label, in the order of the schema, and those of the messages within.
/// `shown`: the same message, with what it leaves out. True where something was edited.
bool fieldControls(PanelActions& actions, google::protobuf::Message& message,
                   const google::protobuf::Message& shown, const FieldFilter& filter = {});

}  // namespace mote::client
