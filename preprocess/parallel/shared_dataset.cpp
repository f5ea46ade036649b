// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/parallel/shared_dataset.h"

#include <utility>

namespace mote::prep {

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
