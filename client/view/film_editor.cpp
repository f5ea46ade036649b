// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/view/film_editor.h"

#include <fmt/format.h>

#include <algorithm>
#include <span>
#include <utility>

#include "client/shared/jobs.h"
#include "client/shared/part_file.h"
#include "client/shared/script.h"

namespace mote::client {
namespace {

/// Large enough that points look as in a whole picture, small enough that it is drawn at once.
FilmSize askedSize(FilmSize film) {
    const auto [width, height] = thumbnailSize(film);
    return {2 * width, 2 * height};
}

}  // namespace

FilmEditor::FilmEditor(Connection& connection, std::function<void(const proto::JobStatus&)> heard)
    : connection_(connection), heard_(std::move(heard)) {}

Status FilmEditor::open(const std::filesystem::path& script) {
    MOTE_ASSIGN_OR_RETURN(const auto read, readScript(script));
    auto model = FilmModel::fromScript(read);
    if (!model.ok()) {
        const auto& error = model.error();
        return Error{error.code, fmt::format("{}: {}", script.string(), error.where), error.message};
    }
    thumbnails_ = FilmThumbnails();
    forgetAsked();
    failed_.clear();
    restore(*model);
    saved_ = model_.revision();
    return success();
}

void FilmEditor::restore(const FilmModel& film) {
    model_ = film;
    preview_.stop();
    filmRevision_.reset();
}

std::optional<proto::View> FilmEditor::draw(const FilmSurroundings& around) {
    refreshFilm();
    const auto handles = [this](std::uint64_t picture) { return thumbnails_.handle(picture); };
    const auto actions = panel_.draw(model_, preview_, stateOf(around), handles, around.left, around.top,
                                     around.width, around.scale);
    thumbnails_.keepOnly(model_);
    held_ = actions.editing;
    return obey(actions, around);
}

FilmState FilmEditor::stateOf(const FilmSurroundings& around) const {
    FilmState state;
    state.message = message_;
    state.failure = failure_;
    state.connected = around.server.connected;
    state.shown = !around.picture.bytes.empty() && around.server.shown != nullptr;
    if (download_) {
        state.saving = true;
        state.saved = download_->progress().value_or(0.0);
        state.savedWhat =
            download_->progress() ? "fetching" : fmt::format("{} pictures", download_->filesDone());
    }
    const auto& jobs = around.server.jobs;
    const auto job = std::find_if(jobs.begin(), jobs.end(), [&](const auto& j) { return j.id() == job_; });
    if (job == jobs.end()) return state;
    state.job = &*job;
    if (job->state() == proto::JobStatus::FAILED && state.message.empty())
        state.message = fmt::format("the film was not made: {}", job->error());
    return state;
}

std::optional<proto::View> FilmEditor::obey(const FilmActions& actions, const FilmSurroundings& around) {
    if (!actions.failure.empty()) message_ = actions.failure;
    if (actions.addKeyframe) keep(model_.add(around.present), around);
    if (actions.replaceKeyframe) keep(model_.replace(around.present), around);
    if (actions.togglePreview) togglePreview(around.now);
    if (actions.makeFilm) makeFilm(*actions.makeFilm);
    const FilmState state = stateOf(around);
    if (actions.saveFilm && state.job != nullptr) askWhereToSave(*state.job);
    if (actions.cancelJob) {
        connection_.cancelJob(job_, [this](const Result<proto::JobStatus>& reply) {
            if (!reply.ok()) message_ = reply.error().toString();
        });
    }
    if (actions.retryJob) {
        message_.clear();
        connection_.retryJob(job_, takeJob());
    }
    if (actions.stopSaving) download_.reset();
    takePaths(actions);
    if (actions.openScript && openTyped(*actions.openScript)) return model_.keyframes().front().view;
    if (!actions.selected && !actions.scrubbed) return std::nullopt;
    preview_.stop();
    if (actions.selected) return model_.keyframes()[*model_.selected()].view;
    return viewAtPlayhead();
}

/// The picture on the screen is the new view's thumbnail.
void FilmEditor::keep(const Status& edit, const FilmSurroundings& around) {
    say(edit);
    if (edit.ok())
        thumbnails_.put(model_.keyframes()[*model_.selected()].picture, around.picture, model_.size());
}

std::optional<proto::View> FilmEditor::viewAtPlayhead() {
    refreshFilm();
    if (film_) return film_->at(model_.playhead());
    if (model_.keyframes().size() == 1) return model_.keyframes().front().view;
    return std::nullopt;
}

void FilmEditor::togglePreview(double now) {
    if (preview_.playing()) return preview_.stop();
    preview_.start(now, model_.playhead(), model_.begin(), model_.end());
}

std::optional<proto::View> FilmEditor::play(double now) {
    if (!preview_.playing()) return std::nullopt;
    refreshFilm();
    if (!film_) preview_.stop();
    const auto due = preview_.next(now, model_.begin(), model_.end(), model_.fps());
    if (!due) return std::nullopt;
    model_.setPlayhead(*due);
    return film_->at(*due);
}

void FilmEditor::takePaths(const FilmActions& actions) {
    const auto answer = [](PathPrompt& prompt, const Status& status) {
        status.ok() ? prompt.close() : prompt.fail(status.error().toString());
    };
    if (actions.saveScript) {
        const bool agreed = panel_.savingScript.agreed(*actions.saveScript);
        const auto saved =
            saveJson(*actions.saveScript, model_.saved(), agreed ? SameName::isReplaced : SameName::stays);
        answer(panel_.savingScript, saved);
        if (saved.ok()) message_ = "saved " + actions.saveScript->string();
        if (saved.ok()) saved_ = model_.revision();
    }
    if (actions.saveFilmTo) saveFilm(*actions.saveFilmTo);
}

bool FilmEditor::openTyped(const std::filesystem::path& script) {
    const auto opened = open(script);
    if (!opened.ok()) {
        panel_.opening.fail(opened.error().toString());
        return false;
    }
    panel_.opening.close();
    message_.clear();
    return true;
}

void FilmEditor::makeFilm(const FilmKind& kind) {
    message_.clear();
    auto request = filmRequest(model_.toScript(), std::string(kind.video));
    request.mutable_film()->set_chroma(std::string(kind.chroma));
    connection_.submitJob(request, takeJob());
}

Connection::Reply<proto::JobStatus> FilmEditor::takeJob() {
    return [this](const Result<proto::JobStatus>& reply) {
        if (!reply.ok()) return say(reply.error());
        job_ = reply->id();
        heard_(*reply);
    };
}

void FilmEditor::askWhereToSave(const proto::JobStatus& job) {
    savedJob_ = job;
    const auto& video = job.request().film().video();
    panel_.savingFilm.open(video.empty() ? "pictures" : "film." + video);
}

void FilmEditor::saveFilm(const std::filesystem::path& path) {
    auto download = FilmDownload::begin(savedJob_, path);
    if (!download.ok()) return panel_.savingFilm.fail(download.error().toString());
    panel_.savingFilm.close();
    message_.clear();
    download_ = *std::move(download);
    savedPath_ = path;
    ++downloads_;
    fetchNext();
}

void FilmEditor::fetchNext() {
    connection_.fetchFilm(download_->wanted(), [this, mine = downloads_](const Result<FilmBytes>& piece) {
        if (!download_ || mine != downloads_) return;  // it was given up
        const auto taken = download_->take(piece);
        if (taken.ok() && !download_->done()) return fetchNext();
        download_.reset();
        say(taken);
        if (taken.ok()) message_ = "saved " + savedPath_.string();
    });
}

void FilmEditor::setCatalogue(const proto::Catalogue& catalogue) {
    catalogue_ = knownDatasets(catalogue);
    known_ = true;
    described_.clear();  // a dataset may have been made anew
    describing_.clear();
    filmRevision_.reset();
}

void FilmEditor::setDescription(const proto::Description& description) {
    described_[description.dataset()] = description;
    filmRevision_.reset();
}

const proto::Description* FilmEditor::description(const std::string& dataset) {
    const auto known = described_.find(dataset);
    if (known != described_.end()) return &known->second;
    if (catalogue_.count(dataset) == 0 || !describing_.insert(dataset).second) return nullptr;
    connection_.describe(dataset, [this](const Result<proto::Description>& reply) {
        reply.ok() ? setDescription(*reply) : say(reply.error());
    });
    return nullptr;
}

/// Makes the film anew where the model or what is known of its datasets has changed.
void FilmEditor::refreshFilm() {
    if (filmRevision_ == model_.revision() || !known_) return;
    filmRevision_ = model_.revision();
    film_.reset();
    failure_.clear();
    if (!model_.isFilm()) return;
    const auto script = model_.toScript();
    auto datasets = catalogue_;
    for (const auto& name : datasetsOf(script)) {
        if (const auto* described = description(name)) datasets[name] = knownDataset(described->manifest());
    }
    auto film = Film::create(script, datasets);
    if (!film.ok()) failure_ = film.error().toString();
    if (film.ok()) film_ = *std::move(film);
}

bool FilmEditor::waits() const {
    return std::any_of(model_.keyframes().begin(), model_.keyframes().end(),
                       [&](const auto& keyframe) {
                           return !thumbnails_.has(keyframe.picture) && failed_.count(keyframe.picture) == 0;
                       }) &&
           !thumbnails_.full();
}

void FilmEditor::askThumbnails() {
    if (!known_ || !asked_.empty() || !waits()) return;
    std::set<std::uint64_t> numbers;
    for (const auto& keyframe : model_.keyframes()) {
        if (thumbnails_.has(keyframe.picture) || failed_.count(keyframe.picture) != 0) continue;
        if (numbers.size() >= FilmThumbnails::most || !numbers.insert(keyframe.picture).second) continue;
        auto view = keyframe.view;
        const auto size = askedSize(model_.size());
        view.set_width(size.width);
        view.set_height(size.height);
        ViewRequest request;
        request.finalOnly = request.queued = true;
        asked_[connection_.setView(std::move(view), request)] = keyframe.picture;
    }
}

bool FilmEditor::takeFrame(const ReceivedFrame& frame) {
    const auto asked = asked_.find(frame.message.view_id());
    if (asked == asked_.end()) return false;
    thumbnails_.put(asked->second, frame.pixels, model_.size());
    if (!thumbnails_.has(asked->second)) failed_.insert(asked->second);
    asked_.erase(asked);
    return true;
}

bool FilmEditor::takeFailure(std::uint64_t view) {
    const auto asked = asked_.find(view);
    if (asked == asked_.end()) return false;
    failed_.insert(asked->second);
    asked_.erase(asked);
    return true;
}

void FilmEditor::say(const Status& status) {
    message_ = status.ok() ? "" : status.error().toString();
}

}  // namespace mote::client
