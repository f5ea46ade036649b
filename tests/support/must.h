// SPDX-License-Identifier: GPL-3.0-or-later
//
// Results of which the error is thrown: as what reads a dataset of somebody else ends.
#pragma once

#include <utility>

#include "protocol/base/error.h"
#include "storage/storage_error.h"

namespace mote::test {

template <class T>
T must(Result<T> result) {
    if (!result.ok()) throw storage::StorageError(result.error());
    return *std::move(result);
}

inline void must(const Status& status) {
    if (!status.ok()) throw storage::StorageError(status.error());
}

}  // namespace mote::test
