// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/unit/damage/rewritten_file.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>

#include "tests/unit/damage/file_bytes.h"

namespace mote::test {

RewrittenFile::RewrittenFile(const std::filesystem::path& path)
    : original_(bytesOfFile(path)), file_(::open(path.c_str(), O_WRONLY | O_CLOEXEC)) {}

RewrittenFile::~RewrittenFile() {
    ::close(file_);
}

void RewrittenFile::write(std::size_t at, std::string_view bytes) const {
    const auto size = std::min(bytes.size(), original_.size() - at);
    EXPECT_EQ(::pwrite(file_, bytes.data(), size, static_cast<off_t>(at)), static_cast<ssize_t>(size));
}

void RewrittenFile::cutOff(std::size_t at) const {
    EXPECT_EQ(::ftruncate(file_, static_cast<off_t>(at)), 0);
}

void disturb(const RewrittenFile& file, const std::string& other, Random& random) {
    const auto at = random.below(file.original().size());
    const auto size = 1 + random.below(random.oneOf<std::uint64_t>({8, 4096, 1 << 17}));
    std::string bytes;
    switch (random.below(4)) {
        case 0:
            for (std::uint64_t i = 0; i < size; ++i) bytes.push_back(static_cast<char>(random.next()));
            break;
        case 1:
            bytes.assign(size, random.oneOf<char>({'\xff', '\0', '\x7f'}));
            break;
        case 2:
            bytes = other.substr(std::min(at, other.size() - 1), size);
            break;
        default:
            file.restore();
            return;
    }
    file.write(at, bytes);
}

}  // namespace mote::test
