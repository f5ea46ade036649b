// SPDX-License-Identifier: GPL-3.0-or-later
//
// ViewReport: what a run over many views came to: how many died, how near the pictures were, the worst of
// them, and how long it took. One owner, one thread.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "tests/views/verdict.h"

namespace mote::test {

class ViewReport {
  public:
    explicit ViewReport(std::string check) : check_(std::move(check)) {}

    void add(const std::string& view, const Verdict& verdict);
    std::string toString() const;
    /// No view died or was broken; pictures are as near as they have to be.
    bool good() const;

  private:
    /// Whether it is of how near pictures are to others.
    bool byNearness() const { return check_ == "difference" || check_ == "dissolve"; }
    std::size_t count(Verdict::Kind kind) const;
    std::string nearness() const;
    std::string steps() const;

    std::string check_;
    std::vector<std::pair<std::string, Verdict>> verdicts_;
};

}  // namespace mote::test
