// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/volume/archive_stream.h"

#include <algorithm>
#include <vector>

namespace mote::prep {
namespace {

class ArchiveStream : public ByteStream {
  public:
    ArchiveStream(ArrayBytes bytes, const ArrayBytes::Part& part)
        : bytes_(std::move(bytes)), name_(part.where), size_(part.bytes), deflated_(part.deflated) {}
    std::string name() const override { return name_; }
    bool sequential() const override { return deflated_; }
    std::optional<std::uint64_t> size() const override { return size_; }
    std::uint64_t mostBytes() const override { return size_; }
    Result<std::size_t> read(std::span<char> bytes) override {
        const auto count = static_cast<std::size_t>(std::min<std::uint64_t>(size_ - at_, bytes.size()));
        MOTE_RETURN_IF_ERROR(bytes_.read(at_, bytes.first(count)));
        at_ += count;
        return count;
    }
    Status seek(std::uint64_t offset) override {
        at_ = std::min(offset, size_);
        return success();
    }

  private:
    ArrayBytes bytes_;
    std::string name_;
    std::uint64_t size_, at_ = 0;
    bool deflated_;
};

}  // namespace

Result<ByteStreamPtr> archiveStream(const ArrayBytes::Part& part) {
    MOTE_ASSIGN_OR_RETURN(auto bytes, ArrayBytes::open(part));
    return ByteStreamPtr(std::make_unique<ArchiveStream>(std::move(bytes), part));
}

Status checkWhole(ByteStream& stream) {
    std::vector<char> block(std::size_t{1} << 18U);
    MOTE_RETURN_IF_ERROR(stream.seek(0));
    while (true) {
        MOTE_ASSIGN_OR_RETURN(const auto got, stream.read(block));
        if (got == 0) return stream.seek(0);
    }
}

}  // namespace mote::prep
