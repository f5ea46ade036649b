// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/readers/text/byte_source.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <limits>

#include "protocol/base/system_error.h"

namespace mote::prep {
namespace {

constexpr std::size_t inputBytes = 256 * 1024, pieceBytes = std::size_t{4} << 20;
constexpr std::uint64_t maxProduced = 1ull << 40;
// zlib's way to say: the greatest window, and a gzip header (16), either header (32), or none (negative).
constexpr int gzipWindow = 15 + 16, anyWindow = 15 + 32, rawWindow = -15;

int windowOf(Inflater::Form form) {
    return form == Inflater::Form::gzip ? gzipWindow : form == Inflater::Form::zlib ? anyWindow : rawWindow;
}

}  // namespace

Result<std::unique_ptr<Inflater>> Inflater::make(Form form, std::string name) {
    std::unique_ptr<Inflater> inflater(new Inflater(form, std::move(name)));
    inflater->input_.resize(inputBytes);
    if (inflateInit2(&inflater->stream_, windowOf(form)) != Z_OK) {
        return Error{ErrorCode::internal, inflater->name_, "zlib cannot be set up"};
    }
    return inflater;
}

Inflater::~Inflater() {
    inflateEnd(&stream_);
}

Status Inflater::fill(const Refill& refill) {
    MOTE_ASSIGN_OR_RETURN(const auto got, refill(input_));
    stream_.next_in = reinterpret_cast<Bytef*>(input_.data());
    stream_.avail_in = static_cast<uInt>(got);
    return success();
}

/// A gzip file may be several ones in a row. Anything else behind the last one is padding.
Status Inflater::endOfMember(const Refill& refill) {
    if (form_ != Form::gzip) {
        atEnd_ = true;
        return success();
    }
    if (stream_.avail_in == 0) MOTE_RETURN_IF_ERROR(fill(refill));
    atEnd_ = stream_.avail_in == 0 || *stream_.next_in != 0x1f;
    if (!atEnd_) inflateReset(&stream_);
    return success();
}

Result<std::size_t> Inflater::read(std::span<char> bytes, const Refill& refill) {
    const std::size_t wanted = std::min<std::size_t>(bytes.size(), std::numeric_limits<uInt>::max());
    stream_.next_out = reinterpret_cast<Bytef*>(bytes.data());
    stream_.avail_out = static_cast<uInt>(wanted);
    while (stream_.avail_out > 0 && !atEnd_) {
        if (stream_.avail_in == 0) {
            MOTE_RETURN_IF_ERROR(fill(refill));
            if (stream_.avail_in == 0) {
                return corrupt(name_, std::string("its ") + formName() + " data is cut short");
            }
        }
        const int code = inflate(&stream_, Z_NO_FLUSH);
        if (code == Z_STREAM_END) {
            MOTE_RETURN_IF_ERROR(endOfMember(refill));
        } else if (code != Z_OK) {
            return corrupt(name_, std::string("its ") + formName() + " data is damaged");
        }
    }
    const std::size_t got = wanted - stream_.avail_out;
    produced_ += got;
    if (produced_ > maxProduced) {
        return Error{ErrorCode::resourceExhausted, name_, "decompresses to more than 1 TiB"};
    }
    return got;
}

Status Inflater::reset() {
    produced_ = 0;
    atEnd_ = false;
    stream_.avail_in = 0;
    if (inflateReset(&stream_) != Z_OK) return Error{ErrorCode::internal, name_, "zlib cannot be set up"};
    return success();
}

Result<std::unique_ptr<ByteSource>> ByteSource::open(const std::filesystem::path& path) {
    std::unique_ptr<ByteSource> source(new ByteSource());
    source->name_ = path.filename().string();
    // O_NONBLOCK: a pipe in the place of a file must not make the job wait.
    source->descriptor_ = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
    if (source->descriptor_ < 0) return systemError(errno, source->name_, "cannot be read");
    struct stat state {};
    if (::fstat(source->descriptor_, &state) != 0) return systemError(errno, source->name_, "cannot be read");
    if (!S_ISREG(state.st_mode)) {
        return unsupported(source->name_, "is not a regular file");
    }
    source->fileBytes_ = static_cast<std::uint64_t>(state.st_size);
    std::array<char, 2> magic{};
    MOTE_ASSIGN_OR_RETURN(const auto got, source->readFile(magic));
    if (got == 2 && magic[0] == '\x1f' && magic[1] == '\x8b') {
        MOTE_ASSIGN_OR_RETURN(auto inflater, Inflater::make(Inflater::Form::gzip, source->name_));
        source->inflater_ = std::move(inflater);
    }
    MOTE_RETURN_IF_ERROR(source->seek(0));
    return source;
}

ByteSource::~ByteSource() {
    if (descriptor_ >= 0) ::close(descriptor_);
}

Result<std::size_t> ByteSource::readFile(std::span<char> bytes) {
    std::size_t done = 0;
    while (done < bytes.size()) {
        const ssize_t got =
            ::pread(descriptor_, bytes.data() + done, bytes.size() - done, static_cast<off_t>(offset_));
        if (got < 0 && errno == EINTR) continue;
        if (got < 0) return systemError(errno, name_, "cannot be read");
        if (got == 0) break;
        done += static_cast<std::size_t>(got);
        offset_ += static_cast<std::uint64_t>(got);
    }
    return done;
}

Result<std::size_t> ByteSource::read(std::span<char> bytes) {
    if (!compressed()) return readFile(bytes);
    return inflater_->read(bytes, [this](std::span<char> input) { return readFile(input); });
}

Status ByteSource::seek(std::uint64_t offset) {
    offset_ = offset;
    if (!compressed()) return success();
    MOTE_CHECK(offset == 0);
    return inflater_->reset();
}

Result<std::string> beginningOf(const std::filesystem::path& path, std::size_t most) {
    MOTE_ASSIGN_OR_RETURN(const auto source, ByteSource::open(path));
    std::string bytes(most, '\0');
    std::size_t got = 0;
    while (got < most) {
        MOTE_ASSIGN_OR_RETURN(const auto more, source->read(std::span(bytes).subspan(got)));
        if (more == 0) break;
        got += more;
    }
    bytes.resize(got);
    return bytes;
}

Result<std::string> wholeFile(const std::filesystem::path& path, std::uint64_t most,
                              const std::string& tooLong, Progress& progress) {
    MOTE_ASSIGN_OR_RETURN(const auto source, ByteSource::open(path));
    std::string bytes;
    for (;;) {
        if (progress.cancelled()) return wasCancelled();
        const std::size_t before = bytes.size();
        bytes.resize(before + pieceBytes);
        MOTE_ASSIGN_OR_RETURN(const auto got, source->read(std::span(bytes).subspan(before)));
        bytes.resize(before + got);
        if (bytes.size() > most) return Error{ErrorCode::resourceExhausted, source->name(), tooLong};
        if (got == 0) return bytes;
    }
}

}  // namespace mote::prep
