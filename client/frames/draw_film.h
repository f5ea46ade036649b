// SPDX-License-Identifier: GPL-3.0-or-later
//
// Draws a script, from servers to files. Main thread.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "client/frames/exposure.h"
#include "client/frames/frame_report.h"
#include "client/frames/frame_sink.h"
#include "client/frames/options.h"
#include "client/frames/picture_file.h"
#include "client/frames/picture_server.h"
#include "client/shared/interrupt.h"
#include "protocol/base/error.h"
#include "protocol/mote.pb.h"
#include "protocol/scene/film/film.h"

namespace mote::client {

struct FilmOrder {
    const Film& film;
    bool keepsStrokes = false;                  ///< each frame is drawn from the one before it, by one server
    PictureFormat format = PictureFormat::png;  ///< decides what pixels are asked for
    std::optional<proto::Page> page = {};       ///< of documents
    ExposureSettings exposure = {};
    bool resume = false;
    bool json = false;  ///< one line of JSON a frame on stdout
};

/// The frames of a script, from one server or several, to a sink. Exact pictures only; servers are
/// asked ahead, so that drawing, travelling, encoding and writing overlap. Main thread.
class FilmRun {
  public:
    /// All outlive it. `servers`: connected, at least one. `dataKey`: of all that is drawn but the views
    /// (servers, devices, datasets).
    FilmRun(const FilmOrder& order, std::vector<PictureServer*> servers, std::string dataKey, FrameSink& sink,
            Wakeup& wakeup, const Interrupt& interrupt);

    /// Draws what is missing and finishes the sink. A frame that fails is tried once more; the others go on,
    /// unless several fail one after the other. Errors: cancelled, the disk's, the servers' where all are
    /// lost; the first frame's that failed, with how many did.
    Status run(ProgressBar& bar);

  private:
    /// A frame that is being drawn.
    struct Open {
        std::size_t index = 0;
        std::string key;
        bool keep = true;                ///< false: it stands; it is drawn because the next ones remember it
        std::size_t left = 0;            ///< views to come
        std::vector<std::size_t> alike;  ///< later frames that show the same
        Exposure exposure{1};
        std::vector<std::uint8_t> payload;
        FrameReport report;
    };
    struct Place {
        PictureServer* server;
        std::map<std::uint64_t, std::shared_ptr<Open>> views;  ///< by the view's number
        unsigned returns = 0;
    };

    std::string keyOf(const std::vector<proto::View>& views) const;
    Status askMore();
    Status ask(Place& place, std::size_t index);
    std::optional<std::size_t> nextFrame();
    Status collect(Place& place);
    bool isLikeLast(const std::string& key) const;
    Status received(Open& open, ReceivedFrame frame);
    void askAgain(const Open& open);
    Status failed(std::size_t index, const Error& error);
    Status settle();
    Status dropLost();
    void drop(Place& place);
    bool drawing() const;
    Status outcome() const;

    const FilmOrder& order_;
    std::vector<Place> places_;
    const std::string dataKey_;
    FrameSink& sink_;
    Wakeup& wakeup_;
    const Interrupt& interrupt_;
    FinishingThreads finishing_;
    ReportLines reports_;

    std::weak_ptr<Open> last_;                  // the frame that was asked for last
    std::size_t next_ = 0;                      // the first frame that was not looked at
    std::deque<std::size_t> again_;             // frames to be asked for once more
    std::map<std::size_t, unsigned> attempts_;  // of frames that failed
    std::map<std::size_t, FrameReport> drawn_;  // and not finished yet
    std::size_t done_ = 0;
    std::map<std::size_t, Error> errors_;  // by frame
    unsigned failuresInRow_ = 0;
};

/// `script`: checked by itself; `name`: what errors call it. Finished pictures stay whatever happens. Errors:
/// the script's with its datasets, the servers', the disk's, cancelled (interrupted).
Status drawFilm(const FramesOptions& options, const proto::Script& script, const std::string& name,
                const Interrupt& interrupt);

/// Draws as a job what its request asks for, into the folder `film` beside the request's file; what is there
/// already stays, and a server that ends is waited for.
Status drawFilmJob(const FramesOptions& options, const Interrupt& interrupt);

}  // namespace mote::client
