// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/data/step_cache.h"

#include <algorithm>
#include <utility>

#include "protocol/base/most_recent.h"
#include "storage/manifest.h"
#include "storage/storage_error.h"

namespace mote::server {
namespace {

/// Devices keep their own form of an open step's volume and octree: all that are open take no more of these
/// together than this share of the budget.
constexpr std::uint64_t openShare = 2;

bool ready(const storage::MappedStep& step, const storage::StepNeed& need) {
    if (need.octree && !step.octreeReady()) return false;
    if (need.volume && !step.volumeReady()) return false;
    if (step.previewReady(need.preview) < need.preview) return false;
    return std::all_of(need.points.begin(), need.points.end(), [&](const storage::PointRange& range) {
        const auto begin = std::min(range.begin, step.pointCount());
        const auto count = std::min(range.count, step.pointCount() - begin);
        return step.positionsReady(begin, count) == count;
    });
}

/// The same share of another step's points.
storage::StepNeed scaled(storage::StepNeed need, std::uint64_t from, std::uint64_t to) {
    const double factor = from == 0 ? 1.0 : static_cast<double>(to) / static_cast<double>(from);
    for (auto& range : need.points) {
        range.begin = static_cast<std::uint64_t>(static_cast<double>(range.begin) * factor);
        range.count = static_cast<std::uint64_t>(static_cast<double>(range.count) * factor) + 1;
    }
    return need;
}

/// Whether a step looks the same in both: its file and the scale of densities are.
bool sameStep(const proto::Manifest& one, const proto::Manifest& other, std::uint32_t index) {
    const auto step = static_cast<int>(index);
    const auto& left = one.particles();
    const auto& right = other.particles();
    if (step >= left.steps_size() || step >= right.steps_size()) return false;
    if (left.density_min() != right.density_min() || left.density_max() != right.density_max()) return false;
    const auto* const file = storage::findFile(one, left.steps(step).file());
    const auto* const same = storage::findFile(other, right.steps(step).file());
    return file != nullptr && same != nullptr && file->name() == same->name() &&
           file->xxh3_128() == same->xxh3_128();
}

constexpr std::size_t readAhead = 8;  // blocks that the disk is asked for before their turn

}  // namespace

StepLoader::StepLoader(std::shared_ptr<storage::BlockBudget> budget, unsigned threads,
                       std::function<void()> arrived)
    : budget_(std::move(budget)),
      arrived_(std::move(arrived)),
      threads_(threads, [this] { return loadOne(); }) {}

bool StepLoader::want(const std::shared_ptr<const storage::MappedStep>& step, const storage::StepNeed& need,
                      Urgency urgency) {
    auto task = std::make_shared<Task>(Task{.step = step,
                                            .key = step.get(),
                                            .ahead = step->aheadOf(need),
                                            .need = need,
                                            .urgency = urgency,
                                            .generation = budget_->generation()});
    if (!task->ahead.empty()) task->block = task->ahead.front().first;
    {
        const std::lock_guard lock(mutex_);
        const bool tried = std::any_of(beyond_.begin(), beyond_.end(), [&](const auto& other) {
            return other->step.lock() == step && other->need == need;
        });
        if (tried) return false;
        forget(task->key);
        if (task->ahead.empty()) return true;
        const auto place = std::find_if(tasks_.begin(), tasks_.end(),
                                        [&](const auto& other) { return other->urgency >= urgency; });
        tasks_.insert(place, std::move(task));
    }
    threads_.wake();
    return true;
}

/// Under the mutex. A new step may stand at the address of one that is gone: both go.
void StepLoader::forget(const storage::MappedStep* step) {
    const auto outdated = [&](const auto& other) { return other->key == step || other->step.expired(); };
    tasks_.remove_if(outdated);
    beyond_.remove_if(outdated);
}

std::size_t StepLoader::waiting() const {
    const std::lock_guard lock(mutex_);
    return tasks_.size();
}

/// Under the mutex: the next piece of the most urgent task that has one.
StepLoader::Piece StepLoader::next() {
    for (auto place = tasks_.begin(); place != tasks_.end();) {
        Task& task = **place;
        auto step = task.step.lock();
        if (!step) {
            place = tasks_.erase(place);
            continue;
        }
        if (task.at < task.ahead.size()) {
            Piece piece{*place, std::move(step), task.ahead[task.at]};
            if (piece.ahead.array) piece.ahead.first = task.block++;
            if (!piece.ahead.array || task.block >= piece.ahead.last) {
                ++task.at;
                task.block = task.at < task.ahead.size() ? task.ahead[task.at].first : 0;
            }
            ++task.busy;
            return piece;
        }
        ++place;  // its last pieces are with other threads
    }
    return {};
}

bool StepLoader::loadOne() {
    Piece piece;  // it may be the last to hold the step, whose end takes a while: not under the mutex
    {
        const std::lock_guard lock(mutex_);
        piece = next();
    }
    if (!piece.task) return false;
    if (finished(piece, serve(piece))) arrived_();
    return true;
}

StepLoader::Served StepLoader::serve(const Piece& piece) const {
    const auto& ahead = piece.ahead;
    try {
        if (!ahead.array) {
            return piece.step->follow(ahead.follows, piece.task->generation) ? Served::yes : Served::noRoom;
        }
        const std::size_t later = ahead.first + readAhead;
        if (later < ahead.last && ahead.array->usedIn(later) == 0) ahead.array->expect(later);
        return ahead.array->bring(ahead.first, piece.task->generation) ? Served::yes : Served::noRoom;
    } catch (const storage::StorageError& error) {
        piece.step->fail(error.error());
        return Served::failed;
    }
}

bool StepLoader::finished(const Piece& piece, Served served) {
    const std::lock_guard lock(mutex_);
    Task& task = *piece.task;
    --task.busy;
    if (served != Served::yes) task.at = task.ahead.size();
    if (served == Served::noRoom) task.beyond = true;
    if (task.at < task.ahead.size() || task.busy > 0) return false;
    // Not if a later need has taken its place.
    const auto place = std::find(tasks_.begin(), tasks_.end(), piece.task);
    if (place == tasks_.end()) return false;
    if (task.beyond) beyond_.push_front(piece.task);
    tasks_.erase(place);
    return true;
}

bool intact(const storage::ParticleStep& step) {
    try {
        step.check();
        return true;
    } catch (const storage::StorageError&) {
        return false;
    }
}

bool StepCache::Place::holds(const Place& later) const {
    if (index != later.index || !(directory == later.directory)) return false;
    return manifest == later.manifest ||
           (manifest->particles().live() && sameStep(*manifest, *later.manifest, index));
}

StepCache::StepCache(std::shared_ptr<storage::BlockBudget> budget, unsigned threads,
                     std::function<void()> arrived)
    : budget_(std::move(budget)),
      loader_(budget_, threads, std::move(arrived)),
      thread_(1, [this] { return openNext(); }) {}

Result<StepCache::Step> StepCache::open(const Place& place) {
    return storage::MappedStep::open(place.directory, *place.manifest, place.index, budget_);
}

/// Null if it is not open, or not to be used any more.
StepCache::Step StepCache::find(const Place& place) {
    const std::lock_guard lock(mutex_);
    auto* const found = mostRecent(steps_, [&](const OpenStep& opened) { return opened.place.holds(place); });
    if (found == nullptr) return nullptr;
    found->place = place;
    if (intact(*found->step)) return found->step;
    steps_.pop_front();
    return nullptr;
}

/// Keeps it, unless somebody else opened it meanwhile; returns the one that is kept.
StepCache::Step StepCache::insert(const Place& place, Step step) {
    if (auto other = find(place)) return other;
    std::list<OpenStep> closed;  // unmapped when the mutex is free
    const std::lock_guard lock(mutex_);
    steps_.push_front({place, step});
    std::uint64_t bytes = 0;
    std::size_t kept = 0;
    auto last = steps_.begin();
    for (; last != steps_.end() && kept < mostSteps; ++last, ++kept) {
        bytes += last->step->bytesAtOnce();
        if (kept > stepsAhead && bytes > budget_->limit() / openShare) break;
    }
    closed.splice(closed.begin(), steps_, last, steps_.end());
    return step;
}

Result<StepCache::Step> StepCache::step(const storage::Catalogue::Entry& entry, std::uint32_t index) {
    const Place place{entry.manifest, entry.directory, index};
    Step step = find(place);
    if (!step) {
        MOTE_ASSIGN_OR_RETURN(auto opened, open(place));
        step = insert(place, std::move(opened));
    }
    expectNext(place);
    return step;
}

/// Under the mutex.
StepCache::Played::Series& StepCache::seriesOf(const Place& place) {
    return series_.of(place.manifest, place.manifest->particles().steps_size());
}

void StepCache::expectNext(const Place& place) {
    {
        const std::lock_guard lock(mutex_);
        auto& series = seriesOf(place);
        series.order.asked(place.index);
        expected_.clear();
        for (const auto index : series.order.next(stepsAhead)) {
            expected_.push_back({place.manifest, place.directory, index});
        }
        if (expected_.empty()) return;
    }
    thread_.wake();
}

bool StepCache::want(const storage::ParticleStep& step, const storage::StepNeed& need) {
    Step mapped;
    {
        const std::lock_guard lock(mutex_);
        const auto found = std::find_if(steps_.begin(), steps_.end(),
                                        [&](const OpenStep& opened) { return opened.step.get() == &step; });
        if (found == steps_.end()) return false;
        mapped = found->step;
        auto& series = seriesOf(found->place);
        series.need = {need, mapped->pointCount()};
    }
    if (!ready(*mapped, need)) return loader_.want(mapped, need, StepLoader::Urgency::inUse);
    loader_.want(mapped, {}, StepLoader::Urgency::inUse);
    return false;
}

storage::StepNeed StepCache::needOf(const Place& place, const storage::MappedStep& step) {
    const std::lock_guard lock(mutex_);
    const auto& last = seriesOf(place).need;
    return scaled(last.need, last.points, step.pointCount());
}

/// The thread: opens what is expected, and has it loaded as far as the pictures so far needed it.
bool StepCache::openNext() {
    Place place;
    {
        const std::lock_guard lock(mutex_);
        if (expected_.empty()) return false;
        place = expected_.front();
        expected_.erase(expected_.begin());
    }
    Step step = find(place);
    if (!step) {
        // What is wrong with it will be said when it is asked for.
        auto opened = open(place);
        if (!opened.ok()) return true;
        step = insert(place, *std::move(opened));
    }
    const auto need = needOf(place, *step);
    if (!ready(*step, need)) loader_.want(step, need, StepLoader::Urgency::expected);
    return true;
}

std::vector<std::uint32_t> StepCache::loaded(const storage::Catalogue::Entry& entry) const {
    std::vector<std::pair<std::uint32_t, Step>> opened;
    Need last;
    {
        const std::lock_guard lock(mutex_);
        const auto* const series = series_.find(entry.manifest);
        if (series == nullptr || series->need.need.empty()) return {};
        last = series->need;
        for (const auto& [place, step] : steps_) {
            if (place.holds({entry.manifest, entry.directory, place.index}))
                opened.emplace_back(place.index, step);
        }
    }
    std::vector<std::uint32_t> steps;
    for (const auto& [index, step] : opened) {
        if (ready(*step, scaled(last.need, last.points, step->pointCount()))) steps.push_back(index);
    }
    std::ranges::sort(steps);
    return steps;
}

std::size_t StepCache::openSteps() const {
    const std::lock_guard lock(mutex_);
    return steps_.size();
}

}  // namespace mote::server
