// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/unit/damage/rewritten_dataset.h"

#include <atomic>
#include <memory>
#include <thread>
#include <vector>

#include "storage/blocks/mapped_file.h"
#include "tests/unit/damage/rewritten_file.h"

namespace mote::test {
namespace {

using Files = std::vector<std::unique_ptr<RewrittenFile>>;

Files filesOf(const DamagedDataset& dataset) {
    Files files;
    for (const auto& [name, bytes] : dataset.files())
        files.push_back(std::make_unique<RewrittenFile>(dataset.path() / name));
    return files;
}

void change(const RewrittenFile& file, const std::string& other, Random& random) {
    if (random.chance(0.25)) return file.cutOff(random.below(file.original().size()));
    disturb(file, other, random);
}

/// Waits for a moment, shorter ones as likely as longer ones, and changes the files until the answer is
/// there.
std::uint64_t disturbUntil(const std::atomic<bool>& answered, const Files& files, Random random) {
    constexpr int longest = 13;  // yields, as a power of two: some milliseconds
    constexpr std::uint64_t most = 6;
    for (auto left = random.magnitude(0, longest); left > 0.0 && !answered; left -= 1.0)
        std::this_thread::yield();
    const auto wanted = 1 + random.below(most);
    std::uint64_t writes = 0;
    for (; writes < wanted && !answered; ++writes) {
        const auto& other = files[random.below(files.size())]->original();
        change(*files[random.below(files.size())], other, random);
    }
    return writes;
}

}  // namespace

std::uint64_t askWhileRewritten(DamagedDataset& dataset, std::uint64_t questions, std::uint64_t seed) {
    storage::catchMappingFaults();
    const auto files = filesOf(dataset);
    Random random(seed, 21);
    std::uint64_t writes = 0;
    for (std::uint64_t i = 0; i < questions; ++i) {
        std::atomic<bool> answered{false};
        std::thread writer([&, own = Random(seed, 22 + i)] { writes += disturbUntil(answered, files, own); });
        dataset.ask(random);
        answered = true;
        writer.join();
        for (const auto& file : files) file->restore();
    }
    return writes;
}

}  // namespace mote::test
