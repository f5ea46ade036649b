// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>
#include <imgui.h>

#include <algorithm>
#include <cmath>
#include <exception>
#include <fstream>
#include <string>
#include <utility>

#include "client/shared/connection.h"
#include "client/view/camera_control.h"
#include "client/view/film_editor.h"
#include "client/view/options.h"
#include "client/view/panel.h"
#include "client/view/playback.h"
#include "client/view/screenshot.h"
#include "client/view/server_state.h"
#include "client/view/view_model.h"
#include "client/view/window.h"
#include "protocol/scene/json.h"

namespace mote::client {
namespace {

constexpr double idleSeconds =
    0.25;  // how long to sleep where nothing happens; input and frames wake at once
constexpr double activeSeconds = 0.005;  // between looks while a gesture or a refinement is under way

ConnectionSettings connectionSettings() {
    ConnectionSettings settings;
    settings.client = "mote-view " MOTE_VERSION;
    settings.wake = [] { Window::wake(); };
    return settings;
}

/// Ties window, model, panel and connection together: a frame loop that sends the latest view, shows the
/// newest picture and sleeps while nothing changes. Main thread.
class Viewer {
  public:
    /// Loads the saved view and the film if they were given. Throws WindowError.
    explicit Viewer(const ViewOptions& options);

    /// Errors of options.view and options.film; to be asked before run().
    const Status& loaded() const { return loaded_; }
    /// Runs until the window closes or, on request, the exact picture was shown. Returns the exit status.
    int run();

  private:
    struct Area {
        float width, height;          // screen coordinates
        std::uint32_t columns, rows;  // pixels of the view
    };

    void listen();
    void askServer();
    void openDataset(const std::string& name);
    /// Shows a view of a film, whatever its dataset.
    void showView(const proto::View& view);
    void describeShown();
    /// Opens the plot that a job of ours was to make, once the catalogue knows it.
    bool openAwaited();
    void plot(const AxisNames& axes);
    void replaceJob(const proto::JobStatus& job);
    void saveView();
    void say(const std::string& message);

    float filmHeight() const;
    Area pictureArea() const;
    void takeInput(const Area& area);
    void takeKeys();
    void apply(const PanelActions& actions);
    void sendView(const Area& area);
    void takePicture();
    void showPicture(const Area& area) const;
    void play();
    void editFilm(const Area& area);
    bool still() const;
    bool finished();
    void refreshStatistics();

    ViewOptions options_;
    Window window_;
    PictureTexture texture_;
    ViewModel model_;
    Playback playback_;
    ServerState server_;
    FilmEditor film_;
    FramePixels picture_;  // on the screen
    Status loaded_ = success();
    bool panelShown_ = true, filmShown_ = false;
    bool dirty_ = true;        // the model differs from what was sent
    bool moving_ = false;      // a gesture is under way
    bool sentMoving_ = false;  // the sent view was announced as moving
    std::uint32_t sentColumns_ = 0, sentRows_ = 0;
    std::uint64_t sentView_ = 0;  // id of the latest view
    std::string awaitedDataset_;  // a plot that a job of ours makes
    int exitStatus_ = 0;
    // Last: its destructor ends the callbacks into this object.
    Connection connection_;
};

Viewer::Viewer(const ViewOptions& options)
    : options_(options),
      window_(options.width, options.height, "Mote"),
      film_(connection_, [this](const proto::JobStatus& job) { replaceJob(job); }),
      connection_(options.connection, connectionSettings()) {
    if (options.view) {
        proto::View view;
        loaded_ = readJsonFile(*options.view, view);
        if (loaded_.ok()) loaded_ = model_.load(view);
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
        if (state == Connection::State::connected) askServer();
        if (state == Connection::State::lost && options_.exitAfterStill) exitStatus_ = 1;
    });
    connection_.onCatalogue([this](const proto::Catalogue& catalogue) {
        server_.catalogue = catalogue;
        film_.setCatalogue(catalogue);
        openAwaited();
    });
    connection_.onJob([this](const proto::JobStatus& job) { replaceJob(job); });
    connection_.onViewFailed([this](std::uint64_t view, const Error& error) {
        if (film_.takeFailure(view)) return;
        say(error.toString());
        if (options_.exitAfterStill) exitStatus_ = 1;
    });
}

void Viewer::askServer() {
    connection_.listDatasets([this](Result<proto::Catalogue> reply) {
        if (!reply.ok()) return say(reply.error().toString());
        server_.catalogue = *reply;
        film_.setCatalogue(*reply);
        if (model_.hasDataset()) return openDataset(model_.dataset());
        if (reply->datasets().empty()) return say("the server has no datasets yet");
        openDataset(reply->datasets(0).name());
    });
    connection_.watchJobs([this](Result<proto::Jobs> reply) {
        if (!reply.ok()) return say(reply.error().toString());
        server_.jobs.assign(reply->jobs().begin(), reply->jobs().end());
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
        server_.message.clear();
        model_.setDataset(name, server_.shown->manifest());
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
    } else {
        *known = job;
    }
    const bool ours = !awaitedDataset_.empty() && datasetName(job.request()) == awaitedDataset_;
    if (!ours) return;
    if (job.state() == proto::JobStatus::SUCCEEDED) openAwaited();
    if (job.state() == proto::JobStatus::FAILED || job.state() == proto::JobStatus::CANCELLED) {
        awaitedDataset_.clear();
    }
}

void Viewer::saveView() {
    const auto area = pictureArea();
    const std::string path = fmt::format("mote-view-{}.json", sentView_);
    std::ofstream file(path);
    file << toJson(model_.view(area.columns, area.rows));
    file.close();
    say(file ? "saved " + path : path + " cannot be written");
}

void Viewer::say(const std::string& message) {
    server_.message = message;
}

float Viewer::filmHeight() const {
    return panelShown_ && filmShown_ ? FilmPanel::height(window_.contentScale()) : 0.0F;
}

Viewer::Area Viewer::pictureArea() const {
    const ImVec2 display = ImGui::GetIO().DisplaySize;
    const ImVec2 density = ImGui::GetIO().DisplayFramebufferScale;
    const float panel = panelShown_ ? panelWidth * window_.contentScale() : 0.0F;
    const float width = std::max(display.x - panel, 1.0F), height = std::max(display.y - filmHeight(), 1.0F);
    return {width, height, static_cast<std::uint32_t>(std::max(width * density.x, 1.0F)),
            static_cast<std::uint32_t>(std::max(height * density.y, 1.0F))};
}

void Viewer::takeInput(const Area& area) {
    const ImGuiIO& io = ImGui::GetIO();
    const bool held = ImGui::IsMouseDown(ImGuiMouseButton_Left) ||
                      ImGui::IsMouseDown(ImGuiMouseButton_Right) ||
                      ImGui::IsMouseDown(ImGuiMouseButton_Middle);
    moving_ = held && !io.WantCaptureMouse;
    if (io.WantCaptureMouse) return;
    if (moving_ || io.MouseWheel != 0.0F) film_.stop();
    const double aspect = static_cast<double>(area.columns) / area.rows;
    const glm::dvec2 drag(io.MouseDelta.x / area.height, io.MouseDelta.y / area.height);
    const bool dragged = drag != glm::dvec2(0.0) && held;
    Camera camera = model_.camera(aspect);
    if (dragged && ImGui::IsMouseDown(ImGuiMouseButton_Left) && !io.KeyShift) {
        camera = orbit(camera, drag);
    } else if (dragged) {
        camera = pan(camera, drag);
    }
    if (io.MouseWheel != 0.0F)
        camera = io.KeyCtrl ? zoom(camera, io.MouseWheel) : dolly(camera, io.MouseWheel);
    if (!dragged && io.MouseWheel == 0.0F) return;
    model_.setCamera(camera);
    dirty_ = true;
}

void Viewer::takeKeys() {
    if (ImGui::GetIO().WantTextInput) return;
    const auto pressed = [](ImGuiKey key) { return ImGui::IsKeyPressed(ImGui::GetKeyIndex(key)); };
    const auto letter = [](char key) { return ImGui::IsKeyPressed(key); };  // GLFW's codes of letters
    const int step = static_cast<int>(model_.step());
    const int wanted = step + (pressed(ImGuiKey_RightArrow) ? 1 : 0) - (pressed(ImGuiKey_LeftArrow) ? 1 : 0);
    if (wanted != step && wanted >= 0 && wanted < model_.steps()) {
        model_.setStep(static_cast<std::uint32_t>(wanted));
        dirty_ = true;
    }
    if (pressed(ImGuiKey_Space)) playback_.playing = !playback_.playing;
    if (letter('F')) model_.fit();
    if (letter('O')) model_.setCamera(toggleProjection(model_.camera(1.0)));
    if (letter('F') || letter('O')) film_.stop();
    if (pressed(ImGuiKey_Tab)) panelShown_ = !panelShown_;
    if (letter('K')) filmShown_ = !filmShown_;
    dirty_ |= letter('F') || letter('O');
}

void Viewer::apply(const PanelActions& actions) {
    if (actions.viewChanged) film_.stop();
    dirty_ |= actions.viewChanged;
    moving_ |= actions.editing;
    if (actions.saveView) saveView();
    if (actions.toggleFilm) filmShown_ = !filmShown_;
    if (actions.reconnect) connection_.reconnect();
    if (actions.openDataset) openDataset(*actions.openDataset);
    if (actions.plot) plot(*actions.plot);
    for (const auto& job : server_.jobs) {
        if (job.id() != actions.saveFilm) continue;
        filmShown_ = true;  // it asks where to
        film_.askWhereToSave(job);
    }
    if (actions.cancelJob) {
        connection_.cancelJob(*actions.cancelJob, [this](Result<proto::JobStatus> reply) {
            if (!reply.ok()) say(reply.error().toString());
        });
    }
}

void Viewer::sendView(const Area& area) {
    if (!server_.shown) return;  // nothing to show before the first dataset is known
    const bool resized = area.columns != sentColumns_ || area.rows != sentRows_;
    const bool released = sentMoving_ && !moving_;
    if (!dirty_ && !resized && !released) return;
    ViewRequest request;
    request.moving = moving_;
    film_.forgetAsked();  // this view takes the place of all others
    sentView_ = connection_.setView(model_.view(area.columns, area.rows), request);
    sentMoving_ = moving_;
    sentColumns_ = area.columns;
    sentRows_ = area.rows;
    dirty_ = false;
}

void Viewer::takePicture() {
    while (auto frame = connection_.takeFrame()) {
        if (film_.takeFrame(*frame)) continue;
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
    } else {
        server_.connection = "Connecting ...";
    }
}

void Viewer::play() {
    if (!server_.shown) return;
    const bool seen = server_.frame && server_.frame->view_id() == sentView_;
    const auto step = playback_.next(ImGui::GetTime(), model_.step(), model_.steps(), seen);
    if (!step) return;
    model_.setStep(*step);
    dirty_ = true;
}

/// What a film's bar and its preview change of the view.
void Viewer::editFilm(const Area& area) {
    const double now = ImGui::GetTime();
    if (const auto view = film_.play(now)) showView(*view);
    if (panelShown_ && filmShown_) {
        const auto present = model_.view(area.columns, area.rows);
        const FilmSurroundings around{0.0F, area.height, area.width, window_.contentScale(),
                                      now,  present,     picture_,   server_};
        if (const auto view = film_.draw(around)) showView(*view);
    }
    moving_ |= film_.moving();
    if (still()) film_.askThumbnails();
}

/// The exact picture of the latest view is on the screen.
bool Viewer::still() const {
    return server_.frame && server_.frame->final() && server_.frame->view_id() == sentView_ && !dirty_ &&
           !moving_;
}

/// And all that is shown beside it.
bool Viewer::finished() {
    if (!still() || film_.waits() || !(options_.screenshot || options_.exitAfterStill)) return false;
    if (options_.screenshot) {
        const auto status = writeScreenshot(*options_.screenshot, window_.readPixels(),
                                            window_.framebufferWidth(), window_.framebufferHeight());
        if (!status.ok()) {
            fmt::print(stderr, "mote-view: {}\n", status.error().toString());
            exitStatus_ = 1;
        }
        options_.screenshot.reset();
    }
    return options_.exitAfterStill;
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
        takeInput(area);
        play();
        if (panelShown_) apply(drawPanel(model_, playback_, server_, window_.contentScale()));
        editFilm(area);
        sendView(area);
        showPicture(area);
        window_.drawFrame();
        done = finished();
        window_.presentFrame();
        const bool lost = options_.exitAfterStill && connection_.state() == Connection::State::lost;
        if (options_.exitAfterStill && (exitStatus_ != 0 || lost)) {
            const auto reason = connection_.lostReason();
            fmt::print(stderr, "mote-view: {}\n", reason ? reason->toString() : server_.message);
            return 1;
        }
    }
    return exitStatus_;
}

}  // namespace
}  // namespace mote::client

int main(int argc, char** argv) {
    using namespace mote::client;
    const auto parsed = parseViewOptions(argc, argv);
    if (const int* status = std::get_if<int>(&parsed)) return *status;
    try {
        Viewer viewer(std::get<ViewOptions>(parsed));
        if (!viewer.loaded().ok()) {
            fmt::print(stderr, "mote-view: {}\n", viewer.loaded().error().toString());
            return 1;
        }
        return viewer.run();
    } catch (const std::exception& error) {
        fmt::print(stderr, "mote-view: {}\n", error.what());
        return 1;
    }
}
