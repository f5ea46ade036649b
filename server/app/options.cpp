// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/app/options.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>

#include "protocol/cli/command.h"
#include "server/data/data_memory.h"

namespace mote::server {
namespace {

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
A configuration file holds the same options:
  root = ["data=/data/runs"]
  state = "/home/me/.mote"
  connection = "/home/me/.mote/connection.json"
)";

struct Texts {
    std::vector<std::string> roots;
    std::string state, connection, listen = "unix", device = "auto", memory, config;
    std::int64_t threads = 0;
};

void addOptions(const cli::Command& app, Texts& texts) {
    app.option("--root", texts.roots, "a folder with datasets and runs, NAME=DIR; may be repeated")
        .repeatable()
        .valueName("NAME=DIR");
    app.option("--state", texts.state, "the server's own folder: jobs and the socket; made where absent");
    app.option("--connection", texts.connection,
               "the file that tells clients where the server is, with the token (mode 0600)");
    app.option("--listen", texts.listen, "unix (reach it from elsewhere through ssh -L)").showDefault("unix");
    app.option("--device", texts.device, "auto, egl or cpu: what renders").showDefault("auto");
    app.option(
        "--memory", texts.memory,
        "what the server may use, and each job besides, for example 8G; default: half of the machine's "
        "memory for data, no limit for jobs");
    app.option("--threads", texts.threads, "of a job, and of the device cpu; default all").range(0, 4096);
    app.option("--config", texts.config, "a TOML file with these options; the command line wins");
    app.footer(examples);
}

/// What stands on the command line stays.
void fillFrom(const FileOptions& file, const cli::Command& app, Texts& texts) {
    const auto fill = [&](const char* option, const auto& value, auto& text) {
        if (value && app.count(option) == 0) text = *value;
    };
    if (app.count("--root") == 0) texts.roots = file.roots;
    fill("--state", file.state, texts.state);
    fill("--connection", file.connection, texts.connection);
    fill("--listen", file.listen, texts.listen);
    fill("--device", file.device, texts.device);
    fill("--memory", file.memory, texts.memory);
    fill("--threads", file.threads, texts.threads);
}

Status checkListen(const std::string& listen) {
    if (listen == "unix") return success();
    if (listen.starts_with("tcp:")) {
        return Error{ErrorCode::unsupported, "--listen",
                     "TCP needs TLS, which is not there yet; use --listen unix and reach the socket from "
                     "elsewhere with ssh -L"};
    }
    return Error{ErrorCode::invalidArgument, "--listen", fmt::format("\"{}\" is not \"unix\"", listen)};
}

Error missing(const char* option) {
    return {ErrorCode::invalidArgument, option, "is needed; see --help"};
}

Result<ServerSettings> toSettings(const Texts& texts) {
    if (texts.roots.empty()) return missing("--root");
    if (texts.state.empty()) return missing("--state");
    if (texts.connection.empty()) return missing("--connection");
    MOTE_RETURN_IF_ERROR(checkListen(texts.listen));
    const auto device = render::parseDeviceKind(texts.device);
    if (!device.ok()) return Error{device.error().code, "--device", device.error().message};
    ServerSettings settings;
    settings.roots = texts.roots;
    settings.stateDirectory = texts.state;
    settings.connectionFile = texts.connection;
    settings.device = *device;
    settings.threads = static_cast<unsigned>(texts.threads);
    if (texts.memory.empty()) return settings;
    const auto memory = parseSize(texts.memory);
    if (!memory.ok()) return memory.error().within("--memory");
    MOTE_RETURN_IF_ERROR(dataMemory(*memory), "--memory");
    settings.memory = *memory;
    return settings;
}

int complain(const Error& error) {
    fmt::print(stderr, "mote-server: {}\n", error.toString());
    return wrongUsage;
}

}  // namespace

Result<std::uint64_t> parseSize(const std::string& text) {
    double number = 0.0;
    const auto [rest, code] = std::from_chars(text.data(), text.data() + text.size(), number);
    std::string unit(rest, text.data() + text.size());
    for (auto& c : unit) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
    if (unit.ends_with("IB")) unit.resize(unit.size() - 2);
    if (unit.ends_with("B")) unit.pop_back();
    constexpr std::string_view units = "KMGT";
    const std::size_t power = unit.empty() ? 0 : units.find(unit) + 1;  // 0 where there is no such unit
    const bool known = unit.empty() || (unit.size() == 1 && power > 0);
    const double bytes = number * std::pow(1024.0, static_cast<double>(power));
    if (code != std::errc{} || !known || !(bytes >= 1.0 && bytes < 0x1p62)) {
        return Error{ErrorCode::invalidArgument, "", fmt::format("\"{}\" is no size such as 8G", text)};
    }
    return static_cast<std::uint64_t>(bytes);
}

std::variant<ServerSettings, int> parseOptions(int argc, const char* const* argv) {
    const cli::Program program("Renders particle datasets where they lie and shows them to clients.",
                               "mote-server");
    const auto app = program.command();
    Texts texts;
    addOptions(app, texts);
    if (const auto end = program.parse(argc, argv)) return *end;
    if (!texts.config.empty()) {
        const auto file = readConfig(texts.config);
        if (!file.ok()) return complain(file.error());
        fillFrom(*file, app, texts);
    }
    auto settings = toSettings(texts);
    if (!settings.ok()) return complain(settings.error());
    return *std::move(settings);
}

}  // namespace mote::server
