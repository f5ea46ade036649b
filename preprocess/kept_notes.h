// SPDX-License-Identifier: GPL-3.0-or-later
//
// KeptNotes: a Progress that passes on what it is told, each sentence once, and keeps the notes for the
// manifest: what was assumed, changed or left out stays with the dataset. One owner; note() is asked by one
// thread at a time.
#pragma once

#include <algorithm>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "preprocess/job.h"
#include "protocol/base/utf8.h"

namespace mote::prep {

class KeptNotes final : public Progress {
  public:
    static constexpr std::size_t most = 100, longest = 1000;

    /// `before`: notes that were said already, of a dataset that goes on.
    explicit KeptNotes(Progress& progress, std::vector<std::string> before = {})
        : progress_(progress), notes_(std::move(before)) {}
    void report(double fraction, std::string_view phase) override { progress_.report(fraction, phase); }
    bool cancelled() const override { return progress_.cancelled(); }
    void note(std::string_view sentence) override {
        auto text = toTerminalText(sentence.substr(0, longest));  // names in it are the file's
        if (std::ranges::count(notes_, text) > 0) return;
        progress_.note(sentence);
        if (notes_.size() < most) notes_.push_back(std::move(text));
    }
    const std::vector<std::string>& notes() const { return notes_; }

  private:
    Progress& progress_;
    std::vector<std::string> notes_;
};

}  // namespace mote::prep
