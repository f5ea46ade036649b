// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/view/viewer.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <imgui.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <glm/geometric.hpp>
#include <string_view>
#include <utility>

#include "client/shared/jobs.h"
#include "client/shared/numbers.h"
#include "client/view/camera_control.h"
#include "client/view/window.h"
#include "protocol/base/complain.h"
#include "protocol/quantity/plot_axes.h"

namespace mote::client {
namespace {

constexpr double activeSeconds = 0.005;  // between looks while a gesture or a refinement is under way
constexpr double idleSeconds = 0.25;     // while numbers of the line fall to rest, or a cursor blinks
constexpr double restSeconds = 2.5;      // from what came last to rest: rates are of two seconds
constexpr const char* panelWidthWish = "panel-width";
constexpr int settlingFrames = 3;  // that Dear ImGui takes to lay out what is new

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
      window_(options.window),
      browser_(options.connection, fileLineOf(connection_, [this](const auto& come) { learnLetters(come); })),
      film_(connection_, [this](const proto::JobStatus& job) { replaceJob(job); }),
      pictures_([this](proto::View view, const ViewRequest& request) {
          return connection_.setView(std::move(view), request);
      }),
      connection_(options.connection, connectionSettings(options)),
      panes_(
          connection_,
          [this] { return std::make_unique<Connection>(options_.connection, connectionSettings(options_)); }),
      numbers_(queryLine()),
      lens_(queryLine()) {
    if (options.view) {
        loaded_ = openView(*options.view);
        if (!note_.empty()) complain("mote-view", note_);
    }
    if (options.film && loaded_.ok()) {
        loaded_ = film_.open(*options.film);
        if (loaded_.ok() && !options.view) loaded_ = model().load(film_.film().keyframes().front().view);
        filmShown_ = true;
    }
    pane().subject = model().dataset();
    makeCommands();
    listen();
    interactive_ = !options_.exitAfterStill && !options_.screenshot && !options_.saveView;
    if (interactive_) beginSession();
    if (interactive_) readWishes();
    saver_.on = interactive_ && isMarked(savesData);
    if (loaded_.ok() && !filmShown_) askAhead();
    if (!window_) window_ = std::make_shared<Window>(options_.width, options_.height, "Mote");
    window_->setLight(isMarked(lightWindow));
    window_->useDevices(!isMarked(noDevices));
    learnLetters(server_.catalogue);
    for (std::size_t i = 0; i < panes_.size(); ++i) {
        learnLetters(panes_[i].model.edited());
        if (panes_[i].shown) learnLetters(*panes_[i].shown);
    }
    if (offered_) window_->letters().learn(offered_->subject);
    settling_ = settlingFrames;
}

QueryLine Viewer::queryLine() {
    return {[this](const proto::Query& query, QueryLine::Reply reply) {
                return connection_.query(query, std::move(reply));
            },
            [this](std::uint64_t query) { connection_.cancelQuery(query); }};
}

void Viewer::beginSession() {
    auto what = options_.target.value_or(options_.connection);
    if (!options_.spawn.empty() && !options_.target) what = fmt::format("{}", fmt::join(options_.spawn, " "));
    const auto key = sessionKey(what);
    offered_ = lastSession(sessionFolder(), key);
    desk_.keepIn(sessionFolder(), key);
    const auto cameras = shelf_.keepIn(sessionFolder() / (key + ".cameras"));
    if (!cameras.ok()) say("Cameras are not kept: " + cameras.error().toString());
}

void Viewer::listen() {
    connection_.onState([this](Connection::State state) {
        film_.forgetAsked();
        if (state != Connection::State::connecting) forgetNumbers();
        if (state == Connection::State::connected) askServer();
        if (state == Connection::State::lost && options_.exitAfterStill) exitStatus_ = 1;
    });
    connection_.onCatalogue([this](const proto::Catalogue& catalogue) {
        takeCatalogue(catalogue);
        forgetNumbers();
        noteAwaited();
        for (std::size_t i = 0; i < panes_.size(); ++i) learnSteps(panes_[i]);
    });
    connection_.onJob([this](const proto::JobStatus& job) { replaceJob(job); });
    connection_.onViewFailed([this](std::uint64_t view, const Error& error) {
        if (film_.takeFailure(view)) return;
        if (pictures_.takeFailure(view)) return say("There is no picture to be kept: " + error.toString());
        if (panes_[0].hears(view)) panes_[0].failure = error.toString();
        said_ = error.toString();
        if (options_.exitAfterStill) exitStatus_ = 1;
    });
}

/// A server that is near has answered before a window could open: it draws meanwhile.
void Viewer::askAhead() {
    using Clock = std::chrono::steady_clock;
    constexpr std::chrono::milliseconds patience{100};  // a server that is far is not waited for
    const auto until = Clock::now() + patience;
    const glm::vec2 size(options_.width, options_.height);
    while (!panes_[0].isAsked()) {
        connection_.poll();
        // On another display its pixels are others: it is asked for again then.
        sendViews(window_ ? pictureArea() : areaWithin(size, glm::vec2(1.0F), 1.0F));
        const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(until - Clock::now());
        const bool lost = connection_.state() == Connection::State::lost;
        if (panes_[0].isAsked() || lost || left.count() <= 0) return;
        connection_.wait(left);
    }
}

/// Before there is a window nothing is drawn: what was taken until then is learned when it opens.
void Viewer::learnLetters(const google::protobuf::Message& of) {
    if (window_) window_->letters().learn(of);
}

void Viewer::takeCatalogue(const proto::Catalogue& catalogue) {
    learnLetters(catalogue);
    server_.catalogue = catalogue;
    film_.setCatalogue(catalogue);
    browser_.setCatalogue(catalogue);
}

void Viewer::askServer() {
    connection_.listDatasets([this](Result<proto::Catalogue> reply) {
        if (!reply.ok()) return say(reply.error().toString());
        takeCatalogue(*reply);
        offerSession();
        for (std::size_t i = 0; i < panes_.size(); ++i) learnAnew(panes_[i]);
        if (model().hasDataset()) return;
        if (model().isLoaded()) return;  // a view without layers
        if (!options_.dataset.empty()) return openDataset(options_.dataset);
        if (reply->datasets().empty()) {
            said_ = "the server has no datasets yet";
            return notes_.add({said_, {{"Prepare a file...", [this] { browser_.openFiles(); }}}});
        }
        openDataset(reply->datasets(0).name());
    });
    connection_.watchJobs([this](Result<proto::Jobs> reply) {
        if (!reply.ok()) return say(reply.error().toString());
        learnLetters(*reply);
        server_.jobs.assign(reply->jobs().begin(), reply->jobs().end());
        server_.allJobs = reply->total();
        jobsPaged_ = 0;
    });
}

void Viewer::learnAnew(const Pane& of) {
    if (!of.model.hasDataset()) return;
    withDescription(of.model.dataset(), [this, id = of.id](const proto::Description& description) {
        say(std::exchange(note_, {}));
        auto* pane = panes_.find(id);
        if (pane == nullptr || description.dataset() != pane->model.dataset()) return;
        pane->model.setDataset(description.dataset(), description.manifest());
        pane->shown = std::make_shared<const proto::Description>(description);
        pane->dirty = true;
    });
}

void Viewer::noteAwaited() {
    const auto& known = server_.catalogue.datasets();
    const auto isAwaited = [this](const auto& entry) { return entry.name() == awaitedDataset_; };
    if (awaitedDataset_.empty() || std::none_of(known.begin(), known.end(), isAwaited)) return;
    const auto name = std::exchange(awaitedDataset_, {});
    notes_.add({name + " is made.", {{"Open it", [this, name] { openDataset(name); }}}});
}

/// Without the panel, which lists all, whatever is under way is said.
void Viewer::drawAwaited(const PictureArea& area) {
    for (const auto& job : server_.jobs) {
        const bool ours = !awaitedDataset_.empty() && datasetName(job.request()) == awaitedDataset_;
        if ((panelShown_ && !ours) || !isUnderWay(job)) continue;
        const bool waits = job.state() == proto::JobStatus::QUEUED;
        PanelActions actions;
        if (drawMaking(area, fmt::format("Making {}", jobName(job.request())), job.progress(),
                       waits ? "waits for its turn" : job.phase()))
            actions.cancelJob = job.id();
        return apply(actions);
    }
}

/// A live dataset has more steps than before.
void Viewer::learnSteps(const Pane& of) {
    const auto* entry = findEntry(of.model.dataset());
    const auto steps = static_cast<std::uint32_t>(of.model.steps());
    if (entry == nullptr || !of.model.isDescribed() || entry->steps() == steps) return;
    withDescription(entry->name(), [this, id = of.id](const proto::Description& description) {
        auto* pane = panes_.find(id);
        if (pane == nullptr || description.dataset() != pane->model.dataset()) return;
        pane->shown = std::make_shared<const proto::Description>(description);
        pane->model.describe(description.manifest());
        pane->dirty = true;
    });
}

void Viewer::withDescription(const std::string& name, std::function<void(const proto::Description&)> take) {
    connection_.describe(name, [this, take = std::move(take)](Result<proto::Description> reply) {
        if (reply.ok()) {
            learnLetters(*reply);
            film_.setDescription(*reply);
            return take(*reply);
        }
        if (options_.exitAfterStill) exitStatus_ = 1;
        say(reply.error().toString());
    });
}

void Viewer::openDataset(const std::string& name) {
    if (name == pane().subject && name == model().dataset()) return;
    if (const auto* kept = desk_.kept(name)) {
        const proto::View view = *kept;
        pane().subject = name;
        return showView(pane(), view, false);
    }
    setDataset(name, true);
}

void Viewer::setDataset(const std::string& name, bool alone) {
    withDescription(name, [this, name, alone, id = pane().id](const proto::Description& description) {
        auto* in = panes_.find(id);
        if (in == nullptr) return;
        auto& model = in->model;
        if (alone) {
            model.keepOnlyChosen();
            in->subject = name;
        }
        const bool first = !in->shown && !model.isLoaded();
        in->shown = std::make_shared<const proto::Description>(description);
        const auto step = model.step();
        model.setDataset(name, description.manifest());
        if (first) model.annotateAsUsual();
        say(std::exchange(note_, {}));
        if (model.step() != step)
            say(fmt::format("{} has no step {}: step {} is shown", name, step, model.step()));
        in->dirty = true;
    });
}

void Viewer::addDataset(const std::string& name) {
    withDescription(name, [this, name, id = pane().id](const proto::Description& description) {
        auto* in = panes_.find(id);
        if (in == nullptr) return;
        in->model.addLayer(name, description.manifest());
        in->dirty = true;
    });
}

void Viewer::showView(Pane& in, const proto::View& view, bool fromFile) {
    const auto loaded = in.model.load(view, fromFile);
    if (!loaded.ok()) return say(loaded.error().toString());
    in.dirty = true;
    describeShown(in);
}

/// Where the datasets of further layers lie, which the camera is fitted to.
void Viewer::learnDatasets() {
    for (std::size_t i = 0; i < panes_.size(); ++i) {
        auto& model = panes_[i].model;
        for (const auto& name : model.unknownDatasets()) {
            if (name == model.dataset()) continue;
            if (const auto* described = film_.description(name)) model.know(name, described->manifest());
        }
    }
}

/// What the panel says of the dataset of the chosen layer, once it is known.
void Viewer::describeShown(Pane& of) {
    auto& model = of.model;
    if (model.isDescribed() || !model.hasDataset()) return;
    const auto* description = film_.description(model.dataset());
    if (of.shown && of.shown->dataset() != model.dataset()) of.shown.reset();
    if (description == nullptr) return;
    of.shown = std::make_shared<const proto::Description>(*description);
    model.describe(description->manifest());
    of.dirty = true;
}

void Viewer::plot(const AxisNames& axes) {
    const auto request = replotRequest(*pane().shown, axes);
    if (!request) return say("the run of this plot is not within the server's reach");
    const auto name = datasetName(*request);
    const auto& known = server_.catalogue.datasets();
    if (std::ranges::any_of(known, [&](const auto& entry) { return entry.name() == name; }))
        return openDataset(name);
    make(*request);
}

void Viewer::make(const proto::JobRequest& request) {
    awaitedDataset_ = datasetName(request);
    connection_.submitJob(request, [this](Result<proto::JobStatus> reply) {
        if (reply.ok()) return replaceJob(*reply);
        awaitedDataset_.clear();
        say(reply.error().toString());
    });
}

void Viewer::replaceJob(const proto::JobStatus& job) {
    learnLetters(job);
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
    if (job.state() == proto::JobStatus::SUCCEEDED) noteAwaited();
    if (!mayBeTriedAgain(job)) return;
    const bool cancelled = job.state() == proto::JobStatus::CANCELLED && job.error().empty();
    say(cancelled ? fmt::format("{} was cancelled.", awaitedDataset_)
                  : fmt::format("{} was not made: {}", awaitedDataset_, job.error()));
    awaitedDataset_.clear();
}

void Viewer::say(const std::string& message) {
    if (message.empty()) return;
    said_ = message;
    if (window_) window_->letters().learn(message);
    notes_.add({message});
}

const proto::Catalogue::Entry* Viewer::findEntry(const std::string& dataset) const {
    const auto& known = server_.catalogue.datasets();
    const auto found = std::ranges::find_if(known, [&](const auto& each) { return each.name() == dataset; });
    return found != known.end() ? &*found : nullptr;
}

/// What the server has is shown, though it has not all; what is missing is said.
void Viewer::leaveOutMissing(proto::View& view) const {
    const auto isMissing = [this](const proto::Layer& layer) {
        return findEntry(layer.dataset()) == nullptr;
    };
    auto& layers = *view.mutable_layers();
    if (std::ranges::all_of(layers, isMissing)) return;
    for (int i = layers.size(); i-- > 0;) {
        if (isMissing(layers[i])) layers.DeleteSubrange(i, 1);
    }
}

void Viewer::sendView(std::size_t index, const PictureArea& area) {
    auto& of = panes_[index];
    const auto& model = of.model;
    const bool missing = interactive_ && model.hasDataset() && !server_.catalogue.datasets().empty() &&
                         findEntry(model.dataset()) == nullptr;
    if (!of.shown && !missing && (model.hasDataset() || !model.isLoaded()))
        return;  // nothing to show before the first dataset is known
    const auto asked = saver_.asked(area);
    const double now = window_ ? ImGui::GetTime() : 0.0;
    if (!of.needs(asked, moving_) || saver_.waits(now, moving_)) return;
    saver_.note(now);
    if (index == 0) film_.forgetAsked();  // this view takes the place of all others of its line
    auto view = model.asked(asked.columns, asked.rows);
    saver_.scale(view);
    if (interactive_) leaveOutMissing(view);
    if (panes_.size() > 1 && view.has_annotations()) keepLettersReadable(view, area);
    of.ask(panes_.line(index), std::move(view), asked, moving_);
}

void Viewer::sendViews(const PictureArea& whole) {
    for (std::size_t i = 0; i < panes_.size(); ++i) sendView(i, paneArea(whole, i, panes_.size()));
}

void Viewer::takePictures() {
    while (auto frame = connection_.takeFrame()) {
        if (film_.takeFrame(*frame)) continue;
        if (const auto said = pictures_.take(*frame)) {
            say(*said);
        } else {
            panes_[0].take(*std::move(frame));
        }
    }
    for (std::size_t i = 1; i < panes_.size(); ++i) {
        while (auto frame = panes_.line(i).takeFrame()) panes_[i].take(*std::move(frame));
    }
}

void Viewer::showPictures(const PictureArea& whole) const {
    for (std::size_t i = 0; i < panes_.size(); ++i) panes_[i].drawPicture(paneArea(whole, i, panes_.size()));
}

/// Not while the mouse holds something of a pane's.
void Viewer::setPanes(std::size_t count) {
    if (ImGui::IsAnyMouseDown()) return;
    if (!pane().shown && !model().isLoaded())
        return say("Nothing is shown yet that a view could begin with.");
    film_.stop();
    panes_.setCount(count);
}

void Viewer::activate(std::size_t index) {
    if (index == panes_.activeIndex() || index >= panes_.size()) return;
    film_.stop();
    panes_.activate(index);
}

void Viewer::setLinks(const Links& links) {
    panes_.setLinks(links);
}

void Viewer::refreshStatistics() {
    const auto statistics = panes_.line(panes_.activeIndex()).statistics();
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

/// What the panel shows of the active pane.
void Viewer::refreshShown() {
    server_.shown = pane().shown;
    server_.frame = pane().frame;
    if (std::exchange(title_, model().dataset()) != model().dataset())
        window_->setTitle(fmt::format("{} - Mote", model().dataset()));
}

bool Viewer::still() const {
    for (std::size_t i = 0; i < panes_.size(); ++i) {
        if (!panes_[i].isStill()) return false;
    }
    return !moving_;
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
        keep(writeScreenshot(*path, window_->readPixels(), window_->framebufferWidth(),
                             window_->framebufferHeight()));
    }
    if (const auto path = std::exchange(options_.saveView, {})) keep(saveView(*path, SameName::stays));
}

/// How long to sleep where nothing comes; without end at rest.
std::optional<double> Viewer::patience() const {
    bool refining = false;
    for (std::size_t i = 0; i < panes_.size() && server_.connected; ++i)
        refining |= panes_[i].frame && !panes_[i].frame->final();
    if (moving_ || playback_.playing || film_.moving() || refining || settling_ > 0) return activeSeconds;
    const bool awake = ImGui::GetIO().WantTextInput || desk_.isStale() || ImGui::GetTime() < restFrom_;
    return awake || options_.exitAfterStill ? std::optional(idleSeconds) : std::nullopt;
}

// Flying, gamepads and 3D mice, and the brush.
namespace {

constexpr std::string_view steeringKeys = "WASDQE";
constexpr double longestMoment = 0.1, firstMoment = 0.016;  // seconds that a frame counts for
constexpr double pauseOfHand = 0.5;                         // seconds after which another gesture begins
constexpr double flightTurn = 1.2;                          // radians a second

}  // namespace

/// Only a camera in perspective comes nearer to anything.
void Viewer::setFlying(bool flying) {
    if (std::exchange(flying_, flying) == flying || !flying) return;
    ++gesture_;
    steered_ = 0.0;
    const auto camera = model().camera(activeArea().aspect());
    if (!camera.perspective()) setCamera(toggleProjection(camera));
}

/// It is the flight's while one is under way, and no command.
bool Viewer::isSteeringKey(const PressedKey& key) const {
    const std::string_view chord = key.chord;
    const auto letter = chord.starts_with("Shift+") ? chord.substr(6) : chord;
    return flying_ && letter.size() == 1 && steeringKeys.find(letter) != steeringKeys.npos;
}

Push Viewer::pushedKeys() const {
    const auto& io = ImGui::GetIO();
    if (!flying_ || io.WantTextInput || io.KeyCtrl || palette_.isOpen()) return {};
    const auto held = [&](char more, char less) {
        return static_cast<double>(window_->isHeld(more)) - static_cast<double>(window_->isHeld(less));
    };
    return {{held('D', 'A'), held('E', 'Q'), held('W', 'S')}, {}};
}

/// How far it is flown in a second: by how far that is which lies ahead, but never nearly nothing.
double Viewer::flightWay(const PictureArea& area) const {
    constexpr double leastShare = 0.02;  // of all that is shown
    constexpr double faster = 4.0;       // with Shift
    const auto camera = model().camera(area.aspect());
    const auto box = model().worldBounds();
    const auto ahead = box ? placeWithin(camera, area.aspect(), {0.5, 0.5}, *box) : std::nullopt;
    const double least = leastShare * (box ? glm::length(box->size()) : 1.0);
    const double away = glm::distance(camera.eye, ahead.value_or(camera.target));
    return flightSpeed_.share() * std::max(away, least) * (ImGui::GetIO().KeyShift ? faster : 1.0);
}

void Viewer::steer(const PictureArea& area) {
    const auto devices = window_->devices();
    for (std::size_t i = 0; i < devices.pads.size(); ++i) {
        const Pad before = i < padsBefore_.size() ? padsBefore_[i] : devices.pads[i];
        for (const auto command : commandsOf(before, devices.pads[i])) {
            ++gesture_;
            run(std::string(command).c_str());
        }
    }
    padsBefore_ = devices.pads;
    auto push = devices.push(flying_);
    push += pushedKeys();
    if (push.atRest() || (!pane().shown && !model().isLoaded())) return;
    const double now = ImGui::GetTime(), since = now - std::exchange(steered_, now);
    if (!flying_ && since > pauseOfHand) ++gesture_;
    const double moment = since > pauseOfHand ? firstMoment : std::min(since, longestMoment);
    const auto camera = model().camera(area.aspect());
    setCamera(flying_ ? flown(camera, push, flightWay(area) * moment, flightTurn * moment)
                      : carried(camera, push, moment));
    moving_ = true;
}

/// In place of turn() while it is flown.
void Viewer::lookAround(const PictureArea& area, bool held) {
    const auto& io = ImGui::GetIO();
    if (io.MouseWheel != 0.0F) flightSpeed_.change(static_cast<double>(io.MouseWheel));
    const glm::dvec2 drag(io.MouseDelta.x / area.height, io.MouseDelta.y / area.height);
    if (held && drag != glm::dvec2(0.0)) setCamera(lookedAround(model().camera(area.aspect()), drag));
}

void Viewer::drawFlight(const PictureArea& area) const {
    if (!flying_) return;
    drawSign(area,
             fmt::format("Flying: W A S D, Q down, E up, Shift faster, drag to look; wheel: {:.2g} of the "
                         "way a second (Esc ends)",
                         flightSpeed_.share()));
}

void Viewer::useDevices(bool used) {
    window_->useDevices(used);
    mark(noDevices, !used);
    say(used ? "Gamepads and 3D mice are used." : "Gamepads and 3D mice are not used.");
}

void Viewer::saveData(bool saved) {
    saver_.on = saved;
    mark(savesData, saved);
    for (std::size_t i = 0; i < panes_.size(); ++i) panes_[i].dirty = true;
}

void Viewer::drawSaver(const PictureArea& whole) {
    std::uint64_t bytes = 0;
    for (std::size_t i = 0; i < panes_.size(); ++i) bytes += panes_.line(i).statistics().bytes;
    if (saver_.on) drawFootnote(whole, saver_.said(activeArea(), bytes));
}

void Viewer::forgetNumbers() {
    numbers_.forget();
    lens_.forget();
}

void Viewer::endTools() {
    numbers_.tool().setKind(PictureTool::Kind::none);
    handles_.brush.on = false;
    lens_.turn(false);
}

void Viewer::lightDensities(const PictureArea& area) {
    const auto* manifest = shownManifest();
    const bool known =
        manifest != nullptr && static_cast<int>(model().step()) < manifest->particles().steps_size();
    const int bins =
        known ? manifest->particles().steps(static_cast<int>(model().step())).density_histogram_size() : 0;
    lens_.ask(model(), area, static_cast<std::uint32_t>(bins), moving_);
    lens_.draw(area);
    server_.litDensities = lens_.lit();
}

void Viewer::toggleBrush() {
    auto& brush = handles_.brush;
    if (!brush.on && model().kind() != proto::Layer::kInk)
        return say("A brush paints layers that are drawn in ink, as \"Layers\" says below a dataset's name.");
    brush.on = !brush.on;
}

bool Viewer::takeBrushKey(const PressedKey& key) {
    auto& brush = handles_.brush;
    if (!brush.on || (key.chord != "[" && key.chord != "]")) return false;
    brush.resize(key.chord == "]" ? 1.0 : -1.0);
    return true;
}

void Viewer::askForBrush() {
    auto& brush = handles_.brush;
    for (auto& question : brush.takeQuestions()) {
        connection_.query(question.query, [&brush, id = question.id](const Result<QueryAnswer>& answer) {
            brush.hear(id, answer.ok() ? Result<proto::Answer>(answer->message) : answer.error());
        });
    }
    say(brush.takeRefusal());
}

void Viewer::readWishes() {
    const auto line = keptWish(panelWidthWish);
    const float width = std::strtof(line.c_str(), nullptr);
    if (width >= leastPanelWidth && width <= static_cast<float>(View::maxSide))
        panelWidth_ = keptPanelWidth_ = width;
    timeBar_.scale = keptWish(timeScaleWish);
}

/// It is kept once it is let go.
void Viewer::takePanelWidth(const PanelActions& actions) {
    if (actions.panelWidth) panelWidth_ = *actions.panelWidth;
    if (ImGui::IsAnyMouseDown() || panelWidth_ == keptPanelWidth_) return;
    keptPanelWidth_ = panelWidth_;
    keepWish(panelWidthWish, fmt::format("{}", panelWidth_));
}

void Viewer::fitTo(Pane& in, const Bounds& box) {
    const double aspect = activeArea().aspect();
    const auto before = in.model.camera(aspect);
    const auto fitted = fitCamera(box, aspect, {before.eye - before.target, before.up});
    film_.stop();
    in.model.setCamera(fitAlong(before, fitted));
    in.dirty = true;
}

/// Asks where the selection's particles lie in this step: a lasso or an expression does not say.
void Viewer::fitSelection() {
    const auto selection = model().numbers.chosenWhole();
    const auto* manifest = shownManifest();
    if (model().kind() != proto::Layer::kParticles || !selection || manifest == nullptr)
        return say("No selection of particles is chosen; L draws a line around some.");
    const auto query = endsOf(model().dataset(), manifest->particles(), model().step(), *selection);
    connection_.query(query, [this, id = pane().id, query](const Result<QueryAnswer>& answer) {
        const auto ends = answer.ok() ? statisticsOf(*answer) : answer.error();
        if (!ends.ok()) return say(ends.error().toString());
        auto* in = panes_.find(id);
        if (in == nullptr || !in->shown || in->model.dataset() != query.dataset()) return;
        const auto box = boxOf(*ends, in->shown->manifest().particles());
        if (!box) return say("The selection has no particle within the plot in this step.");
        fitTo(*in, box->transformed(in->model.layerToWorld()));
    });
}

void Viewer::takeCameraWish(const CameraWish& wish) {
    const auto cameras = shelf_.of(pane().subject);
    ++gesture_;
    if (wish.what != CameraWish::What::go) {
        const auto kept = shelf_.apply(pane().subject, wish, model().camera(activeArea().aspect()));
        if (!kept.ok()) say(kept.error().toString());
    } else if (wish.index < cameras.size()) {
        film_.stop();
        glide_.begin(model().camera(activeArea().aspect()), cameras[wish.index].camera, ImGui::GetTime());
        model().setCamera(model().camera(activeArea().aspect()));
    }
}

void Viewer::makeCameraCommands() {
    std::vector<std::string> names;
    for (const auto& camera : shelf_.of(pane().subject)) names.push_back(camera.name);
    if (std::exchange(cameraCommands_, names) == names) return;
    constexpr const char* group = "Named camera";
    std::erase_if(commands_,
                  [&](const Command& command) { return std::string_view(command.group) == group; });
    for (const auto& name : names) window_->letters().learn(name);
    for (std::size_t i = 0; i < names.size(); ++i)
        commands_.push_back({group, names[i], i < 9 ? fmt::format("{}", i + 1) : "", [this, i] {
                                 takeCameraWish({CameraWish::What::go, i});
                             }});
}

/// A short way to a camera that was asked for.
void Viewer::glide() {
    const auto camera = glide_.next(ImGui::GetTime(), model().camera(activeArea().aspect()));
    if (!camera) return;
    model().setCamera(*camera);
    pane().dirty = true;
    moving_ |= glide_.underWay();
}

void Viewer::hearServer() {
    connection_.poll();
    panes_.pollFurther();
    for (std::size_t i = 0; i < panes_.size(); ++i) describeShown(panes_[i]);
    takePictures();
    refreshStatistics();
}

/// A frame of the window, from the pictures on.
void Viewer::drawAll(const PictureArea& whole) {
    showPictures(whole);
    takePress(whole);
    takeInput(activeArea());
    steer(activeArea());
    glide();
    makeCameraCommands();
    drawFlight(activeArea());
    lightDensities(activeArea());
    play();
    learnDatasets();
    refreshShown();
    const PanesShown shown{panes_.size(), panes_.links(), shelf_.of(pane().subject)};
    server_.savesData = saver_.on;
    if (panelShown_) {
        const auto actions =
            drawPanel(model(), numbers_, handles_, server_, shown, window_->contentScale(), panelWidth_);
        apply(actions);
        takePanelWidth(actions);
    }
    drawTime(whole);
    editFilm(whole);
    editNumbers(activeArea());
    drawOver(whole);
    lookAtDesk();
    sendViews(whole);
}

int Viewer::run() {
    bool done = false;
    while (!done && !mayClose()) {
        if (window_->beginFrame(patience())) {
            settling_ = settlingFrames;
            restFrom_ = ImGui::GetTime() + restSeconds;
        } else {
            settling_ -= settling_ > 0 ? 1 : 0;
        }
        countGestures();
        hearServer();
        takeKeys();
        drawAll(pictureArea());
        window_->drawFrame();
        done = finished();
        keepWindow();
        window_->presentFrame();
        keepSession();
        const bool lost = options_.exitAfterStill && connection_.state() == Connection::State::lost;
        if (options_.exitAfterStill && (exitStatus_ != 0 || lost)) {
            const auto reason = connection_.lostReason();
            complain("mote-view", reason ? reason->toString() : said_);
            return 1;
        }
    }
    return exitStatus_;
}

}  // namespace mote::client
