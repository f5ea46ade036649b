// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/frames/picture_files.h"

#include "protocol/scene/film_job.h"

namespace mote::client {

PictureFiles::~PictureFiles() {
    std::error_code ignored;
    if (made_) std::filesystem::remove(folder_, ignored);  // fails where there is a picture: as it should
}

Status PictureFiles::open(bool) {
    std::error_code code;
    made_ = std::filesystem::create_directories(folder_, code);
    if (!code && std::filesystem::is_directory(folder_)) return success();
    if (!code) return Error{ErrorCode::alreadyExists, folder_.string(), "is no folder"};
    const bool denied = code == std::errc::permission_denied;
    return Error{denied ? ErrorCode::permissionDenied : ErrorCode::internal, folder_.string(),
                 "the folder cannot be made: " + code.message()};
}

bool PictureFiles::has(std::size_t index, std::string_view key, std::uint32_t width,
                       std::uint32_t height) const {
    return readPictureKey(fileOf(index), format_, width, height) == key;
}

Status PictureFiles::put(DrawnFrame frame) {
    MOTE_ASSIGN_OR_RETURN(const auto bytes, encodePicture(frame.pixels, format_, frame.key));
    return writeFile(fileOf(frame.index), bytes);
}

std::filesystem::path PictureFiles::fileOf(std::size_t index) const {
    return folder_ / pictureName(index, extension(format_));
}

}  // namespace mote::client
