// SPDX-License-Identifier: GPL-3.0-or-later
//
// WorkInTurns: work that may be interrupted where it is deep in loops of its own. It has a thread of its own,
// which goes on while its owner lets it, and comes to a halt where it calls giveWay() and its turn is over.
// Work and owner never go on at the same time, so that they share what is one thread's.
#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <stop_token>
#include <thread>

namespace mote::render {

class WorkInTurns {
  public:
    using Duration = std::chrono::steady_clock::duration;
    /// Worth its change of threads, and short beside what a screen waits for.
    static constexpr std::chrono::milliseconds shortTurn{3};

    /// What its threads share.
    class Gate;

    /// Nothing is done yet. `least`: that a turn takes, whoever waits; zero: it ends at the next giveWay().
    explicit WorkInTurns(std::function<void()> work, Duration least = shortTurn);
    /// Work that is not done ends where it is: giveWay() throws there what is no std::exception. Any thread.
    ~WorkInTurns();
    WorkInTurns(const WorkInTurns&) = delete;
    WorkInTurns& operator=(const WorkInTurns&) = delete;

    /// Goes on until the work is done or, where `pause` is requested, gives way. Whether it is done. Throws
    /// what it threw. Where there is no thread for it, all of it is done at once on this one.
    bool advance(const std::stop_token& pause);

  private:
    bool begin();
    void run();

    const std::function<void()> work_;
    const std::unique_ptr<Gate> gate_;
    std::thread thread_;
};

/// Where work may be interrupted. Of no effect on threads that do not work in turns, here and below.
void giveWay();
/// giveWay(), and whether a stop is requested.
bool isStopped(const std::stop_token& stop);
/// How long this thread's work waited for its turns.
WorkInTurns::Duration timeOfOthers();

/// What only the owner's thread may do: it calls `step` in its turns, until that returns true. On threads
/// that do not work in turns `step` is called once, with `pause`. Whether it returned true. Throws what it
/// throws.
using OwnersStep = std::function<bool(const std::stop_token& pause)>;
bool byOwner(const OwnersStep& step, const std::stop_token& pause);

/// Both at the same time, each of which may give way. Throws what one of them throws.
void bothInTurns(const std::function<void()>& one, const std::function<void()>& other);

/// While it lives, this thread gives way by its word alone: it shares its work with threads that cannot.
class Undisturbed {
  public:
    Undisturbed();
    ~Undisturbed();
    Undisturbed(const Undisturbed&) = delete;
    Undisturbed& operator=(const Undisturbed&) = delete;

    bool inTurns() const { return gate_ != nullptr; }
    /// Both only in turns. Any thread of its work; this one.
    bool isOver() const;
    void giveWay();

  private:
    WorkInTurns::Gate* const gate_;
};

}  // namespace mote::render
