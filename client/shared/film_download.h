// SPDX-License-Identifier: GPL-3.0-or-later
//
// FilmDownload: a film or an export that a job has made, on its way from the server to files here: it says
// which piece is wanted next and takes it. Each file grows under a hidden name and appears by one rename, so
// that a download that is given up leaves no part of a file. It asks nobody by itself; one owner, one thread.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "client/shared/connection.h"
#include "client/shared/part_file.h"
#include "protocol/base/error.h"
#include "protocol/mote.pb.h"

namespace mote::client {

class FilmDownload {
  public:
    /// The video or export of a job to a file, or, if it made none, its pictures into a folder, which is
    /// made if it is not there. Files of the same names are replaced. Errors: invalidArgument: the job
    /// makes neither; permissionDenied and others of the system.
    static Result<std::unique_ptr<FilmDownload>> begin(const proto::JobStatus& job,
                                                       const std::filesystem::path& target);
    FilmDownload(const FilmDownload&) = delete;
    FilmDownload& operator=(const FilmDownload&) = delete;

    /// The piece to ask for; not once done().
    proto::FetchFilm wanted() const;
    /// The piece that was wanted, or why there is none: that there are no more pictures is the end. Errors,
    /// after which it is of no use: that one; corrupt: it is another piece; those of the system for a file.
    Status take(const Result<FilmBytes>& answer);

    /// Tells whether all files are there.
    bool done() const { return done_; }
    std::uint64_t filesDone() const { return filesDone_; }
    /// The share that is there of a video or an export, 0 to 1; nothing of pictures: how many they are is
    /// told by the last one.
    std::optional<double> progress() const;

  private:
    FilmDownload(const proto::JobStatus& job, std::filesystem::path target);
    std::filesystem::path file() const;
    Status open();
    Status finishFile();

    const std::string id_;
    const bool oneFile_;
    const proto::FilmJob film_;
    const std::filesystem::path target_;
    bool done_ = false;
    std::uint64_t filesDone_ = 0;
    std::unique_ptr<PartFile> part_;  // of the present file
    std::uint64_t received_ = 0;      // bytes of it
    std::uint64_t size_ = 0;          // bytes; 0: not known yet
};

}  // namespace mote::client
