// SPDX-License-Identifier: GPL-3.0-or-later
//
// Viewer: ties window, panes, panel, film and connections together: a frame loop that sends the latest views,
// shows the newest pictures and sleeps while nothing changes. Main thread.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "client/shared/connection.h"
#include "client/shared/part_file.h"
#include "client/shared/server_line.h"
#include "client/view/commands.h"
#include "client/view/datasets/dataset_browser.h"
#include "client/view/desk.h"
#include "client/view/files/picture_keeper.h"
#include "client/view/files/view_files.h"
#include "client/view/film_editor.h"
#include "client/view/hand/named_cameras.h"
#include "client/view/numbers/density_lens.h"
#include "client/view/numbers/numbers_editor.h"
#include "client/view/over_picture.h"
#include "client/view/panel.h"
#include "client/view/panes/pane.h"
#include "client/view/server_state.h"
#include "client/view/time_bar.h"
#include "client/view/view_model.h"
#include "client/view/window.h"

namespace mote::client {

/// The command line of mote-view.
struct ViewOptions {
    std::filesystem::path connection;             ///< connection file of the server
    std::optional<std::filesystem::path> target;  ///< what is shown without a server of the user's
    std::vector<std::string> spawn;               ///< "NAME=DIR": roots of a private server
    std::string dataset;                          ///< shown first; empty: the catalogue's first
    std::optional<std::filesystem::path> view;    ///< a saved view, or a script, to start with
    std::optional<std::filesystem::path> film;    ///< a script of keyframes to start with
    int width = 1600;                             ///< of the window, screen coordinates
    int height = 900;
    std::optional<std::filesystem::path>
        screenshot;  ///< PNG of the window, once the first exact picture is shown
    std::optional<std::filesystem::path>
        saveView;                         ///< a file that is not there, for the view that was shown then
    bool exitAfterStill = false;          ///< and then the program ends
    std::shared_ptr<Window> window = {};  ///< that is open already
    std::shared_ptr<PrivateServer> server = {};  ///< one of our own, which starts or has started
};

/// Completes options with a target: roots of a private server, which starts meanwhile, and what it is to
/// show: a folder of datasets, a dataset, or a file that is prepared into the user's cache, which a window
/// says that is then the viewer's. Errors: notFound, cancelled. Throws WindowError.
Status resolveTarget(ViewOptions& options);

/// Starts a server with the roots of options.spawn. Errors: PrivateServer's.
Status startServer(ViewOptions& options);

class Viewer {
  public:
    /// Loads the saved view and the film if they were given, and asks for the first picture, so that it is
    /// drawn while the window opens. Throws WindowError.
    explicit Viewer(const ViewOptions& options);

    /// Errors of options.view and options.film; to be asked before run().
    const Status& loaded() const { return loaded_; }
    /// Runs until the window closes or, on request, the exact picture was shown. Returns the exit status.
    int run();

  private:
    // The server.

    void listen();
    void askAhead();
    void askServer();
    void replaceJob(const proto::JobStatus& job);
    void addOlderJobs();
    void takeCatalogue(const proto::Catalogue& catalogue);
    void learnLetters(const google::protobuf::Message& of);
    void learnDatasets();
    void describeShown(Pane& of);
    /// Null: the server has none of this name.
    const proto::Catalogue::Entry* findEntry(const std::string& dataset) const;
    void leaveOutMissing(proto::View& view) const;
    void sendView(std::size_t index, const PictureArea& area);
    void sendViews(const PictureArea& whole);
    void takePictures();
    void refreshStatistics();
    void refreshShown();
    /// Says that the plot is there that a job of ours was to make, once the catalogue knows it.
    void noteAwaited();
    /// And before that how far it is.
    void drawAwaited(const PictureArea& area);
    /// Asks for the steps of the dataset that a pane shows, if it has others by now.
    void learnSteps(const Pane& of);
    /// What a pane's dataset is may be another now.
    void learnAnew(const Pane& of);
    void plot(const AxisNames& axes);
    /// Submits a job, and says when what it makes is there.
    void make(const proto::JobRequest& request);

    // What is worked on: what the active pane shows.

    Pane& pane() { return panes_.active(); }
    const Pane& pane() const { return panes_.active(); }
    Pane& timed() { return panes_.timed(); }
    const Pane& timed() const { return panes_.timed(); }
    ViewModel& model() { return pane().model; }
    const ViewModel& model() const { return pane().model; }
    void hearServer();
    void drawAll(const PictureArea& whole);
    void setPanes(std::size_t count);
    void activate(std::size_t index);
    void setLinks(const Links& links);

    /// What was last seen of it, or it as it is at first.
    void openDataset(const std::string& name);
    /// The chosen layer is of it; `alone`: and there is no other.
    void setDataset(const std::string& name, bool alone);
    void addDataset(const std::string& name);
    /// Asks what a dataset is; failures are said.
    void withDescription(const std::string& name, std::function<void(const proto::Description&)> take);
    /// Shows a view, whatever its dataset.
    void showView(Pane& in, const proto::View& view, bool fromFile = true);
    void restore(const std::optional<DeskState>& state, const char* where);
    void showCameras(const std::optional<PaneCameras>& cameras);
    Status openView(const std::filesystem::path& path);
    Status saveView(const std::filesystem::path& path, SameName sameName);
    void takePaths(const PanelActions& actions);
    Status openStyle(const std::filesystem::path& path);
    void savePicture(const std::filesystem::path& path);
    Status askPicture(const PictureGoal& goal, int width, int height);
    void copyPicture(bool background);
    /// Once nothing lies over it any more.
    void keepWindow();
    void copyCommand();
    /// The state of this moment belongs to the present gesture.
    void lookAtDesk();
    void beginSession();
    QueryLine queryLine();
    void keepSession();
    void offerSession();
    void takeUpSession(const Session& session);

    // The hand.

    float filmHeight(float scale) const;
    float timeHeight(float scale) const;
    void takePanelWidth(const PanelActions& actions);
    void readWishes();
    /// What all panes share, and that of the active one.
    PictureArea pictureArea() const;
    PictureArea areaWithin(glm::vec2 size, glm::vec2 density, float scale) const;
    PictureArea activeArea() const;
    void countGestures();
    void takePress(const PictureArea& whole);
    void takeInput(const PictureArea& area);
    void turn(const PictureArea& area, bool held);
    void lookAround(const PictureArea& area, bool held);
    void steer(const PictureArea& area);
    Push pushedKeys() const;
    double flightWay(const PictureArea& area) const;
    void setFlying(bool flying);
    void drawFlight(const PictureArea& area) const;
    void toggleBrush();
    void askForBrush();
    /// What the left button does in place of turning the camera; nothing from now on.
    void endTools();
    /// The server is another one, or knows other datasets.
    void forgetNumbers();
    bool takeBrushKey(const PressedKey& key);
    bool isSteeringKey(const PressedKey& key) const;
    glm::dvec3 placeUnderPointer(const PictureArea& area) const;
    void takeKeys();
    void run(const char* command);
    void apply(const PanelActions& actions);
    void fitView();
    void fitSelection();
    void fitTo(Pane& in, const Bounds& box);
    void setCamera(const Camera& camera);
    void glide();
    void takeCameraWish(const CameraWish& wish);
    /// Those of the active pane's dataset, first to ninth by their numbers.
    void makeCameraCommands();
    void goSteps(std::int64_t steps);
    void makeCommands();
    void makeViewCommands();
    /// What the user wants of all windows: marks in the folder of sessions.
    static constexpr const char *lightWindow = "light", *noDevices = "no-devices", *savesData = "saves-data",
                                *timeScaleWish = "time-scale";
    static bool isMarked(const char* name);
    void mark(const char* name, bool marked);
    void useLight(bool light);
    void useDevices(bool used);
    void saveData(bool saved);

    // What is shown.

    void say(const std::string& message);
    void showPictures(const PictureArea& whole) const;
    void drawOver(const PictureArea& whole);
    void drawTriads(const PictureArea& whole);
    void drawSaver(const PictureArea& whole);
    void browse(const PictureArea& area);
    std::vector<Note> whatIsWrong(std::size_t index);
    std::optional<Note> whatOfLine(std::size_t index);
    std::optional<Note> whatOfLayer(std::size_t index, int at);
    void drawPrompts();
    void drawClosing();
    void play();
    void drawTime(const PictureArea& whole);
    void editFilm(const PictureArea& whole);
    void editNumbers(const PictureArea& area);
    void lightDensities(const PictureArea& area);
    const proto::Manifest* shownManifest() const;
    /// Exact pictures of the latest views are on the screen.
    bool still() const;
    bool finished();
    void keepResults();
    bool mayClose();
    std::optional<double> patience() const;

    ViewOptions options_;
    std::shared_ptr<Window> window_;
    Playback playback_;
    TimeBar timeBar_;
    DataSaver saver_;
    Handles handles_;
    ServerState server_;
    ViewFiles files_;
    Desk desk_;
    CameraShelf shelf_;
    CameraGlide glide_;
    std::vector<std::string> cameraCommands_;  // names of the cameras that commands go to
    Notes notes_;
    std::vector<Command> commands_;
    CommandPalette palette_;
    DatasetBrowser browser_;
    std::optional<Session> offered_;
    bool interactive_ = true;  // no script runs the viewer
    bool offersSession_ = true, keysShown_ = false, flying_ = false;
    std::uint64_t gesture_ = 0;  // of the hand; counts
    double lastWheel_ = 0.0;     // when it turned, seconds
    glm::dvec3 pivot_{0.0};      // of the drag under way
    FlightSpeed flightSpeed_;
    double steered_ = 0.0;  // when a hand leaned last, seconds
    std::vector<Pad> padsBefore_;
    enum class Closing { no, asked, agreed } closing_ = Closing::no;
    std::string title_;            // of the window
    std::string note_;             // on what was opened
    std::string said_;             // the last that was said
    std::uint64_t jobsPaged_ = 0;  // jobs of the pages that were asked for
    FilmEditor film_;
    Status loaded_ = success();
    bool panelShown_ = true, filmShown_ = false;
    bool moving_ = false;         // a gesture is under way
    std::string awaitedDataset_;  // a plot that a job of ours makes
    PictureKeeper pictures_;
    std::optional<std::filesystem::path> windowTo_;  // a picture of the window is to be saved there
    int settling_ = 0;                               // frames that follow what came last
    float panelWidth_ = panelWidth;
    double restFrom_ = 0.0;  // seconds; then nothing is drawn any more
    int exitStatus_ = 0;
    float keptPanelWidth_ = panelWidth;  // as it is kept for the next time
    // Last: their destructors end the callbacks into this object; but the numbers drop what they have asked.
    Connection connection_;
    Panes panes_;  // the first asks over that connection
    NumbersEditor numbers_;
    DensityLens lens_;
};

}  // namespace mote::client
