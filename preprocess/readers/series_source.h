// SPDX-License-Identifier: GPL-3.0-or-later
//
// SeriesSource: what readers share whose files are a step each, or several: the order of files, those that
// cannot be read beside others that can, and what a read fills in before its reader does. A reader says how a
// file's steps are added and how rows are read. Owned as ParticleSource says; one thread.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "preprocess/job.h"
#include "preprocess/readers/particle_source.h"
#include "protocol/base/error.h"

namespace mote::prep {

/// The last number in a file's name, its endings left out: 101 of "fort.101.txt.gz", 3 of "beam_0003.csv".
std::optional<std::int64_t> fileNumber(const std::filesystem::path& path);

/// Files by their numbers where all have different ones, else as they are given.
std::vector<std::filesystem::path> inOrder(std::vector<std::filesystem::path> files);
/// The same by another number of theirs.
std::vector<std::filesystem::path> inOrder(
    std::vector<std::filesystem::path> files,
    std::optional<std::int64_t> (*numberOf)(const std::filesystem::path& path));

class SeriesSource : public ParticleSource {
  public:
    std::string format() const final { return format_; }
    const std::vector<SourceStep>& steps() const final { return steps_; }
    bool has(Column column) const final { return has_[static_cast<std::size_t>(column)]; }
    std::vector<SourceRecord> records() const final { return records_; }
    Status read(std::size_t step, std::uint64_t begin, std::size_t count, const std::vector<Column>& wanted,
                ParticleChunk& chunk) final;

  protected:
    SeriesSource(std::string format, Progress& progress) : progress_(progress), format_(std::move(format)) {}

    /// Adds the steps of a file. An error that is of this file alone (corrupt, unsupported, notFound) leaves
    /// it out, with a note, where others are read.
    virtual Status addFile(const std::filesystem::path& path) = 0;
    /// Whether anything was read; else the first error is that of the run.
    virtual bool anyRead() const { return !steps_.empty(); }
    /// What can be done and said once all files are there.
    virtual Status finish() { return success(); }
    /// Whether every step has a column; asked once, after finish().
    virtual bool hasEverywhere(Column column) const = 0;
    /// The records that every step with particles has, each name once; asked once, after finish(). Those
    /// beyond mostRecords are left out, with a note.
    virtual std::vector<SourceRecord> recordsEverywhere() const { return {}; }
    /// What the run calls a record.
    const std::string& recordName(Column column) const {
        return records_[static_cast<std::size_t>(column) - columnCount].name;
    }
    /// Fills rows [chunk.begin, + chunk.size), which the step has, of columns that the run has; until then
    /// nothing is lost, weights are 1 and ids the rows. The other columns have their size.
    virtual Status readRows(std::size_t step, const std::vector<Column>& wanted, ParticleChunk& chunk) = 0;

    /// A step numbered as the file is, else by its place among the steps.
    SourceStep stepOf(const std::filesystem::path& file, std::uint64_t particles, double time = 0.0) const;
    /// For an error of a single step: kept for a note, passed on where it is of the whole run (cancelled, a
    /// wrong option, no memory).
    Status leaveOut(const Status& opened);
    void noteOnce(const std::string& sentence) {
        if (noted_.insert(sentence).second) progress_.note(sentence);
    }
    /// Puts the steps, and what is kept for each, in the order of their iterations.
    template <class Place>
    void sortByIteration(std::vector<Place>& places);

    Progress& progress_;
    std::vector<SourceStep> steps_;

  private:
    friend Result<std::unique_ptr<ParticleSource>> openSeries(
        std::unique_ptr<SeriesSource> source, const std::vector<std::filesystem::path>& files);

    std::vector<std::size_t> orderOfIterations() const;
    Status noteLeftOut() const;

    std::string format_;
    bool has_[columnCount] = {};
    std::vector<SourceRecord> records_;
    std::set<std::string> noted_;
    std::optional<Error> firstOdd_;
    std::size_t odd_ = 0;
};

/// The source with all files added, in this order. Errors: those of its addFile and finish; cancelled.
Result<std::unique_ptr<ParticleSource>> openSeries(std::unique_ptr<SeriesSource> source,
                                                   const std::vector<std::filesystem::path>& files);

template <class Place>
void SeriesSource::sortByIteration(std::vector<Place>& places) {
    std::vector<SourceStep> steps;
    std::vector<Place> sorted;
    for (const std::size_t i : orderOfIterations()) {
        steps.push_back(std::move(steps_[i]));
        sorted.push_back(std::move(places[i]));
    }
    steps_ = std::move(steps);
    places = std::move(sorted);
}

}  // namespace mote::prep
