// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/shared/save_json.h"

#include "client/shared/part_file.h"
#include "protocol/scene/json.h"

namespace mote::client {

Status saveJson(const std::filesystem::path& path, const google::protobuf::Message& message,
                SameName sameName) {
    const auto text = toJson(message);
    MOTE_ASSIGN_OR_RETURN(const auto part, PartFile::create(path));
    MOTE_RETURN_IF_ERROR(part->append({reinterpret_cast<const std::uint8_t*>(text.data()), text.size()}));
    MOTE_RETURN_IF_ERROR(part->sync());
    return sameName == SameName::stays ? part->publishNew() : part->publish();
}

}  // namespace mote::client
