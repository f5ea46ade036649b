// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/app/place_check.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <filesystem>
#include <string_view>

#include "protocol/scene/system_error.h"
#include "server/jobs/own_files.h"

namespace mote::server {
namespace {

namespace fs = std::filesystem;

Error unusable(std::string_view option, const fs::path& path, std::string_view why) {
    return {ErrorCode::permissionDenied, std::string(option), fmt::format("{} {}", path.string(), why)};
}

/// A folder in which something can be made.
Status checkFolder(std::string_view option, const fs::path& folder) {
    std::error_code code;
    if (!fs::is_directory(folder, code)) return unusable(option, folder, "is no folder");
    if (::access(folder.c_str(), W_OK | X_OK) == 0) return success();
    return unusable(option, folder, fmt::format("cannot be written to: {}", systemMessage(errno)));
}

/// What is there of the path to something that is to be made.
fs::path thereOf(fs::path path) {
    std::error_code code;
    while (!fs::exists(fs::symlink_status(path, code)) && path.has_relative_path()) path = path.parent_path();
    return path;
}

Status checkState(const fs::path& state) {
    std::error_code code;
    // The user may have put a link in its place, as for the server itself.
    const auto place = fs::canonical(state, code);
    if (code) return checkFolder("--state", thereOf(fs::absolute(state)));
    MOTE_RETURN_IF_ERROR(checkOwnFolder(place));
    return checkFolder("--state", place);
}

/// A file that is written anew, or whose name an older one gets: its folder counts.
Status checkFile(std::string_view option, const fs::path& file, const fs::path& folder) {
    std::error_code code;
    if (fs::is_directory(file, code)) return unusable(option, file, "is a folder");
    MOTE_RETURN_IF_ERROR(checkFolder(option, folder));
    if (!fs::exists(file, code) || ::access(file.c_str(), W_OK) == 0) return success();
    return unusable(option, file, fmt::format("cannot be written to: {}", systemMessage(errno)));
}

}  // namespace

Status checkPlaces(const ServerSettings& settings) {
    MOTE_RETURN_IF_ERROR(checkState(settings.stateDirectory));
    const auto connection = fs::absolute(settings.connectionFile);
    auto folder = connection.parent_path();
    // The state's folder is made before the file is.
    if (folder == fs::absolute(settings.stateDirectory)) folder = thereOf(folder);
    MOTE_RETURN_IF_ERROR(checkFile("--connection", connection, folder));
    if (settings.logFile.empty()) return success();
    // Folders of the log are made.
    const auto log = fs::absolute(settings.logFile);
    return checkFile("--log", log, thereOf(log.parent_path()));
}

}  // namespace mote::server
