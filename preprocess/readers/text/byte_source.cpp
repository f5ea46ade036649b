// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/readers/text/byte_source.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>

#include "protocol/scene/system_error.h"

namespace mote::prep {
Result<std::unique_ptr<ByteSource>> ByteSource::open(const std::filesystem::path& path) {
    std::unique_ptr<ByteSource> source(new ByteSource());
    source->name_ = path.filename().string();
    // O_NONBLOCK: a pipe in the place of a file must not make the job wait.
    source->descriptor_ = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
    if (source->descriptor_ < 0) return systemError(errno, source->name_, "cannot be read");
    struct stat state {};
    if (::fstat(source->descriptor_, &state) != 0) return systemError(errno, source->name_, "cannot be read");
    if (!S_ISREG(state.st_mode)) {
        return Error{ErrorCode::unsupported, source->name_, "is not a regular file"};
    }
    source->fileBytes_ = static_cast<std::uint64_t>(state.st_size);
    std::array<char, 2> magic{};
    const auto got = source->readFile(magic);
    if (!got) return got.error();
    if (*got == 2 && magic[0] == '\x1f' && magic[1] == '\x8b') {
        auto inflater = Inflater::make(Inflater::Form::gzip, source->name_);
        if (!inflater) return inflater.error();
        source->inflater_ = std::move(inflater).value();
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

}  // namespace mote::prep
