// SPDX-License-Identifier: GPL-3.0-or-later
//
// One picture, drawn by all ranks: each adds up the points of its own leaves; where depth matters, it sends
// their cells to the owners of the tiles, who composite them with the volumes, which every rank has. Sums do
// not depend on which rank's points lie in front: no order of the ranks is needed. All ranks call it alike.
#pragma once

#include <exception>
#include <new>
#include <optional>
#include <stop_token>

#include "protocol/scene/error.h"
#include "server/render/cpu/cpu_parts.h"
#include "server/render/ranks/frame_order.h"
#include "server/render/ranks/ranks.h"
#include "storage/storage_error.h"

namespace mote::render {

/// Agreement: how a picture goes on or ends on all ranks alike, though one of them fails or the picture is
/// stopped. One a picture and rank; one thread.
class Agreement {
  public:
    explicit Agreement(Ranks& ranks) : ranks_(ranks) {}

    /// Does this rank's work, unless some of it failed before. What is thrown waits for all().
    template <class Work>
    void attempt(Work work) {
        if (error_) return;
        try {
            work();
        } catch (const storage::StorageError& failure) {
            error_ = failure.error();
        } catch (const std::bad_alloc&) {
            error_ = Error{ErrorCode::resourceExhausted, "view", "there is not enough memory to draw it"};
        } catch (const std::exception& failure) {
            error_ = Error{ErrorCode::internal, "view", failure.what()};
        }
    }

    /// All ranks call it: whether they go on. Not where one of them failed, or `stop` was requested on one.
    bool all(const std::stop_token& stop);

    /// The first failure, naming its rank, on rank 0 once all() said no; nothing where it was a stop.
    const std::optional<Error>& failure() const { return error_; }

  private:
    void collectErrors();

    Ranks& ranks_;
    std::optional<Error> error_;
};

/// Leaves in the order's plan what this rank draws of it; of points that stand alone, all.
void keepOwnPoints(FrameOrder& order, const Ranks& ranks);

/// The picture on rank 0, or nothing where `agreement` did not go on; nothing on the others. `order`: with
/// the rank's own steps and leaves, unless something failed before, which `agreement` knows.
std::optional<Picture> drawTogether(Ranks& ranks, CpuParts& parts, const FrameOrder& order,
                                    Agreement& agreement, const std::stop_token& stop);

}  // namespace mote::render
