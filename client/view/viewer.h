// SPDX-License-Identifier: GPL-3.0-or-later
//
// Viewer: ties window, model, panel, film and connection together: a frame loop that sends the latest view,
// shows the newest picture and sleeps while nothing changes. Main thread.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "client/shared/connection.h"
#include "client/shared/part_file.h"
#include "client/view/film_editor.h"
#include "client/view/numbers/numbers_editor.h"
#include "client/view/panel.h"
#include "client/view/server_state.h"
#include "client/view/view_files.h"
#include "client/view/view_model.h"
#include "client/view/window.h"

namespace mote::client {

/// The command line of mote-view.
struct ViewOptions {
    std::filesystem::path connection;           ///< connection file of the server
    std::optional<std::filesystem::path> view;  ///< a saved view, or a script, to start with
    std::optional<std::filesystem::path> film;  ///< a script of keyframes to start with
    int width = 1600;                           ///< of the window, screen coordinates
    int height = 900;
    std::optional<std::filesystem::path>
        screenshot;  ///< PNG of the window, once the first exact picture is shown
    std::optional<std::filesystem::path>
        saveView;                 ///< a file that is not there, for the view that was shown then
    bool exitAfterStill = false;  ///< and then the program ends
};

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
    void addOlderJobs();
    Status openView(const std::filesystem::path& path);
    Status saveView(const std::filesystem::path& path, SameName sameName);
    void takePaths(const PanelActions& actions);
    void learnDatasets();
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
    void editNumbers(const Area& area);
    const proto::Manifest* shownManifest() const;
    bool still() const;
    bool finished();
    void keepResults();
    void refreshStatistics();

    ViewOptions options_;
    Window window_;
    PictureTexture texture_;
    ViewModel model_;
    Playback playback_;
    ServerState server_;
    ViewFiles files_;
    std::string note_;             // on what was opened
    std::string viewFailure_;      // why there is no picture of the latest view
    std::uint64_t jobsPaged_ = 0;  // jobs of the pages that were asked for
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
    // Last: its destructor ends the callbacks into this object; but the numbers drop what they have asked.
    Connection connection_;
    NumbersEditor numbers_;
};

}  // namespace mote::client
