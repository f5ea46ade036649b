// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/frames/frame_run.h"

#include <fmt/format.h>
#include <xxhash.h>

#include <cstdio>
#include <memory>
#include <optional>

#include "client/frames/progress_bar.h"
#include "client/frames/script.h"
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

}  // namespace

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

Status FrameRun::report(const Asked& asked, const ReceivedFrame& frame) const {
    const std::chrono::duration<double, std::milli> total = std::chrono::steady_clock::now() - asked.since;
    const auto& message = frame.message;
    const FrameReport said{asked.index,         fileOf(asked.index).string(),
                           frame.pixels.width,  frame.pixels.height,
                           message.device(),    message.points_drawn(),
                           message.plan_ms(),   message.render_ms(),
                           message.encode_ms(), total.count()};
    const std::string line = said.toJson() + "\n";
    if (std::fputs(line.c_str(), stdout) >= 0 && std::fflush(stdout) == 0) return success();
    return Error{ErrorCode::internal, "stdout", "cannot be written to any more"};
}

}  // namespace mote::client
