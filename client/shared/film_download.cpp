// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/shared/film_download.h"

#include <fmt/format.h>

#include <utility>

#include "protocol/base/mote_check.h"
#include "protocol/base/system_error.h"
#include "protocol/scene/film/check_script.h"
#include "protocol/scene/film/film_job.h"

namespace mote::client {
namespace {

constexpr std::uint64_t largestFile = std::uint64_t{1} << 40;  // bytes; a server may say anything

}  // namespace

Result<std::unique_ptr<FilmDownload>> FilmDownload::begin(const proto::JobStatus& job,
                                                          const std::filesystem::path& target) {
    if (!job.request().has_film() && !job.request().has_export_())
        return Error{ErrorCode::invalidArgument, "",
                     fmt::format("job {} makes no film and no export", job.id())};
    if (job.request().has_film() && job.request().film().video().empty()) {
        std::error_code code;
        std::filesystem::create_directories(target, code);
        if (code) return systemError(code.value(), target.string(), "cannot be made");
    }
    std::unique_ptr<FilmDownload> download(new FilmDownload(job, target));
    MOTE_RETURN_IF_ERROR(download->open());
    return download;
}

FilmDownload::FilmDownload(const proto::JobStatus& job, std::filesystem::path target)
    : id_(job.id()),
      oneFile_(job.request().has_export_() || !job.request().film().video().empty()),
      film_(job.request().film()),
      target_(std::move(target)) {}

std::filesystem::path FilmDownload::file() const {
    if (oneFile_) return target_;
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
    if (!oneFile_) piece.set_frame(static_cast<std::uint32_t>(filesDone_));
    piece.set_begin(received_);
    return piece;
}

Status FilmDownload::take(const Result<FilmBytes>& answer) {
    MOTE_CHECK(!done());
    if (!answer.ok()) {
        const auto& error = answer.error();
        const bool past = error.code == ErrorCode::notFound && error.where == "frame";
        if (oneFile_ || !past || filesDone_ == 0 || received_ > 0) return error;
        part_.reset();
        done_ = true;
        return success();
    }
    const auto& piece = *answer;
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
    done_ = oneFile_ || filesDone_ == maxFrames;
    return done_ ? success() : open();
}

std::optional<double> FilmDownload::progress() const {
    if (!oneFile_) return std::nullopt;
    if (size_ == 0) return 0.0;
    return static_cast<double>(received_) / static_cast<double>(size_);
}

}  // namespace mote::client
