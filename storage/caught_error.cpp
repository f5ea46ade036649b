// SPDX-License-Identifier: GPL-3.0-or-later
#include "storage/caught_error.h"

#include <new>
#include <utility>

#include "storage/storage_error.h"

namespace mote::storage {

Error caughtError(Error shortage) {
    try {
        throw;
    } catch (const StorageError& failure) {
        return failure.error();
    } catch (const std::bad_alloc&) {
        return shortage;
    } catch (const std::exception& failure) {
        return {ErrorCode::internal, std::move(shortage.where), failure.what()};
    }
}

}  // namespace mote::storage
