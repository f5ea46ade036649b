// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>
#include <unistd.h>
#include <xxhash.h>

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <exception>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "client/frames/interrupt.h"
#include "client/frames/options.h"
#include "client/frames/private_server.h"
#include "client/frames/script.h"
#include "client/shared/connection.h"
#include "protocol/scene/json.h"

namespace mote::client {
namespace {

/// Signals are looked for this often.
constexpr std::chrono::milliseconds patience{50};

/// Makes the folder of the pictures, and takes it away again where nothing came to lie in it.
class OutputFolder {
  public:
    explicit OutputFolder(std::filesystem::path path) : path_(std::move(path)) {}
    ~OutputFolder() {
        std::error_code ignored;
        if (made_) std::filesystem::remove(path_, ignored);  // fails where there is a picture: as it should
    }
    OutputFolder(const OutputFolder&) = delete;
    OutputFolder& operator=(const OutputFolder&) = delete;

    Status make() {
        std::error_code code;
        made_ = std::filesystem::create_directories(path_, code);
        if (!code && std::filesystem::is_directory(path_)) return success();
        if (!code) return Error{ErrorCode::alreadyExists, path_.string(), "is no folder"};
        const bool denied = code == std::errc::permission_denied;
        return Error{denied ? ErrorCode::permissionDenied : ErrorCode::internal, path_.string(),
                     "the folder cannot be made: " + code.message()};
    }

  private:
    std::filesystem::path path_;
    bool made_ = false;
};

std::string remaining(std::chrono::duration<double> elapsed, std::size_t done, std::size_t total) {
    if (done == 0) return "";
    const auto seconds = static_cast<long>(
        elapsed.count() * static_cast<double>(total - done) / static_cast<double>(done) + 0.5);
    if (seconds < 60) return fmt::format(", {} s left", seconds);
    return fmt::format(", {} min {} s left", seconds / 60, seconds % 60);
}

/// How far a run is, on stderr, where that is a terminal.
class ProgressBar {
  public:
    /// Shows nothing where `wanted` is false or stderr is no terminal.
    ProgressBar(std::size_t total, bool wanted)
        : total_(total), visible_(wanted && total > 0 && ::isatty(STDERR_FILENO) == 1) {
        show(0);
    }
    ~ProgressBar() {
        if (visible_) std::fputs(wipe, stderr);
    }
    ProgressBar(const ProgressBar&) = delete;
    ProgressBar& operator=(const ProgressBar&) = delete;

    void show(std::size_t done) {
        if (!visible_) return;
        constexpr std::size_t width = 30;
        const std::size_t filled = width * done / total_;
        const std::string bar = std::string(filled, '#') + std::string(width - filled, '.');
        const auto elapsed = std::chrono::steady_clock::now() - start_;
        fmt::print(stderr, "{}[{}] {} of {} frames{}", wipe, bar, done, total_,
                   remaining(elapsed, done, total_));
        std::fflush(stderr);
    }

  private:
    static constexpr const char* wipe = "\r\x1b[K";

    const std::size_t total_;
    const bool visible_;
    const std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

/// A JSON string. Bytes beyond ASCII are passed on as they are: names of files are UTF-8 nearly always.
std::string jsonString(std::string_view text) {
    std::string result = "\"";
    for (const char each : text) {
        if (each == '"' || each == '\\') {
            result += '\\';
            result += each;
        } else if (static_cast<unsigned char>(each) < 0x20) {
            result += fmt::format("\\u{:04x}", static_cast<unsigned>(each));
        } else {
            result += each;
        }
    }
    return result + '"';
}

/// Those of the layers, and the images that they show.
std::vector<std::string> datasetsOf(const proto::View& view) {
    std::vector<std::string> names;
    for (const auto& layer : view.layers()) {
        names.push_back(layer.dataset());
        if (!layer.stipple().image().empty()) names.push_back(layer.stipple().image());
    }
    return names;
}

Error inView(const Error& error, std::size_t index) {
    return error.within(fmt::format("views[{}]", index));
}

/// The views of a script, one after the other, from a server to files. Exact pictures only; while one is
/// encoded here, the server draws the next. Main thread.
class FrameRun {
  public:
    /// Keeps references: they outlive it.
    FrameRun(const FramesOptions& options, const std::vector<proto::View>& views, Connection& connection,
             const Interrupt& interrupt);

    /// Waits for the server, checks the datasets, draws. Finished pictures stay whatever happens. Errors: the
    /// server's, the disk's, cancelled (interrupted).
    Status run();

  private:
    using Time = std::chrono::steady_clock::time_point;
    struct Asked {
        std::size_t index = 0;  // of the view
        std::uint64_t id = 0;   // the connection's, of the view
        Time since;
    };

    Status waitUntil(const std::function<bool()>& done);
    template <class T>
    Result<T> answer(const std::function<void(Connection::Reply<T>)>& ask);
    Status learnDatasets();
    std::string keyOf(const proto::View& view) const;
    std::vector<std::size_t> missing() const;
    std::filesystem::path fileOf(std::size_t index) const;

    bool isDocument() const { return options_.page.format() != proto::Page::FORMAT_UNSPECIFIED; }

    Status drawAll(const std::vector<std::size_t>& indices);
    Asked ask(std::size_t index);
    Result<ReceivedFrame> receive(const Asked& asked);
    Status finish(const Asked& asked, const ReceivedFrame& frame);
    Status report(const Asked& asked, const ReceivedFrame& frame) const;

    const FramesOptions& options_;
    const std::vector<proto::View>& views_;
    Connection& connection_;
    const Interrupt& interrupt_;
    std::map<std::string, std::string> manifests_;  // of the datasets shown, as JSON
    std::map<std::uint64_t, Error> failures_;       // by view id
};

FrameRun::FrameRun(const FramesOptions& options, const std::vector<proto::View>& views,
                   Connection& connection, const Interrupt& interrupt)
    : options_(options), views_(views), connection_(connection), interrupt_(interrupt) {
    connection_.onViewFailed(
        [this](std::uint64_t id, const Error& error) { failures_.insert_or_assign(id, error); });
}

Status FrameRun::run() {
    MOTE_RETURN_IF_ERROR(waitUntil([&] { return connection_.state() == Connection::State::connected; }));
    MOTE_RETURN_IF_ERROR(learnDatasets());
    OutputFolder folder(options_.out);
    MOTE_RETURN_IF_ERROR(folder.make());
    return drawAll(missing());
}

Status FrameRun::waitUntil(const std::function<bool()>& done) {
    while (true) {
        connection_.poll();
        if (interrupt_.requested()) return Error{ErrorCode::cancelled, "", "interrupted"};
        if (done()) return success();
        if (connection_.state() == Connection::State::lost) return connection_.lostReason().value_or(Error{});
        connection_.wait(patience);
    }
}

template <class T>
Result<T> FrameRun::answer(const std::function<void(Connection::Reply<T>)>& ask) {
    const auto got = std::make_shared<std::optional<Result<T>>>();
    ask([got](Result<T> result) { *got = std::move(result); });
    MOTE_RETURN_IF_ERROR(waitUntil([&] { return got->has_value(); }));
    return **got;
}

Status FrameRun::learnDatasets() {
    const auto catalogue = answer<proto::Catalogue>([&](auto reply) { connection_.listDatasets(reply); });
    MOTE_RETURN_IF_ERROR(catalogue);
    const auto checked = checkDatasets(views_, *catalogue);
    if (!checked.ok()) {
        const auto& error = checked.error();
        return Error{error.code, fmt::format("{}: {}", options_.script.string(), error.where), error.message};
    }
    for (const auto& view : views_) {
        for (const auto& dataset : datasetsOf(view)) {
            if (manifests_.count(dataset) > 0) continue;
            const auto description = answer<proto::Description>(
                [&](auto reply) { connection_.describe(dataset, std::move(reply)); });
            MOTE_RETURN_IF_ERROR(description);
            manifests_[dataset] = toJsonLine(description->manifest());
        }
    }
    return success();
}

/// Everything that decides a picture's bytes: view, data (the manifest holds the digest of every file), who
/// draws, and what kind of file it becomes.
std::string FrameRun::keyOf(const proto::View& view) const {
    const auto welcome = connection_.welcome();
    std::string text = fmt::format("1\n{}\n{}\n{}\n{}\n", name(options_.format), welcome.server(),
                                   welcome.device(), toJsonLine(view));
    if (isDocument()) text += toJsonLine(options_.page) + "\n";
    for (const auto& dataset : datasetsOf(view)) text += manifests_.at(dataset) + "\n";
    const XXH128_hash_t hash = XXH3_128bits(text.data(), text.size());
    return fmt::format("{:016x}{:016x}", hash.high64, hash.low64);
}

std::filesystem::path FrameRun::fileOf(std::size_t index) const {
    return options_.out / fmt::format("frame-{:06}.{}", index, name(options_.format));
}

std::vector<std::size_t> FrameRun::missing() const {
    std::vector<std::size_t> indices;
    for (std::size_t i = 0; i < views_.size(); ++i) {
        const auto& view = views_[i];
        const bool there = options_.resume && readPictureKey(fileOf(i), options_.format, view.width(),
                                                             view.height()) == keyOf(view);
        if (!there) indices.push_back(i);
    }
    return indices;
}

Status FrameRun::drawAll(const std::vector<std::size_t>& indices) {
    ProgressBar bar(indices.size(), !options_.quiet);
    std::optional<Asked> next;
    for (std::size_t i = 0; i < indices.size(); ++i) {
        const Asked asked = next ? *next : ask(indices[i]);
        MOTE_ASSIGN_OR_RETURN(const auto frame, receive(asked));
        next.reset();
        if (i + 1 < indices.size()) next = ask(indices[i + 1]);
        MOTE_RETURN_IF_ERROR(finish(asked, frame));
        bar.show(i + 1);
    }
    return success();
}

FrameRun::Asked FrameRun::ask(std::size_t index) {
    ViewRequest request;
    request.finalOnly = true;
    request.format = pixelFormat(options_.format);
    if (isDocument()) request.page = options_.page;
    const auto since = std::chrono::steady_clock::now();
    return {index, connection_.setView(views_[index], request), since};
}

Result<ReceivedFrame> FrameRun::receive(const Asked& asked) {
    std::optional<ReceivedFrame> frame;
    const auto failed = [&] { return failures_.count(asked.id) + failures_.count(0) > 0; };
    MOTE_RETURN_IF_ERROR(waitUntil([&] {
        auto taken = connection_.takeFrame();
        if (taken && taken->message.view_id() == asked.id && taken->message.final()) frame = std::move(taken);
        return frame.has_value() || failed();
    }));
    if (!frame) return inView(failures_.begin()->second, asked.index);
    const auto& view = views_[asked.index];
    if (frame->pixels.width != view.width() || frame->pixels.height != view.height()) {
        return inView({ErrorCode::corrupt, "", "the server sent a picture of another size"}, asked.index);
    }
    return *std::move(frame);
}

Status FrameRun::finish(const Asked& asked, const ReceivedFrame& frame) {
    const auto bytes = encodePicture(frame.pixels, options_.format, keyOf(views_[asked.index]));
    if (!bytes.ok()) return inView(bytes.error(), asked.index);
    MOTE_RETURN_IF_ERROR(writeFile(fileOf(asked.index), *bytes));
    return options_.json ? report(asked, frame) : success();
}

/// One JSON object on one line; times from the server, but for the total: from sending the view to the file.
Status FrameRun::report(const Asked& asked, const ReceivedFrame& frame) const {
    const std::chrono::duration<double, std::milli> total = std::chrono::steady_clock::now() - asked.since;
    const auto& message = frame.message;
    const std::string line = fmt::format(
        "{{\"index\": {}, \"file\": {}, \"width\": {}, \"height\": {}, \"device\": {}, \"pointsDrawn\": {}, "
        "\"planMs\": {:.3f}, \"renderMs\": {:.3f}, \"encodeMs\": {:.3f}, \"totalMs\": {:.3f}}}\n",
        asked.index, jsonString(fileOf(asked.index).string()), frame.pixels.width, frame.pixels.height,
        jsonString(message.device()), message.points_drawn(), message.plan_ms(), message.render_ms(),
        message.encode_ms(), total.count());
    if (std::fputs(line.c_str(), stdout) >= 0 && std::fflush(stdout) == 0) return success();
    return Error{ErrorCode::internal, "stdout", "cannot be written to any more"};
}

constexpr int failure = 1;
constexpr int killedBy = 128;  // and the signal's number, as shells say it

int fail(const Error& error, const Interrupt& interrupt) {
    fmt::print(stderr, "mote-frames: {}\n", error.toString());
    return interrupt.requested() ? killedBy + interrupt.signal() : failure;
}

Status draw(const FramesOptions& options, const std::vector<proto::View>& views, const Interrupt& interrupt) {
    std::unique_ptr<PrivateServer> server;
    if (!options.connect) {
        MOTE_ASSIGN_OR_RETURN(
            server, PrivateServer::start({serverBesideUs(), options.roots, options.device}, interrupt));
    }
    ConnectionSettings settings;
    settings.client = "mote-frames " MOTE_VERSION;
    Connection connection(server ? server->connectionFile() : *options.connect, settings);
    const auto drawn = FrameRun(options, views, connection, interrupt).run();
    const bool died = server && connection.state() == Connection::State::lost;
    if (drawn.ok() || !died || server->lastWords().empty()) return drawn;
    return Error{drawn.error().code, "mote-server",
                 fmt::format("{}; it last said: {}", drawn.error().toString(), server->lastWords())};
}

int run(int argc, const char* const* argv) {
    const Interrupt interrupt;
    const auto parsed = parseFramesOptions(argc, argv);
    if (const int* status = std::get_if<int>(&parsed)) return *status;
    const auto& options = std::get<FramesOptions>(parsed);
    const auto views = readScript(options.script);
    if (!views.ok()) return fail(views.error(), interrupt);
    const auto drawn = draw(options, *views, interrupt);
    return drawn.ok() ? 0 : fail(drawn.error(), interrupt);
}

}  // namespace
}  // namespace mote::client

int main(int argc, char** argv) {
    try {
        return mote::client::run(argc, argv);
    } catch (const std::exception& error) {
        fmt::print(stderr, "mote-frames: {}\n", error.what());
        return 1;
    }
}
