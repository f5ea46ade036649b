// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/parallel/communicator.h"

#include <utility>

namespace mote::prep {
namespace {

class SingleProcess final : public Communicator {
  public:
    int rank() const override { return 0; }
    int size() const override { return 1; }
    bool onOneMachine() const override { return true; }
    Result<std::vector<Bytes>> exchange(std::vector<Bytes> outgoing) override { return outgoing; }
    Result<std::vector<Bytes>> share(std::span<const std::byte> mine) override {
        std::vector<Bytes> all;
        all.push_back(bytesOf(mine));
        return all;
    }
};

/// Waits for nothing before it is finished.
class LateExchange final : public Exchange {
  public:
    LateExchange(Communicator& ranks, std::vector<Bytes> outgoing)
        : ranks_(ranks), outgoing_(std::move(outgoing)) {}
    Result<std::vector<Bytes>> finish() override { return ranks_.exchange(std::move(outgoing_)); }

  private:
    Communicator& ranks_;
    std::vector<Bytes> outgoing_;
};

std::string textOf(const Bytes& bytes) {
    return std::string(reinterpret_cast<const char*>(bytes.data()), bytes.size());
}

}  // namespace

std::unique_ptr<Exchange> Communicator::begin(std::vector<Bytes> outgoing) {
    return std::make_unique<LateExchange>(*this, std::move(outgoing));
}

std::unique_ptr<Communicator> singleProcess() {
    return std::make_unique<SingleProcess>();
}

Status agree(Communicator& ranks, const Status& mine) {
    if (ranks.size() == 1) return mine;
    // Code, whether it passes, place and sentence, with a zero between these; nothing where all is well.
    std::string text;
    if (!mine.ok()) {
        text += static_cast<char>(mine.error().code);
        text += mine.error().passing ? '1' : '0';
        text += mine.error().where + '\0' + mine.error().message;
    }
    MOTE_ASSIGN_OR_RETURN(const auto all, ranks.share(std::as_bytes(std::span(text))));
    for (const auto& bytes : all) {
        if (bytes.empty()) continue;
        const auto said = textOf(bytes);
        const auto end = said.find('\0', 2);
        return Error{static_cast<ErrorCode>(said[0]), said.substr(2, end - 2), said.substr(end + 1),
                     said[1] == '1'};
    }
    return success();
}

Result<std::string> fromFirst(Communicator& ranks, const std::string& text) {
    MOTE_ASSIGN_OR_RETURN(const auto all,
                          ranks.share(std::as_bytes(std::span(ranks.first() ? text : std::string()))));
    return textOf(all.front());
}

namespace fs = std::filesystem;

Result<SharedDataset> SharedDataset::create(Communicator& ranks, const fs::path& output) {
    std::string name;
    Status status = success();
    if (ranks.first()) {
        const auto chosen = storage::DatasetWriter::choose(output);
        if (!chosen.ok()) status = chosen.error();
        if (chosen.ok()) name = chosen->string();
    }
    MOTE_RETURN_IF_ERROR(agree(ranks, status));
    // The others know its name before it is there.
    MOTE_ASSIGN_OR_RETURN(const auto shared, fromFirst(ranks, name));
    SharedDataset dataset(shared, std::nullopt);
    if (ranks.first()) {
        auto writer = storage::DatasetWriter::create(output, dataset.directory_);
        if (!writer.ok()) status = writer.error();
        if (writer.ok()) dataset.writer_.emplace(*std::move(writer));
    }
    MOTE_RETURN_IF_ERROR(agree(ranks, status));
    return dataset;
}

SharedDataset::SharedDataset(SharedDataset&& other) noexcept
    : directory_(std::exchange(other.directory_, {})), writer_(std::move(other.writer_)) {}

SharedDataset::~SharedDataset() {
    if (directory_.empty() || writer_) return;
    // Several ranks may do so at once, each meeting what another has removed.
    std::error_code code;
    for (int attempt = 0; attempt < 100 && fs::exists(directory_, code); ++attempt) {
        fs::remove_all(directory_, code);
    }
}

}  // namespace mote::prep
