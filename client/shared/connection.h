// SPDX-License-Identifier: GPL-3.0-or-later
//
// Connection: a client's line to its server. It owns an I/O thread that connects, authenticates, sends,
// receives and decodes; its owner's thread asks and is answered: every function may be called from any
// thread, every callback runs inside poll() and nowhere else. Destroying it closes the line; callbacks not
// yet run are then dropped.
//
// A view is a state: setView replaces the view that is wanted, and one that was not sent yet is never sent.
// Frames are a state too: takeFrame gives the newest one, older ones nobody took are dropped. Queued views
// are none: each is drawn, in order, and each frame is there to be taken. Everything else is a question with
// one answer.
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "client/shared/decode.h"
#include "protocol/base/error.h"
#include "protocol/mote.pb.h"

namespace mote::client {

struct ConnectionSettings {
    std::string client = "mote client";  ///< program and version, for the server's log
    /// Called by the I/O thread when poll() or takeFrame() has something new; must only wake the owner.
    std::function<void()> wake;
    std::chrono::milliseconds pingInterval{1000};     ///< the round trip is measured this often; 0: never
    std::chrono::milliseconds connectTimeout{10000};  ///< from the socket to the server's welcome
    /// A line that broke is opened again for so long: a server whose process died is there again in a moment.
    std::chrono::milliseconds returnPatience{5000};
    /// A server that said farewell as it ended is waited for like one whose process died.
    bool outlastsFarewells = false;
    bool background = false;  ///< pictures are made only while nobody else waits for one
};

struct ViewRequest {
    bool finalOnly = false;                    ///< only the exact picture: scripts
    bool moving = false;                       ///< the hand is still on it: no refinement yet
    proto::PixelFormat format = proto::SRGB8;  ///< of the final picture
    std::optional<proto::Page> page = {};      ///< the final picture as a document
    bool queued = false;  ///< the views before it stay and are drawn first; with finalOnly
};

/// Servers of this minor version and above list folders, look at files and tell which steps are loaded.
inline constexpr std::uint32_t filesFromMinor = 5;

/// How a job is to be run.
struct JobWish {
    bool again = false;           ///< although the same request waits, runs or has its output there
    std::uint32_t timeLimit = 0;  ///< s, of a run; 0: the server's, which is never exceeded
};

/// A frame as it arrived, decoded.
struct ReceivedFrame {
    proto::Frame message;  ///< whose picture it is, its quality, where the time went on the server
    FramePixels pixels;
    std::vector<std::uint8_t> payload = {};  ///< of a queued view: as it travelled
    std::size_t payloadBytes = 0;
    double latencyMs = 0.0;  ///< from setView to the decoded picture, by this machine's clock
    double decodeMs = 0.0;   ///< of that, decoding
};

struct ConnectionStatistics {
    double framesPerSecond = 0.0;     ///< received, over the last two seconds
    double bytesPerSecond = 0.0;      ///< received, over the last two seconds
    double linkBytesPerSecond = 0.0;  ///< that the link carries, as the server measures it; 0: not known
    double roundTripMs = 0.0;         ///< of the latest ping; 0 before the first answer
    std::uint64_t pictureBytes = 0;  ///< of frames, unfinished ones too, since the connection object was made
    std::uint64_t frames = 0;        ///< received since the connection object was made
    std::uint64_t bytes = 0;
};

/// A piece of a file that a film job has made.
struct FilmBytes {
    proto::FilmPiece message;
    std::vector<std::uint8_t> bytes;
};

/// The answer to a query, for one step.
struct QueryAnswer {
    proto::Answer message;
    std::vector<std::uint8_t> payload;
};

class Connection {
  public:
    /// A line that broke without a word of the server's is "connecting" while it is opened again, and so is
    /// one for which the server has no place at the moment. The session goes on: the latest view and all
    /// questions are asked again where the server has not kept them, but not jobs that may have been
    /// submitted and queries that were answered in part.
    enum class State { connecting, connected, lost };
    template <class T>
    using Reply = std::function<void(Result<T>)>;

    /// Begins to connect to the server of a connection file; returns at once. A file that is missing or wrong
    /// is a lost connection with that reason.
    Connection(std::filesystem::path connectionFile, ConnectionSettings settings);
    ~Connection();
    Connection(const Connection&) = delete;
    Connection& operator=(const Connection&) = delete;

    State state() const;
    /// Why the connection is lost; empty while it is not.
    std::optional<Error> lostReason() const;
    /// Why the line broke that is being opened again; empty while none is.
    std::optional<Error> brokenBy() const;
    /// What the server said of itself; default values before it is connected.
    proto::Welcome welcome() const;
    ConnectionStatistics statistics() const;

    /// Drops the present connection if there is one, reads the connection file again (a restarted server has
    /// a new token) and connects; the session goes on. Jobs are watched again only on request.
    void reconnect();

    /// Runs the callbacks that are due, on the caller's thread: replies and the listeners below. Returns how
    /// many ran. Not to be called from a callback.
    std::size_t poll();
    /// Blocks until poll() or takeFrame() has something, at most `timeout`. Returns whether it has.
    bool wait(std::chrono::milliseconds timeout);

    /// Wants this view from now on. Returns its id, which frames of it carry; ids ascend. Kept and sent once
    /// connected if it is not yet. A view that is not queued takes the place of all before it. Of queued
    /// ones at most wire::maxQueuedViews are sent at a time; the others wait here.
    std::uint64_t setView(proto::View view, const ViewRequest& request);
    /// The oldest decoded frame of a queued view, or else the newest of the present one, that was not taken
    /// yet; the server may then render another.
    std::optional<ReceivedFrame> takeFrame();

    // Each question is answered once: by the server's answer, its failure, or an Error (internal) that says
    // why the connection was lost. Questions are sent in order, also those asked before it is connected.
    void listDatasets(Reply<proto::Catalogue> reply);
    void describe(const std::string& dataset, Reply<proto::Description> reply);
    /// A small picture of a dataset, of the server's size; of a server of minor 4 and above.
    void thumbnail(const std::string& dataset, Reply<FramePixels> reply);
    /// What lies in a folder beneath a root, "ROOT/PATH", from a place in it on; "": the roots. This and the
    /// next two of a server of filesFromMinor and above.
    void listFolder(const std::string& folder, std::uint64_t first, Reply<proto::Folder> reply);
    /// What a file holds, or a folder as one run. Returns what cancelQuery takes; another look ends it too.
    std::uint64_t lookAtFile(const proto::LookAtFile& wanted, Reply<proto::Look> reply);
    /// Which steps of a dataset the server has in memory.
    void listLoaded(const std::string& dataset, Reply<proto::Loaded> reply);
    /// The same request that waits, runs or has its output there is answered with that job.
    void submitJob(const proto::JobRequest& job, Reply<proto::JobStatus> reply, const JobWish& wish = {});
    void cancelJob(const std::string& id, Reply<proto::JobStatus> reply);
    /// What failed or was cancelled, as a new job.
    void retryJob(const std::string& id, Reply<proto::JobStatus> reply);
    /// A page of all jobs, the latest first.
    void listJobs(std::uint64_t first, Reply<proto::Jobs> reply);
    /// Asks for all jobs; from then on onJob hears of every change.
    void watchJobs(Reply<proto::Jobs> reply);
    /// A piece of what a film job has made, from a place in the file on.
    void fetchFilm(const proto::FetchFilm& piece, Reply<FilmBytes> reply);
    void ping(Reply<double> reply);  ///< the round trip, ms

    /// Asks for numbers. `reply` is called with each answer, until one of them is the last, or once with an
    /// error; protocol's numbers are checked in numbers.h. Returns what cancelQuery takes.
    std::uint64_t query(const proto::Query& query, Reply<QueryAnswer> reply);
    /// Ends a query, or a look, whose answers are not wanted: the server hears of it, its reply is not called
    /// again. Does nothing if it has ended.
    void cancelQuery(std::uint64_t query);

    // Listeners, one each; set them before the first poll().
    void onState(std::function<void(State)> listener);
    /// The catalogue changed (not: an answer to listDatasets).
    void onCatalogue(std::function<void(const proto::Catalogue&)> listener);
    void onJob(std::function<void(const proto::JobStatus&)> listener);
    /// A view cannot be drawn, or a frame of it was damaged; or id 0: the server reports something that
    /// belongs to no question.
    void onViewFailed(std::function<void(std::uint64_t viewId, const Error&)> listener);

  private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

}  // namespace mote::client
