// SPDX-License-Identifier: GPL-3.0-or-later
//
// NotedProgress: another's Progress, that keeps what is noted for the manifest: what was assumed, changed or
// left out stays with the dataset. Owned by who runs the job; note() from one thread at a time.
#pragma once

#include <algorithm>
#include <string>
#include <vector>

#include "preprocess/job.h"
#include "protocol/scene/utf8.h"

namespace mote::prep {

class NotedProgress final : public Progress {
  public:
    static constexpr std::size_t mostNotes = 100, longestNote = 1000;

    explicit NotedProgress(Progress& to) : to_(to) {}

    void report(double fraction, std::string_view phase) override { to_.report(fraction, phase); }
    void note(std::string_view sentence) override {
        to_.note(sentence);
        // Names in it are the file's.
        auto text = toTerminalText(sentence.substr(0, longestNote));
        if (notes_.size() < mostNotes && std::ranges::count(notes_, text) == 0)
            notes_.push_back(std::move(text));
    }
    bool cancelled() const override { return to_.cancelled(); }

    const std::vector<std::string>& notes() const { return notes_; }

  private:
    Progress& to_;
    std::vector<std::string> notes_;
};

}  // namespace mote::prep
