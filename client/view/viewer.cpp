// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/view/viewer.h"

#include <fmt/format.h>
#include <imgui.h>

#include <algorithm>
#include <utility>

#include "client/shared/jobs.h"
#include "client/view/window.h"
#include "protocol/scene/complain.h"

namespace mote::client {
namespace {

constexpr double idleSeconds =
    0.25;  // how long to sleep where nothing happens; input and frames wake at once
constexpr double activeSeconds = 0.005;  // between looks while a gesture or a refinement is under way

/// A server of a node that is down for the night is still waited for.
constexpr std::chrono::hours untiringPatience{24 * 30};

ConnectionSettings connectionSettings(const ViewOptions& options) {
    ConnectionSettings settings;
    settings.client = "mote-view " MOTE_VERSION;
    settings.wake = [] { Window::wake(); };
    if (!options.exitAfterStill) {
        settings.returnPatience = untiringPatience;
        settings.outlastsFarewells = true;
    }
    return settings;
}

}  // namespace

Viewer::Viewer(const ViewOptions& options)
    : options_(options),
      window_(options.width, options.height, "Mote"),
      film_(connection_, [this](const proto::JobStatus& job) { replaceJob(job); }),
      connection_(options.connection, connectionSettings(options)),
      numbers_({[this](const proto::Query& query, QueryLine::Reply reply) {
                    return connection_.query(query, std::move(reply));
                },
                [this](std::uint64_t query) { connection_.cancelQuery(query); }}) {
    if (options.view) {
        loaded_ = openView(*options.view);
        if (!note_.empty()) complain("mote-view", note_);
    }
    if (options.film && loaded_.ok()) {
        loaded_ = film_.open(*options.film);
        if (loaded_.ok() && !options.view) loaded_ = model_.load(film_.film().keyframes().front().view);
        filmShown_ = true;
    }
    listen();
}

void Viewer::listen() {
    connection_.onState([this](Connection::State state) {
        film_.forgetAsked();
        if (state != Connection::State::connecting) numbers_.forget();
        if (state == Connection::State::connected) askServer();
        if (state == Connection::State::lost && options_.exitAfterStill) exitStatus_ = 1;
    });
    connection_.onCatalogue([this](const proto::Catalogue& catalogue) {
        server_.catalogue = catalogue;
        film_.setCatalogue(catalogue);
        numbers_.forget();
        openAwaited();
    });
    connection_.onJob([this](const proto::JobStatus& job) { replaceJob(job); });
    connection_.onViewFailed([this](std::uint64_t view, const Error& error) {
        if (film_.takeFailure(view)) return;
        viewFailure_ = error.toString();
        say(viewFailure_);
        if (options_.exitAfterStill) exitStatus_ = 1;
    });
}

void Viewer::askServer() {
    connection_.listDatasets([this](Result<proto::Catalogue> reply) {
        if (!reply.ok()) return say(reply.error().toString());
        server_.catalogue = *reply;
        film_.setCatalogue(*reply);
        if (model_.hasDataset()) return openDataset(model_.dataset());
        if (model_.isLoaded()) return;  // a view without layers
        if (reply->datasets().empty()) return say("the server has no datasets yet");
        openDataset(reply->datasets(0).name());
    });
    connection_.watchJobs([this](Result<proto::Jobs> reply) {
        if (!reply.ok()) return say(reply.error().toString());
        server_.jobs.assign(reply->jobs().begin(), reply->jobs().end());
        server_.allJobs = reply->total();
        jobsPaged_ = 0;
    });
}

bool Viewer::openAwaited() {
    const auto& known = server_.catalogue.datasets();
    const auto isAwaited = [this](const auto& entry) { return entry.name() == awaitedDataset_; };
    if (awaitedDataset_.empty() || std::none_of(known.begin(), known.end(), isAwaited)) return false;
    openDataset(std::exchange(awaitedDataset_, {}));
    return true;
}

void Viewer::openDataset(const std::string& name) {
    connection_.describe(name, [this, name](Result<proto::Description> reply) {
        if (!reply.ok()) {
            if (options_.exitAfterStill) exitStatus_ = 1;
            return say(reply.error().toString());
        }
        film_.setDescription(*reply);
        server_.shown = *std::move(reply);
        const auto step = model_.step();
        model_.setDataset(name, server_.shown->manifest());
        say(std::exchange(note_, {}));
        if (model_.step() != step)
            say(fmt::format("{} has no step {}: step {} is shown", name, step, model_.step()));
        window_.setTitle(fmt::format("{} - Mote", name));
        dirty_ = true;
    });
}

void Viewer::showView(const proto::View& view) {
    const auto loaded = model_.load(view);
    if (!loaded.ok()) return say(loaded.error().toString());
    dirty_ = true;
    describeShown();
}

/// Where the datasets of further layers lie, which the camera is fitted to.
void Viewer::learnDatasets() {
    for (const auto& name : model_.unknownDatasets()) {
        if (name == model_.dataset()) continue;
        if (const auto* described = film_.description(name)) model_.know(name, described->manifest());
    }
}

/// What the panel says of the dataset in the view, once it is known.
void Viewer::describeShown() {
    const auto* description = film_.description(model_.dataset());
    if (description == nullptr) return;
    if (!server_.shown || server_.shown->dataset() != model_.dataset()) {
        server_.shown = *description;
        window_.setTitle(fmt::format("{} - Mote", model_.dataset()));
    }
    model_.describe(description->manifest());
}

void Viewer::plot(const AxisNames& axes) {
    const auto request = replotRequest(*server_.shown, axes);
    if (!request) return say("the run of this plot is not within the server's reach");
    awaitedDataset_ = datasetName(*request);
    if (openAwaited()) return;
    connection_.submitJob(*request, [this](Result<proto::JobStatus> reply) {
        if (reply.ok()) return replaceJob(*reply);
        awaitedDataset_.clear();
        say(reply.error().toString());
    });
}

void Viewer::replaceJob(const proto::JobStatus& job) {
    auto& jobs = server_.jobs;
    const auto known =
        std::find_if(jobs.begin(), jobs.end(), [&](const auto& j) { return j.id() == job.id(); });
    if (known == jobs.end()) {
        jobs.insert(jobs.begin(), job);
        ++server_.allJobs;
    } else {
        *known = job;
    }
    const bool ours = !awaitedDataset_.empty() && datasetName(job.request()) == awaitedDataset_;
    if (!ours) return;
    if (job.state() == proto::JobStatus::SUCCEEDED) openAwaited();
    if (mayBeTriedAgain(job)) awaitedDataset_.clear();
}

void Viewer::say(const std::string& message) {
    server_.message = message;
}

void Viewer::sendView(const Area& area) {
    if (!server_.shown && (model_.hasDataset() || !model_.isLoaded()))
        return;  // nothing to show before the first dataset is known
    const bool resized = area.columns != sentColumns_ || area.rows != sentRows_;
    const bool released = sentMoving_ && !moving_;
    if (!dirty_ && !resized && !released) return;
    ViewRequest request;
    request.moving = moving_;
    film_.forgetAsked();  // this view takes the place of all others
    sentView_ = connection_.setView(model_.asked(area.columns, area.rows), request);
    sentMoving_ = moving_;
    sentColumns_ = area.columns;
    sentRows_ = area.rows;
    dirty_ = false;
}

void Viewer::takePicture() {
    while (auto frame = connection_.takeFrame()) {
        if (film_.takeFrame(*frame)) continue;
        if (frame->message.view_id() == sentView_ && server_.message == std::exchange(viewFailure_, {}))
            server_.message.clear();  // what failed is shown now
        texture_.upload(frame->pixels.bytes, frame->pixels.width, frame->pixels.height);
        picture_ = std::move(frame->pixels);
        server_.frame = std::move(frame->message);
    }
}

void Viewer::showPicture(const Area& area) const {
    if (texture_.empty()) return;
    ImGui::GetBackgroundDrawList()->AddImage(texture_.handle(), {0.0F, 0.0F}, {area.width, area.height});
}

void Viewer::refreshStatistics() {
    const auto statistics = connection_.statistics();
    server_.connected = connection_.state() == Connection::State::connected;
    server_.framesPerSecond = statistics.framesPerSecond;
    server_.roundTripMs = statistics.roundTripMs;
    server_.bytesPerSecond = statistics.bytesPerSecond;
    if (server_.connected) {
        const auto welcome = connection_.welcome();
        server_.connection = fmt::format("{}, {}", welcome.server(), welcome.device());
    } else if (const auto reason = connection_.lostReason()) {
        server_.connection = "Not connected: " + reason->toString();
    } else if (const auto broken = connection_.brokenBy()) {
        server_.connection = "Connecting again: " + broken->toString();
    } else {
        server_.connection = "Connecting ...";
    }
}

/// The exact picture of the latest view is on the screen.
bool Viewer::still() const {
    return server_.frame && server_.frame->final() && server_.frame->view_id() == sentView_ && !dirty_ &&
           !moving_;
}

/// And all that is shown beside it.
bool Viewer::finished() {
    const bool wanted = options_.screenshot || options_.saveView || options_.exitAfterStill;
    if (!still() || film_.waits() || !wanted) return false;
    keepResults();
    return options_.exitAfterStill;
}

/// What the command line wants of the first exact picture.
void Viewer::keepResults() {
    const auto keep = [this](const Status& status) {
        if (status.ok()) return;
        complain("mote-view", status.error().toString());
        exitStatus_ = 1;
    };
    if (const auto path = std::exchange(options_.screenshot, {})) {
        keep(writeScreenshot(*path, window_.readPixels(), window_.framebufferWidth(),
                             window_.framebufferHeight()));
    }
    if (const auto path = std::exchange(options_.saveView, {})) keep(saveView(*path, SameName::stays));
}

int Viewer::run() {
    bool done = false;
    while (!done && !window_.shouldClose()) {
        const bool active = moving_ || playback_.playing || (server_.frame && !server_.frame->final());
        window_.beginFrame(active ? activeSeconds : idleSeconds);
        connection_.poll();
        takePicture();
        refreshStatistics();
        takeKeys();
        const Area area = pictureArea();
        showPicture(area);
        takeInput(area);
        play();
        learnDatasets();
        if (panelShown_)
            apply(drawPanel(model_, playback_, numbers_, files_, server_, window_.contentScale()));
        editFilm(area);
        editNumbers(area);
        sendView(area);
        window_.drawFrame();
        done = finished();
        window_.presentFrame();
        const bool lost = options_.exitAfterStill && connection_.state() == Connection::State::lost;
        if (options_.exitAfterStill && (exitStatus_ != 0 || lost)) {
            const auto reason = connection_.lostReason();
            complain("mote-view", reason ? reason->toString() : server_.message);
            return 1;
        }
    }
    return exitStatus_;
}

}  // namespace mote::client
