// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/shared/film_download.h"

#include <fmt/format.h>

#include <utility>

#include "protocol/scene/film/check_script.h"
#include "protocol/scene/film_job.h"
#include "protocol/scene/mote_check.h"
#include "protocol/scene/system_error.h"

namespace mote::client {
namespace {

constexpr std::uint64_t largestFile = std::uint64_t{1} << 40;  // bytes; a server may say anything

}  // namespace

Result<std::unique_ptr<FilmDownload>> FilmDownload::begin(const proto::JobStatus& job,
                                                          const std::filesystem::path& target) {
    if (!job.request().has_film())
        return Error{ErrorCode::invalidArgument, "", fmt::format("job {} is no film", job.id())};
    const auto& film = job.request().film();
    std::uint64_t files = 1;
    if (film.video().empty()) {
        MOTE_RETURN_IF_ERROR(checkFilmJob(film), "film");
        MOTE_RETURN_IF_ERROR(checkScript(film.script()), "film.script");
        files = frameCountOf(film.script());
        std::error_code code;
        std::filesystem::create_directories(target, code);
        if (code) return systemError(code.value(), target.string(), "cannot be made");
    }
    std::unique_ptr<FilmDownload> download(new FilmDownload(job, target, files));
    MOTE_RETURN_IF_ERROR(download->open());
    return download;
}

FilmDownload::FilmDownload(const proto::JobStatus& job, std::filesystem::path target, std::uint64_t files)
    : id_(job.id()), film_(job.request().film()), target_(std::move(target)), files_(files) {}

std::filesystem::path FilmDownload::file() const {
    if (!film_.video().empty()) return target_;
    return target_ / filmPictureName(film_, static_cast<std::uint32_t>(filesDone_));
}

Status FilmDownload::open() {
    auto part = PartFile::create(file());
    MOTE_RETURN_IF_ERROR(part);
    part_ = *std::move(part);
    received_ = size_ = 0;
    return success();
}

proto::FetchFilm FilmDownload::wanted() const {
    proto::FetchFilm piece;
    piece.set_id(id_);
    if (film_.video().empty()) piece.set_frame(static_cast<std::uint32_t>(filesDone_));
    piece.set_begin(received_);
    return piece;
}

Status FilmDownload::take(const FilmBytes& piece) {
    MOTE_CHECK(!done());
    const auto size = piece.message.size();
    const bool sound = piece.message.begin() == received_ && size <= largestFile &&
                       (received_ == 0 || size == size_) && !piece.bytes.empty() &&
                       piece.bytes.size() <= size - received_;
    if (!sound) return Error{ErrorCode::corrupt, file().string(), "the server sent a piece of another file"};
    MOTE_RETURN_IF_ERROR(part_->append(piece.bytes));
    size_ = size;
    received_ += piece.bytes.size();
    return received_ == size_ ? finishFile() : success();
}

Status FilmDownload::finishFile() {
    MOTE_RETURN_IF_ERROR(part_->publish());
    part_.reset();
    ++filesDone_;
    return done() ? success() : open();
}

double FilmDownload::progress() const {
    const double share =
        size_ > 0 && !done() ? static_cast<double>(received_) / static_cast<double>(size_) : 0.0;
    return (static_cast<double>(filesDone_) + share) / static_cast<double>(files_);
}

}  // namespace mote::client
