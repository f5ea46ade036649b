// SPDX-License-Identifier: GPL-3.0-or-later
//
// Loadable: something of a dataset that is loaded whole: a step of a hybrid volume, a stippled surface, an
// image. It says what tells it from all else, how much memory it takes, and how it is read; Residency brings
// it in. A value; `load` is called on other threads than the one that asks.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <typeindex>
#include <utility>

#include "protocol/base/error.h"
#include "storage/catalogue.h"

namespace mote::server {

/// Something that is in memory, and the bytes that it takes there.
struct Resident {
    std::shared_ptr<const void> value;
    std::uint64_t bytes = 0;
};

/// A Loadable of any type.
struct AnyLoadable {
    using Cancelled = std::function<bool()>;

    storage::Catalogue::Entry dataset;  ///< its manifest tells it from a later one of its name
    std::type_index type;               ///< of the value
    int part = 0;                       ///< which one, if a step has several of the type
    std::string key = {};               ///< which one, if more than a number tells: a selection, a column
    std::uint32_t step = 0;
    int steps = 1;  ///< of its series, at least one; those that come next are loaded ahead while it is played

    /// An estimate from the manifest of the bytes that a step takes while it is loaded, at most.
    std::function<std::uint64_t(std::uint32_t step)> expected;
    /// Reads a step. Errors: of the files; cancelled.
    std::function<Result<Resident>(std::uint32_t step, const Cancelled&)> load;

    bool sameAs(const AnyLoadable& other) const {
        return dataset.manifest == other.dataset.manifest && type == other.type && part == other.part &&
               step == other.step && key == other.key;
    }
};

template <class T>
struct Loadable : AnyLoadable {
    using Value = std::shared_ptr<const T>;
    using Load = std::function<Result<Value>(std::uint32_t step, const Cancelled&)>;

    /// T says in bytes() how much it takes.
    // clang-tidy sees no move in a template: NOLINTNEXTLINE(performance-unnecessary-value-param)
    Loadable(storage::Catalogue::Entry entry, std::function<std::uint64_t(std::uint32_t)> expects, Load read)
        : AnyLoadable{.dataset = std::move(entry),
                      .type = typeid(T),
                      .expected = std::move(expects),
                      .load = withBytes(std::move(read))} {}

  private:
    static auto withBytes(Load read) {
        return [read = std::move(read)](std::uint32_t step, const Cancelled& cancelled) -> Result<Resident> {
            MOTE_ASSIGN_OR_RETURN(auto value, read(step, cancelled));
            const std::uint64_t bytes = value->bytes();
            return Resident{std::move(value), bytes};
        };
    }
};

}  // namespace mote::server
