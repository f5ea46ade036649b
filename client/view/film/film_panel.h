// SPDX-License-Identifier: GPL-3.0-or-later
//
// FilmPanel: the bar along the bottom of the window in which a film is edited. It edits the film's model and
// returns what only the viewer can do. Main thread, between Window::beginFrame and drawFrame.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "client/view/files/view_files.h"
#include "client/view/film/film_model.h"
#include "client/view/film/film_strip.h"
#include "protocol/mote.pb.h"

namespace mote::client {

/// What the panel shows beside the model.
struct FilmState {
    std::string message;                    ///< the last failure or news, one sentence
    std::string failure;                    ///< why keyframes make no film; empty: they do, or are too few
    bool connected = false;                 ///< to a server
    bool shown = false;                     ///< there is a picture
    bool saving = false;                    ///< a film is fetched
    double saved = 0.0;                     ///< of it, 0 to 1; of pictures 0
    std::string savedWhat;                  ///< "12 pictures"
    const proto::JobStatus* job = nullptr;  ///< the latest that makes a film of this one; null: none
};

/// What a film is made as.
struct FilmKind {
    std::string_view name;         ///< that the user reads
    std::string_view video = {};   ///< "mp4", ...; "": pictures
    std::string_view chroma = {};  ///< "full" keeps the colours of single points; "": it plays everywhere
};

/// What the user asked for in this frame.
struct FilmActions {
    bool addKeyframe = false, replaceKeyframe = false;
    bool selected = false;  ///< a keyframe: its view is to be shown
    bool scrubbed = false;  ///< the film at the playhead is to be shown
    bool editing = false;   ///< and the mouse is still on it
    bool togglePreview = false;
    bool cancelJob = false, retryJob = false, stopSaving = false;
    bool saveFilm = false;               ///< where to is to be asked
    const FilmKind* makeFilm = nullptr;  ///< the one that is wanted
    std::optional<std::filesystem::path> openScript, saveScript, saveFilmTo;
    std::string failure;  ///< of an edit, one sentence
};

class FilmPanel {
  public:
    /// Pixels that it takes from the picture's height.
    static float height(float scale);

    /// Draws it in this place, pixels.
    FilmActions draw(FilmModel& model, FilmPreview& preview, const FilmState& state,
                     const ThumbnailHandles& thumbnails, float left, float top, float width, float scale);

    PathPrompt opening{"Open script", "Open", "film.json", false};
    PathPrompt savingScript{"Save script", "Save", "film.json", true};
    PathPrompt savingFilm{"Save film", "Save", "", true};

  private:
    void drawKeyframeControls(FilmModel& model, const FilmState& state, FilmActions& actions, float scale);
    void drawTime(FilmModel& model, FilmActions& actions, float scale);
    void drawPreview(const FilmModel& model, FilmPreview& preview, const FilmState& state,
                     FilmActions& actions, float scale);
    void drawFilmControls(FilmModel& model, FilmActions& actions, float scale);
    void drawFiles(const FilmModel& model, const FilmState& state, FilmActions& actions, float scale);
    void drawJob(const FilmState& state, FilmActions& actions, float scale);
    void drawPrompts(FilmActions& actions, float scale);

    FilmStrip strip_;
    std::string kind_ = "mp4";  // of the film that is made
};

}  // namespace mote::client
