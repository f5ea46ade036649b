// SPDX-License-Identifier: GPL-3.0-or-later
//
// VerifiedArray: one array of a mapped file whose MiB blocks are held to their digest at their first use.
// Safe to use from any number of threads; two that meet at a fresh block may both hash it, which does no
// harm.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "protocol/mote.pb.h"
#include "protocol/scene/error.h"

namespace mote::storage {

class VerifiedArray {
  public:
    /// `file` is the file's name for messages, `bytes` its whole mapping, which must outlive this. Errors:
    /// corrupt, where the digest contradicts itself or the file's size.
    static Result<VerifiedArray> make(std::string file, std::span<const std::byte> bytes,
                                      const proto::DigestArray& digest);

    /// Slowest first.
    const std::vector<std::uint64_t>& shape() const { return shape_; }
    const std::string& type() const { return type_; }
    /// Elements.
    std::uint64_t size() const;

    /// Elements [begin, begin + count), their blocks verified; T is what type() says. Throws StorageError
    /// (corrupt, with file, array and offset).
    template <class T>
    std::span<const T> get(std::uint64_t begin, std::uint64_t count) const {
        verify(begin * sizeof(T), count * sizeof(T));
        return {reinterpret_cast<const T*>(bytes_.data()) + begin, count};
    }
    template <class T>
    std::span<const T> all() const {
        return get<T>(0, bytes_.size() / sizeof(T));
    }

    std::size_t blockCount() const { return blocks_.size(); }
    /// Hashes one block, whether or not it was verified before; the Error names file, array and offset.
    std::optional<Error> checkBlock(std::size_t block) const;

  private:
    VerifiedArray() = default;
    void verify(std::uint64_t offset, std::uint64_t length) const;

    std::string where_;  ///< "DIR/step-000000.h5:/points/position"
    std::string type_;
    std::vector<std::uint64_t> shape_;
    std::uint64_t offset_ = 0;  ///< of bytes_ in the file
    std::span<const std::byte> bytes_;
    std::vector<std::uint64_t> blocks_;
    std::unique_ptr<std::atomic<std::uint64_t>[]> verified_;  ///< one bit a block
};

}  // namespace mote::storage
