// SPDX-License-Identifier: GPL-3.0-or-later
//
// FilmEditor: the film of the viewer and all that it needs of the server: what its datasets are, thumbnails,
// its preview, the job that makes it and the way of that film to a file. Owned by the viewer; main thread,
// with the window's context current.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>

#include "client/shared/connection.h"
#include "client/shared/film_download.h"
#include "client/view/film/film_model.h"
#include "client/view/film/film_panel.h"
#include "client/view/film/film_thumbnails.h"
#include "client/view/server_state.h"
#include "protocol/scene/film/film.h"

namespace mote::client {

/// Where the film's bar lies, and what is to be seen beside it.
struct FilmSurroundings {
    float left, top, width;  ///< pixels
    float scale;             ///< pixels to a screen coordinate
    double now;              ///< seconds
    const proto::View& present;
    const FramePixels& picture;  ///< on the screen; without pixels before the first
    const ServerState& server;
};

class FilmEditor {
  public:
    /// `heard` is told of the jobs that it submits. The connection outlives it, but is not used before the
    /// first draw().
    FilmEditor(Connection& connection, std::function<void(const proto::JobStatus&)> heard);

    /// Edits a script's film. Errors: as readScript() and FilmModel::fromScript(), with the file's name.
    Status open(const std::filesystem::path& script);
    const FilmModel& film() const { return model_; }
    /// Edits this one from now on.
    void restore(const FilmModel& film);
    /// It is as in a file of the user's.
    bool isSaved() const { return saved_ == model_.revision(); }

    /// Draws the bar and does what the user asks for; the view that is to be shown now, if another one is.
    std::optional<proto::View> draw(const FilmSurroundings& around);
    /// The view that is due while the film is played.
    std::optional<proto::View> play(double now);
    void stop() { preview_.stop(); }
    /// The view changes all the time: it is played, or the mouse is on its bar.
    bool moving() const { return preview_.playing() || held_; }
    /// Asks where the film of a job is to be saved, in the next draw().
    void askWhereToSave(const proto::JobStatus& job);

    // What the viewer hears of its server.

    void setCatalogue(const proto::Catalogue& catalogue);
    void setDescription(const proto::Description& description);
    /// What is known of a dataset; null, and it is asked for, if it is not known.
    const proto::Description* description(const std::string& dataset);
    /// Asks for the thumbnails that are missing; to be called while nothing else is to be drawn.
    void askThumbnails();
    /// The viewer asked for a view, or the line is another one: thumbnails that were asked for do not come.
    void forgetAsked() { asked_.clear(); }
    /// Tells whether it was a thumbnail's.
    bool takeFrame(const ReceivedFrame& frame);
    bool takeFailure(std::uint64_t view);
    /// A thumbnail is still to come.
    bool waits() const;

  private:
    std::optional<proto::View> obey(const FilmActions& actions, const FilmSurroundings& around);
    void keep(const Status& edit, const FilmSurroundings& around);
    std::optional<proto::View> viewAtPlayhead();
    void togglePreview(double now);
    void takePaths(const FilmActions& actions);
    bool openTyped(const std::filesystem::path& script);
    void makeFilm(const FilmKind& kind);
    /// The answer names the job that makes the film from now on.
    Connection::Reply<proto::JobStatus> takeJob();
    void saveFilm(const std::filesystem::path& path);
    void fetchNext();
    void refreshFilm();
    void say(const Status& status);
    FilmState stateOf(const FilmSurroundings& around) const;

    Connection& connection_;
    const std::function<void(const proto::JobStatus&)> heard_;
    FilmModel model_;
    FilmPreview preview_;
    FilmPanel panel_;
    FilmThumbnails thumbnails_;
    bool held_ = false;
    std::string message_;
    std::optional<std::uint64_t> saved_;  // revision that a file has

    FilmDatasets catalogue_;
    bool known_ = false;  // there is a catalogue
    std::map<std::string, proto::Description> described_;
    std::set<std::string> describing_;           // asked for
    std::optional<Film> film_;                   // of the model, if it is one
    std::string failure_;                        // or why it is none
    std::optional<std::uint64_t> filmRevision_;  // of the model that it was made from

    std::map<std::uint64_t, std::uint64_t> asked_;  // views of thumbnails, and their numbers
    std::set<std::uint64_t> failed_;                // thumbnails that there cannot be

    std::string job_;            // the latest of ours, an id
    proto::JobStatus savedJob_;  // whose film is to be saved
    std::filesystem::path savedPath_;
    std::unique_ptr<FilmDownload> download_;
    std::uint64_t downloads_ = 0;  // begun so far
};

}  // namespace mote::client
