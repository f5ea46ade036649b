// SPDX-License-Identifier: GPL-3.0-or-later
//
// StorageError: thrown if a file of ours cannot be made, or an array of ours differs from its digest while
// it is in use. Carries an Error (code, file and position, sentence). May be thrown on any thread.
#pragma once

#include <stdexcept>

#include "protocol/base/error.h"

namespace mote::storage {

class StorageError : public std::runtime_error {
  public:
    explicit StorageError(Error error) : std::runtime_error(error.toString()), error_(std::move(error)) {}
    const Error& error() const { return error_; }

  private:
    Error error_;
};

}  // namespace mote::storage
