// SPDX-License-Identifier: GPL-3.0-or-later
//
// JobLife: where a job is in its life, and what follows from what happens to it. A value and a pure function:
// it knows no files, no processes and no clock, and the queue does what it says.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace mote::server {

struct JobLife {
    enum class Stage {
        waits,   ///< for its turn
        pauses,  ///< likewise, but has no turn for a while
        starts,  ///< its runner makes a run, which has not begun
        runs,
        unsure,  ///< nobody can see now whether it runs
        over,    ///< its run has ended, and nobody has seen yet what came of it
        succeeded,
        failed,
        cancelled,
    };

    Stage stage = Stage::waits;
    bool keepsFiles = false;  ///< what it makes stays with it, as a film does
    bool cancelled = false;   ///< a client has asked for its end
    int mostAttempts = 2;     ///< interrupted in the last of so many, it fails
    int attempts = 0;         ///< how often a run has begun, those that found no room left out
    int interrupted = 0;      ///< how often it waits again as others ended its run
    int roomless = 0;         ///< how often a run found no room

    bool operator==(const JobLife&) const = default;
};

/// A run that found no room is tried so often: a quarter of an hour, for a disk that someone must clear.
inline constexpr int mostRoomless = 12;

enum class JobEvent {
    chosen,   ///< it is its turn
    held,     ///< it cannot begin now, nor can any other: the place is at fault
    denied,   ///< it cannot begin now, and others may
    refused,  ///< it can never begin
    begun,    ///< there is a run, which waits for its word
    rested,   ///< its pause is over
    cancel,   ///< a client wants its end, or what it has made to go
    found,    ///< its run is there
    gone,     ///< its run is not there any more
    hidden,   ///< whether it runs, or what came of it, cannot be seen now
    made,     ///< what came of it: all that was wanted
    broken,   ///< it failed by itself, or ran into a limit
    taken,    ///< others ended it
    roomless  ///< it found no room for its output
};

/// What is to be done, in this order, when the change is stored.
enum class JobDeed {
    start,      ///< has its runner make a run
    go,         ///< lets the run begin, and waits for its end
    drop,       ///< lets it never begin
    watch,      ///< waits for the end of a run that was found
    stop,       ///< tells the run to end
    look,       ///< looks what came of it
    lookLater,  ///< tries again after a while
    hold,       ///< begins nothing for a while
    rest,       ///< begins its pause
    clear,      ///< takes away what nobody needs after its end
};

struct JobStep {
    JobLife life;
    std::vector<JobDeed> deeds = {};
    std::string error = {};  ///< why it failed
};

/// `why`: a sentence, where something is at fault. What cannot happen in a stage changes nothing.
JobStep next(const JobLife& life, JobEvent event, std::string_view why = {});

/// Whether it waits or runs.
bool isLive(JobLife::Stage stage);
/// Whether it takes one of the places for those that run: it runs, or may.
bool takesPlace(JobLife::Stage stage);

}  // namespace mote::server
