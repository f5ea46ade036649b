// SPDX-License-Identifier: GPL-3.0-or-later
//
// What the tests of the readers share: a Progress that keeps its notes, and short ways to open and to read.
// Values and functions without state.
#pragma once

#include <gtest/gtest.h>

#include <atomic>
#include <filesystem>
#include <fstream>
#include <memory>
#include <string>
#include <vector>

#include "preprocess/readers/particle_source.h"
#include "tests/support/temp_dir.h"

namespace mote::test {

class NoteKeeper : public prep::Progress {
  public:
    void report(double, std::string_view) override {}
    void note(std::string_view sentence) override { notes.emplace_back(sentence); }
    bool cancelled() const override { return cancel; }

    bool noted(std::string_view part) const {
        for (const std::string& note : notes) {
            if (note.find(part) != std::string::npos) return true;
        }
        return false;
    }

    std::vector<std::string> notes;
    std::atomic<bool> cancel = false;
};

/// What tests of readers have: a folder for files, and what is noted while they are read.
struct SourceTest : testing::Test {
    TempDir folder;
    NoteKeeper progress;
};

using OpenResult = Result<std::unique_ptr<prep::ParticleSource>>;

inline OpenResult openFiles(const std::vector<std::filesystem::path>& files, NoteKeeper& progress,
                            const proto::ParticlesJob& job = {}) {
    return prep::openParticleSource(job, files, progress);
}

/// The error of opening files and reading all of them; no code where there is none.
inline std::string errorOf(const std::vector<std::filesystem::path>& files,
                           const proto::ParticlesJob& job = {}) {
    NoteKeeper progress;
    auto source = openFiles(files, progress, job);
    if (!source) return std::string(name(source.error().code)) + ": " + source.error().toString();
    for (std::size_t step = 0; step < (*source)->steps().size(); ++step) {
        std::vector<prep::Column> wanted;
        for (std::size_t i = 0; i < prep::columnCount; ++i) {
            const auto column = static_cast<prep::Column>(i);
            if ((*source)->has(column)) wanted.push_back(column);
        }
        prep::ParticleChunk chunk;
        const std::uint64_t rows = std::min<std::uint64_t>((*source)->steps()[step].particles, 1u << 22);
        const auto status = (*source)->read(step, 0, rows, wanted, chunk);
        if (!status) return std::string(name(status.error().code)) + ": " + status.error().toString();
    }
    return "";
}

/// All of a step's rows of one column.
inline std::vector<double> column(prep::ParticleSource& source, std::size_t step, prep::Column wanted) {
    prep::ParticleChunk chunk;
    const auto status = source.read(step, 0, source.steps().at(step).particles, {wanted}, chunk);
    EXPECT_TRUE(status.ok()) << (status.ok() ? "" : status.error().toString());
    return chunk[wanted];
}

/// All of a step's rows of a record; none where there is none of this name and unit.
inline std::vector<double> record(prep::ParticleSource& source, std::size_t step, std::string_view name,
                                  std::string_view unit = "1") {
    const auto records = source.records();
    for (std::size_t i = 0; i < records.size(); ++i) {
        if (records[i].name == name && records[i].unit == unit)
            return column(source, step, prep::recordColumn(i));
    }
    return {};
}

inline prep::ParticleChunk chunkOf(prep::ParticleSource& source, std::size_t step,
                                   const std::vector<prep::Column>& wanted) {
    prep::ParticleChunk chunk;
    const auto status = source.read(step, 0, source.steps().at(step).particles, wanted, chunk);
    EXPECT_TRUE(status.ok()) << (status.ok() ? "" : status.error().toString());
    return chunk;
}

inline void writeFile(const std::filesystem::path& path, std::string_view bytes) {
    std::ofstream(path, std::ios::binary).write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
}

}  // namespace mote::test

/// Opens files into the variable `source`, a std::unique_ptr<ParticleSource>, or ends the test with the
/// error.
#define MOTE_OPEN(source, ...)                                                                          \
    auto source##Result = mote::test::openFiles(__VA_ARGS__);                                           \
    ASSERT_TRUE(source##Result.ok()) << (source##Result.ok() ? "" : source##Result.error().toString()); \
    auto source = std::move(source##Result).value()
