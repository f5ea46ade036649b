// SPDX-License-Identifier: GPL-3.0-or-later
//
// PointOutput: the points of a built step, from the ranks that have them to their places in the file, window
// by window; and the preview, whose candidates are gathered on the way and put in order by each rank some.
// One object a step and rank, used from one thread; works on all threads of its arena.
#pragma once

#include <functional>
#include <span>
#include <vector>

#include "preprocess/particles/preview_selection.h"
#include "preprocess/particles/range_builder.h"
#include "preprocess/particles/step_builder.h"
#include "storage/particles/particle_step.h"
#include "storage/particles/step_file.h"

namespace mote::prep {

class PointOutput {
  public:
    /// All references outlive this.
    PointOutput(const BuiltStep& step, const storage::StepFile& file, Communicator& ranks,
                std::function<bool()> cancelled);

    /// Writes the points of all windows. Errors: resourceExhausted (disk full), cancelled, internal; the same
    /// on all ranks.
    Status run();

    /// Writes the preview, after run(). Errors: as run().
    Status writePreview();

  private:
    /// Points of the file that are gathered and written at once.
    struct Window {
        std::uint64_t begin, end;
    };
    /// A thread's memory.
    struct Worker {
        std::vector<LeafPoint> gathered;
        std::vector<storage::PackedPosition> positions;
        std::vector<std::uint64_t> rows;
    };

    std::size_t own() const { return static_cast<std::size_t>(ranks_.rank()); }
    std::size_t windowCount() const;
    Window window(std::size_t index) const;
    template <class Use>
    void forEachPart(const Window& window, Use use) const;
    std::size_t rankOf(std::size_t leaf) const;
    Status runAlone();
    Status runRound(std::size_t first, std::size_t last);
    Result<std::vector<Bytes>> gatherRound(std::size_t first, std::size_t last);
    std::uint64_t ownPoints(const Window& window) const;
    Status gather(const Window& window, std::span<std::byte> to) const;
    Status write(std::size_t index, std::vector<std::span<const LeafPoint>> streams, Worker& worker);
    std::vector<Bytes> slices();
    Status writePreview(const std::vector<std::span<const PreviewCandidate>>& lists);
    Status write(const BuiltPreview& preview);

    const BuiltStep& step_;
    const storage::StepFile& file_;
    Communicator& ranks_;
    std::function<bool()> cancelled_;
    PreviewSelection selection_;
    std::vector<std::vector<PreviewCandidate>> candidates_;  ///< by window
};

}  // namespace mote::prep
