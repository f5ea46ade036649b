// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "client/shared/interrupt.h"
#include "client/shared/server_line.h"
#include "client/view/viewer.h"
#include "protocol/base/complain.h"
#include "protocol/cli/command.h"

namespace mote::client {
namespace {

/// "1600x900" into two numbers from 64 to 16384.
bool parseSize(const std::string& text, ViewOptions& options) {
    const char* end = text.data() + text.size();
    const auto width = std::from_chars(text.data(), end, options.width);
    if (width.ec != std::errc() || width.ptr == end || *width.ptr != 'x') return false;
    const auto height = std::from_chars(width.ptr + 1, end, options.height);
    if (height.ec != std::errc() || height.ptr != end) return false;
    const auto sensible = [](int side) { return side >= 64 && side <= 16384; };
    return sensible(options.width) && sensible(options.height);
}

/// Where a server writes its connection file unless told otherwise.
std::filesystem::path standardConnection() {
    const char* home = std::getenv("HOME");
    return std::filesystem::path(home ? home : ".") / ".mote" / "connection.json";
}

/// "user@node", where no file is called so.
bool isNode(const std::filesystem::path& target) {
    const auto text = target.string();
    const auto at = text.find('@');
    std::error_code code;
    return at != text.npos && at > 0 && at + 1 < text.size() && text.find('/') == text.npos &&
           text.front() != '-' && !std::filesystem::exists(target, code);
}

/// Becomes "mote connect NODE -- mote-view", with all else that was said. Returns the exit status if it
/// cannot.
int becomeConnect(const std::string& node, std::span<const char* const> said) {
    const auto mote = serverBesideUs().replace_filename("mote").string();
    std::vector<std::string> words{mote, "connect", node, "--", "mote-view"};
    const auto target = std::ranges::find(said, std::string_view(node),
                                          [](const char* word) { return std::string_view(word); });
    for (auto word = said.begin() + 1; word != said.end(); ++word) {
        if (word != target) words.emplace_back(*word);
    }
    std::vector<char*> pointers;
    pointers.reserve(words.size() + 1);
    for (auto& word : words) pointers.push_back(word.data());
    pointers.push_back(nullptr);
    ::execv(mote.c_str(), pointers.data());
    complain("mote-view",
             fmt::format("{}: {} is needed and cannot be run: {}", node, mote, std::strerror(errno)));
    return 1;
}

/// The options, or the exit status after help or a mistake, which has been printed.
std::variant<ViewOptions, int> parseViewOptions(int argc, const char* const* argv) {
    ViewOptions options;
    options.connection = standardConnection();
    std::string size;
    const cli::Program program("mote-view shows the datasets of a mote-server.", "mote-view");
    const auto app = program.command();
    app.footer(
        "In the window, ? shows all keys and Ctrl-K finds every command.\n\n"
        "Examples:\n"
        "  mote-view run.h5\n"
        "  mote-view plots/\n"
        "  mote-view user@node\n"
        "  mote-view --connect ~/.mote/connection.json\n"
        "  mote-view --connect c.json --view halo.json --screenshot halo.png --exit-after-still\n"
        "  mote-view --connect c.json --film film.json");
    app.option(
        "TARGET", options.target,
        "A folder of datasets, a dataset, or the file of a run, a volume or a mesh, which is prepared into a "
        "cache; shown by a server that this program starts and stops. Or USER@NODE, for what the server "
        "there "
        "shows, as mote connect");
    app.option("--spawn", options.spawn, "A root of a server that this program starts and stops, NAME=DIR");
    app.option("--connect", options.connection, "Connection file of the server").showDefault();
    app.option("--view", options.view,
               "A saved view (JSON) to start with, or a script, whose first view is shown");
    app.option("--film", options.film, "A script of keyframes (JSON) to edit");
    app.option("--size", size, "Size of the window, WIDTHxHEIGHT").showDefault("1600x900");
    app.option("--screenshot", options.screenshot,
               "Writes the window as PNG once the exact picture is shown");
    app.option("--save-view", options.saveView,
               "Saves the view once the exact picture is shown; an existing file is kept, and is an error");
    app.flag("--exit-after-still", options.exitAfterStill, "Exits once the exact picture is shown");
    const auto check = [&]() -> Status {
        if (!size.empty() && !parseSize(size, options))
            return invalid("--size", size + " is not WIDTHxHEIGHT, 64 to 16384 each");
        return options.target && !isNode(*options.target) ? resolveTarget(options) : success();
    };
    if (const auto end = program.parse(argc, argv, check)) return *end;
    if (options.target && isNode(*options.target))
        return becomeConnect(options.target->string(), {argv, static_cast<std::size_t>(argc)});
    return options;
}

/// One of our own is ready, if the options want one.
Status awaitServer(ViewOptions& options) {
    if (options.spawn.empty()) return success();
    if (!options.server) MOTE_RETURN_IF_ERROR(startServer(options));
    const Interrupt interrupt;  // while it starts
    MOTE_RETURN_IF_ERROR(options.server->waitUntilReady(interrupt));
    options.connection = options.server->connectionFile();
    return success();
}

}  // namespace
}  // namespace mote::client

int main(int argc, char** argv) {
    using namespace mote::client;
    try {
        const auto parsed = parseViewOptions(argc, argv);
        if (const int* status = std::get_if<int>(&parsed)) return *status;
        auto options = std::get<ViewOptions>(parsed);
        if (const auto served = awaitServer(options); !served.ok()) {
            mote::complain("mote-view", served.error().toString());
            return 1;
        }
        Viewer viewer(options);
        if (!viewer.loaded().ok()) {
            mote::complain("mote-view", viewer.loaded().error().toString());
            return 1;
        }
        return viewer.run();
    } catch (const std::exception& error) {
        mote::complainAtEnd("mote-view", error);
        return 1;
    }
}
