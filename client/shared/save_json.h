// SPDX-License-Identifier: GPL-3.0-or-later
//
// Messages as JSON files that are there whole or not at all. Pure, but for the files.
#pragma once

#include <google/protobuf/message.h>

#include <filesystem>

#include "protocol/scene/error.h"

namespace mote::client {

/// What becomes of a file that has the name already.
enum class SameName { stays, isReplaced };

/// As toJson() has it. What was there stays as it was where anything fails. Errors: PartFile's; alreadyExists
/// where it stays.
Status saveJson(const std::filesystem::path& path, const google::protobuf::Message& message,
                SameName sameName);

}  // namespace mote::client
