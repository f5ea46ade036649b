// SPDX-License-Identifier: GPL-3.0-or-later
#include "storage/files/writeback.h"

#include <utility>

#include "storage/files/dataset_file.h"

namespace mote::storage {
namespace {

constexpr std::size_t mostUnderWay = 4;

}  // namespace

void Writeback::begin(std::filesystem::path path) {
    while (underWay_.size() >= mostUnderWay) finishFirst();
    underWay_.push_back(std::async(std::launch::async, [path = std::move(path)] { return syncPath(path); }));
}

Status Writeback::finish() {
    while (!underWay_.empty()) finishFirst();
    return std::exchange(failed_, success());
}

void Writeback::finishFirst() {
    // The kernel tells an error of the disk once: it must not get lost here.
    const Status status = underWay_.front().get();
    underWay_.pop_front();
    if (failed_.ok()) failed_ = status;
}

}  // namespace mote::storage
