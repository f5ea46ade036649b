// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/data/step_loader.h"

#include <algorithm>

#include "storage/storage_error.h"

namespace mote::server {
namespace {

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
            piece.step->follow(ahead.follows);
            return Served::yes;
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
    // Not where a later need has taken its place.
    const auto place = std::find(tasks_.begin(), tasks_.end(), piece.task);
    if (place == tasks_.end()) return false;
    if (task.beyond) beyond_.push_front(piece.task);
    tasks_.erase(place);
    return true;
}

}  // namespace mote::server
