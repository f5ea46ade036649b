// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/volume/byte_stream.h"

#include <algorithm>
#include <limits>
#include <vector>

#include "preprocess/readers/text/byte_source.h"

namespace mote::prep {
namespace {

// A bit of deflate data gives at most 258 bytes, two of them being the least for that (RFC 1951).
constexpr std::uint64_t deflateRatio = 1032;
constexpr std::size_t skipBytes = 256 * 1024;

class PlainFile : public ByteStream {
  public:
    explicit PlainFile(std::unique_ptr<ByteSource> source) : source_(std::move(source)) {}
    std::string name() const override { return source_->name(); }
    bool sequential() const override { return false; }
    std::optional<std::uint64_t> size() const override { return source_->fileBytes(); }
    std::uint64_t mostBytes() const override { return source_->fileBytes(); }
    Result<std::size_t> read(std::span<char> bytes) override { return source_->read(bytes); }
    Status seek(std::uint64_t offset) override { return source_->seek(offset); }

  private:
    std::unique_ptr<ByteSource> source_;
};

class GzipFile : public ForwardStream {
  public:
    explicit GzipFile(std::unique_ptr<ByteSource> source) : source_(std::move(source)) {}
    std::string name() const override { return source_->name(); }
    std::uint64_t mostBytes() const override { return mostInflated(source_->fileBytes()); }

  protected:
    Result<std::size_t> next(std::span<char> bytes) override { return source_->read(bytes); }
    Status restart() override { return source_->seek(0); }

  private:
    std::unique_ptr<ByteSource> source_;
};

class PartStream : public ByteStream {
  public:
    PartStream(ByteStreamPtr whole, std::uint64_t begin, std::uint64_t length)
        : whole_(std::move(whole)), begin_(begin), length_(length) {}
    std::string name() const override { return whole_->name(); }
    bool sequential() const override { return whole_->sequential(); }
    std::optional<std::uint64_t> size() const override {
        if (!whole_->size()) return std::nullopt;
        return mostBytes();
    }
    std::uint64_t mostBytes() const override {
        return std::min(whole_->mostBytes() - std::min(begin_, whole_->mostBytes()), length_);
    }
    Result<std::size_t> read(std::span<char> bytes) override {
        const auto left = static_cast<std::size_t>(std::min<std::uint64_t>(length_ - at_, bytes.size()));
        auto got = whole_->read(bytes.first(left));
        if (got) at_ += *got;
        return got;
    }
    Status seek(std::uint64_t offset) override {
        at_ = std::min(offset, length_);
        return whole_->seek(begin_ + at_);
    }

  private:
    ByteStreamPtr whole_;
    std::uint64_t begin_, length_, at_ = 0;
};

class InflatedStream : public ForwardStream {
  public:
    InflatedStream(ByteStreamPtr compressed, std::unique_ptr<Inflater> inflater)
        : compressed_(std::move(compressed)), inflater_(std::move(inflater)) {}
    std::string name() const override { return compressed_->name(); }
    std::uint64_t mostBytes() const override { return mostInflated(compressed_->mostBytes()); }

  protected:
    Result<std::size_t> next(std::span<char> bytes) override {
        return inflater_->read(bytes, [this](std::span<char> input) { return compressed_->read(input); });
    }
    Status restart() override {
        MOTE_RETURN_IF_ERROR(compressed_->seek(0));
        return inflater_->reset();
    }

  private:
    ByteStreamPtr compressed_;
    std::unique_ptr<Inflater> inflater_;
};

}  // namespace

std::uint64_t mostInflated(std::uint64_t bytes) {
    return bytes > std::numeric_limits<std::uint64_t>::max() / deflateRatio
               ? std::numeric_limits<std::uint64_t>::max()
               : bytes * deflateRatio;
}

Result<std::size_t> ForwardStream::read(std::span<char> bytes) {
    auto got = next(bytes);
    if (got) position_ += *got;
    return got;
}

Status ForwardStream::seek(std::uint64_t offset) {
    if (offset < position_) {
        MOTE_RETURN_IF_ERROR(restart());
        position_ = 0;
    }
    std::vector<char> skipped(
        static_cast<std::size_t>(std::min<std::uint64_t>(offset - position_, skipBytes)));
    while (position_ < offset) {
        const auto left = std::min<std::uint64_t>(offset - position_, skipped.size());
        const auto got = read(std::span(skipped).first(static_cast<std::size_t>(left)));
        if (!got) return got.error();
        if (*got == 0) break;
    }
    return success();
}

Result<ByteStreamPtr> fileStream(const std::filesystem::path& path) {
    auto source = ByteSource::open(path);
    if (!source) return source.error();
    if ((*source)->compressed()) return ByteStreamPtr(new GzipFile(std::move(source).value()));
    return ByteStreamPtr(new PlainFile(std::move(source).value()));
}

Result<ByteStreamPtr> partStream(ByteStreamPtr whole, std::uint64_t begin,
                                 std::optional<std::uint64_t> length) {
    const std::uint64_t rest = std::numeric_limits<std::uint64_t>::max() - begin;
    ByteStreamPtr part(new PartStream(std::move(whole), begin, std::min(length.value_or(rest), rest)));
    MOTE_RETURN_IF_ERROR(part->seek(0));
    return part;
}

Result<ByteStreamPtr> inflatedStream(ByteStreamPtr compressed, Inflater::Form form) {
    auto inflater = Inflater::make(form, compressed->name());
    if (!inflater) return inflater.error();
    return ByteStreamPtr(new InflatedStream(std::move(compressed), std::move(inflater).value()));
}

Result<std::string> readHead(ByteStream& stream, std::size_t limit) {
    std::string head(static_cast<std::size_t>(std::min<std::uint64_t>(stream.mostBytes(), limit)), '\0');
    MOTE_RETURN_IF_ERROR(stream.seek(0));
    const auto got = stream.read(head);
    if (!got) return got.error();
    head.resize(*got);
    return head;
}

}  // namespace mote::prep
