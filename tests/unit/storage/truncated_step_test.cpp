// SPDX-License-Identifier: GPL-3.0-or-later
//
// A step whose file is truncated while it is mapped: in every array, before and after its first use.
#include <gmock/gmock.h>

#include <numeric>

#include "storage/blocks/mapped_file.h"
#include "storage/manifest.h"
#include "storage/particles/particle_step.h"
#include "storage/particles/step_layout.h"
#include "storage/storage_error.h"
#include "tests/support/temp_dir.h"
#include "tests/unit/storage/forged_digest.h"
#include "tests/unit/storage/tiny_dataset.h"

namespace mote::storage {
namespace {

template <class T>
double touch(std::span<const T> values) {
    const auto bytes = std::as_bytes(values);
    return std::accumulate(bytes.begin(), bytes.end(), 0.0,
                           [](double sum, std::byte byte) { return sum + static_cast<double>(byte); });
}

/// Reads every byte that a renderer may read.
double readAll(const ParticleStep& step) {
    const auto nodes = step.nodes();
    const auto leaves = step.leaves();
    const auto preview = step.preview(Preview::mostPoints);
    return touch(nodes.level) + touch(nodes.morton) + touch(nodes.firstChild) + touch(nodes.childCount) +
           touch(nodes.count) + touch(nodes.density) + touch(nodes.minDensity) + touch(leaves.node) +
           touch(leaves.pointBegin) + touch(leaves.pointCount) + touch(leaves.density) +
           touch(step.positions(0, step.pointCount())) + touch(step.rows(0, step.pointCount())) +
           touch(step.volume()) + touch(preview.points) + touch(preview.threshold);
}

class TruncatedStep : public testing::TestWithParam<std::size_t> {
  protected:
    TruncatedStep() {
        catchMappingFaults();
        test::TinyDataset().write(dataset_);
        step_ = *ParticleStep::open(dataset_, *readManifest(dataset_), 0);
        const auto digest = test::digestOf(dataset_);
        end_ = digest.arrays(static_cast<int>(GetParam())).offset();
    }

    void truncate() { std::filesystem::resize_file(dataset_ / "step-000000.h5", end_); }

    void expectDamage(const std::function<void()>& use) {
        try {
            use();
            FAIL() << "nothing was thrown";
        } catch (const StorageError& error) {
            EXPECT_EQ(error.error().code, ErrorCode::corrupt);
            EXPECT_THAT(error.error().toString(), testing::HasSubstr("step-000000.h5"));
            EXPECT_THAT(error.error().message, testing::HasSubstr("byte "));
        }
    }

    test::TempDir folder_;
    const std::filesystem::path dataset_ = folder_ / "tiny.mote";
    std::shared_ptr<const ParticleStep> step_;
    std::uint64_t end_ = 0;
};

TEST_P(TruncatedStep, BeforeItsFirstUse) {
    truncate();
    expectDamage([&] {
        readAll(*step_);
        step_->check();
    });
    EXPECT_THROW(step_->check(), StorageError);
}

TEST_P(TruncatedStep, AfterAllWasVerified) {
    const double whole = readAll(*step_);
    EXPECT_NO_THROW(step_->check());
    EXPECT_EQ(readAll(*step_), whole);
    truncate();
    // What the accessors return may be zeros now: that is found out at the end of the picture at the latest.
    expectDamage([&] {
        readAll(*step_);
        step_->check();
    });
}

TEST_P(TruncatedStep, AfterASpanWasTaken) {
    readAll(*step_);
    const auto positions = step_->positions(0, step_->pointCount());
    const auto volume = step_->volume();
    truncate();
    touch(positions);
    touch(volume);
    expectDamage([&] { step_->check(); });
}

INSTANTIATE_TEST_SUITE_P(Everywhere, TruncatedStep, testing::Range<std::size_t>(0, stepArrays.size()),
                         [](const auto& at) {
                             std::string name = stepArrays[at.param].name;
                             name.erase(std::remove_if(name.begin(), name.end(),
                                                       [](char c) { return !std::isalnum(c); }),
                                        name.end());
                             return name;
                         });

}  // namespace
}  // namespace mote::storage
