// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/app/options.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <filesystem>
#include <map>
#include <string_view>

#include "protocol/base/complain.h"
#include "protocol/base/system_error.h"
#include "protocol/base/utf8.h"
#include "protocol/cli/command.h"
#include "server/app/config_file.h"
#include "server/app/server_option.h"
#include "server/data/data_memory.h"
#include "server/jobs/runner.h"
#include "server/jobs/state_directory.h"
#include "storage/roots.h"

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

/// Whether a server could keep its things where its settings say, asked without making any of them: the state
/// directory, the connection file and the log. Errors: permissionDenied, saying of the first of them that
/// cannot be what is wrong with it.
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

constexpr int wrongUsage = 2;

constexpr const char* examples = R"(
Examples:
  mote-server --root data=/data/runs --state ~/.mote --connection ~/.mote/connection.json
  mote-server --root data=/data/runs --root home=$HOME/plots --state /var/tmp/$USER-mote \
              --connection /var/tmp/$USER-mote.json --device egl --memory 8G
  mote-server --config ~/.config/mote/server.toml

From another machine, through ssh (the connection file says where the socket is; copy the file, mode 0600,
and let its address be that of the local end):
  ssh -N -L /tmp/mote.sock:/home/me/.mote/mote.sock node

It prints one line "ready ..." when it accepts clients, and ends on SIGTERM or Ctrl-C.
A configuration file holds the same options, a key each:
  root = ["data=/data/runs"]
  state = "/home/me/.mote"
  connection = "/home/me/.mote/connection.json"
)";

/// What the command line holds, option by option.
struct Words {
    std::map<std::string, std::vector<std::string>> values;
    std::map<std::string, bool> flags;
    std::string config;
    bool checkConfig = false;
};

void addOptions(const cli::Command& app, Words& words) {
    for (const auto& option : serverOptions()) {
        const std::string name = std::string("--") + option.name;
        if (option.isFlag()) {
            app.flag(name, words.flags[option.name], option.help);
        } else {
            app.option(name, words.values[option.name], option.help).repeatable().valueName(option.valueName);
        }
    }
    app.option("--config", words.config, "a TOML file with these options; the command line wins")
        .valueName("FILE");
    app.flag("--check-config", words.checkConfig,
             "check all options, the file and what they name, print one line and exit with 0 or 1");
    app.footer(examples);
}

/// What was given for an option, on the command line or else in the file, and where.
ConfigValue given(const ServerOption& option, const Words& words,
                  const std::map<std::string, ConfigValue>& file) {
    const std::string where = std::string("--") + option.name;
    if (option.isFlag() && words.flags.at(option.name)) return {{"true"}, where};
    if (!option.isFlag() && !words.values.at(option.name).empty()) {
        return {words.values.at(option.name), where};
    }
    const auto found = file.find(option.name);
    return found == file.end() ? ConfigValue{{}, where} : found->second;
}

/// What rows of the table do not say.
Status checkTogether(const ServerSettings& settings) {
    if (const auto roots = storage::Roots::check(settings.roots); !roots.ok()) {
        const auto& error = roots.error();
        return Error{error.code, "--root", fmt::format("\"{}\": {}", error.where, error.message)};
    }
    MOTE_RETURN_IF_ERROR(dataMemory(settings.memory), "--memory");
    if (settings.runner == "local" && settings.jobRanks > 1)
        return Error{ErrorCode::invalidArgument, "--job-ranks", "needs --runner mpi or slurm"};
    if (settings.runner == "mpi" && settings.jobRanks == 1)
        return Error{ErrorCode::invalidArgument, "--runner", "\"mpi\" needs --job-ranks of 2 or more"};
    return success();
}

Result<ServerSettings> toSettings(const Words& words) {
    std::map<std::string, ConfigValue> file;
    if (!words.config.empty()) {
        MOTE_ASSIGN_OR_RETURN(file, readConfig(words.config));
    }
    ServerSettings settings;
    for (const auto& option : serverOptions()) {
        const auto value = given(option, words, file);
        if (value.values.empty() && option.needed) {
            return Error{ErrorCode::invalidArgument, value.where, "is needed; see --help"};
        }
        const auto set = option.set(value.values, settings);
        if (!set.ok()) return Error{set.error().code, value.where, set.error().message};
    }
    MOTE_RETURN_IF_ERROR(checkTogether(settings));
    return settings;
}

int fail(const Error& error, int code) {
    complain("mote-server", error.toString());
    return code;
}

/// What only the place knows: the roots are there and may be read, what the server keeps can be kept, and its
/// runner has its programs. How many roots there are.
Result<std::size_t> checkSystem(const ServerSettings& settings) {
    MOTE_ASSIGN_OR_RETURN(const auto roots, storage::Roots::parse(settings.roots));
    MOTE_RETURN_IF_ERROR(checkPlaces(settings));
    MOTE_RETURN_IF_ERROR(checkRunner(settings.runner, settings.jobRanks));
    return roots.entries().size();
}

int reportCheck(const ServerSettings& settings) {
    const auto roots = checkSystem(settings);
    if (!roots.ok()) return fail(roots.error(), 1);
    fmt::print("mote-server: the configuration is right: {} roots, state {}, connection {}\n", *roots,
               toTerminalText(settings.stateDirectory.string()),
               toTerminalText(settings.connectionFile.string()));
    return 0;
}

}  // namespace

std::variant<ServerSettings, int> parseOptions(int argc, const char* const* argv) {
    const cli::Program program("Renders datasets where they lie and streams the pictures to clients.",
                               "mote-server");
    const auto app = program.command();
    Words words;
    addOptions(app, words);
    if (const auto end = program.parse(argc, argv)) return *end;
    auto settings = toSettings(words);
    if (!settings.ok()) return fail(settings.error(), words.checkConfig ? 1 : wrongUsage);
    if (words.checkConfig) return reportCheck(*settings);
    return *std::move(settings);
}

}  // namespace mote::server
