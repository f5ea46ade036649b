// SPDX-License-Identifier: GPL-3.0-or-later
//
// JobSettings: where a server keeps its jobs and what each may use. A value.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace mote::server {

struct JobSettings {
    std::filesystem::path stateDirectory;  ///< made (0700) where absent; holds jobs.sqlite, jobs/ID/, film/
    std::filesystem::path prep;            ///< the program mote-prep
    std::filesystem::path frames;          ///< mote-frames; empty: beside `prep`
    std::filesystem::path supervisor;      ///< mote-supervise; empty: beside `prep`
    std::vector<std::string> roots;        ///< "NAME=DIR", as the server's --root
    std::size_t running = 1;       ///< jobs that may run at a time, at least 1; and one film beside them
    std::size_t queued = 1000;     ///< jobs that may wait
    std::size_t kept = 1000;       ///< finished jobs that are remembered
    std::uint64_t memory = 0;      ///< bytes for each job; 0: no limit
    unsigned threads = 0;          ///< of each job, or rank of it; 0: its own choice
    bool allowUnconfined = false;  ///< jobs run even where the kernel cannot confine them
    std::string runner = "local";  ///< of what makes datasets and exports: "local", "mpi" or "slurm"
    unsigned ranks = 1;            ///< processes of a job whose kind can have several, of mpi and slurm
    std::uint32_t timeLimit = 0;   ///< s, of a run; 0: none
    std::chrono::milliseconds slurmPoll{1000};  ///< how often Slurm is asked
    /// Before a job is tried again whose run found no place for its output; then twice as long each time.
    std::chrono::milliseconds placePause{1000};
};

/// The connection file that film jobs read. It has a folder of its own, made by the queue: a process that may
/// read that folder finds the file of the next server there too.
inline std::filesystem::path filmConnectionFile(const std::filesystem::path& stateDirectory) {
    return stateDirectory / "film" / "connection.json";
}

}  // namespace mote::server
